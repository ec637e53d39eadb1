//! A running demo: started, ready, ended by signal or by itself.

use crate::program::sextant;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Child, ChildStdout, ExitStatus, Stdio};

/// A demo that has said it is ready. Dropping it kills it; its children die with it.
pub struct Demo {
    child: Child,
    stdout: BufReader<ChildStdout>,
    /// The page's address, as `http://127.0.0.1:8600`.
    pub page: String,
    /// The router's endpoint.
    pub connect: String,
    /// Process ids of the nodes by name.
    pub processes: Vec<(String, u32)>,
}

/// How a demo ended.
pub struct DemoOutcome {
    /// Its exit status.
    pub status: ExitStatus,
    /// Its last line.
    pub summary: Value,
}

impl Demo {
    /// Starts a demo with these arguments on a free port of the page and waits until it is ready.
    ///
    /// # Panics
    /// When it ends before.
    #[must_use]
    pub fn start(arguments: &[&str]) -> Self {
        let port = free_port();
        let mut command = sextant();
        command
            .args([
                "demo",
                "--no-browser",
                "--json",
                "--port",
                &port.to_string(),
            ])
            .args(arguments);
        let mut child = command
            .stdout(Stdio::piped())
            .spawn()
            .expect("sextant starts");
        let mut stdout = BufReader::new(child.stdout.take().expect("a pipe"));
        let ready = next_json(&mut stdout).expect("the demo says that it is ready");
        assert_eq!(ready["event"], "ready", "{ready}");
        let text = |value: &Value| value.as_str().expect("a text").to_owned();
        let processes = ready["processes"].as_object().expect("processes");
        let id =
            |value: &Value| u32::try_from(value.as_u64().expect("an id")).expect("a process id");
        Self {
            page: text(&ready["page"]),
            connect: text(&ready["connect"]),
            processes: processes
                .iter()
                .map(|(name, value)| (name.clone(), id(value)))
                .collect(),
            child,
            stdout,
        }
    }

    /// The parent's process id.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sends a signal to the parent.
    pub fn signal(&self, signal: i32) {
        send(self.child.id(), signal);
    }

    /// Waits for the end.
    ///
    /// # Panics
    /// When the demo's last line is no JSON.
    #[must_use]
    pub fn wait(mut self) -> DemoOutcome {
        let mut summary = Value::Null;
        while let Some(line) = next_json(&mut self.stdout) {
            summary = line;
        }
        DemoOutcome {
            status: self.child.wait().expect("the demo can be waited for"),
            summary,
        }
    }
}

impl Drop for Demo {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Sends a signal to a process that this test started.
pub fn send(process: u32, signal: i32) {
    let process = libc::pid_t::try_from(process).expect("a process id");
    // SAFETY: kill touches no memory of ours.
    unsafe { libc::kill(process, signal) };
}

fn next_json(stdout: &mut impl BufRead) -> Option<Value> {
    let mut line = String::new();
    stdout
        .read_line(&mut line)
        .expect("the demo's output is text");
    (!line.is_empty())
        .then(|| serde_json::from_str(&line).unwrap_or_else(|cause| panic!("{cause}: {line}")))
}

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    listener.local_addr().expect("an address").port()
}
