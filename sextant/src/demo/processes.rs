//! The demo's child processes: the nodes of a site, run by this binary.

use crate::demo::site_folder::SiteFolder;
use anyhow::{Context, bail};
use sextant_process::children::{self, ChildProcess};
use std::fs::{self, File};
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
    /// Starts every node of the site.
    pub fn start(folder: &SiteFolder) -> anyhow::Result<Self> {
        let mut all = Self {
            children: Vec::new(),
            logs: folder.logs().to_owned(),
        };
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

    fn start_node(
        &mut self,
        name: &str,
        arguments: &[&str],
        config: &std::path::Path,
    ) -> anyhow::Result<()> {
        let program =
            std::env::current_exe().context("this program's own file is not to be found")?;
        let log = File::create(self.log_of(name)).context("a log file can't be made")?;
        let mut command = Command::new(program);
        // In a process group of its own: Ctrl-C reaches only the parent, which then ends the children in order.
        command.args(arguments).arg(config).process_group(0);
        command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(log);
        let child = ChildProcess::spawn(name, &mut command)
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
