//! Messages of fusion nodes in words, for a trace.

use crate::host::true_ns;
use crate::scene::Scene;
use node_fusion::Put;
use sextant_proto::{ClockReport, ConfigAnswer, FusionStatus, ObjectPose, decode};

/// A message, published from a rig of this world; none of those that come too often to be read.
#[must_use]
pub fn described(put: &Put, scene: &Scene, world: i32) -> Option<String> {
    let payload = &put.payload;
    if let Ok(pose) = decode(payload) {
        return Some(pose_in_words(&pose, scene, world));
    }
    if let Ok(ConfigAnswer { key, outcome, .. }) = decode(payload) {
        return Some(format!("answers {key}: {outcome:?}"));
    }
    if let Ok(status) = decode::<FusionStatus>(payload) {
        let faults = status.faults.iter().map(|fault| format!("{fault:?}"));
        let notices = status.notices.iter().map(ToString::to_string);
        let all: Vec<String> = faults.chain(notices).collect();
        return Some(format!("status: {}", all.join("; ")));
    }
    let report: ClockReport = decode(payload).ok()?;
    let clocks = report.cameras.iter().map(|clock| {
        let (offset_ms, sigma_ms) = (clock.offset_s * 1e3, clock.sigma_s * 1e3);
        format!("{} {offset_ms:.1} +- {sigma_ms:.2}", clock.camera)
    });
    let clocks: Vec<String> = clocks.collect();
    Some(format!("clocks, ms: {}", clocks.join(", ")))
}

fn pose_in_words(pose: &ObjectPose, scene: &Scene, world: i32) -> String {
    let variance: f64 = [0, 7, 14].iter().map(|at| pose.covariance[*at]).sum();
    let (error_m, _) = scene.error(pose, world, &[true_ns(pose.capture_ns)]);
    format!(
        "{} {:?} off by {:.1} mm, within {:.1} mm by {} cameras and {} tags",
        pose.object,
        pose.state,
        error_m * 1e3,
        variance.sqrt() * 1e3,
        pose.cameras,
        pose.tags
    )
}
