//! The demo's child processes: the nodes of a site, run by this binary.

use crate::demo::site_folder::SiteFolder;
use anyhow::{Context, bail};
use sextant_process::children::{self, ChildProcess};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Timeout for children to end.
const GRACE: Duration = Duration::from_secs(3);
/// Lines of a dead child's log that are shown.
const LAST_LINES: usize = 8;

/// All child processes; dropping it ends them.
pub struct Processes {
    children: Vec<ChildProcess>,
    logs: PathBuf,
}

impl Processes {
    /// Starts every node of the site; before them, a recorder with these arguments, so that it has their first
    /// messages.
    pub fn start(folder: &SiteFolder, recorder: Option<&[OsString]>) -> anyhow::Result<Self> {
        let mut all = Self {
            children: Vec::new(),
            logs: folder.logs().to_owned(),
        };
        if let Some(arguments) = recorder {
            all.start_recorder(arguments)?;
        }
        all.start_node("fusion", &["fusion", "--config"], &folder.fusion_config())?;
        all.start_node("viewer", &["viewer", "--config"], &folder.viewer_config())?;
        for camera in folder.cameras() {
            for part in ["detect", "capture"] {
                let config = folder.camera_config(camera);
                all.start_node(
                    &format!("{part}-{camera}"),
                    &["camera", "--part", part, "--config"],
                    &config,
                )?;
            }
        }
        Ok(all)
    }

    /// Waits until it records.
    fn start_recorder(&mut self, arguments: &[OsString]) -> anyhow::Result<()> {
        let mut command = self.command("record")?;
        command.args(["record", "--json"]).args(arguments);
        command.stdout(Stdio::piped());
        self.spawn("record", &mut command)?;
        let recorder = self.children.last_mut();
        let output = recorder.and_then(|child| child.child_mut().stdout.take());
        let mut line = String::new();
        if let Some(output) = output {
            BufReader::new(output).read_line(&mut line)?;
        }
        if line.is_empty() {
            bail!("no recording: {}", self.last_words("record"));
        }
        Ok(())
    }

    /// Starts a server for Foxglove and Lichtblick.
    pub fn start_foxglove(&mut self, site: &[OsString]) -> anyhow::Result<()> {
        let mut command = self.command("foxglove")?;
        command.arg("foxglove").args(site).stdout(Stdio::null());
        self.spawn("foxglove", &mut command)
    }

    fn start_node(
        &mut self,
        name: &str,
        arguments: &[&str],
        config: &std::path::Path,
    ) -> anyhow::Result<()> {
        let mut command = self.command(name)?;
        command.args(arguments).arg(config).stdout(Stdio::null());
        self.spawn(name, &mut command)
    }

    /// This program with a log of its own, in a process group of its own: Ctrl-C reaches only the parent, which then
    /// ends the children in order.
    fn command(&self, name: &str) -> anyhow::Result<Command> {
        let program =
            std::env::current_exe().context("this program's own file is not to be found")?;
        let log = File::create(self.log_of(name)).context("a log file can't be made")?;
        let mut command = Command::new(program);
        command.process_group(0).stdin(Stdio::null()).stderr(log);
        Ok(command)
    }

    fn spawn(&mut self, name: &str, command: &mut Command) -> anyhow::Result<()> {
        let child = ChildProcess::spawn(name, command)
            .with_context(|| format!("{name} can't be started"))?;
        self.children.push(child);
        Ok(())
    }

    /// Fails with the last log lines of a child that has ended.
    pub fn check(&mut self) -> anyhow::Result<()> {
        for child in &mut self.children {
            if let Some(status) = child.try_wait()? {
                let name = child.name().to_owned();
                bail!("{name} ended with {status}\n{}", self.last_words(&name));
            }
        }
        Ok(())
    }

    /// Names and process ids.
    pub fn ids(&self) -> Vec<(String, u32)> {
        self.children
            .iter()
            .map(|child| (child.name().to_owned(), child.id()))
            .collect()
    }

    /// Ends all children in order; returns the names of those that had to be killed.
    pub fn stop(&mut self) -> Vec<String> {
        let killed = children::stop_all(&mut self.children, GRACE);
        self.children.clear();
        killed
    }

    fn log_of(&self, name: &str) -> PathBuf {
        self.logs.join(format!("{name}.log"))
    }

    fn last_words(&self, name: &str) -> String {
        let log = fs::read_to_string(self.log_of(name)).unwrap_or_default();
        let lines: Vec<&str> = log.lines().collect();
        lines[lines.len().saturating_sub(LAST_LINES)..].join("\n")
    }
}

impl Drop for Processes {
    fn drop(&mut self) {
        self.stop();
    }
}
