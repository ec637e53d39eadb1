//! One host, from the first question to the last word.

use crate::desired::Desired;
use crate::error::FleetError;
use crate::facts::HostFacts;
use crate::health::Health;
use crate::packages::PackageFolder;
use crate::plan::Plan;
use crate::ssh::{SSH_FAILED, Ssh, SshError, lines_of, rest_of};
use crate::target::Target;
use serde::Serialize;
use sextant_process::Shutdown;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::terminal::plain;
use sextant_proto::CameraStatus;
use std::io::Write;
use std::path::Path;
use std::process::{ChildStdin, Command};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

const SCRIPT: &str = include_str!("host.sh");
/// Where the host keeps what belongs to deployments.
const BASE: &str = "/var/lib/sextant-deploy";
/// The host waits so much longer for our word than we for its health, s.
const GRACE_S: u64 = 30;
/// Time for a step on the host, such as the installation of a package.
const SILENCE: Duration = Duration::from_secs(600);
/// Lines of logs that are handed on.
const MOST_LOG_LINES: usize = 40;

/// How the deployment on one host ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DeployOutcome {
    /// It has what it shall have, and the site sees it.
    New,
    /// It had everything already.
    Unchanged,
    /// Nothing was done: `--dry-run`.
    Planned,
    /// What was there before is there again.
    RolledBack,
    /// Nothing was changed.
    Untouched,
    /// The host could not be asked; nothing was changed.
    Unreachable,
    /// Neither the former nor the desired state, or unknown.
    Broken,
    /// Interrupted before anything was changed.
    Interrupted,
}

/// What became of a host.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// As ssh takes it.
    pub host: String,
    /// Its camera.
    pub camera: String,
    /// How the deployment on one host ended.
    pub outcome: DeployOutcome,
    /// Version before.
    pub from: Option<String>,
    /// Version wanted.
    pub to: Option<String>,
    /// What was to be done.
    pub changes: Vec<String>,
    /// Why it failed.
    pub cause: Option<String>,
    /// The last lines of the host's log, where it failed.
    pub log: Vec<String>,
    /// What the camera itself complains about.
    pub notices: Vec<String>,
}

/// Learns what a host, by its number, is at.
pub type OnStep<'a> = &'a (dyn Fn(usize, &str) + Sync);

/// What every host is deployed with.
pub struct Deployment<'a> {
    /// The packages.
    pub packages: &'a PackageFolder,
    /// What the site sees; none for a dry run.
    pub health: Option<&'a Health>,
    /// How long the site may take to see a camera after its start.
    pub timeout: Duration,
    /// Learns each step.
    pub on_step: OnStep<'a>,
    /// What a camera complains about in its status.
    pub notices_of: fn(&CameraStatus) -> Vec<String>,
    /// The request to stop.
    pub shutdown: &'a Shutdown,
}

/// One host's part of it.
pub struct HostJob<'a> {
    /// Number of the host.
    pub number: usize,
    /// The host and its camera.
    pub target: &'a Target,
    /// What it shall have.
    pub desired: &'a Desired,
    /// The way to it.
    pub ssh: Ssh,
}

/// What stopped it.
struct Stop {
    outcome: DeployOutcome,
    cause: String,
}

impl From<SshError> for Stop {
    fn from(error: SshError) -> Self {
        let outcome = match error {
            SshError::Unreachable(_) => DeployOutcome::Unreachable,
            SshError::Refused(_) => DeployOutcome::Untouched,
        };
        Self {
            outcome,
            cause: error.to_string(),
        }
    }
}

impl From<FleetError> for Stop {
    fn from(error: FleetError) -> Self {
        Self {
            outcome: DeployOutcome::Untouched,
            cause: error.to_string(),
        }
    }
}

impl From<String> for Stop {
    fn from(cause: String) -> Self {
        Self {
            outcome: DeployOutcome::Untouched,
            cause,
        }
    }
}

impl Deployment<'_> {
    /// Brings one host to what it shall have, or leaves it as it was.
    pub fn run(&self, job: &HostJob<'_>) -> Report {
        let mut report = Report {
            host: job.target.host.clone(),
            camera: job.target.camera.to_string(),
            outcome: DeployOutcome::Untouched,
            from: None,
            to: None,
            changes: Vec::new(),
            cause: None,
            log: Vec::new(),
            notices: Vec::new(),
        };
        match self.steps(job, &mut report) {
            Ok(outcome) => report.outcome = outcome,
            Err(Stop { outcome, cause }) => {
                report.outcome = outcome;
                report.cause.get_or_insert(cause);
            }
        }
        (self.on_step)(job.number, &report.words());
        report
    }

    fn steps(&self, job: &HostJob<'_>, report: &mut Report) -> Result<DeployOutcome, Stop> {
        self.say(job, "looking")?;
        let (camera, keys) = (&job.target.camera, job.desired.keys_place());
        let facts = job.ssh.run(SCRIPT, &format!("look {camera} {keys}"))?;
        let facts = HostFacts::parse(&facts)?;
        let package = self.packages.for_host(&facts)?;
        let plan = Plan::compare(&facts, package, job.desired)?;
        report.from.clone_from(&plan.from);
        report.to = Some(plan.to.clone());
        report.changes.clone_from(&plan.changes);
        if plan.changes.is_empty() {
            return Ok(DeployOutcome::Unchanged);
        }
        if plan.package.is_some() && !facts.is_writable {
            return Err(
                "its root is read-only: remount it, or put the package into its image \
                (deploy/README.md)"
                    .to_owned()
                    .into(),
            );
        }
        let Some(health) = self.health else {
            return Ok(DeployOutcome::Planned);
        };
        self.say(job, "copying")?;
        let folder = job
            .ssh
            .unpack(&archive(&plan, job.desired)?, &format!("{BASE}/{camera}"))?;
        if !folder.starts_with(BASE) {
            let cause = format!(
                "it answers {folder:?} in place of a folder: look at what its login shell prints, and keep \
                 that to terminals (`case $- in *i*) ...`)"
            );
            return Err(cause.into());
        }
        self.say(job, "changing")?;
        self.apply(job, &plan, &folder, health, report)
    }

    /// A new step, unless there is a wish to stop.
    fn say(&self, job: &HostJob<'_>, step: &str) -> Result<(), Stop> {
        if self.shutdown.is_requested() {
            return Err(Stop {
                outcome: DeployOutcome::Interrupted,
                cause: "interrupted; nothing was changed".to_owned(),
            });
        }
        (self.on_step)(job.number, step);
        Ok(())
    }

    /// Lets the host change itself and tells it whether to keep that.
    fn apply(
        &self,
        job: &HostJob<'_>,
        plan: &Plan,
        folder: &str,
        health: &Health,
        report: &mut Report,
    ) -> Result<DeployOutcome, Stop> {
        let (camera, keys) = (&job.target.camera, job.desired.keys_place());
        let wait_s = self.timeout.as_secs() + GRACE_S;
        let command = format!("sh {folder}/host.sh apply {camera} {keys} {folder} {wait_s}");
        let mut child = job.ssh.start(&command)?;
        let (Some(input), Some(output), Some(errors)) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            return Err("ssh has no standard streams".to_owned().into());
        };
        let (sender, lines) = sync_channel(MOST_LOG_LINES);
        let heard = std::thread::scope(|scope| {
            scope.spawn(move || {
                for line in lines_of(output) {
                    if sender.send(line).is_err() {
                        return;
                    }
                }
            });
            let said = scope.spawn(move || rest_of(errors));
            let mut dialogue = Dialogue {
                deployment: self,
                job,
                plan,
                health,
                input: Some(input),
                started: None,
                has_begun: false,
                outcome: None,
            };
            if !dialogue.follow(&lines, report) {
                // Ends the threads that read what it says, too.
                let _ = child.kill();
            }
            drop(lines);
            let said = said.join().unwrap_or_default();
            (dialogue.outcome, dialogue.has_begun, said)
        });
        let status = child.wait().ok().and_then(|status| status.code());
        match heard {
            (Some(outcome), ..) => Ok(outcome),
            (None, has_begun, said) => {
                let cause = job.ssh.error(status, &said);
                let is_cut_off = status.is_none_or(|code| code == SSH_FAILED);
                Err(match has_begun || is_cut_off {
                    true => broken(&cause),
                    false => remove_stage(job, folder, &cause).into(),
                })
            }
        }
    }
}

/// The host ended without a word on how.
fn broken(cause: &SshError) -> Stop {
    Stop {
        outcome: DeployOutcome::Broken,
        cause: format!(
            "{cause}; the host restores its former state unless it had been told to keep the new one: \
             run this command again to see"
        ),
    }
}

/// Nothing was started on the host: what was copied, keys among it, is not left there. Why, in words.
fn remove_stage(job: &HostJob<'_>, folder: &str, cause: &SshError) -> String {
    match job.ssh.run("rm -rf -- \"$1\"", folder) {
        Ok(_) => cause.to_string(),
        Err(left) => format!("{cause}; {folder} with its keys is still there ({left})"),
    }
}

/// What host and we say while it changes itself.
struct Dialogue<'a> {
    deployment: &'a Deployment<'a>,
    job: &'a HostJob<'a>,
    plan: &'a Plan,
    health: &'a Health,
    /// Closed: the host is to bring back what it had.
    input: Option<ChildStdin>,
    /// When the new program was started.
    started: Option<Instant>,
    /// Whether the host has said anything of what it does.
    has_begun: bool,
    outcome: Option<DeployOutcome>,
}

impl Dialogue<'_> {
    /// Whether the host came to its end; a host that says nothing for too long is given up.
    fn follow(&mut self, lines: &Receiver<String>, report: &mut Report) -> bool {
        let patience = self.deployment.timeout + Duration::from_secs(GRACE_S) + SILENCE;
        let mut heard = Instant::now();
        while heard.elapsed() < patience {
            match lines.recv_timeout(SHUTDOWN_POLL) {
                Ok(line) => {
                    heard = Instant::now();
                    self.hear(&line, report);
                }
                Err(RecvTimeoutError::Timeout) => self.decide(report),
                Err(RecvTimeoutError::Disconnected) => return true,
            }
        }
        report.cause.get_or_insert_with(|| {
            format!("the host has said nothing for {} s", patience.as_secs())
        });
        false
    }

    fn hear(&mut self, line: &str, report: &mut Report) {
        let line = plain(line);
        let (word, rest) = line.split_once(' ').unwrap_or((&line, ""));
        self.has_begun |= matches!(word, "step" | "cause" | "outcome");
        match word {
            "step" => {
                if rest == "waiting" {
                    self.started = Some(Instant::now());
                }
                (self.deployment.on_step)(self.job.number, rest);
            }
            "cause" => drop(report.cause.get_or_insert_with(|| rest.to_owned())),
            "log" if report.log.len() < MOST_LOG_LINES => report.log.push(rest.to_owned()),
            "outcome" => {
                self.outcome = Some(match rest {
                    "new" => DeployOutcome::New,
                    "former" => DeployOutcome::RolledBack,
                    "untouched" => DeployOutcome::Untouched,
                    _ => DeployOutcome::Broken,
                });
            }
            _ => {}
        }
    }

    /// Whether the host is to keep what it has now.
    fn decide(&mut self, report: &mut Report) {
        if self.input.is_none() {
            return;
        }
        let Deployment {
            shutdown, timeout, ..
        } = self.deployment;
        if shutdown.is_requested() {
            self.undo(report, "interrupted".to_owned());
            return;
        }
        let Some(started) = self.started else { return };
        match self.health.after(&self.job.target.camera, started) {
            Some(status) if status.version == self.plan.program_version => {
                report.notices = (self.deployment.notices_of)(&status);
                if let Some(mut input) = self.input.take() {
                    // A lost connection is heard of as the end of what the host says.
                    let _ = input.write_all(b"keep\n");
                }
            }
            seen if started.elapsed() >= *timeout => {
                let cause = match seen {
                    Some(status) => format!(
                        "the site sees version {} of it, not {}",
                        status.version, self.plan.program_version
                    ),
                    None => format!(
                        "the site did not see its camera within {} s",
                        timeout.as_secs()
                    ),
                };
                self.undo(report, cause);
            }
            _ => {}
        }
    }

    fn undo(&mut self, report: &mut Report, cause: String) {
        report.cause.get_or_insert(cause);
        self.input = None;
    }
}

/// What the host unpacks: the script, the configuration, the keys, the package.
fn archive(plan: &Plan, desired: &Desired) -> Result<Vec<u8>, FleetError> {
    let folder = tempfile::tempdir().map_err(FleetError::system(&std::env::temp_dir()))?;
    let folder = folder.path();
    let write = |name: &str, content: &[u8]| {
        let path = folder.join(name);
        std::fs::write(&path, content).map_err(FleetError::system(&path))
    };
    write("host.sh", SCRIPT.as_bytes())?;
    desired.write(folder)?;
    if let Some(package) = &plan.package {
        std::fs::copy(&package.file, folder.join(package.staged_name()))
            .map_err(FleetError::system(&package.file))?;
        write("package.sha256", package.digest.as_bytes())?;
    }
    let output = Command::new("tar")
        .args([
            "--create",
            "--owner=0",
            "--group=0",
            "--numeric-owner",
            "--directory",
        ])
        .arg(folder)
        .arg(".")
        .output()
        .map_err(FleetError::system(Path::new("tar")))?;
    if !output.status.success() {
        let cause = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(FleetError::Archive(cause));
    }
    Ok(output.stdout)
}

impl Report {
    /// The outcome in one line, with versions, changes or the cause.
    pub fn words(&self) -> String {
        let changes = self.changes.join(", ");
        let to = self.to.as_deref().unwrap_or("?");
        let cause = self.cause.as_deref().unwrap_or("");
        match self.outcome {
            DeployOutcome::New => format!("healthy, version {to} ({changes})"),
            DeployOutcome::Unchanged => format!("nothing to do, version {to}"),
            DeployOutcome::Planned => format!("would {changes}"),
            DeployOutcome::RolledBack => format!("failed and rolled back: {cause}"),
            DeployOutcome::Untouched => format!("failed, nothing was changed: {cause}"),
            DeployOutcome::Unreachable => format!("not reached: {cause}"),
            DeployOutcome::Broken => format!("FAILED: {cause}"),
            DeployOutcome::Interrupted => cause.to_owned(),
        }
    }
}
