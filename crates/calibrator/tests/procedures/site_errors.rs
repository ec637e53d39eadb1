//! Errors of a calibrated site by its truth.

use crate::site_scene::SimulatedSite;
use sextant_calibrator::CalibratedSite;
use sextant_geometry::{Pose, se3};
use sextant_site_model::{ObjectModel, Rig};

/// Largest errors, and the largest in units of their reported standard deviations.
#[derive(Clone, Copy, Debug, Default)]
pub struct SiteErrors {
    pub camera_mm: f64,
    pub camera_deg: f64,
    pub camera_sigmas: f64,
    pub focal_percent: f64,
    pub focal_sigmas: f64,
    pub tag_mm: f64,
    pub tag_deg: f64,
    pub clock_ms: f64,
    pub clock_sigmas: f64,
    /// Of the line delays, per cent; zero with global shutters.
    pub line_delay_percent: f64,
    pub line_delay_sigmas: f64,
}

impl SiteErrors {
    pub fn measure(found: &CalibratedSite, truth: &SimulatedSite) -> Self {
        let mut errors = Self::default();
        let relative = |rig: &Rig, at: usize| {
            let pose = |at: usize| rig.cameras()[at].world_from_camera.unwrap();
            pose(0).inverse() * pose(at)
        };
        for (at, camera) in truth.rig.cameras().iter().enumerate() {
            let (stated, calibrated) = (&found.report.cameras[at], &found.rig.cameras()[at]);
            let focal = |camera: &sextant_site_model::Camera| camera.lens.intrinsics().fx;
            let off = focal(calibrated) - focal(camera);
            errors.focal_percent = errors.focal_percent.max(100.0 * off.abs() / focal(camera));
            errors.focal_sigmas = errors.focal_sigmas.max(off.abs() / stated.focal_sigma_px);
            if let (Some(us), Some(sigma)) = (stated.line_delay_us, stated.line_delay_sigma_us) {
                let off = (us - truth.line_delay_s * 1e6).abs();
                errors.line_delay_sigmas = errors.line_delay_sigmas.max(off / sigma);
                if truth.line_delay_s > 0.0 {
                    let percent = 1e-4 * off / truth.line_delay_s;
                    errors.line_delay_percent = errors.line_delay_percent.max(percent);
                }
            }
            if at == 0 {
                continue;
            }
            let error = se3::difference(&relative(&found.rig, at), &relative(&truth.rig, at));
            let mm = error.fixed_rows::<3>(0).norm() * 1e3;
            let deg = error.fixed_rows::<3>(3).norm().to_degrees();
            errors.camera_mm = errors.camera_mm.max(mm);
            errors.camera_deg = errors.camera_deg.max(deg);
            let sigmas = (mm / stated.sigma_mm).max(deg / stated.sigma_deg) / 3.0_f64.sqrt();
            errors.camera_sigmas = errors.camera_sigmas.max(sigmas);
            if let (Some(ms), Some(sigma)) = (stated.clock_offset_ms, stated.clock_sigma_ms) {
                let off = (ms - truth.clock_offsets_s[at] * 1e3).abs();
                errors.clock_ms = errors.clock_ms.max(off);
                errors.clock_sigmas = errors.clock_sigmas.max(off / sigma);
            }
        }
        for object in &truth.objects {
            let same = found.objects.iter().find(|own| own.id() == object.id());
            let (mm, deg) = same.map_or((1e3, 180.0), |own| constellation_errors(own, object));
            errors.tag_mm = errors.tag_mm.max(mm);
            errors.tag_deg = errors.tag_deg.max(deg);
        }
        errors
    }
}

/// Largest error of a tag relative to the object's first tag.
fn constellation_errors(found: &ObjectModel, truth: &ObjectModel) -> (f64, f64) {
    let relative = |object: &ObjectModel, at: usize| -> Option<Pose> {
        let tag = truth.tags()[at].tag;
        let pose = |tag| {
            let own = object.tags().iter().find(|own| own.tag == tag)?;
            own.object_from_tag
        };
        Some(pose(truth.tags()[0].tag)?.inverse() * pose(tag)?)
    };
    let mut worst = (0.0_f64, 0.0_f64);
    for at in 1..truth.tags().len() {
        let (Some(found), Some(truth)) = (relative(found, at), relative(truth, at)) else {
            return (1e3, 180.0);
        };
        let error = se3::difference(&found, &truth);
        worst.0 = worst.0.max(error.fixed_rows::<3>(0).norm() * 1e3);
        worst.1 = worst.1.max(error.fixed_rows::<3>(3).norm().to_degrees());
    }
    worst
}
