//! Images through the estimator, and which of its poses are final.

use super::ledger::Ledger;
use crate::output::print_line;
use anyhow::{Context, bail};
use sextant_estimator::{Fusion, Input, Output};
use sextant_process::{Exit, Failure, Shutdown};
use sextant_recordings::pose_json;
use sextant_site_report::ObjectEstimate;
use std::time::{Duration, Instant};

/// One pass of a recording through the estimator.
pub struct Pass {
    /// The estimator; replaced where the recorded node was restarted.
    pub fusion: Fusion,
    ledger: Ledger,
    pace: Option<Pace>,
    prints: bool,
    poses: Vec<ObjectEstimate>,
}

/// How a pass gives its poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Delivery {
    /// At the recorded speed.
    pub is_realtime: bool,
    /// On standard output.
    pub prints: bool,
}

impl Pass {
    /// A pass of images of these capture times.
    ///
    /// # Errors
    /// When signals cannot be caught.
    pub fn new(
        fusion: Fusion,
        capture_times_ns: impl Iterator<Item = u64>,
        delivery: Delivery,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            fusion,
            ledger: Ledger::of(capture_times_ns),
            pace: delivery.is_realtime.then(Pace::start).transpose()?,
            prints: delivery.prints,
            poses: Vec::new(),
        })
    }

    /// Takes an input in; every pose that the estimator gives after it, final or not.
    ///
    /// # Errors
    /// [`Exit::Interrupted`] while waiting for the recorded time, and a closed output.
    pub fn take(&mut self, now_ns: u64, input: Input) -> anyhow::Result<Vec<ObjectEstimate>> {
        if let Some(pace) = &mut self.pace {
            pace.wait_for(now_ns)?;
        }
        let capture_ns = match &input {
            Input::Image(image) => Some(image.capture_ns),
            _ => None,
        };
        self.fusion.handle(now_ns, input);
        let outputs = std::iter::from_fn(|| self.fusion.poll_output());
        let estimates: Vec<_> = outputs.filter_map(pose_of).collect();
        if let Some(capture_ns) = capture_ns {
            let finals = self.ledger.took(capture_ns, estimates.iter().cloned());
            if self.pace.is_some() && self.prints {
                print(&finals)?;
            }
            self.poses.extend(finals);
        }
        Ok(estimates)
    }

    /// The final poses, sorted by time and object; printed unless they were printed as they came.
    ///
    /// # Errors
    /// A closed output.
    pub fn finish(mut self) -> anyhow::Result<(Vec<ObjectEstimate>, Fusion)> {
        self.poses
            .sort_by(|a, b| (a.capture_ns, &a.object).cmp(&(b.capture_ns, &b.object)));
        if self.pace.is_none() && self.prints {
            print(&self.poses)?;
        }
        Ok((self.poses, self.fusion))
    }
}

fn print(poses: &[ObjectEstimate]) -> std::io::Result<()> {
    poses
        .iter()
        .try_for_each(|pose| print_line(&pose_json(pose)))
}

fn pose_of(output: Output) -> Option<ObjectEstimate> {
    match output {
        Output::Pose(estimate) => Some(estimate),
        Output::Refused(_) | Output::ClockStep { .. } => None,
    }
}

/// Replay at the recorded speed.
struct Pace {
    shutdown: Shutdown,
    start: Option<(Instant, u64)>,
}

impl Pace {
    fn start() -> anyhow::Result<Self> {
        let shutdown = Shutdown::install().context("signals cannot be caught")?;
        Ok(Self {
            shutdown,
            start: None,
        })
    }

    fn wait_for(&mut self, arrival_ns: u64) -> anyhow::Result<()> {
        let (start, first_ns) = *self.start.get_or_insert((Instant::now(), arrival_ns));
        let due = start + Duration::from_nanos(arrival_ns.saturating_sub(first_ns));
        if self
            .shutdown
            .wait(due.saturating_duration_since(Instant::now()))
        {
            let cause = anyhow::anyhow!("interrupted");
            bail!(Failure::new(Exit::Interrupted, cause));
        }
        Ok(())
    }
}
