//! Verdict on a calibrated site.

use super::report::{SiteReport, SiteSolution};
use crate::verdict::{Finding, Grade};

/// Standard deviations below which a camera is well placed (millimetres, degrees); five times as much is usable.
const WELL_PLACED_CAMERA: (f64, f64) = (1.0, 0.035);
/// The same of a tag on its object; three times as much is usable.
const WELL_PLACED_TAG: (f64, f64) = (0.3, 0.23);
/// Relative standard deviation of a good and of a usable focal length.
const FOCAL: (f64, f64) = (0.002, 0.01);
/// Fewer images of objects are too few for a camera.
const FEW_IMAGES: usize = 40;
/// Fewer shared images of an object do not join cameras.
const FEW_SHARED: usize = 5;

impl SiteSolution {
    /// Grade and findings, and what is not solved.
    pub(super) fn judge(&self, report: &mut SiteReport) {
        let verdict = &mut report.verdict;
        for camera in &report.cameras {
            let name = camera.camera.clone();
            if !camera.placed {
                let cause = format!(
                    "camera {name} shares no view with the others: carry an object where it and one of them see it at the same time"
                );
                report.unsolved.push(cause.clone());
                verdict.add(Grade::Usable, Finding::Unplaced(cause));
                continue;
            }
            if camera.images < FEW_IMAGES {
                let images = camera.images;
                verdict.add(
                    Grade::Usable,
                    Finding::FewSightings {
                        camera: name.clone(),
                        images,
                    },
                );
            }
            let share = camera.focal_sigma_px / camera.focal_px;
            if share > FOCAL.0 {
                let grade = if share > FOCAL.1 {
                    Grade::Poor
                } else {
                    Grade::Usable
                };
                let percent = 100.0 * share;
                verdict.add(
                    grade,
                    Finding::UncertainFocal {
                        camera: name.clone(),
                        percent,
                    },
                );
            }
            if camera.corners_covered < 1.0 {
                let missing = (4.0 * (1.0 - camera.corners_covered)).round() as usize;
                verdict.add(
                    Grade::Good,
                    Finding::UncoveredCorners {
                        camera: name,
                        missing,
                    },
                );
            }
        }
        let excess = |sigma_mm: f64, sigma_deg: f64, well: (f64, f64)| {
            (sigma_mm / well.0).max(sigma_deg / well.1)
        };
        for (grade, above, below) in [(Grade::Poor, 5.0, f64::INFINITY), (Grade::Usable, 1.0, 5.0)]
        {
            let vague = report.cameras.iter().filter(|camera| {
                let excess = excess(camera.sigma_mm, camera.sigma_deg, WELL_PLACED_CAMERA);
                camera.placed && excess > above && excess <= below
            });
            let cameras: Vec<String> = vague.map(|camera| camera.camera.clone()).collect();
            if !cameras.is_empty() {
                let (mm, deg) = (WELL_PLACED_CAMERA.0 * above, WELL_PLACED_CAMERA.1 * above);
                verdict.add(grade, Finding::UncertainCameras { cameras, mm, deg });
            }
        }
        for object in &report.objects {
            if object.shared < FEW_SHARED && report.cameras.len() > 1 {
                let object = object.object.clone();
                verdict.add(Grade::Usable, Finding::UnsharedObject(object));
            }
            let excess = excess(object.sigma_mm, object.sigma_deg, WELL_PLACED_TAG);
            if excess > 1.0 {
                let grade = if excess > 3.0 {
                    Grade::Poor
                } else {
                    Grade::Usable
                };
                let factor = if excess > 3.0 { 3.0 } else { 1.0 };
                let (mm, deg) = (WELL_PLACED_TAG.0 * factor, WELL_PLACED_TAG.1 * factor);
                let tags = vec![format!("tags of {}", object.object)];
                verdict.add(grade, Finding::UncertainTags { tags, mm, deg });
            }
        }
        if !report.unassigned.is_empty() {
            let tags = report.unassigned.clone();
            verdict.add(Grade::Usable, Finding::UnassignedTags(tags));
        }
        let tags = 0..self.members.n_carried();
        let lost = tags.filter(|&tag| !self.is_tag_placed(tag));
        for tag in lost {
            let cause = format!(
                "{} could not be placed on its object: show it nearer, together with its neighbours",
                self.members.wanted[tag].tag
            );
            report.unsolved.push(cause.clone());
            verdict.add(Grade::Usable, Finding::Unplaced(cause));
        }
        if self.synchronised {
            for camera in &report.cameras {
                if let (Some(ms), Some(sigma_ms)) = (camera.clock_offset_ms, camera.clock_sigma_ms)
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
        }
    }
}
