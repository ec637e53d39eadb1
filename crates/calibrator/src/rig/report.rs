//! Report of a rig calibration, and the rig in the world frame.

use super::clocks::{self, Clocks};
use super::former::FormerDifference;
use super::origin::Origin;
use super::sightings::Sightings;
use super::{CalibratedRig, RigError, RigSession};
use crate::adjustment::AdjustmentResult;
use crate::held_out::{self, HeldOutImages};
use crate::learn::root_mean_square;
use crate::lens::lens_sigma;
use crate::verdict::{Finding, Verdict};
use nalgebra::Matrix6;
use serde::Serialize;
use sextant_geometry::Pose;
use sextant_site_model::{Camera, LensSigma, PoseSigma, Prior, Rig};
use std::collections::{BTreeMap, BTreeSet};

/// One camera of a calibrated rig.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CalibratedCamera {
    /// Id of the camera.
    pub camera: String,
    /// Number of its used images.
    pub images: usize,
    /// Number of used tags in them.
    pub tags: usize,
    /// Number of excluded outlier tags.
    pub left_out: usize,
    /// One standard deviation of its position relative to the reference camera (root of the mean of the three axes),
    /// millimetres, the common scale apart; 0 for the reference itself.
    pub sigma_mm: f64,
    /// Standard deviation of its attitude (root mean square of the axes), degrees.
    pub sigma_deg: f64,
    /// Along the reference camera's axes, millimetres.
    pub sigma_axes_mm: [f64; 3],
    /// About the reference camera's axes, degrees.
    pub sigma_axes_deg: [f64; 3],
    /// RMS reprojection error, pixels.
    pub rms_px: f64,
    /// Its clock minus that of the reference, milliseconds, as fusion reports it: positive where its times are too
    /// late. `None` if it was not estimated.
    pub clock_offset_ms: Option<f64>,
    /// Standard deviation of the same.
    pub clock_sigma_ms: Option<f64>,
    /// Line delay of its shutter, microseconds from a row to the next; `None` if it was not estimated.
    pub line_delay_us: Option<f64>,
    /// Standard deviation of the same.
    pub line_delay_sigma_us: Option<f64>,
}

/// Accuracy of a rig calibration, and a verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RigReport {
    /// Reference camera of the standard deviations.
    pub reference: String,
    /// Number of images received.
    pub images: usize,
    /// Images used.
    pub images_used: usize,
    /// Number of instants with the object.
    pub instants: usize,
    /// Whether shutters are synchronised.
    pub synchronised: bool,
    /// RMS reprojection error over all used corners, pixels.
    pub rms_px: f64,
    /// Corner noise as a multiple of the detector's; 1 is expected.
    pub noise_ratio: f64,
    /// Residuals of images that had no part in a solution; `None` where there are too few.
    pub held_out: Option<HeldOutImages>,
    /// In the order of the rig.
    pub cameras: Vec<CalibratedCamera>,
    /// Tags of the object that were often outliers, as (tag, images, outliers).
    pub tags_left_out: Vec<(String, usize, usize)>,
    /// Weakly determined motions of cameras.
    pub weak: Vec<Finding>,
    /// Cameras that could not be placed and keep their entries, with reason and remedy.
    pub unsolved: Vec<String>,
    /// Source of the scale, as text.
    pub scale: String,
    /// Grade and findings.
    pub verdict: Verdict,
}

/// The solution of a rig.
pub(super) struct RigSolution {
    pub sightings: Sightings,
    pub adjusted: AdjustmentResult,
    pub clocks: Clocks,
    pub synchronised: bool,
    /// By what the former rig differs as a whole; `None` where it is unknown or as the solved one.
    pub former: Option<FormerDifference>,
}

/// Share of a tag's views from which outliers are reported, and the least number of views.
const MANY_LEFT_OUT: f64 = 0.25;
const SEEN_OFTEN: usize = 8;

impl RigSession {
    pub(super) fn finish(&self, found: RigSolution) -> Result<CalibratedRig, RigError> {
        let bundle = &found.adjusted.solution.bundle;
        let floor = self.floor_poses(&found);
        let world = self.plan.origin.world(&floor)?;
        let report = self.report(&found);
        let poses: Vec<Pose> = bundle
            .cameras
            .iter()
            .map(|camera| camera.world_from_camera)
            .collect();
        let origin = &self.plan.origin;
        let poses = origin.explained(&self.images.rig, &poses, world, found.former.as_ref());
        let solved = poses.into_iter().zip(&report.cameras);
        let cameras = self.images.rig.cameras().iter().zip(solved).enumerate();
        let cameras = cameras.map(|(at, (camera, (pose, stated)))| Camera {
            world_from_camera: Some(pose),
            lens: bundle.cameras[at].lens,
            pose_prior: Prior::Sigma(pose_sigma(stated)),
            lens_prior: self.lens_prior(&found, at),
            line_delay_s: clocks::line_delay(&found.adjusted.solution, at)
                .filter(|found| found.is_rolling(camera))
                .map_or(camera.line_delay_s, |found| Some(found.line_delay_s)),
            ..camera.clone()
        });
        let corrected = found.former.as_ref().and_then(FormerDifference::correction);
        let of_object = || self.plan.object.scale_sigma_or_usual();
        let scale_sigma = Some(corrected.map_or_else(of_object, |scale| scale.sigma));
        let rig = Rig::new(cameras.collect())
            .and_then(|rig| rig.with_scale_sigma(scale_sigma))
            .map_err(|error| RigError::Undetermined(error.to_string()))?;
        Ok(CalibratedRig { rig, report })
    }

    /// Standard deviations of a focal length and distortion after the adjustment; those of before if the lens was
    /// fixed.
    fn lens_prior(&self, found: &RigSolution, at: usize) -> Prior<LensSigma> {
        let (solution, camera) = (&found.adjusted.solution, &self.images.rig.cameras()[at]);
        let (solved, covariance) = (&solution.bundle.cameras[at], solution.covariance.lens(at));
        if covariance.nrows() == solved.lens.n_parameters() {
            Prior::Sigma(lens_sigma(&solved.lens, camera.resolution, &covariance))
        } else if covariance.is_empty() {
            camera.lens_prior
        } else {
            Prior::Default
        }
    }

    /// Poses of the floor tags in the frame of the adjustment.
    fn floor_poses(&self, found: &RigSolution) -> Vec<Option<Pose>> {
        let bundle = &found.adjusted.solution.bundle;
        let n = self.n_carried();
        let of = |tag: usize| {
            let image = bundle
                .images
                .iter()
                .find(|i| i.tags.iter().all(|t| t.tag == tag) && !i.tags.is_empty())?;
            Some(bundle.instants[image.instant].world_from_object)
        };
        (n..self.images.wanted.len()).map(of).collect()
    }

    fn report(&self, found: &RigSolution) -> RigReport {
        let solution = &found.adjusted.solution;
        let cameras: Vec<CalibratedCamera> = (0..self.images.rig.cameras().len())
            .map(|at| self.camera(found, at))
            .collect();
        let tags_left_out = self.tags_left_out(found);
        let weak = self.weak(found);
        let reference = self.plan.origin.reference(&self.images.rig);
        let held_out = found.adjusted.held_out(&found.sightings.views);
        let mut verdict = self.verdict(found, &cameras, &tags_left_out, &weak);
        held_out::judge(held_out.as_ref(), &mut verdict);
        RigReport {
            held_out,
            reference: self.images.rig.cameras()[reference].id.to_string(),
            images: self.images.stored.n_received(),
            images_used: used(found, |_| true),
            instants: solution.bundle.instants.len(),
            synchronised: found.synchronised,
            rms_px: solution.rms_px,
            noise_ratio: found.adjusted.noise_ratio(),
            scale: self.scale(found),
            verdict,
            cameras,
            tags_left_out,
            weak,
            unsolved: Vec::new(),
        }
    }

    fn camera(&self, found: &RigSolution, at: usize) -> CalibratedCamera {
        let adjusted = &found.adjusted;
        let own = || {
            adjusted
                .solution
                .bundle
                .images
                .iter()
                .filter(|image| image.camera == at)
        };
        let reference = self.plan.origin.reference(&self.images.rig);
        let world_from_reference = adjusted.solution.bundle.cameras[reference].world_from_camera;
        let turn = *world_from_reference
            .rotation
            .inverse()
            .to_rotation_matrix()
            .matrix();
        let covariance = adjusted.solution.covariance.at_known_scale().camera(at);
        let covariance = covariance.unwrap_or_else(Matrix6::zeros);
        let axes = |first: usize| {
            let block = turn * covariance.fixed_view::<3, 3>(first, first) * turn.transpose();
            [0, 1, 2].map(|axis| block[(axis, axis)].max(0.0).sqrt())
        };
        let (axes_mm, axes_deg) = (axes(0).map(|s| s * 1e3), axes(3).map(f64::to_degrees));
        let clock = found.clocks[at];
        let line_delay = clocks::line_delay(&adjusted.solution, at);
        let views = &found.sightings.views;
        let left_out = adjusted
            .misfits
            .iter()
            .filter(|m| views[m.view].camera == at)
            .count();
        CalibratedCamera {
            camera: self.images.rig.cameras()[at].id.to_string(),
            images: used(found, |camera| camera == at),
            tags: own().map(|image| image.tags.len()).sum(),
            left_out: left_out + self.unfitting(found, |view| view == at, |_| true),
            sigma_mm: root_mean_square(&axes_mm),
            sigma_deg: root_mean_square(&axes_deg),
            sigma_axes_mm: axes_mm,
            sigma_axes_deg: axes_deg,
            rms_px: rms_px(found, |image| image.camera == at),
            clock_offset_ms: clock.map(|c| c.offset_s * 1e3),
            clock_sigma_ms: clock.map(|c| c.sigma_s * 1e3),
            line_delay_us: line_delay.map(|found| found.line_delay_s * 1e6),
            line_delay_sigma_us: line_delay.map(|found| found.sigma_s * 1e6),
        }
    }

    /// Tags of the object that were seen but excluded before the adjustment.
    fn unfitting(
        &self,
        found: &RigSolution,
        camera: impl Fn(usize) -> bool,
        tag: impl Fn(usize) -> bool,
    ) -> usize {
        let views = &found.sightings.views;
        let wanted = |view: &crate::image_store::ImageView| {
            view.tags
                .iter()
                .filter(|t| t.tag < self.n_carried() && tag(t.tag))
                .count()
        };
        let seen: usize = views.iter().filter(|v| camera(v.camera)).map(wanted).sum();
        let taken = found
            .adjusted
            .adjustment
            .images
            .iter()
            .filter(|i| camera(i.camera));
        let taken = taken.flat_map(|i| i.tags.iter().map(|&t| views[i.view].tags[t].tag));
        seen.saturating_sub(taken.filter(|&t| t < self.n_carried() && tag(t)).count())
    }

    fn tags_left_out(&self, found: &RigSolution) -> Vec<(String, usize, usize)> {
        let views = &found.sightings.views;
        let mut gated: BTreeMap<usize, usize> = BTreeMap::new();
        for misfit in found.adjusted.misfits.iter().filter(|m| m.is_elsewhere()) {
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
            (self.images.wanted[tag].tag.to_string(), seen, out)
        };
        let all = (0..self.n_carried()).map(of);
        all.filter(|(_, seen, out)| {
            *seen >= SEEN_OFTEN && *out as f64 > MANY_LEFT_OUT * *seen as f64
        })
        .collect()
    }
}

/// As in the report: relative to the reference, for which it is zero. Where a tag is the world frame, the uncertainty
/// of its pose is excluded, since it moves all cameras together.
fn pose_sigma(stated: &CalibratedCamera) -> PoseSigma {
    PoseSigma {
        position_m: stated.sigma_mm * 1e-3,
        orientation_rad: stated.sigma_deg.to_radians(),
    }
}

/// Images used of some cameras; an image that shows the object and static tags occurs in the adjustment once for each.
fn used(found: &RigSolution, camera: impl Fn(usize) -> bool) -> usize {
    let images = found.adjusted.used();
    let views = images.filter(|image| camera(image.camera));
    views
        .map(|image| image.view)
        .collect::<BTreeSet<usize>>()
        .len()
}

fn rms_px(found: &RigSolution, of: impl Fn(&sextant_adjustment::BundleImage) -> bool) -> f64 {
    let bundle = &found.adjusted.solution.bundle;
    let own = bundle.residuals().filter(|r| of(&bundle.images[r.image]));
    let squares: Vec<f64> = own.map(|r| r.rms_px().powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

impl Origin {
    /// As text, for the reader of the report.
    pub fn words(&self) -> String {
        match self {
            Self::FirstCamera => "the first camera".to_owned(),
            Self::Camera(id) => format!("camera {id}"),
            Self::Tag(tag, _) => format!("tag {tag}"),
            Self::ThreeTags([a, b, c], _) => format!("tags {a}, {b} and {c}"),
            Self::Levelled(frame, _) => format!("{}, levelled", frame.words()),
        }
    }
}
