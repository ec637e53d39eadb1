//! Priority: work without deadline (previews, recordings) yields to everything else.

use std::io;

/// Gives the calling thread the niceness 10, below everything that serves a measurement.
pub fn lower_this_thread() -> io::Result<()> {
    // SAFETY: setpriority has no memory precondition; on Linux PRIO_PROCESS with 0 means the calling thread.
    let result = unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, 10) };
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_thread_may_always_step_aside() {
        std::thread::spawn(|| super::lower_this_thread().unwrap())
            .join()
            .unwrap();
    }
}
