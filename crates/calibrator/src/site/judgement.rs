//! Verdict on a calibrated site.

use super::report::{SiteCameraReport, SiteObjectReport, SiteReport};
use super::solution::SiteSolution;
use crate::held_out;
use crate::verdict::{Finding, Grade, Verdict};

/// Standard deviations below which a camera is well placed (millimetres, degrees); five times as much is usable.
const WELL_PLACED_CAMERA: [f64; 2] = [1.0, 0.035];
const OF_USE: f64 = 5.0;
/// The same of a tag on its object; three times as much is usable.
const WELL_PLACED_TAG: [f64; 2] = [0.3, 0.23];
const TAG_OF_USE: f64 = 3.0;
/// Relative standard deviation of a good and of a usable focal length.
const FOCAL: (f64, f64) = (0.002, 0.01);
/// Standard deviation of the distortion in the corners of the image of a good and of a usable lens, pixels.
const DISTORTION_PX: (f64, f64) = (10.0, 50.0);
/// Fewer images of objects are too few for a camera.
const FEW_IMAGES: usize = 40;
/// Fewer shared images of an object do not join cameras.
const FEW_SHARED: usize = 5;

/// How far deviations exceed those of something well placed.
fn excess(sigma_mm: f64, sigma_deg: f64, well_placed: [f64; 2]) -> f64 {
    (sigma_mm / well_placed[0]).max(sigma_deg / well_placed[1])
}

impl SiteSolution {
    /// Grade and findings, and what is not solved.
    pub(super) fn judge(&self, report: &mut SiteReport) {
        let verdict = &mut report.verdict;
        for camera in &report.cameras {
            if camera.placed {
                judge_camera(camera, verdict);
            } else {
                let cause = format!(
                    "camera {} shares no view with the others: carry an object where it and one \
                     of them see it at the same time",
                    camera.camera
                );
                report.unsolved.push(cause.clone());
                verdict.add(Grade::Usable, Finding::Unplaced(cause));
            }
        }
        judge_deviations(&report.cameras, verdict);
        let is_alone = report.cameras.len() == 1;
        for object in &report.objects {
            if object.shared < FEW_SHARED && !is_alone {
                let object = object.object.clone();
                verdict.add(Grade::Usable, Finding::UnsharedObject(object));
            }
            judge_tags(object, verdict);
        }
        if !report.unassigned.is_empty() {
            let tags = report.unassigned.clone();
            verdict.add(Grade::Usable, Finding::UnassignedTags(tags));
        }
        for cause in self.lost_tags() {
            report.unsolved.push(cause.clone());
            verdict.add(Grade::Usable, Finding::Unplaced(cause));
        }
        if self.synchronised {
            judge_clocks(&report.cameras, verdict);
        }
        held_out::judge(report.held_out.as_ref(), verdict);
        for found in &self.contradictions {
            let [object, by] = [found.body, found.trusted].map(|body| self.name_of(body));
            let ratio = found.ratio;
            verdict.add(Grade::Poor, Finding::SizesContradict { object, by, ratio });
        }
    }

    /// Why tags of objects have no place.
    fn lost_tags(&self) -> Vec<String> {
        let tags = 0..self.members.n_carried();
        let lost = tags.filter(|&tag| !self.is_tag_placed(tag));
        let cause = |tag: usize| {
            format!(
                "{} could not be placed on its object: show it nearer, together with its neighbours",
                self.members.wanted[tag].tag
            )
        };
        lost.map(cause).collect()
    }
}

fn judge_camera(camera: &SiteCameraReport, verdict: &mut Verdict) {
    let name = || camera.camera.clone();
    if camera.images < FEW_IMAGES {
        let (camera, images) = (name(), camera.images);
        verdict.add(Grade::Usable, Finding::FewSightings { camera, images });
    }
    let share = camera.focal_sigma_px / camera.focal_px;
    if share > FOCAL.0 {
        let grade = if share > FOCAL.1 {
            Grade::Poor
        } else {
            Grade::Usable
        };
        let (camera, percent) = (name(), 100.0 * share);
        verdict.add(grade, Finding::UncertainFocal { camera, percent });
    }
    if camera.corners_covered < 1.0 {
        let missing = (4.0 * (1.0 - camera.corners_covered)).round() as usize;
        let grade = match camera.distortion_sigma_px {
            px if px > DISTORTION_PX.1 => Grade::Poor,
            px if px > DISTORTION_PX.0 => Grade::Usable,
            _ => Grade::Good,
        };
        let camera = name();
        verdict.add(grade, Finding::UncoveredCorners { camera, missing });
    }
}

fn judge_deviations(cameras: &[SiteCameraReport], verdict: &mut Verdict) {
    for (grade, above, below) in [
        (Grade::Poor, OF_USE, f64::INFINITY),
        (Grade::Usable, 1.0, OF_USE),
    ] {
        let vague = cameras.iter().filter(|camera| {
            let excess = excess(camera.sigma_mm, camera.sigma_deg, WELL_PLACED_CAMERA);
            camera.placed && excess > above && excess <= below
        });
        let cameras: Vec<String> = vague.map(|camera| camera.camera.clone()).collect();
        if !cameras.is_empty() {
            let (mm, deg) = (WELL_PLACED_CAMERA[0] * above, WELL_PLACED_CAMERA[1] * above);
            verdict.add(grade, Finding::UncertainCameras { cameras, mm, deg });
        }
    }
}

fn judge_tags(object: &SiteObjectReport, verdict: &mut Verdict) {
    let excess = excess(object.sigma_mm, object.sigma_deg, WELL_PLACED_TAG);
    let (grade, factor) = match excess {
        much if much > TAG_OF_USE => (Grade::Poor, TAG_OF_USE),
        some if some > 1.0 => (Grade::Usable, 1.0),
        _ => return,
    };
    let tags = vec![format!("tags of {}", object.object)];
    let (mm, deg) = (WELL_PLACED_TAG[0] * factor, WELL_PLACED_TAG[1] * factor);
    verdict.add(grade, Finding::UncertainTags { tags, mm, deg });
}

/// Reports the clocks of synchronised shutters that are off.
fn judge_clocks(cameras: &[SiteCameraReport], verdict: &mut Verdict) {
    for camera in cameras {
        if let (Some(ms), Some(sigma_ms)) = (camera.clock_offset_ms, camera.clock_sigma_ms) {
            let camera = camera.camera.clone();
            let finding = Finding::ClockOffset {
                camera,
                ms,
                sigma_ms,
            };
            verdict.add(Grade::Usable, finding);
        }
    }
}
