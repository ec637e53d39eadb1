//! Writes the models to their files in a thread of its own: no image waits for a disk.

use crate::files::ModelFiles;
use crate::replica::KeepJob;
use anyhow::Context;
use sextant_process::fail_point;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

/// Hands jobs to the thread, one at a time.
#[derive(Debug)]
pub struct Storer {
    /// None once the thread is to end.
    jobs: Option<SyncSender<KeepJob>>,
    outcomes: Receiver<Result<(), String>>,
    thread: Option<JoinHandle<()>>,
}

impl Storer {
    /// Starts the thread, which ends with this value after the job at hand.
    ///
    /// # Errors
    /// Where the machine has no thread left.
    pub fn start(mut files: ModelFiles) -> anyhow::Result<Self> {
        let (jobs, waiting) = sync_channel::<KeepJob>(1);
        let (done, outcomes) = sync_channel(1);
        let write = move || {
            for job in waiting {
                fail_point!("storer");
                let kept = files.keep_all(&job);
                if done
                    .send(kept.map_err(|cause| format!("{cause:#}")))
                    .is_err()
                {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().name("storer".to_owned());
        let thread = thread.spawn(write).context("no thread for writing files")?;
        Ok(Self {
            jobs: Some(jobs),
            outcomes,
            thread: Some(thread),
        })
    }

    /// Has changes written. The outcome of the job before has been polled.
    pub fn keep(&self, job: KeepJob) {
        if let Some(jobs) = &self.jobs {
            // The thread ends after this value only.
            let _ = jobs.try_send(job);
        }
    }

    /// What became of the last job, once it is done.
    pub fn poll(&self) -> Option<Result<(), String>> {
        self.outcomes.try_recv().ok()
    }
}

impl Drop for Storer {
    /// Waits for the job at hand: a node that is asked to end leaves no half of a change behind.
    fn drop(&mut self) {
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
