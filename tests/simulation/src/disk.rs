//! The disk of a fusion node's host: what is on it outlives the process.
//!
//! A job writes its journal, one file after another, each whole or not at all, and the record of the version last; a
//! process that ends meanwhile leaves what was written by then, and the next one completes what the journal says.

use node_fusion::{Change, KeepJob, ModelsInForce, ModelsRecord};

/// The models in the files, and the version that they are of by the record.
#[derive(Debug, Clone)]
pub struct Disk {
    /// In the files.
    pub models: ModelsInForce,
    /// As written last.
    pub record: Option<ModelsRecord>,
    /// A change that was interrupted.
    pub journal: Option<KeepJob>,
}

impl Disk {
    /// Writes the first `n_written` of the files of a job, the journal being the first; with all of them, the record
    /// too.
    pub fn write(&mut self, job: &KeepJob, n_written: usize) {
        for change in job.changes.iter().take(n_written.saturating_sub(1)) {
            self.apply(change);
        }
        let is_whole = n_written >= Self::steps(job);
        if is_whole {
            self.record = Some(job.record.clone());
        }
        self.journal = (n_written > 0 && !is_whole).then(|| job.clone());
    }

    /// A process starts.
    pub fn complete_interrupted(&mut self) {
        if let Some(job) = self.journal.take() {
            self.write(&job, Self::steps(&job));
        }
    }

    /// The files that a job writes.
    #[must_use]
    pub fn steps(job: &KeepJob) -> usize {
        job.changes.len() + 2
    }

    fn apply(&mut self, change: &Change) {
        let changed = self.models.changed(std::slice::from_ref(change));
        if let Ok(Some(after)) = changed {
            self.models = after;
        }
    }
}
