//! Verdict on a calibrated rig.

use super::RigSession;
use super::former::circles;
use super::report::{CalibratedCamera, RigSolution};
use crate::verdict::{Finding, Grade, ScaleSource, Verdict, WeakMotion};
use nalgebra::Vector3;
use sextant_adjustment::{KeptParameter, WeakDirection};
use std::collections::BTreeMap;

/// Standard deviations below which a camera is well placed (metres, radians); five times as much is usable.
const WELL_PLACED: (f64, f64) = (0.001, 0.0006);
const OF_USE: f64 = 5.0;
/// Largest harmless relative difference of a size.
const HARMLESS_SIZE: f64 = 0.004;

impl RigSession {
    pub(super) fn weak(&self, found: &RigSolution) -> Vec<Finding> {
        let mut weak: Vec<Finding> = Vec::new();
        for direction in &found.adjusted.solution.weak {
            if let Some(finding) = self
                .weak_camera(found, direction)
                .filter(|finding| !weak.contains(finding))
            {
                weak.push(finding);
            }
        }
        weak
    }

    /// A weak direction as the motion of the camera that moves most.
    fn weak_camera(&self, found: &RigSolution, direction: &WeakDirection) -> Option<Finding> {
        let camera = direction.made_of.iter().find_map(|(p, _)| match *p {
            KeptParameter::CameraPosition { camera, .. }
            | KeptParameter::CameraRotation { camera, .. } => Some(camera),
            KeptParameter::Clock { camera } => Some(camera),
            _ => None,
        })?;
        let (mut moves, mut turns, mut clock) = (Vector3::zeros(), Vector3::zeros(), 0.0_f64);
        for (parameter, share) in &direction.made_of {
            match *parameter {
                KeptParameter::CameraPosition { camera: c, axis } if c == camera => {
                    moves[axis] = *share
                }
                KeptParameter::CameraRotation { camera: c, axis } if c == camera => {
                    turns[axis] = *share
                }
                KeptParameter::Clock { camera: c } if c == camera => clock = *share,
                _ => {}
            }
        }
        let id = &self.images.rig.cameras()[camera].id;
        let solved = &found.adjusted.solution.bundle.cameras[camera];
        let along = |v: Vector3<f64>| {
            let in_camera = solved.world_from_camera.inverse_transform_vector(&v);
            in_camera.z.abs() > 0.8 * in_camera.norm()
        };
        let motion = if clock.abs() > moves.norm().max(turns.norm()) {
            WeakMotion::Clock
        } else if turns.norm() > moves.norm() && along(turns) {
            WeakMotion::Roll
        } else if turns.norm() > moves.norm() {
            WeakMotion::Tilt
        } else if along(moves) {
            WeakMotion::Along
        } else {
            WeakMotion::Across
        };
        let camera = id.clone();
        Some(Finding::WeakCamera { camera, motion })
    }

    pub(super) fn verdict(
        &self,
        found: &RigSolution,
        cameras: &[CalibratedCamera],
        left_out: &[(String, usize, usize)],
        weak: &[Finding],
    ) -> Verdict {
        let mut verdict = Verdict::new();
        if let Some(finding) = self.images.stored.thinned() {
            verdict.add(Grade::Good, finding);
        }
        for finding in weak {
            verdict.add(Grade::Poor, finding.clone());
        }
        for cause in &found.sightings.unplaced {
            verdict.add(Grade::Usable, Finding::Unplaced(cause.clone()));
        }
        judge_deviations(cameras, &mut verdict);
        for camera in cameras {
            if let (Some(ms), Some(sigma_ms)) = (camera.clock_offset_ms, camera.clock_sigma_ms)
                && found.synchronised
            {
                let camera = camera.camera.clone();
                verdict.add(
                    Grade::Usable,
                    Finding::ClockOffset {
                        camera,
                        ms,
                        sigma_ms,
                    },
                );
            }
        }
        for (tag, seen, out) in left_out {
            let (tag, seen) = (tag.clone(), *seen);
            let fits = seen - seen.min(*out);
            verdict.add(Grade::Usable, Finding::RarelyFits { tag, fits, seen });
        }
        for (&tag, &images) in self.images.doubled() {
            verdict.add(Grade::Usable, Finding::Duplicated { tag, images });
        }
        self.judge_sizes(found, &mut verdict);
        self.judge_former(found, &mut verdict);
        verdict
    }

    /// Reports sizes that differ from the given ones, which the adjustment has corrected.
    fn judge_sizes(&self, found: &RigSolution, verdict: &mut Verdict) {
        let solution = &found.adjusted.solution;
        let mut wrong: BTreeMap<(i64, ScaleSource), Vec<String>> = BTreeMap::new();
        for (at, wanted) in self.images.wanted.iter().enumerate() {
            let sigma = solution
                .covariance
                .sigma(KeptParameter::TagSize { tag: at });
            let off = solution.bundle.tags[at].size_m / wanted.size_m - 1.0;
            if sigma.is_some_and(|s| off.abs() > HARMLESS_SIZE && off.abs() > 5.0 * s) {
                let scale = if at >= self.n_carried() {
                    ScaleSource::Object
                } else if found.sightings.seeking_tags {
                    ScaleSource::OtherTags
                } else {
                    ScaleSource::Spacing
                };
                let per_mille = (off * 1e3).round() as i64;
                wrong
                    .entry((per_mille, scale))
                    .or_default()
                    .push(wanted.tag.to_string());
            }
        }
        for ((per_mille, scale), tags) in wrong {
            let ratio = 1.0 + per_mille as f64 / 1e3;
            verdict.add(Grade::Usable, Finding::SizesDiffer { tags, ratio, scale });
        }
    }

    /// Source of the scale, as text.
    pub(super) fn scale(&self, found: &RigSolution) -> String {
        let object = self.plan.object.id();
        if self.still_tags_with_size(&found.sightings.views).is_empty() {
            return format!(
                "all lengths depend on the given sizes of {object}; an error common to all of them cannot be detected"
            );
        }
        format!("the given sizes of {object} and of the tags that lie still were compared")
    }

    /// Reports by what the solved rig differs from the former one as a whole.
    fn judge_former(&self, found: &RigSolution, verdict: &mut Verdict) {
        let Some(former) = &found.former else { return };
        for cameras in circles(&self.images.rig, &former.order) {
            verdict.add(Grade::Poor, Finding::ExchangedNames(cameras));
        }
        if let Some(scale) = former.scale {
            let object = self.plan.object.id().clone();
            let (ratio, sigma) = (scale.ratio, scale.sigma);
            let (grade, finding) = match scale.is_of_object {
                true => (
                    Grade::Usable,
                    Finding::PrintedAtScale {
                        object,
                        ratio,
                        sigma,
                    },
                ),
                false => (Grade::Poor, Finding::RigScaled { object, ratio }),
            };
            verdict.add(grade, finding);
        }
        if let Some(turn_rad) = former.turn_rad {
            let reference =
                &self.images.rig.cameras()[self.plan.origin.reference(&self.images.rig)];
            let (reference, deg) = (reference.id.clone(), turn_rad.to_degrees());
            verdict.add(Grade::Usable, Finding::RigTurned { reference, deg });
        }
    }
}

fn judge_deviations(cameras: &[CalibratedCamera], verdict: &mut Verdict) {
    let (well_mm, well_deg) = (WELL_PLACED.0 * 1e3, WELL_PLACED.1.to_degrees());
    let excess = |c: &CalibratedCamera| (c.sigma_mm / well_mm).max(c.sigma_deg / well_deg);
    for (grade, above, below) in [
        (Grade::Poor, OF_USE, f64::INFINITY),
        (Grade::Usable, 1.0, OF_USE),
    ] {
        let vague = cameras
            .iter()
            .filter(|c| excess(c) > above && excess(c) <= below);
        let cameras: Vec<String> = vague.map(|c| c.camera.clone()).collect();
        if !cameras.is_empty() {
            let (mm, deg) = (well_mm * above, well_deg * above);
            verdict.add(grade, Finding::UncertainCameras { cameras, mm, deg });
        }
    }
}
