//! Shutdown requests: SIGINT, SIGTERM and SIGHUP permanently set a flag and make a file descriptor readable. Loops read
//! the flag, and waits poll the descriptor. This needs no thread, except to watch standard input.

use std::io::Write;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use crate::Exit;

/// Longest time that a loop may wait for anything else before it reads the flag again.
pub const SHUTDOWN_POLL: Duration = Duration::from_millis(50);

/// A cheap handle on the shutdown request; clones share it.
#[derive(Debug, Clone)]
pub struct Shutdown {
    state: Arc<ShutdownState>,
}

#[derive(Debug)]
struct ShutdownState {
    requested: Arc<AtomicBool>,
    /// While set, SIGINT ends the process immediately.
    is_interruptible: Arc<AtomicBool>,
    /// Readable from the request on; never read, so that every waiter wakes.
    readable: UnixStream,
    writable: UnixStream,
}

impl Shutdown {
    /// Installs the handlers of SIGINT, SIGTERM and SIGHUP.
    pub fn install() -> std::io::Result<Self> {
        let shutdown = Self::manual()?;
        let is_interruptible = Arc::clone(&shutdown.state.is_interruptible);
        let code = Exit::Interrupted as i32;
        signal_hook::flag::register_conditional_shutdown(SIGINT, code, is_interruptible)?;
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&shutdown.state.requested))?;
            signal_hook::low_level::pipe::register(signal, shutdown.state.writable.try_clone()?)?;
        }
        Ok(shutdown)
    }

    /// A handle without signals, set by [`Shutdown::request`], for threads and tests.
    pub fn manual() -> std::io::Result<Self> {
        let (readable, writable) = UnixStream::pair()?;
        writable.set_nonblocking(true)?;
        let requested = Arc::new(AtomicBool::new(false));
        Ok(Self {
            state: Arc::new(ShutdownState {
                requested,
                is_interruptible: Arc::new(AtomicBool::new(false)),
                readable,
                writable,
            }),
        })
    }

    /// Requests a shutdown, like a signal.
    pub fn request(&self) {
        self.state.requested.store(true, Ordering::SeqCst);
        // A full pipe is readable already, which is sufficient.
        let _ = (&self.state.writable).write(&[0]);
    }

    /// Requests a shutdown when standard input ends, as it does when the program that holds its other end is killed.
    pub fn request_at_end_of_input(&self) {
        let shutdown = self.clone();
        std::thread::spawn(move || {
            // A fault of the pipe is an end too.
            let _ = std::io::copy(&mut std::io::stdin().lock(), &mut std::io::sink());
            shutdown.request();
        });
    }

    /// Runs work that does not check for shutdown: Ctrl-C ends the process during it, with [`Exit::Interrupted`] and
    /// without cleanup.
    pub fn interruptible<T>(&self, work: impl FnOnce() -> T) -> T {
        self.state.is_interruptible.store(true, Ordering::SeqCst);
        let done = work();
        self.state.is_interruptible.store(false, Ordering::SeqCst);
        done
    }

    /// Whether a shutdown is requested.
    pub fn is_requested(&self) -> bool {
        self.state.requested.load(Ordering::SeqCst)
    }

    /// Sleeps for at most `timeout` and returns early, with `true`, on a shutdown request.
    pub fn wait(&self, timeout: Duration) -> bool {
        let deadline = Instant::now() + timeout;
        while !self.is_requested() {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            wait_readable(self.as_fd(), left);
        }
        true
    }
}

impl AsFd for Shutdown {
    /// Readable from the request on. Poll it; never read it.
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.state.readable.as_fd()
    }
}

fn wait_readable(fd: BorrowedFd<'_>, timeout: Duration) {
    let mut poll = libc::pollfd {
        fd: fd.as_raw_fd(),
        events: libc::POLLIN,
        revents: 0,
    };
    let timeout = libc::timespec {
        tv_sec: libc::time_t::try_from(timeout.as_secs()).unwrap_or(libc::time_t::MAX),
        tv_nsec: timeout.subsec_nanos().cast_signed().into(),
    };
    // SAFETY: `poll` is one valid pollfd, whose descriptor stays open through the borrow; the mask of signals stays as
    // it is.
    unsafe { libc::ppoll(&raw mut poll, 1, &raw const timeout, std::ptr::null()) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_ends_every_wait() {
        let shutdown = Shutdown::manual().unwrap();
        let waiters: Vec<_> = (0..3)
            .map(|_| {
                let shutdown = shutdown.clone();
                std::thread::spawn(move || shutdown.wait(Duration::from_secs(60)))
            })
            .collect();
        shutdown.request();
        assert!(waiters.into_iter().all(|waiter| waiter.join().unwrap()));
    }

    #[test]
    fn a_wait_without_a_request_ends_with_false() {
        assert!(!Shutdown::manual().unwrap().wait(Duration::from_millis(2)));
    }

    #[test]
    fn a_signal_is_a_request() {
        let shutdown = Shutdown::install().unwrap();
        signal_hook::low_level::raise(SIGTERM).unwrap();
        assert!(shutdown.wait(Duration::from_secs(60)));
    }

    /// Runs this test again as a process of its own, which Ctrl-C ends.
    #[test]
    fn ctrl_c_ends_interruptible_work_and_no_other() {
        const CHILD: &str = "SEXTANT_TEST_INTERRUPTIBLE";
        const NAME: &str = "shutdown::tests::ctrl_c_ends_interruptible_work_and_no_other";
        if std::env::var_os(CHILD).is_some() {
            let shutdown = Shutdown::install().unwrap();
            signal_hook::low_level::raise(SIGINT).unwrap();
            assert!(shutdown.is_requested());
            shutdown.interruptible(|| signal_hook::low_level::raise(SIGINT).unwrap());
            unreachable!("the second SIGINT came during interruptible work");
        }
        let child = std::process::Command::new(std::env::current_exe().unwrap())
            .args([NAME, "--exact"])
            .env(CHILD, "1")
            .output()
            .unwrap();
        assert_eq!(child.status.code(), Some(Exit::Interrupted as i32));
    }
}
