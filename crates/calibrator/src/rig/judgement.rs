//! Verdict on a calibrated rig.

use super::RigSession;
use super::report::{CalibratedCamera, RigSolution};
use crate::bundle::{KeptParameter, WeakDirection};
use crate::verdict::{Grade, Verdict, listed};
use nalgebra::Vector3;
use sextant_geometry::Pose;
use std::collections::BTreeMap;

/// A camera known better than this is well placed (metres, radians); five times as much is still of use.
const WELL_PLACED: (f64, f64) = (0.001, 0.0006);
const OF_USE: f64 = 5.0;
/// Sizes that disagree with the spacing by less do no harm.
const HARMLESS_SIZE: f64 = 0.004;

impl RigSession {
    pub(super) fn weak(&self, found: &RigSolution) -> Vec<String> {
        let mut words: Vec<String> = Vec::new();
        for direction in &found.adjusted.solution.weak {
            if let Some(text) = self
                .named(found, direction)
                .filter(|text| !words.contains(text))
            {
                words.push(text);
            }
        }
        words
    }

    /// A weak direction as the motion of the camera that moves most.
    fn named(&self, found: &RigSolution, direction: &WeakDirection) -> Option<String> {
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
        let id = &self.rig.cameras()[camera].id;
        let solved = &found.adjusted.solution.bundle.cameras[camera];
        let along = |v: Vector3<f64>| {
            let in_camera = solved.world_from_camera.inverse_transform_vector(&v);
            in_camera.z.abs() > 0.8 * in_camera.norm()
        };
        Some(if clock.abs() > moves.norm().max(turns.norm()) {
            format!(
                "the clock of {id} is not observable: move the object faster and in changing directions"
            )
        } else if turns.norm() > moves.norm() && along(turns) {
            format!(
                "rotation about the optical axis of {id} is not observable: carry the object off the line"
            )
        } else if turns.norm() > moves.norm() {
            format!(
                "the tilt of {id} is not observable: show it the object in more places of its picture"
            )
        } else if along(moves) {
            format!(
                "the position of {id} along its optical axis is not observable: bring the object nearer, and tilt it"
            )
        } else {
            format!(
                "the position of {id} across its optical axis is not observable: show it the object in more places, tilted"
            )
        })
    }

    pub(super) fn verdict(
        &self,
        found: &RigSolution,
        cameras: &[CalibratedCamera],
        (left_out, weak): (&[(String, usize, usize)], &[String]),
    ) -> Verdict {
        let mut verdict = Verdict::new();
        for text in weak {
            verdict.add(Grade::Poor, text.clone());
        }
        for text in &found.sightings.unplaced {
            verdict.add(Grade::Usable, text.clone());
        }
        judge_deviations(cameras, &mut verdict);
        for camera in cameras {
            if let (Some(ms), Some(sigma)) = (camera.clock_offset_ms, camera.clock_sigma_ms)
                && found.synchronised
            {
                verdict.add(Grade::Usable, format!(
                    "the clock of {} is {:.1} ms (one sigma {:.1}) {} those of the others, which was allowed for",
                    camera.camera, ms.abs(), sigma, if ms > 0.0 { "behind" } else { "ahead of" }));
            }
        }
        for (tag, seen, out) in left_out {
            verdict.add(Grade::Usable, format!(
                "{tag} fits in only {} of {seen} images: it has moved, is bent, or is there twice", seen - out.min(seen)));
        }
        for (tag, count) in self.coverage.doubled() {
            verdict.add(
                Grade::Usable,
                format!("{count} images show {tag} twice, and were not used for it"),
            );
        }
        self.judge_sizes(found, &mut verdict);
        self.judge_names(found, &mut verdict);
        verdict
    }

    /// Sizes that the images show to be other than given, which the adjustment allows for.
    fn judge_sizes(&self, found: &RigSolution, verdict: &mut Verdict) {
        let solution = &found.adjusted.solution;
        let mut wrong: BTreeMap<(String, &str), Vec<&crate::image_store::TagSpec>> =
            BTreeMap::new();
        for (at, wanted) in self.wanted.iter().enumerate() {
            let sigma = solution
                .covariance
                .sigma(KeptParameter::TagSize { tag: at });
            let off = solution.bundle.tags[at].size_m / wanted.size_m - 1.0;
            if sigma.is_some_and(|s| off.abs() > HARMLESS_SIZE && off.abs() > 5.0 * s) {
                let word = if off > 0.0 { "larger" } else { "smaller" };
                let by = if at >= self.n_carried() {
                    "the carried object"
                } else if found.sightings.seeking_tags {
                    "the other tags"
                } else {
                    "their spacing"
                };
                let how = format!("{:.1} % {word}", off.abs() * 100.0);
                wrong.entry((how, by)).or_default().push(wanted);
            }
        }
        for ((how, by), tags) in wrong {
            verdict.add(Grade::Usable, format!(
                "{} {how} than given, judged by {by}, which was allowed for: measure the black squares and the spacing",
                listed(tags.iter().map(|w| w.tag))));
        }
    }

    /// Source of the scale, in words.
    pub(super) fn scale(&self, found: &RigSolution) -> String {
        let object = self.plan.object.id();
        if self.still_tags_with_size(&found.sightings.views).is_empty() {
            return format!(
                "all lengths depend on the given sizes of {object}; an error common to all of them cannot be detected"
            );
        }
        format!("the given sizes of {object} and of the tags that lie still were compared")
    }

    /// Cameras that stand where the rig had another one before.
    fn judge_names(&self, found: &RigSolution, verdict: &mut Verdict) {
        let solved = &found.adjusted.solution.bundle.cameras;
        let cameras = self.rig.cameras();
        for a in 0..cameras.len() {
            for b in a + 1..cameras.len() {
                let (Some(old_a), Some(old_b)) =
                    (cameras[a].world_from_camera, cameras[b].world_from_camera)
                else {
                    continue;
                };
                let far = |x: &Pose, y: &Pose| (x.translation.vector - y.translation.vector).norm();
                let apart = far(&old_a, &old_b);
                let (new_a, new_b) = (&solved[a].world_from_camera, &solved[b].world_from_camera);
                if apart > 0.1
                    && far(new_a, &old_b) < 0.2 * apart
                    && far(new_b, &old_a) < 0.2 * apart
                {
                    verdict.add(Grade::Poor, format!(
                        "{} stands where {} stood before and the other way round: are the names swapped?",
                        cameras[a].id, cameras[b].id));
                }
            }
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
        let vague: Vec<&str> = vague.map(|c| c.camera.as_str()).collect();
        if !vague.is_empty() {
            verdict.add(grade, format!(
                "{} known to no better than {:.0} mm or {:.2} degrees: carry the object longer and nearer through what it shares with others",
                listed(vague), well_mm * above, well_deg * above));
        }
    }
}
