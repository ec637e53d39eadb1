//! How a replay gives its poses: on standard output or not, at the recorded speed or not.

use crate::output::print_line;
use crate::progress::Progress;
use crate::robot_frame::OutputFrame;
use anyhow::{Context, bail};
use sextant_process::{Exit, Failure, Shutdown};
use sextant_recordings::pose_json;
use sextant_replay::{ReplayError, ReplayObserver, Replayed};
use sextant_site_report::ObjectEstimate;
use std::time::{Duration, Instant};

/// How a replay gives its poses.
pub struct Delivery {
    /// In which frame.
    pub frame: OutputFrame,
    /// At the recorded speed.
    pub is_realtime: bool,
    /// On standard output.
    pub prints: bool,
}

impl Delivery {
    /// Runs a replay of so many images, if that is known, and prints its poses unless they were printed as they came.
    ///
    /// # Errors
    /// [`Exit::Input`] for a recording that cannot be replayed, [`Exit::Interrupted`] while waiting for the recorded
    /// time, and a closed output.
    pub fn deliver(
        self,
        images: Option<u64>,
        replay: impl FnOnce(&mut Deliverer<'_>) -> anyhow::Result<Replayed>,
    ) -> anyhow::Result<Replayed> {
        let mut deliverer = Deliverer {
            pace: self.is_realtime.then(Pace::start).transpose()?,
            prints_at_once: self.is_realtime && self.prints,
            frame: &self.frame,
            progress: images.map(|images| Progress::new(images, "images")),
        };
        let mut replayed = replay(&mut deliverer).map_err(|error| {
            if error.is::<ReplayError>() {
                Failure::new(Exit::Input, error).into()
            } else {
                error
            }
        })?;
        drop(deliverer);
        replayed.poses = replayed
            .poses
            .into_iter()
            .map(|pose| self.frame.transform(pose))
            .collect();
        if self.prints && !self.is_realtime {
            print(&replayed.poses)?;
        }
        Ok(replayed)
    }
}

/// Gives poses while they come.
pub struct Deliverer<'a> {
    frame: &'a OutputFrame,
    pace: Option<Pace>,
    prints_at_once: bool,
    progress: Option<Progress>,
}

impl ReplayObserver for Deliverer<'_> {
    type Error = anyhow::Error;

    fn before(&mut self, now_ns: u64) -> anyhow::Result<()> {
        if let Some(progress) = &mut self.progress {
            progress.step();
        }
        match &mut self.pace {
            Some(pace) => pace.wait_for(now_ns),
            None => Ok(()),
        }
    }

    fn take(&mut self, poses: &[ObjectEstimate]) -> anyhow::Result<()> {
        if self.prints_at_once {
            let poses = poses.iter().map(|pose| self.frame.transform(pose.clone()));
            print(&poses.collect::<Vec<_>>())?;
        }
        Ok(())
    }
}

fn print(poses: &[ObjectEstimate]) -> std::io::Result<()> {
    poses
        .iter()
        .try_for_each(|pose| print_line(&pose_json(pose)))
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
