//! The disk of a fusion node's host: what is on it outlives the process.
//!
//! A job writes one file after another, each whole or not at all, and the record of the version last; a process that
//! ends meanwhile leaves what was written by then.

use node_fusion::{Change, KeepJob, ModelsInForce};
use sextant_proto::ModelsState;

/// The models in the files, and the version that they are of by the record.
#[derive(Debug, Clone)]
pub struct Disk {
    /// In the files.
    pub models: ModelsInForce,
    /// As written last.
    pub record: Option<ModelsState>,
}

impl Disk {
    /// Writes the first `n_written` of the files of a job; with all of them, and the record.
    pub fn write(&mut self, job: &KeepJob, n_written: usize) {
        for change in job.changes.iter().take(n_written) {
            self.apply(change);
        }
        if n_written > job.changes.len() {
            self.record = Some(job.record.clone());
        }
    }

    /// The files that a job writes.
    #[must_use]
    pub fn steps(job: &KeepJob) -> usize {
        job.changes.len() + 1
    }

    fn apply(&mut self, change: &Change) {
        let changed = self.models.changed(std::slice::from_ref(change));
        if let Ok(Some(after)) = changed {
            self.models = after;
        }
    }
}
