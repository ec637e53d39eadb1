//! Motion blur: the instants of an exposure at which the objects are drawn.

use super::Scene;
use crate::model::SolidModel;

/// Objects move at most this far between two instants, px.
const STEP_PX: f64 = 0.5;
/// The most instants in an image.
const MAX_INSTANTS: u64 = 32;

/// Instants evenly spread over an exposure; their mean is its middle.
pub(super) struct Instants {
    start_ns: u64,
    exposure_ns: u64,
    count: u64,
}

impl Instants {
    pub fn iter(&self) -> impl Iterator<Item = u64> + use<> {
        let Self {
            start_ns,
            exposure_ns,
            count,
        } = *self;
        (0..count).map(move |i| start_ns + exposure_ns * (2 * i + 1) / (2 * count))
    }

    /// The share of the light of each instant.
    pub fn weight(&self) -> f64 {
        1.0 / self.count as f64
    }
}

/// As many instants as the fastest point in the image needs.
pub(super) fn instants(scene: &Scene, true_capture_ns: u64) -> Instants {
    let exposure_ns = scene.camera.exposure_ns;
    let start_ns = true_capture_ns.saturating_sub(exposure_ns / 2);
    let ways = scene
        .model
        .solids
        .iter()
        .map(|solid| way_px(scene, solid, start_ns));
    let longest = ways.fold(0.0, f64::max);
    Instants {
        start_ns,
        exposure_ns,
        count: ((longest / STEP_PX).ceil() as u64).clamp(1, MAX_INSTANTS),
    }
}

/// How far the corners of a solid move in the image over the exposure.
fn way_px(scene: &Scene, solid: &SolidModel, start_ns: u64) -> f64 {
    let path = &scene.model.paths[solid.object];
    let pose_at = |true_ns| scene.camera_from_world * path.world_from_object(true_ns);
    let (start, end) = (
        pose_at(start_ns),
        pose_at(start_ns + scene.camera.exposure_ns),
    );
    let lens = &scene.camera.lens;
    let ways = solid.vertices.iter().filter_map(|vertex| {
        let (from, to) = (
            lens.project(&(start * vertex))?,
            lens.project(&(end * vertex))?,
        );
        Some((to - from).norm())
    });
    ways.fold(0.0, f64::max)
}
