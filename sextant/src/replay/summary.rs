//! A word on what was done, and what of the recording did not count.

use super::table::table;
use serde::Serialize;
use sextant_evaluation::{Alignment, ObjectComparison};
use sextant_replay::{CameraCounts, LiveComparison, Replayed};
use sextant_site_model::{CameraId, ObjectId};

/// What a replay ends with.
#[derive(Debug, Serialize)]
pub struct Summary {
    images: usize,
    cameras: Vec<Camera>,
    objects: Vec<Object>,
    /// What the images show to be wrong with the site, or imperfect in its files, each with the remedy.
    pub notices: Vec<String>,
    /// Of the poses that were published live; none where other models are used than then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub live: Option<LiveComparison>,
    /// Errors against a reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against: Option<(Alignment, Vec<ObjectComparison>)>,
}

#[derive(Debug, Serialize)]
struct Camera {
    id: CameraId,
    images: usize,
    /// Older than the estimator's window when they arrived.
    late: u64,
    /// Captured after their arrival.
    ahead: u64,
    /// Tags of no object.
    unknown_tags: u64,
}

#[derive(Debug, Serialize)]
struct Object {
    id: ObjectId,
    poses: usize,
}

impl Summary {
    /// Counts and findings of a replay.
    pub fn new(replayed: &Replayed) -> Self {
        let notices = replayed.faults.iter().map(ToString::to_string);
        let imperfections = replayed.imperfections.iter().map(ToString::to_string);
        let poses_of = |id: &ObjectId| replayed.poses.iter().filter(|p| p.object == *id).count();
        let objects = replayed.objects.iter().map(|id| Object {
            poses: poses_of(id),
            id: id.clone(),
        });
        let cameras = replayed.cameras.iter();
        let cameras: Vec<Camera> = cameras
            .map(|(camera, counts)| Camera::new(camera, counts))
            .collect();
        Self {
            images: cameras.iter().map(|camera| camera.images).sum(),
            cameras,
            objects: objects.collect(),
            notices: notices.chain(imperfections).collect(),
            live: replayed.live,
            against: None,
        }
    }

    /// The summary as lines, for people.
    pub fn text(&self) -> String {
        let mut lines = vec![format!(
            "{} images of {} cameras",
            self.images,
            self.cameras.len()
        )];
        lines.extend(self.cameras.iter().filter_map(Camera::trouble));
        lines.extend(self.objects.iter().map(|object| match object.poses {
            0 => format!(
                "{}: no pose; are its tags in the pictures, and their family and ids those of its file?",
                object.id
            ),
            poses => format!("{}: {poses} poses", object.id),
        }));
        lines.extend(self.live.filter(|live| live.n_compared() > 0).map(|live| {
            format!(
                "{} of {} poses published live are identical bit for bit",
                live.identical,
                live.n_compared()
            )
        }));
        lines.extend(self.notices.iter().cloned());
        let against = self.against.iter();
        lines.extend(against.map(|(alignment, comparisons)| table(comparisons, *alignment)));
        lines.join("\n")
    }
}

impl Camera {
    fn new(id: &CameraId, counts: &CameraCounts) -> Self {
        Self {
            id: id.clone(),
            images: counts.images,
            late: counts.late,
            ahead: counts.ahead,
            unknown_tags: counts.unknown_tags,
        }
    }

    fn trouble(&self) -> Option<String> {
        let mut troubles = Vec::new();
        if self.late > 0 {
            troubles.push(format!("{} arrived too late to count", self.late));
        }
        if self.ahead > 0 {
            troubles.push(format!(
                "{} were refused: captured long after they arrived, as the recording says",
                self.ahead
            ));
        }
        let said = format!(
            "{}: of {} images {}",
            self.id,
            self.images,
            troubles.join(", ")
        );
        (!troubles.is_empty()).then_some(said)
    }
}
