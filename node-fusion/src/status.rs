//! What a fusion node says about itself once a second: what came in, what was dropped and why, how the objects fare.

use crate::intake::Intake;
use sextant_estimator::{ObjectEstimate, ObjectId, ObjectModel, State, Statistics};
use sextant_proto::{CameraIntake, FusionStatus, NodeId, ObjectHealth};
use std::collections::BTreeMap;

/// Collects between two statuses.
#[derive(Debug)]
pub struct StatusBook {
    node: NodeId,
    started_ns: u64,
    last_ns: u64,
    objects: BTreeMap<ObjectId, ObjectCount>,
}

#[derive(Debug, Clone, Copy)]
struct ObjectCount {
    state: State,
    poses: u64,
}

impl StatusBook {
    /// A book that begins at `now_ns`; every object is lost until it is seen.
    #[must_use]
    pub fn new(node: NodeId, objects: &[ObjectModel], now_ns: u64) -> Self {
        let unseen = ObjectCount {
            state: State::Lost,
            poses: 0,
        };
        let objects = objects
            .iter()
            .map(|object| (object.id().clone(), unseen))
            .collect();
        Self {
            node,
            started_ns: now_ns,
            last_ns: now_ns,
            objects,
        }
    }

    /// Counts a pose that was published.
    pub fn count(&mut self, estimate: &ObjectEstimate) {
        if let Some(object) = self.objects.get_mut(&estimate.object) {
            object.state = estimate.state;
            object.poses += 1;
        }
    }

    /// The status at `now_ns`; rates are over the time since the last one.
    pub fn status(
        &mut self,
        intake: &mut Intake,
        statistics: &Statistics,
        now_ns: u64,
    ) -> FusionStatus {
        let elapsed_s = now_ns.saturating_sub(self.last_ns) as f64 / 1e9;
        self.last_ns = now_ns;
        let cameras = intake
            .cameras(elapsed_s)
            .into_iter()
            .map(|camera| with_statistics(camera, statistics))
            .collect();
        FusionStatus {
            node: self.node.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            uptime_s: now_ns.saturating_sub(self.started_ns) / 1_000_000_000,
            cameras,
            foreign: intake.foreign(),
            objects: self
                .objects
                .iter_mut()
                .map(|(id, object)| object.health(id, elapsed_s))
                .collect(),
            faults: Vec::new(),
        }
    }
}

impl ObjectCount {
    fn health(&mut self, id: &ObjectId, elapsed_s: f64) -> ObjectHealth {
        let poses = std::mem::take(&mut self.poses);
        let rate_hz = if elapsed_s > 0.0 {
            (poses as f64 / elapsed_s) as f32
        } else {
            0.0
        };
        ObjectHealth {
            object: id.clone(),
            state: self.state,
            rate_hz,
        }
    }
}

/// What the estimator counted of a camera joins what the intake counted.
fn with_statistics(mut camera: CameraIntake, statistics: &Statistics) -> CameraIntake {
    if let Some(counts) = statistics.cameras.get(&camera.camera) {
        camera.unknown_tags = counts.unknown_tags;
        camera.late = counts.late;
        camera.gated = counts.gated_tags;
        camera.last_capture_ns = counts.last_capture_ns;
    }
    camera
}
