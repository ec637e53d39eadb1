//! How well a rig was calibrated, and the rig itself in the world's frame.

use super::clocks::{Clocked, Clocks};
use super::origin::Origin;
use super::solving::Sightings;
use super::{Calibrated, RigError, RigSession};
use crate::bundle::{Freedom, KeptParameter, WeakDirection, solve};
use crate::verdict::{Grade, Verdict, listed};
use nalgebra::{Matrix6, Vector3};
use serde::Serialize;
use sextant_estimator::{Camera, Rig};
use sextant_geometry::Pose;
use std::collections::BTreeMap;

/// One camera of a calibrated rig.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibratedCamera {
    /// Its name.
    pub camera: String,
    /// Images of it that were used.
    pub images: usize,
    /// Tags in them that were used.
    pub tags: usize,
    /// Tags that were left out because they fit nowhere.
    pub left_out: usize,
    /// One standard deviation of its position relative to the reference camera (root of the mean of the three axes),
    /// millimetres; 0 for the reference itself.
    pub sigma_mm: f64,
    /// Of its attitude, the same, degrees.
    pub sigma_deg: f64,
    /// Distance between model and seen corners, root mean square, pixels.
    pub rms_px: f64,
    /// What has to be added to its times, milliseconds; `None` where its clock was taken as it is.
    pub clock_offset_ms: Option<f64>,
    /// One standard deviation of that.
    pub clock_sigma_ms: Option<f64>,
}

/// How well a rig was calibrated, in numbers and words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RigReport {
    /// The camera relative to which deviations are stated.
    pub reference: String,
    /// Images taken in.
    pub images: usize,
    /// Images used.
    pub images_used: usize,
    /// Times at which the object was seen.
    pub instants: usize,
    /// Whether cameras took images at the same times.
    pub synchronised: bool,
    /// Over all corners used, pixels.
    pub rms_px: f64,
    /// The corners' error in units of what the detector states of itself; near 1 if that is right.
    pub noise_ratio: f64,
    /// In the order of the rig.
    pub cameras: Vec<CalibratedCamera>,
    /// Tags of the object that were left out often, as (tag, times seen, times left out).
    pub tags_left_out: Vec<(String, usize, usize)>,
    /// What the images hardly determine, in words.
    pub weak: Vec<String>,
    /// In words.
    pub verdict: Verdict,
}

/// What solving found.
pub(super) struct Found {
    pub sightings: Sightings,
    pub adjusted: Clocked,
    pub clocks: Clocks,
    pub synchronised: bool,
}

/// A camera known better than this is well placed (metres, radians); five times as much is still of use.
const WELL_PLACED: (f64, f64) = (0.001, 0.0006);
const OF_USE: f64 = 5.0;
/// More of a tag's views left out is worth a word, if it was seen so often.
const MANY_LEFT_OUT: f64 = 0.25;
const SEEN_OFTEN: usize = 8;
/// Sizes that disagree with the spacing by less do no harm.
const HARMLESS_SIZE: f64 = 0.004;

impl RigSession {
    pub(super) fn finish(&self, found: Found) -> Result<Calibrated, RigError> {
        let bundle = &found.adjusted.adjusted.solution.bundle;
        let floor = self.floor_poses(&found);
        let world = self.plan.origin.world(&floor)?;
        let cameras = self.rig.cameras().iter().zip(&bundle.cameras);
        let cameras = cameras.map(|(camera, solved)| Camera {
            world_from_camera: Some(world * solved.world_from_camera),
            ..camera.clone()
        });
        let rig = Rig::new(cameras.collect())
            .map_err(|error| RigError::Undetermined(error.to_string()))?;
        Ok(Calibrated {
            rig,
            report: self.report(&found),
        })
    }

    /// Where each tag of the floor stands in the frame of the adjustment.
    fn floor_poses(&self, found: &Found) -> Vec<Option<Pose>> {
        let bundle = &found.adjusted.adjusted.solution.bundle;
        let n = self.n_carried();
        let of = |tag: usize| {
            let image = bundle
                .images
                .iter()
                .find(|i| i.tags.iter().all(|t| t.tag == tag) && !i.tags.is_empty())?;
            Some(bundle.instants[image.instant].world_from_object)
        };
        (n..self.wanted.len()).map(of).collect()
    }

    fn report(&self, found: &Found) -> RigReport {
        let solution = &found.adjusted.adjusted.solution;
        let cameras: Vec<CalibratedCamera> = (0..self.rig.cameras().len())
            .map(|at| self.camera(found, at))
            .collect();
        let tags_left_out = self.tags_left_out(found);
        let weak = self.weak(found);
        let reference = self.plan.origin.reference(&self.rig);
        RigReport {
            reference: self.rig.cameras()[reference].id.to_string(),
            images: self.images.len(),
            images_used: found.adjusted.adjusted.images.len(),
            instants: solution.bundle.instants.len(),
            synchronised: found.synchronised,
            rms_px: solution.rms_px,
            noise_ratio: solution.variance_factor.sqrt(),
            verdict: self.verdict(found, &cameras, (&tags_left_out, &weak)),
            cameras,
            tags_left_out,
            weak,
        }
    }

    fn camera(&self, found: &Found, at: usize) -> CalibratedCamera {
        let adjusted = &found.adjusted.adjusted;
        let own = || {
            adjusted
                .solution
                .bundle
                .images
                .iter()
                .filter(|image| image.camera == at)
        };
        let covariance = adjusted.solution.covariance.camera(at);
        let variance = covariance.unwrap_or_else(Matrix6::zeros).diagonal();
        let mean = |first: usize| (variance.fixed_rows::<3>(first).sum().max(0.0) / 3.0).sqrt();
        let clock = found.clocks[at];
        let views = &found.sightings.views;
        let left_out = adjusted
            .misfits
            .iter()
            .filter(|m| views[m.view].camera == at)
            .count();
        CalibratedCamera {
            camera: self.rig.cameras()[at].id.to_string(),
            images: own().count(),
            tags: own().map(|image| image.tags.len()).sum(),
            left_out: left_out + self.unfitting(found, |view| view == at, |_| true),
            sigma_mm: mean(0) * 1e3,
            sigma_deg: mean(3).to_degrees(),
            rms_px: rms_px(found, |image| image.camera == at),
            clock_offset_ms: clock.map(|c| c.offset_s * 1e3),
            clock_sigma_ms: clock.map(|c| c.sigma_s * 1e3),
        }
    }

    /// Tags of the object that were seen but not even taken to the adjustment.
    fn unfitting(
        &self,
        found: &Found,
        camera: impl Fn(usize) -> bool,
        tag: impl Fn(usize) -> bool,
    ) -> usize {
        let views = &found.sightings.views;
        let wanted = |view: &crate::intake::ImageView| {
            view.tags
                .iter()
                .filter(|t| t.tag < self.n_carried() && tag(t.tag))
                .count()
        };
        let seen: usize = views.iter().filter(|v| camera(v.camera)).map(wanted).sum();
        let taken = found
            .adjusted
            .whole
            .images
            .iter()
            .filter(|i| camera(i.camera));
        let taken = taken.flat_map(|i| i.tags.iter().map(|&t| views[i.view].tags[t].tag));
        seen.saturating_sub(taken.filter(|&t| t < self.n_carried() && tag(t)).count())
    }

    fn tags_left_out(&self, found: &Found) -> Vec<(String, usize, usize)> {
        let views = &found.sightings.views;
        let mut gated: BTreeMap<usize, usize> = BTreeMap::new();
        for misfit in &found.adjusted.adjusted.misfits {
            *gated
                .entry(views[misfit.view].tags[misfit.seen].tag)
                .or_default() += 1;
        }
        let of = |tag: usize| {
            let seen = views
                .iter()
                .filter(|v| v.tags.iter().any(|t| t.tag == tag))
                .count();
            let out = gated.get(&tag).copied().unwrap_or(0)
                + self.unfitting(found, |_| true, |t| t == tag);
            (self.wanted[tag].tag.to_string(), seen, out)
        };
        let all = (0..self.n_carried()).map(of);
        all.filter(|(_, seen, out)| {
            *seen >= SEEN_OFTEN && *out as f64 > MANY_LEFT_OUT * *seen as f64
        })
        .collect()
    }

    fn weak(&self, found: &Found) -> Vec<String> {
        let mut words: Vec<String> = Vec::new();
        for direction in &found.adjusted.adjusted.solution.weak {
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
    fn named(&self, found: &Found, direction: &WeakDirection) -> Option<String> {
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
        let solved = &found.adjusted.adjusted.solution.bundle.cameras[camera];
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

    fn verdict(
        &self,
        found: &Found,
        cameras: &[CalibratedCamera],
        (left_out, weak): (&[(String, usize, usize)], &[String]),
    ) -> Verdict {
        let mut verdict = Verdict::new();
        for text in weak {
            verdict.add(Grade::Poor, text.clone());
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

    /// Sizes against spacing, where both are stated; where all sizes are wrong alike and the spacing too, nobody can tell.
    fn judge_sizes(&self, found: &Found, verdict: &mut Verdict) {
        let mut bundle = found.adjusted.adjusted.solution.bundle.clone();
        let frame = bundle
            .tags
            .iter()
            .position(|tag| tag.pose == Freedom::Fixed);
        for (at, tag) in bundle.tags[..self.n_carried()].iter_mut().enumerate() {
            let scale = found.sightings.seeking_tags && Some(at) == frame;
            tag.size = if scale { Freedom::Fixed } else { Freedom::Free };
        }
        let Ok(solution) = solve(bundle, &super::solving::options()) else {
            return;
        };
        let mut wrong: BTreeMap<String, Vec<&crate::intake::Wanted>> = BTreeMap::new();
        for (at, wanted) in self.wanted[..self.n_carried()].iter().enumerate() {
            let sigma = solution
                .covariance
                .sigma(KeptParameter::TagSize { tag: at });
            let off = solution.bundle.tags[at].size_m / wanted.size_m - 1.0;
            if sigma.is_some_and(|s| off.abs() > HARMLESS_SIZE && off.abs() > 5.0 * s) {
                let word = if off > 0.0 { "larger" } else { "smaller" };
                wrong
                    .entry(format!("{:.1} % {word}", off.abs() * 100.0))
                    .or_default()
                    .push(wanted);
            }
        }
        for (how, tags) in wrong {
            verdict.add(Grade::Poor, format!(
                "{} {how} than stated, judged by {}: measure the black squares and the spacing again",
                listed(tags.iter().map(|w| w.tag)),
                if found.sightings.seeking_tags { "the other tags" } else { "their spacing" }));
        }
    }

    /// Cameras that stand where the rig had another one before.
    fn judge_names(&self, found: &Found, verdict: &mut Verdict) {
        let solved = &found.adjusted.adjusted.solution.bundle.cameras;
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

fn rms_px(found: &Found, of: impl Fn(&crate::bundle::BundleImage) -> bool) -> f64 {
    let bundle = &found.adjusted.adjusted.solution.bundle;
    let own = bundle.residuals().filter(|r| of(&bundle.images[r.image]));
    let squares: Vec<f64> = own.map(|r| r.rms_px().powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

impl Origin {
    /// In words, for the report's reader.
    pub fn words(&self) -> String {
        match self {
            Self::FirstCamera => "the first camera".to_owned(),
            Self::Camera(id) => format!("camera {id}"),
            Self::Tag(tag, _) => format!("tag {tag}"),
            Self::ThreeTags([a, b, c], _) => format!("tags {a}, {b} and {c}"),
        }
    }
}
