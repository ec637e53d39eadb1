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
    scope: Scope,
    /// Once it has been waited for; its id may be another process's from then on.
    status: Option<ExitStatus>,
}

/// Recipient of a child's signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scope {
    Process,
    /// Its whole process group: the child and its descendants.
    Group,
}

impl ChildProcess {
    /// Starts `command`. The kernel sends the child SIGTERM when the *thread* that called this ends, so call it
    /// from a thread that outlives the child: the main thread.
    pub fn spawn(name: &str, command: &mut Command) -> io::Result<Self> {
        Self::spawn_in(Scope::Process, name, command)
    }

    /// Starts `command` in a process group of its own: its descendants are stopped and killed with it. Ctrl-C in
    /// the terminal does not reach that group.
    ///
    /// # Errors
    /// A program that does not exist or cannot be started.
    pub fn spawn_group(name: &str, command: &mut Command) -> io::Result<Self> {
        command.process_group(0);
        Self::spawn_in(Scope::Group, name, command)
    }

    fn spawn_in(scope: Scope, name: &str, command: &mut Command) -> io::Result<Self> {
        let parent = std::process::id();
        // SAFETY: between fork and exec only prctl and getppid run, both async-signal-safe; nothing is allocated.
        unsafe { command.pre_exec(move || die_with_parent(parent)) };
        Ok(Self {
            name: name.to_owned(),
            child: command.spawn()?,
            scope,
            status: None,
        })
    }

    /// The name for messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The process id, for signals.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The pipes that the command requested.
    pub fn child_mut(&mut self) -> &mut Child {
        &mut self.child
    }

    /// Its exit status, if it has ended.
    pub fn try_wait(&mut self) -> io::Result<Option<ExitStatus>> {
        if self.status.is_none() && has_ended(self.child.id())? {
            if self.scope == Scope::Group {
                // Before the child is waited for: until then its process group cannot be reused.
                self.signal(libc::SIGKILL);
            }
            self.status = Some(self.child.wait()?);
        }
        Ok(self.status)
    }

    fn signal(&self, signal: i32) {
        if let Ok(pid) = libc::pid_t::try_from(self.child.id()) {
            let receiver = match self.scope {
                Scope::Process => pid,
                Scope::Group => -pid,
            };
            // SAFETY: kill touches no memory of ours; the child has not been waited for, so its id is still its own.
            unsafe { libc::kill(receiver, signal) };
        }
    }

    fn kill(&mut self) -> io::Result<()> {
        self.signal(libc::SIGKILL);
        self.status = Some(self.child.wait()?);
        Ok(())
    }

    /// Sends SIGTERM; ignores a child that has ended.
    pub fn ask_to_stop(&mut self) {
        if matches!(self.try_wait(), Ok(None)) {
            self.signal(libc::SIGTERM);
        }
    }

    /// Waits for its end until `deadline`, then kills it. `None` if it was killed.
    pub fn wait_until(&mut self, deadline: Instant) -> io::Result<Option<ExitStatus>> {
        loop {
            if let Some(status) = self.try_wait()? {
                return Ok(Some(status));
            }
            if Instant::now() >= deadline {
                self.kill()?;
                return Ok(None);
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        if matches!(self.try_wait(), Ok(None)) {
            let _ = self.kill();
        }
    }
}

/// Stops all children within a common `grace` period, then kills the rest. Returns the names of the killed ones.
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

/// Makes the kernel send SIGTERM to this process when its parent ends. Fails when the parent, `parent`, has ended
/// already.
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

/// Whether a child has ended without being waited for; it stays waitable.
fn has_ended(pid: u32) -> io::Result<bool> {
    // SAFETY: all-zero bytes are a valid siginfo (plain integers).
    let mut info: libc::siginfo_t = unsafe { std::mem::zeroed() };
    let options = libc::WEXITED | libc::WNOHANG | libc::WNOWAIT;
    // SAFETY: `info` is valid and writable for the whole call.
    let result = unsafe { libc::waitid(libc::P_PID, pid, &raw mut info, options) };
    if result != 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: waitid filled the fields of a child, or left the zeros.
    Ok(unsafe { info.si_pid() } != 0)
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

    /// Starts a shell that starts a sleeper, and returns the sleeper's process id.
    fn parent_of_a_sleeper(script: &str) -> (ChildProcess, u32) {
        let mut command = Command::new("sh");
        command
            .args(["-c", script])
            .stdout(std::process::Stdio::piped());
        let mut child = ChildProcess::spawn_group("shell", &mut command).unwrap();
        let output = child.child_mut().stdout.as_mut().unwrap();
        let mut line = String::new();
        io::BufRead::read_line(&mut io::BufReader::new(output), &mut line).unwrap();
        (child, line.trim().parse().unwrap())
    }

    /// Whether a process is gone, or dead and only not waited for.
    fn until_dead(pid: u32) {
        let deadline = Instant::now() + Duration::from_secs(30);
        loop {
            let status = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
            if status.is_empty() || status.contains(") Z ") {
                return;
            }
            assert!(Instant::now() < deadline, "{status}");
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_group_ends_with_all_that_it_has_started() {
        let (mut child, sleeper) = parent_of_a_sleeper("sleep 60 & echo $!; wait");
        assert!(stop_all(std::slice::from_mut(&mut child), Duration::from_secs(30)).is_empty());
        until_dead(sleeper);

        let (mut child, sleeper) = parent_of_a_sleeper("sleep 60 & echo $!");
        let status = child.wait_until(Instant::now() + Duration::from_secs(30));
        assert!(status.unwrap().unwrap().success());
        until_dead(sleeper);

        let (child, sleeper) = parent_of_a_sleeper("trap '' TERM; sleep 60 & echo $!; wait");
        drop(child);
        until_dead(sleeper);
    }

    #[test]
    fn a_missing_program_is_an_error_of_spawn() {
        assert!(ChildProcess::spawn("none", &mut Command::new("/nonexistent/program")).is_err());
    }
}
