//! A panic of any thread ends the process: a node that has lost a thread would appear alive, and its
//! supervisor would not restart it. Only work marked as [`contained`] may panic; its caller gets the message.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};

use crate::Exit;

thread_local! {
    static IS_CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// Makes a panic of any thread, including those of libraries, print its location and end the process with
/// [`Exit::Panic`]. Nothing is unwound and no destructor runs, so that inconsistent state is not written anywhere.
pub fn end_the_process() {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        print(info);
        if !IS_CONTAINED.get() {
            let said = message(info.payload());
            let lack = lack_of(&said).or_else(|| lack_now(&said));
            let (exit, words) = match lack {
                Some(lack) => (
                    Exit::Fault,
                    format!("this process ends, as the system refuses it {lack}"),
                ),
                None => (Exit::Panic, last_words(info)),
            };
            eprintln!("error: {words}");
            // SAFETY: _exit ends the process at once and touches no memory of ours.
            unsafe { libc::_exit(exit as i32) };
        }
    }));
}

fn last_words(info: &PanicHookInfo<'_>) -> String {
    let thread = std::thread::current();
    format!(
        "the thread \"{}\" panicked, so this process ends: {}; this is a defect of the program, please report it",
        thread.name().unwrap_or("without a name"),
        message(info.payload())
    )
}

/// What the system lacked, where a library panics for want of it.
fn lack_of(message: &str) -> Option<&'static str> {
    const LACKS: [(&str, i32, &str); 3] = [
        (
            "Too many open files",
            libc::EMFILE,
            "more files and connections: raise the limit (`ulimit -n`, LimitNOFILE= of its unit)",
        ),
        (
            "Too many open files in system",
            libc::ENFILE,
            "more files and connections: the system's limit is reached (fs.file-max)",
        ),
        (
            "Cannot allocate memory",
            libc::ENOMEM,
            "more memory: end other programs, or raise the limit (`ulimit -v`, MemoryMax= of its unit)",
        ),
    ];
    let mut lacks = LACKS.into_iter();
    let found = lacks.find(|(text, code, _)| has_error(message, text, *code));
    let is_of_threads = may_lack_threads(message) && message.to_lowercase().contains("thread");
    found
        .map(|(_, _, lack)| lack)
        .or(is_of_threads.then_some(THREADS))
}

const THREADS: &str = "more threads: raise the limit (`ulimit -u`, TasksMax= of its unit)";

fn has_error(message: &str, text: &str, code: i32) -> bool {
    message.contains(&format!("code: {code},")) || message.contains(&format!("{text} (os error"))
}

/// The system refuses threads with the error that sockets, pipes and locks have where they would block.
fn may_lack_threads(message: &str) -> bool {
    has_error(message, "Resource temporarily unavailable", libc::EAGAIN)
}

/// What the system lacks, where the panic does not say it: nothing was closed since, and no thread has ended.
fn lack_now(message: &str) -> Option<&'static str> {
    if let Err(refusal) = std::fs::File::open("/dev/null") {
        return lack_of(&refusal.to_string());
    }
    let is_refused = || std::thread::Builder::new().spawn(|| {}).is_err();
    (may_lack_threads(message) && is_refused()).then_some(THREADS)
}

/// Runs work whose panic does not end the process: long calculations on recorded data. Shared state must remain
/// valid if it is interrupted; ideally there is none.
///
/// # Errors
/// The panic's message.
pub fn contained<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let outer = IS_CONTAINED.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    IS_CONTAINED.set(outer);
    done.map_err(|payload| message(payload.as_ref()))
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "no message".to_owned())
}

/// Panics in a test's process where the variable `SEXTANT_TEST_PANIC` has this name. Compiled into the unit tests of
/// the calling crate only.
#[macro_export]
macro_rules! fail_point {
    ($place:literal) => {
        #[cfg(test)]
        if std::env::var_os("SEXTANT_TEST_PANIC").is_some_and(|place| place == $place) {
            panic!(concat!("the fail point ", $place));
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::{Command, Output};

    #[test]
    fn what_the_system_lacks_is_no_defect() {
        let lack = |text| lack_of(text).unwrap_or("a defect");
        let zenohs = "called `Result::unwrap()` on an `Err` value: Os \
            { code: 24, kind: Uncategorized, message: \"Too many open files\" }";
        assert!(lack(zenohs).contains("LimitNOFILE"));
        assert!(
            lack("failed to spawn thread: Resource temporarily unavailable (os error 11)")
                .contains("TasksMax")
        );
        let threads = "called `Result::unwrap()` on an `Err` value: ThreadPoolBuildError \
            { kind: IOError(Os { code: 11, kind: WouldBlock, message: \"Resource temporarily unavailable\" }) }";
        assert!(lack(threads).contains("TasksMax"));
        let a_sockets = "called `Result::unwrap()` on an `Err` value: Os \
            { code: 11, kind: WouldBlock, message: \"Resource temporarily unavailable\" }";
        assert_eq!(lack(a_sockets), "a defect");
        assert_eq!(lack_now(a_sockets), None);
        assert_eq!(
            lack("index out of bounds: the len is 24 but the index is 24"),
            "a defect"
        );
    }

    const CHILD: &str = "SEXTANT_TEST_PANICKING";

    /// Runs the test of this name again as a process of its own.
    fn run_again(name: &str) -> Output {
        Command::new(std::env::current_exe().unwrap())
            .args([&format!("panics::tests::{name}"), "--exact", "--nocapture"])
            .env(CHILD, "1")
            .output()
            .unwrap()
    }

    fn is_child() -> bool {
        let is_child = std::env::var_os(CHILD).is_some();
        if is_child {
            end_the_process();
        }
        is_child
    }

    #[test]
    fn a_panic_of_any_thread_ends_the_process_with_a_message() {
        if is_child() {
            let thread = std::thread::Builder::new().name("worker".into());
            let _ = thread.spawn(|| panic!("of all {}", 7)).unwrap().join();
            unreachable!("the process has ended");
        }
        let output = run_again("a_panic_of_any_thread_ends_the_process_with_a_message");
        assert_eq!(output.status.code(), Some(Exit::Panic as i32));
        let words = String::from_utf8(output.stderr).unwrap();
        assert!(words.contains("\"worker\" panicked"), "{words}");
        assert!(words.contains("of all 7"), "{words}");
    }

    #[test]
    fn contained_work_reports_its_panic_and_the_process_goes_on() {
        if is_child() {
            let thread = std::thread::spawn(|| contained(|| -> u8 { panic!("of all {}", 7) }));
            assert_eq!(thread.join().unwrap(), Err("of all 7".to_owned()));
            assert_eq!(contained(|| contained(|| 1)), Ok(Ok(1)));
            // Panics after contained work end the process again.
            let _ = std::thread::spawn(|| {
                assert_eq!(contained(|| 2), Ok(2));
                panic!("after it");
            })
            .join();
            unreachable!("the process has ended");
        }
        let output = run_again("contained_work_reports_its_panic_and_the_process_goes_on");
        let words = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(Exit::Panic as i32), "{words}");
        assert!(words.contains("ends: after it"), "{words}");
    }
}
