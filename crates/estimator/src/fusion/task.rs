//! What takes longer than an image may wait: copies of all that they need, which any thread may solve while images go
//! on being fused.

use std::sync::Arc;

use crate::contradictions::search::MistakeSearch;
use crate::self_calibration::AdjustmentTask;

/// A task that is due: [`crate::Fusion::task`] gives it out, [`crate::Input::Adjusted`] applies it.
#[derive(Debug, Clone)]
pub enum SolverTask {
    /// An adjustment of the site's files.
    Adjustment(Arc<AdjustmentTask>),
    /// A search for mistakes in the files or in the room.
    Mistakes(Arc<MistakeSearch>),
}

impl SolverTask {
    /// Whether it has been solved.
    #[must_use]
    pub fn is_solved(&self) -> bool {
        match self {
            Self::Adjustment(task) => task.is_solved(),
            Self::Mistakes(search) => search.is_solved(),
        }
    }

    /// Solves it, which takes up to some tenths of a second; the same task always has the same solution.
    pub fn solve(&self) {
        match self {
            Self::Adjustment(task) => task.solve(),
            Self::Mistakes(search) => search.solve(),
        }
    }

    /// Whether it is the very same task.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Adjustment(one), Self::Adjustment(other)) => Arc::ptr_eq(one, other),
            (Self::Mistakes(one), Self::Mistakes(other)) => Arc::ptr_eq(one, other),
            _ => false,
        }
    }
}
