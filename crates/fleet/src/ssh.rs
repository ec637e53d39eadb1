//! The system's ssh: commands on a host, and what its complaints mean.

use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// What the host's `host.sh` is started with: root, at once or by sudo without a password. The words after it are safe in a shell.
const AS_ROOT: &str = "if [ \"$(id -u)\" = 0 ]; then exec sh -s";
/// `ssh` itself failed.
const SSH_FAILED: i32 = 255;

/// A host, by the system's ssh.
#[derive(Debug, Clone)]
pub struct Ssh {
    /// In place of `~/.ssh/config`.
    pub config: Option<PathBuf>,
    /// As ssh takes it.
    pub host: String,
}

/// Why a host could not be asked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SshError {
    /// No connection, or one that was cut off.
    #[error("{0}")]
    Unreachable(String),
    /// A command failed there.
    #[error("{0}")]
    Refused(String),
}

impl Ssh {
    /// Runs `host.sh` with these arguments as root and returns what it prints.
    ///
    /// # Errors
    /// No connection, no root, a command that failed.
    pub fn run(&self, script: &str, arguments: &str) -> Result<String, SshError> {
        let mut child = self.spawn(&as_root(arguments))?;
        feed(&mut child, script.as_bytes());
        self.output(child)
    }

    /// Unpacks a tar archive as root into a new private folder below `parent` and returns the folder's name.
    ///
    /// # Errors
    /// As [`Ssh::run`].
    pub fn unpack(&self, archive: &[u8], parent: &str) -> Result<String, SshError> {
        let command = format!(
            "sh -c 'umask 077; mkdir -p {parent} && folder=$(mktemp -d {parent}/stage.XXXXXX) && tar -x -f - -C \"$folder\" && echo \"$folder\"'"
        );
        let mut child = self.spawn(&with_root(&command))?;
        feed(&mut child, archive);
        Ok(self.output(child)?.trim().to_owned())
    }

    /// Starts a command as root whose standard streams the caller takes. Ctrl-C at this terminal does not reach it.
    ///
    /// # Errors
    /// No ssh on this machine.
    pub fn start(&self, command: &str) -> Result<Child, SshError> {
        use std::os::unix::process::CommandExt;
        let mut ssh = self.command(&with_root(command));
        ssh.process_group(0);
        ssh.spawn().map_err(no_ssh)
    }

    fn spawn(&self, remote: &str) -> Result<Child, SshError> {
        self.command(remote).spawn().map_err(no_ssh)
    }

    fn command(&self, remote: &str) -> Command {
        let mut ssh = Command::new("ssh");
        ssh.args(["-T", "-o", "BatchMode=yes", "-o", "ConnectTimeout=10"]);
        ssh.args(["-o", "ServerAliveInterval=5", "-o", "ServerAliveCountMax=3"]);
        if let Some(config) = &self.config {
            ssh.arg("-F").arg(config);
        }
        ssh.args(["--", &self.host, remote]);
        ssh.stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        ssh
    }

    fn output(&self, child: Child) -> Result<String, SshError> {
        let output = child.wait_with_output();
        let output = output.map_err(|cause| SshError::Unreachable(cause.to_string()))?;
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.success() {
            return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
        }
        Err(self.error(output.status.code(), &said))
    }

    /// What an end of ssh with this code and these words on standard error means.
    pub fn error(&self, code: Option<i32>, said: &str) -> SshError {
        let host = &self.host;
        let last = said
            .lines()
            .rfind(|line| !line.trim().is_empty())
            .unwrap_or("no word of why")
            .trim();
        let known = [
            (
                "REMOTE HOST IDENTIFICATION HAS CHANGED",
                format!(
                    "the host key of {host} differs from the known one: if the board was installed anew, remove the old key with `ssh-keygen -R`; otherwise the connection may be intercepted"
                ),
            ),
            (
                "Host key verification failed",
                format!(
                    "the host key of {host} is not known here: connect once with `ssh {host}`, compare the fingerprint, and run this again"
                ),
            ),
            (
                "Permission denied",
                format!(
                    "{host} wants a password: copy your public key there with `ssh-copy-id {host}`, or unlock it with `ssh-add`"
                ),
            ),
            (
                "sudo: not found",
                format!("there is no sudo on {host}: connect as root"),
            ),
            (
                "sudo: command not found",
                format!("there is no sudo on {host}: connect as root"),
            ),
            (
                "sudo: a password is required",
                format!(
                    "sudo on {host} wants a password: connect as root, or allow it without one (`USER ALL=(root) NOPASSWD: ALL` in /etc/sudoers.d/sextant)"
                ),
            ),
            (
                "sudo:",
                format!(
                    "sudo on {host} refuses ({last}): connect as root, or allow it without a password (`USER ALL=(root) NOPASSWD: ALL` in /etc/sudoers.d/sextant)"
                ),
            ),
        ];
        let known = known.into_iter().find(|(words, _)| said.contains(words));
        match (known, code) {
            (Some((_, words)), _) => SshError::Unreachable(words),
            (None, Some(SSH_FAILED) | None) => {
                SshError::Unreachable(format!("no connection to {host}: {last}"))
            }
            (None, Some(_)) => SshError::Refused(last.to_owned()),
        }
    }
}

fn no_ssh(cause: std::io::Error) -> SshError {
    SshError::Unreachable(format!(
        "ssh cannot be started ({cause}): install the OpenSSH client"
    ))
}

/// The script comes on standard input.
fn as_root(arguments: &str) -> String {
    format!("{AS_ROOT} -- {arguments}; else exec sudo -n sh -s -- {arguments}; fi")
}

fn with_root(command: &str) -> String {
    format!("if [ \"$(id -u)\" = 0 ]; then exec {command}; else exec sudo -n {command}; fi")
}

/// Writes standard input and closes it. A command that ends before it has read all says why itself.
fn feed(child: &mut Child, bytes: &[u8]) {
    if let Some(mut input) = child.stdin.take() {
        let _ = input.write_all(bytes);
    }
}

/// Everything that a started command says on standard error.
pub fn rest_of(mut stream: impl Read) -> String {
    let mut text = Vec::new();
    let _ = stream.read_to_end(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_refusal_of_ssh_and_sudo_has_a_remedy() {
        let ssh = Ssh {
            config: None,
            host: "pi@north".into(),
        };
        for (code, said, remedy) in [
            (
                255,
                "pi@north: Permission denied (publickey,password).\r\n",
                "ssh-copy-id pi@north",
            ),
            (
                255,
                "No ED25519 host key is known.\nHost key verification failed.\n",
                "connect once with `ssh pi@north`",
            ),
            (
                255,
                "@ WARNING: REMOTE HOST IDENTIFICATION HAS CHANGED! @\nHost key verification failed.\n",
                "ssh-keygen -R",
            ),
            (
                255,
                "ssh: connect to host north port 22: Connection refused\n",
                "no connection to pi@north: ssh: connect",
            ),
            (1, "sudo: a password is required\n", "NOPASSWD"),
            (127, "sh: 1: exec: sudo: not found\n", "connect as root"),
        ] {
            let words = ssh.error(Some(code), said).to_string();
            assert!(words.contains(remedy), "{words}");
        }
        assert_eq!(
            ssh.error(Some(1), "tar: no space\n"),
            SshError::Refused("tar: no space".into())
        );
    }
}
