//! A word on what was done, and what of the recording did not count.

use serde::Serialize;
use sextant_estimator::{CameraId, Fusion, ObjectEstimate, ObjectId, ObjectModel, Statistics};
use sextant_recordings::{CameraRecording, Dataset};

/// What a replay ends with.
#[derive(Debug, Serialize)]
pub struct Summary {
    images: usize,
    cameras: Vec<Camera>,
    objects: Vec<Object>,
    /// What the images show to be wrong with the site, or imperfect in its files, each with the remedy.
    notices: Vec<String>,
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
    /// Of a recording, its objects, their poses, and the estimator's counts.
    pub fn of(
        dataset: &Dataset,
        objects: &[ObjectModel],
        poses: &[ObjectEstimate],
        fusion: &Fusion,
    ) -> Self {
        let statistics = fusion.statistics();
        let faults = fusion.faults();
        let notices = faults.iter().map(ToString::to_string);
        let imperfections = fusion.imperfections().iter().map(ToString::to_string);
        let objects = objects.iter().map(|object| Object {
            id: object.id().clone(),
            poses: poses.iter().filter(|p| p.object == *object.id()).count(),
        });
        let cameras: Vec<Camera> = dataset
            .cameras()
            .iter()
            .map(|camera| Camera::of(camera, statistics))
            .collect();
        Self {
            images: cameras.iter().map(|camera| camera.images).sum(),
            cameras,
            objects: objects.collect(),
            notices: notices.chain(imperfections).collect(),
        }
    }

    /// For people.
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
        lines.extend(self.notices.iter().cloned());
        lines.join("\n")
    }
}

impl Camera {
    fn of(recording: &CameraRecording, statistics: &Statistics) -> Self {
        let id = recording.camera.clone();
        let counts = statistics.cameras.get(&id).copied().unwrap_or_default();
        Self {
            id,
            images: recording.rows.len(),
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
