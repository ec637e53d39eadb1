//! Zenoh's own threads: it starts five pools with six threads; four serve a node.

use std::sync::Once;

const VARIABLE: &str = "ZENOH_RUNTIME";
const SMALL: &str = "(rx: (handover: app), acc: (handover: app), app: (worker_threads: 2))";

/// Asks zenoh for fewer threads, before its first session; only while this process has a single thread, since the
/// environment may not be written beside a reader. An operator's own `ZENOH_RUNTIME` stays.
pub(crate) fn ask_for_few_threads() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        if std::env::var_os(VARIABLE).is_none() && is_single_threaded() {
            // SAFETY: this is the only thread of the process, so nobody reads or writes the environment meanwhile.
            unsafe { std::env::set_var(VARIABLE, SMALL) };
        }
    });
}

fn is_single_threaded() -> bool {
    std::fs::read_dir("/proc/self/task").is_ok_and(|tasks| tasks.count() == 1)
}
