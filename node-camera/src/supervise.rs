//! The parent of both parts: starts them, starts again what fails, ends them together.

use std::path::Path;
use std::process::{Command, ExitStatus};
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow};
use sextant_process::children::{ChildProcess, stop_all};
use sextant_process::{Exit, Failure, Shutdown, WithExit, watchdog};

use crate::part::Part;

/// How often the children are looked after.
const LOOK_PERIOD: Duration = Duration::from_millis(100);
/// Before a part is started again: doubled at each failure in a row, up to the second.
const RESTART_DELAYS: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(10)];
/// A part that ran so long did not fail in a row.
const GOOD_RUN: Duration = Duration::from_secs(2);
/// How long the parts may take to end: the network's close is bounded by two seconds.
const GRACE: Duration = Duration::from_secs(3);
/// After a recording's end the last images are still being detected.
const LAST_IMAGES: Duration = Duration::from_millis(500);

/// Runs both parts until `shutdown`, until the capturing part has nothing more to capture, or until one fails in a way
/// that starting it again cannot mend.
///
/// # Errors
/// A part that cannot be started, or that found its configuration wrong.
pub(crate) fn run(config: &Path, subcommand: &[&str], shutdown: &Shutdown) -> anyhow::Result<()> {
    let start = |part| SupervisedPart::start(part, config, subcommand);
    let mut parts = [start(Part::Detect)?, start(Part::Capture)?];
    let outcome = look_after(&mut parts, shutdown);
    let mut children: Vec<_> = parts.into_iter().filter_map(|part| part.child).collect();
    let killed = stop_all(&mut children, GRACE);
    if !killed.is_empty() {
        tracing::warn!(parts = killed.join(", "), "had to be killed");
    }
    outcome
}

fn look_after(parts: &mut [SupervisedPart; 2], shutdown: &Shutdown) -> anyhow::Result<()> {
    while !shutdown.wait(LOOK_PERIOD) {
        watchdog::feed();
        for part in parts.iter_mut() {
            if part.poll()? == ChildOutcome::Finished {
                shutdown.wait(LAST_IMAGES);
                return Ok(());
            }
        }
    }
    Ok(())
}

#[derive(Debug, PartialEq, Eq)]
enum ChildOutcome {
    GoesOn,
    Finished,
}

struct SupervisedPart {
    part: Part,
    command: Command,
    child: Option<ChildProcess>,
    started: Instant,
    delay: Duration,
}

impl SupervisedPart {
    fn start(part: Part, config: &Path, subcommand: &[&str]) -> anyhow::Result<Self> {
        let program = std::env::current_exe().context("where this program lies")?;
        let mut command = Command::new(program);
        command
            .args(subcommand)
            .arg("--config")
            .arg(config)
            .args(["--part", part.name()]);
        let [delay, _] = RESTART_DELAYS;
        let mut supervised = Self {
            part,
            command,
            child: None,
            started: Instant::now(),
            delay,
        };
        supervised.spawn()?;
        Ok(supervised)
    }

    fn spawn(&mut self) -> anyhow::Result<()> {
        let child = ChildProcess::spawn(self.part.name(), &mut self.command);
        self.child = Some(
            child
                .with_context(|| format!("starting the part {}", self.part.name()))
                .exit_with(Exit::Fault)?,
        );
        self.started = Instant::now();
        Ok(())
    }

    fn poll(&mut self) -> anyhow::Result<ChildOutcome> {
        match &mut self.child {
            Some(child) => match child.try_wait()? {
                Some(status) => self.ended(status),
                None => Ok(ChildOutcome::GoesOn),
            },
            None if self.started.elapsed() >= self.delay => {
                self.delay = (self.delay * 2).min(RESTART_DELAYS[1]);
                self.spawn()?;
                Ok(ChildOutcome::GoesOn)
            }
            None => Ok(ChildOutcome::GoesOn),
        }
    }

    fn ended(&mut self, status: ExitStatus) -> anyhow::Result<ChildOutcome> {
        self.child = None;
        if status.success() && self.part == Part::Capture {
            return Ok(ChildOutcome::Finished);
        }
        if let Some(exit) = unmendable(status) {
            // The part has said why, on the same stderr.
            return Err(
                Failure::new(exit, anyhow!("the part {} gives up", self.part.name())).into(),
            );
        }
        if self.started.elapsed() >= GOOD_RUN {
            self.delay = RESTART_DELAYS[0];
        }
        self.started = Instant::now();
        tracing::warn!(part = self.part.name(), %status, again_in = ?self.delay, "ended; starting it again");
        Ok(ChildOutcome::GoesOn)
    }
}

/// Starting again does not mend a wrong file or wrong usage.
fn unmendable(status: ExitStatus) -> Option<Exit> {
    match status.code() {
        Some(code) if code == Exit::Input as i32 => Some(Exit::Input),
        Some(code) if code == Exit::Usage as i32 => Some(Exit::Usage),
        _ => None,
    }
}
