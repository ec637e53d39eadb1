//! How far a procedure is, as a person is shown it.

use super::ProcedureKind;
use crate::lens::{COLUMNS, Hint, LensProgress};
use crate::{CameraProgress, DiscoveredTags, LearnProgress, RigProgress, SketchedTag, TagProgress};
use serde::Serialize;

/// How far a procedure is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// Which procedure.
    pub kind: ProcedureKind,
    /// Number of images received.
    pub images: usize,
    /// Progress from 0 to 1; 1 is enough.
    pub fraction: f64,
    /// Whether it is time to solve. Solving may be tried before.
    pub is_enough: bool,
    /// Instruction for the next step, without a full stop.
    pub hint: String,
    /// What this procedure alone has to show.
    pub details: ProgressDetails,
}

/// Details of one kind of procedure; [`Progress::kind`] says which.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ProgressDetails {
    /// Of a lens.
    Lens(LensDetails),
    /// Of a rig.
    Rig(RigDetails),
    /// Of an object.
    Learn(LearnDetails),
}

/// Where the board has been.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LensDetails {
    /// Images kept.
    pub views: usize,
    /// Corners in each cell of the picture, row by row from the top left.
    pub coverage: Vec<[u32; COLUMNS]>,
    /// Views in which the board's left, right, upper and lower side was turned away.
    pub tilted: [u32; 4],
}

/// Coverage of each camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RigDetails {
    /// Every camera of the rig.
    pub cameras: Vec<CameraProgress>,
    /// Number of common views of each pair of cameras.
    pub together: Vec<(String, String, usize)>,
}

/// What has been seen of the object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearnDetails {
    /// Images with at least two tags: only those join tags.
    pub joining: usize,
    /// Every wanted tag.
    pub tags: Vec<TagProgress>,
    /// Approximate poses of the largest group of connected tags, for display.
    pub sketch: Vec<SketchedTag>,
    /// Roles of the discovered tags, where none were named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<DiscoveredTags>,
}

impl Progress {
    pub(super) fn of_lens(progress: &LensProgress) -> Self {
        Self {
            kind: ProcedureKind::Lens,
            images: progress.images,
            fraction: progress.fraction,
            is_enough: progress.hint == Hint::Enough,
            hint: progress.hint.to_string(),
            details: ProgressDetails::Lens(LensDetails {
                views: progress.views,
                coverage: progress.coverage.to_vec(),
                tilted: progress.tilted,
            }),
        }
    }

    pub(super) fn of_rig(progress: RigProgress) -> Self {
        Self {
            kind: ProcedureKind::Rig,
            images: progress.images,
            fraction: progress.complete,
            is_enough: progress.complete >= 1.0,
            hint: progress.hint,
            details: ProgressDetails::Rig(RigDetails {
                cameras: progress.cameras,
                together: progress.together,
            }),
        }
    }

    pub(super) fn of_learn(progress: LearnProgress, sketch: Vec<SketchedTag>) -> Self {
        Self {
            kind: ProcedureKind::Learn,
            images: progress.images,
            fraction: progress.complete,
            is_enough: progress.complete >= 1.0,
            hint: progress.hint,
            details: ProgressDetails::Learn(LearnDetails {
                joining: progress.joining,
                tags: progress.tags,
                sketch,
                found: None,
            }),
        }
    }

    pub(super) fn with(mut self, found: DiscoveredTags) -> Self {
        if let ProgressDetails::Learn(details) = &mut self.details {
            details.found = Some(found);
        }
        self
    }
}
