//! Zenoh's threads: by default five pools with six threads; four are enough for a node.

use std::sync::Once;

const VARIABLE: &str = "ZENOH_RUNTIME";
const SMALL: &str = "(rx: (handover: app), acc: (handover: app), app: (worker_threads: 2))";

/// Reduces zenoh's threads, before its first session and only while this process has a single thread, since the
/// environment must not be written while it may be read. An operator's own `ZENOH_RUNTIME` has precedence.
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
