//! The system's ssh: commands on a host, and what its complaints mean.

use sextant_process::terminal::plain;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// What the host's `host.sh` is started with: root, at once or by sudo without a password. The words after it are safe
/// in a shell.
const AS_ROOT: &str = "if [ \"$(id -u)\" = 0 ]; then exec sh -s";
/// Longest answer of a host, and what is kept of its complaints.
const MOST_BYTES: usize = 64 << 10;
/// Time for a question.
const ANSWER: Duration = Duration::from_secs(60);
/// Time for copying a package.
const COPY: Duration = Duration::from_secs(600);
/// Time for what an ended command has said.
const LAST_WORDS: Duration = Duration::from_secs(2);
/// Between two looks at whether a command has ended.
const POLL: Duration = Duration::from_millis(20);
/// Comes before the answer of a command: a login shell may have greeted by then.
const ANSWER_BEGINS: &str = "--- sextant: the answer begins ---";
/// Exit code of `ssh` where it failed itself: no connection, or one that was cut off.
pub const SSH_FAILED: i32 = 255;

/// Words of ssh and sudo on standard error, the first that fits, with what they mean for the {host}; {last}: their last
/// line.
const KNOWN: &[(&str, &str)] = &[
    (
        "REMOTE HOST IDENTIFICATION HAS CHANGED",
        "the host key of {host} differs from the known one: if the board was installed anew, \
         remove the old key with `ssh-keygen -R`; otherwise the connection may be intercepted",
    ),
    (
        "Host key verification failed",
        "the host key of {host} is not known here: connect once with `ssh {host}`, compare the \
         fingerprint, and run this again",
    ),
    (
        "Permission denied",
        "{host} wants a password: copy your public key there with `ssh-copy-id {host}`, or \
         unlock it with `ssh-add`",
    ),
    (
        "sudo: not found",
        "there is no sudo on {host}: connect as root",
    ),
    (
        "sudo: command not found",
        "there is no sudo on {host}: connect as root",
    ),
    (
        "sudo: a password is required",
        "sudo on {host} wants a password: connect as root, or allow it without one (`USER \
         ALL=(root) NOPASSWD: ALL` in /etc/sudoers.d/sextant)",
    ),
    (
        "sudo:",
        "sudo on {host} refuses ({last}): connect as root, or allow it without a password (`USER \
         ALL=(root) NOPASSWD: ALL` in /etc/sudoers.d/sextant)",
    ),
];

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
        let child = self.spawn(&as_root(arguments))?;
        self.output(child, script.as_bytes(), ANSWER)
    }

    /// Unpacks a tar archive as root into a new private folder below `parent` and returns the folder's name.
    ///
    /// # Errors
    /// As [`Ssh::run`].
    pub fn unpack(&self, archive: &[u8], parent: &str) -> Result<String, SshError> {
        let command = format!(
            "sh -c 'umask 077; mkdir -p {parent} && folder=$(mktemp -d {parent}/stage.XXXXXX) && \
             tar -x -f - -C \"$folder\" && echo \"$folder\"'"
        );
        let child = self.spawn(&with_root(&command))?;
        Ok(self.output(child, archive, COPY)?.trim().to_owned())
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

    /// Gives a command its standard input, and takes what it says, within a bound and a time.
    fn output(&self, mut child: Child, input: &[u8], limit: Duration) -> Result<String, SshError> {
        let broken = |cause: std::io::Error| SshError::Unreachable(cause.to_string());
        let (stdin, input) = (child.stdin.take(), input.to_vec());
        std::thread::spawn(move || feed(stdin, &input));
        let (answer, said) = (listen(child.stdout.take()), listen(child.stderr.take()));
        let Some(status) = ended(&mut child, limit).map_err(broken)? else {
            let (host, limit_s) = (&self.host, limit.as_secs());
            let cause = format!("{host} did not answer within {limit_s} s");
            return Err(SshError::Unreachable(cause));
        };
        // A program that ssh left behind may hold the streams open.
        let heard = |stream: Receiver<Vec<u8>>| stream.recv_timeout(LAST_WORDS).unwrap_or_default();
        let (answer, said) = (heard(answer), heard(said));
        if answer.len() > MOST_BYTES {
            let cause = format!("its answer is longer than {} KiB", MOST_BYTES >> 10);
            return Err(SshError::Refused(cause));
        }
        match status.success() {
            true => Ok(without_greeting(&plain_lines(&answer)).to_owned()),
            false => Err(self.error(status.code(), &plain_lines(&said))),
        }
    }

    /// What an end of ssh with this code and these words on standard error means.
    pub fn error(&self, code: Option<i32>, said: &str) -> SshError {
        let host = &self.host;
        let last = said
            .lines()
            .rfind(|line| !line.trim().is_empty())
            .map_or_else(|| "no word of why".to_owned(), |line| plain(line.trim()));
        let known = KNOWN.iter().find(|(words, _)| said.contains(words));
        let known = known.map(|(_, meaning)| {
            let meaning = meaning.replace("{host}", host);
            meaning.replace("{last}", &last)
        });
        match (known, code) {
            (Some(meaning), _) => SshError::Unreachable(meaning),
            (None, Some(SSH_FAILED) | None) => {
                SshError::Unreachable(format!("no connection to {host}: {last}"))
            }
            (None, Some(_)) => SshError::Refused(last),
        }
    }
}

fn no_ssh(cause: std::io::Error) -> SshError {
    SshError::Unreachable(format!(
        "ssh cannot be started ({cause}): install the OpenSSH client"
    ))
}

/// What follows the mark in what a host says; all of it where there is none. What comes before is not the command's:
/// some hosts greet at every login, also where no person does.
fn without_greeting(said: &str) -> &str {
    let mark = said.find(ANSWER_BEGINS);
    let answer = mark.map_or(said, |at| &said[at + ANSWER_BEGINS.len()..]);
    answer.strip_prefix('\n').unwrap_or(answer)
}

/// The script comes on standard input.
fn as_root(arguments: &str) -> String {
    format!(
        "echo '{ANSWER_BEGINS}'; {AS_ROOT} -- {arguments}; else exec sudo -n sh -s -- {arguments}; fi"
    )
}

fn with_root(command: &str) -> String {
    format!(
        "echo '{ANSWER_BEGINS}'; if [ \"$(id -u)\" = 0 ]; then exec {command}; else exec sudo -n {command}; fi"
    )
}

/// Writes standard input and closes it. A command that ends before it has read all says why itself.
fn feed(stdin: Option<ChildStdin>, bytes: &[u8]) {
    if let Some(mut input) = stdin {
        let _ = input.write_all(bytes);
    }
}

/// Waits for the end of a command, which is killed after a time.
fn ended(child: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if begun.elapsed() >= limit {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        std::thread::sleep(POLL);
    }
}

/// Reads a stream in a thread.
fn listen(stream: Option<impl Read + Send + 'static>) -> Receiver<Vec<u8>> {
    let (sender, heard) = channel();
    std::thread::spawn(move || drop(sender.send(bounded(stream))));
    heard
}

/// What a stream says, up to a byte more than the bound. Then it is closed, which ends the one that writes.
fn bounded(stream: Option<impl Read>) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Some(stream) = stream {
        let _ = stream.take(MOST_BYTES as u64 + 1).read_to_end(&mut bytes);
    }
    bytes
}

/// Text of a host without what a terminal obeys.
fn plain_lines(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    let lines = text.lines().map(|line| plain(line) + "\n");
    lines.collect()
}

/// What a started command says on standard error; beyond the bound it is read and left out.
pub fn rest_of(mut stream: impl Read) -> String {
    let said = bounded(Some(&mut stream));
    let _ = std::io::copy(&mut stream, &mut std::io::sink());
    plain_lines(&said)
}

/// The lines that a started command says on standard output, each cut at the bound.
pub fn lines_of(stream: impl Read) -> impl Iterator<Item = String> {
    let mut stream = BufReader::new(stream);
    std::iter::from_fn(move || {
        let mut line = Vec::new();
        let read = (&mut stream)
            .take(MOST_BYTES as u64)
            .read_until(b'\n', &mut line);
        let is_line = read.is_ok_and(|n_bytes| n_bytes > 0);
        is_line.then(|| plain(String::from_utf8_lossy(&line).trim_end()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(script: &str, limit: Duration) -> Result<String, SshError> {
        let mut shell = Command::new("sh");
        shell.args(["-c", script]);
        shell
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let ssh = Ssh {
            config: None,
            host: "north".into(),
        };
        ssh.output(shell.spawn().unwrap(), b"input", limit)
    }

    #[test]
    fn a_host_is_neither_trusted_nor_awaited_for_ever() {
        let soon = Duration::from_secs(20);
        assert_eq!(
            ask("cat; printf 'a\\033[2Jb\\n'", soon).unwrap(),
            "inputa [2Jb\n"
        );
        let greets = format!("echo Welcome; echo '{ANSWER_BEGINS}'; echo /var/lib");
        assert_eq!(ask(&greets, soon).unwrap(), "/var/lib\n");
        let error = ask("printf 'x\\033]0;owned\\007y\\n' >&2; exit 1", soon).unwrap_err();
        assert!(
            !error.to_string().contains(|c: char| c.is_control()),
            "{error:?}"
        );
        let error = ask("yes", soon).unwrap_err();
        assert_eq!(error.to_string(), "its answer is longer than 64 KiB");
        let error = ask("sleep 1000", Duration::from_millis(50)).unwrap_err();
        assert!(
            error.to_string().starts_with("north did not answer within"),
            "{error}"
        );
        let endless = std::io::repeat(b'x');
        assert_eq!(lines_of(endless).next().unwrap().len(), MOST_BYTES);
    }

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
