//! Adjustments of the site's files, solved by a thread of their own: no image waits for them.

use anyhow::Context;
use sextant_estimator::SolverTask;
use sextant_process::{background, fail_point};
use std::sync::mpsc::{SyncSender, sync_channel};

/// Hands adjustments to the thread, one at a time.
#[derive(Debug)]
pub struct Adjuster {
    tasks: SyncSender<SolverTask>,
    /// The last one handed over.
    given: Option<SolverTask>,
}

impl Adjuster {
    /// Starts the thread, which ends with this value.
    ///
    /// # Errors
    /// Where the machine has no thread left.
    pub fn start() -> anyhow::Result<Self> {
        let (tasks, waiting) = sync_channel::<SolverTask>(1);
        let solve = move || {
            if let Err(error) = background::lower_this_thread() {
                tracing::debug!("adjustments compete with images for the processor: {error}");
            }
            fail_point!("adjuster");
            waiting.iter().for_each(|task| task.solve());
        };
        let thread = std::thread::Builder::new().name("adjuster".to_owned());
        thread.spawn(solve).context("no thread for adjustments")?;
        Ok(Self { tasks, given: None })
    }

    /// Has a task solved; one that has been handed over already is not solved again.
    pub fn solve(&mut self, task: &SolverTask) {
        let is_given = |given: &SolverTask| given.is_same(task);
        if !self.given.as_ref().is_some_and(is_given) && self.tasks.try_send(task.clone()).is_ok() {
            self.given = Some(task.clone());
        }
    }
}
