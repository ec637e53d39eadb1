//! Child processes that never outlive their parent, and end in an orderly way: SIGTERM, a grace period, then SIGKILL.

use std::io;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

/// A running child with a name for messages. Dropping it kills it.
#[derive(Debug)]
pub struct ChildProcess {
    name: String,
    child: Child,
}

impl ChildProcess {
    /// Starts `command`. The child gets SIGTERM when the *thread* that called this ends (the kernel's rule), so call it
    /// from a thread that lives as long as the children shall: the main thread.
    pub fn spawn(name: &str, command: &mut Command) -> io::Result<Self> {
        let parent = std::process::id();
        // SAFETY: between fork and exec only prctl and getppid run, both async-signal-safe; nothing is allocated.
        unsafe { command.pre_exec(move || die_with_parent(parent)) };
        Ok(Self {
            name: name.to_owned(),
            child: command.spawn()?,
        })
    }

    /// The name for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The pipes, where the command asked for any.
    pub fn child_mut(&mut self) -> &mut Child {
        &mut self.child
    }

    /// How it ended, if it did.
    pub fn try_wait(&mut self) -> io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    /// Asks it to stop (SIGTERM); one that has ended is no error.
    pub fn ask_to_stop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            send_signal(self.child.id(), libc::SIGTERM);
        }
    }

    /// Waits for its end until `deadline`, then kills it. `None`: it had to be killed.
    pub fn wait_until(&mut self, deadline: Instant) -> io::Result<Option<ExitStatus>> {
        loop {
            if let Some(status) = self.child.try_wait()? {
                return Ok(Some(status));
            }
            if Instant::now() >= deadline {
                self.child.kill()?;
                self.child.wait()?;
                return Ok(None);
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Asks all to stop, gives them `grace` together, kills the rest. Returns the names of the killed.
pub fn stop_all(children: &mut [ChildProcess], grace: Duration) -> Vec<String> {
    for child in children.iter_mut() {
        child.ask_to_stop();
    }
    let deadline = Instant::now() + grace;
    children
        .iter_mut()
        .filter_map(|child| {
            (!matches!(child.wait_until(deadline), Ok(Some(_)))).then(|| child.name.clone())
        })
        .collect()
}

/// Makes the kernel send SIGTERM to this process when its parent ends. Fails when the parent, `parent`, has ended already.
pub fn die_with_parent(parent: u32) -> io::Result<()> {
    // SAFETY: PR_SET_PDEATHSIG takes a signal number and touches no memory of ours.
    if unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGTERM) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: getppid has no precondition.
    if unsafe { libc::getppid() }.unsigned_abs() != parent {
        return Err(io::Error::from_raw_os_error(libc::ESRCH));
    }
    Ok(())
}

fn send_signal(pid: u32, signal: i32) {
    if let Ok(pid) = libc::pid_t::try_from(pid) {
        // SAFETY: kill touches no memory of ours; the child has not been waited for, so its id is still its own.
        unsafe { libc::kill(pid, signal) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;

    #[test]
    fn a_child_that_listens_ends_by_sigterm() {
        let mut child = ChildProcess::spawn("sleep", Command::new("sleep").arg("60")).unwrap();
        child.ask_to_stop();
        let status = child
            .wait_until(Instant::now() + Duration::from_secs(30))
            .unwrap()
            .unwrap();
        assert_eq!(status.signal(), Some(libc::SIGTERM));
    }

    #[test]
    fn a_child_that_does_not_listen_is_killed() {
        let mut command = Command::new("sh");
        command.args(["-c", "trap '' TERM; echo ready; while :; do sleep 1; done"]);
        command.stdout(std::process::Stdio::piped());
        let mut child = ChildProcess::spawn("deaf", &mut command).unwrap();
        let mut ready = [0];
        io::Read::read_exact(child.child_mut().stdout.as_mut().unwrap(), &mut ready).unwrap();
        let killed = stop_all(std::slice::from_mut(&mut child), Duration::from_millis(50));
        assert_eq!(killed, ["deaf"]);
    }

    #[test]
    fn a_missing_program_is_an_error_of_spawn() {
        assert!(ChildProcess::spawn("none", &mut Command::new("/nonexistent/program")).is_err());
    }
}
