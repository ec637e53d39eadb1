//! Models and report of a solved site.

use super::solution::SiteSolution;
use super::world::{Scale, WorldFrame};
use super::{CalibratedSite, SiteError, SiteSession};
use crate::held_out::HeldOutImages;
use crate::learn::framing::sigma as pose_sigma;
use crate::learn::gauge::{aligned, centroid, turned};
use crate::lens::lens_sigma;
use crate::rig::clocks;
use crate::verdict::{Finding, Grade, Verdict};
use nalgebra::{DMatrix, Matrix6};
use serde::Serialize;
use sextant_adjustment::KeptParameter;
use sextant_geometry::Pose;
use sextant_site_model::{Camera, ObjectId, ObjectModel, ObjectTag, PoseSigma, Prior, Rig};

/// One camera of a calibrated site.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SiteCameraReport {
    /// Id of the camera.
    pub camera: String,
    /// Whether it could be placed.
    pub placed: bool,
    /// Number of its images that show a tag of an object.
    pub images: usize,
    /// One standard deviation of its position relative to the reference camera (root mean square of the axes),
    /// millimetres, the common scale apart.
    pub sigma_mm: f64,
    /// Of its attitude, degrees.
    pub sigma_deg: f64,
    /// Focal length along x, pixels.
    pub focal_px: f64,
    /// Standard deviation of the focal length, pixels.
    pub focal_sigma_px: f64,
    /// Standard deviation of the distortion in the corners of the image, pixels.
    pub distortion_sigma_px: f64,
    /// Share of the four corners of the image that tags have reached.
    pub corners_covered: f64,
    /// RMS reprojection error, pixels.
    pub rms_px: f64,
    /// Its clock minus that of the reference, milliseconds, as fusion reports it; `None` if it was not estimated.
    pub clock_offset_ms: Option<f64>,
    /// Standard deviation of the same.
    pub clock_sigma_ms: Option<f64>,
    /// Line delay of its shutter, microseconds from a row to the next; `None` if it was not estimated.
    pub line_delay_us: Option<f64>,
    /// Standard deviation of the same.
    pub line_delay_sigma_us: Option<f64>,
}

/// One object of a calibrated site.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SiteObjectReport {
    /// The object's name.
    pub object: String,
    /// Its tags, family and number.
    pub tags: Vec<String>,
    /// Largest standard deviation of the position of a tag, millimetres, the common scale apart.
    pub sigma_mm: f64,
    /// Largest standard deviation of the attitude of a tag, degrees.
    pub sigma_deg: f64,
    /// Images that show it.
    pub images: usize,
    /// Images that show it while another camera sees it, too.
    pub shared: usize,
}

/// Accuracy of a calibrated site, and a verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SiteReport {
    /// The frame of the result, as text.
    pub world: String,
    /// Reference camera of the standard deviations and clocks.
    pub reference: String,
    /// Number of images received.
    pub images: usize,
    /// Whether shutters are synchronised.
    pub synchronised: bool,
    /// RMS reprojection error over all used corners, pixels.
    pub rms_px: f64,
    /// Corner noise as a multiple of the detector's; 1 is expected.
    pub noise_ratio: f64,
    /// Residuals of images that had no part in a solution; `None` where there are too few.
    pub held_out: Option<HeldOutImages>,
    /// In the order of the plan.
    pub cameras: Vec<SiteCameraReport>,
    /// The objects that moved.
    pub objects: Vec<SiteObjectReport>,
    /// Static tags.
    pub still: Vec<String>,
    /// Tags that move, but of which it is not known what they belong to.
    pub unassigned: Vec<String>,
    /// Factor by which measured distances corrected the scale of the printed sizes.
    pub scale_factor: f64,
    /// Relative standard deviation of the common scale.
    pub scale_sigma: f64,
    /// Cameras and tags that could not be placed, with reason and remedy.
    pub unsolved: Vec<String>,
    /// Grade and findings.
    pub verdict: Verdict,
}

/// The name of the object with the static tags.
const ROOM: &str = "room";
/// Views of one object by two cameras within this time are shared, ns.
const SHARED_NS: u64 = 50_000_000;
/// Columns and rows of a corner of the image, as shares.
const CORNER: f64 = 0.25;

impl SiteSession {
    pub(super) fn finish(&self, found: SiteSolution) -> Result<CalibratedSite, SiteError> {
        let world = WorldFrame::choose(&self.plan, &found)?;
        let scale = Scale::from_distances(&self.plan.distances, &found)?;
        let wrong = |error: &dyn std::fmt::Display| SiteError::Result(error.to_string());
        let cameras: Vec<SiteCameraReport> = (0..found.rig.cameras().len())
            .map(|at| found.camera(at))
            .collect();
        let rig = found.calibrated_rig(&world, &scale, &cameras);
        let rig = rig.map_err(|error| wrong(&error))?;
        let covariance = found.covariance_at_known_scale();
        let (mut objects, mut reports) = (Vec::new(), Vec::new());
        for body in 0..found.members.n_bodies {
            if let Some((object, report)) = found.object(body, &covariance, &scale)? {
                objects.push(object);
                reports.push(report);
            }
        }
        objects.extend(found.room(&world, &scale)?);
        let loose = &found.members.loose;
        let still = &found.members.wanted[found.members.n_carried()..];
        let mut report = SiteReport {
            world: world.tag.map_or_else(
                || format!("camera {}", found.rig.cameras()[found.reference].id),
                |tag| tag.to_string(),
            ),
            reference: found.rig.cameras()[found.reference].id.to_string(),
            images: self.images.n_received(),
            synchronised: found.synchronised,
            rms_px: found.adjusted.solution.rms_px,
            noise_ratio: found.adjusted.noise_ratio(),
            held_out: found.adjusted.held_out(&found.seen.views),
            cameras,
            objects: reports,
            still: still.iter().map(|own| own.tag.to_string()).collect(),
            unassigned: loose.iter().map(ToString::to_string).collect(),
            scale_factor: scale.correction,
            scale_sigma: scale.sigma,
            unsolved: Vec::new(),
            verdict: Verdict::new(),
        };
        found.judge(&mut report);
        self.judge_blind_cameras(&mut report);
        Ok(CalibratedSite {
            rig,
            objects,
            report,
        })
    }
}

impl SiteSession {
    /// Names the cameras that are left out.
    fn judge_blind_cameras(&self, report: &mut SiteReport) {
        for camera in self.blind_cameras() {
            let cause = format!(
                "no image of camera {camera} shows a tag, so that nothing is known of it and it was left out: carry \
                 objects before it, check its light and focus"
            );
            report.unsolved.push(cause.clone());
            report.verdict.add(Grade::Usable, Finding::Unplaced(cause));
        }
    }
}

impl SiteSolution {
    fn calibrated_rig(
        &self,
        world: &WorldFrame,
        scale: &Scale,
        reports: &[SiteCameraReport],
    ) -> Result<Rig, sextant_site_model::RigError> {
        let bundle = &self.adjusted.solution.bundle;
        let cameras = self.rig.cameras().iter().enumerate().map(|(at, camera)| {
            let solved = &bundle.cameras[at];
            let pose = world.world_from_adjusted * solved.world_from_camera;
            let report = &reports[at];
            let sigma = PoseSigma {
                position_m: (report.sigma_mm * 1e-3).min(1.0),
                orientation_rad: report.sigma_deg.to_radians().min(1.0),
            };
            Camera {
                lens: solved.lens,
                world_from_camera: self.is_placed[at].then(|| scale.apply(&pose)),
                pose_prior: self.is_placed[at].then_some(sigma).into(),
                lens_prior: self.lens_prior(at),
                line_delay_s: clocks::line_delay(&self.adjusted.solution, at)
                    .filter(|found| found.is_rolling(camera))
                    .map(|found| found.line_delay_s),
                ..camera.clone()
            }
        });
        Rig::new(cameras.collect())?.with_scale_sigma(Some(scale.sigma))
    }

    fn lens_prior(&self, at: usize) -> Prior<sextant_site_model::LensSigma> {
        let solution = &self.adjusted.solution;
        let (solved, covariance) = (&solution.bundle.cameras[at], solution.covariance.lens(at));
        if covariance.nrows() != solved.lens.n_parameters() {
            return Prior::Default;
        }
        let resolution = self.rig.cameras()[at].resolution;
        Prior::Sigma(lens_sigma(&solved.lens, resolution, &covariance))
    }

    fn camera(&self, at: usize) -> SiteCameraReport {
        let solution = &self.adjusted.solution;
        let covariance = solution.covariance.at_known_scale().camera(at);
        let covariance = covariance.unwrap_or_else(Matrix6::zeros);
        let rms = |first: usize| {
            let variance = (first..first + 3).map(|row| covariance[(row, row)].max(0.0));
            (variance.sum::<f64>() / 3.0).sqrt()
        };
        let lens_sigma = self.lens_prior(at).given();
        let focal = KeptParameter::Lens {
            camera: at,
            parameter: 0,
        };
        let focal_sigma = solution.covariance.sigma(focal);
        let own = solution.bundle.residuals();
        let own = own.filter(|residual| solution.bundle.images[residual.image].camera == at);
        let squares: Vec<f64> = own.map(|residual| residual.rms_px().powi(2)).collect();
        let clock = self.clocks[at];
        let line_delay = clocks::line_delay(solution, at);
        SiteCameraReport {
            camera: self.rig.cameras()[at].id.to_string(),
            placed: self.is_placed[at],
            images: self.images_of(at),
            sigma_mm: rms(0) * 1e3,
            sigma_deg: rms(3).to_degrees(),
            focal_px: solution.bundle.cameras[at].lens.intrinsics().fx,
            focal_sigma_px: focal_sigma.unwrap_or(0.0),
            distortion_sigma_px: lens_sigma.map_or(0.0, |sigma| sigma.distortion_px),
            corners_covered: self.corners_covered(at),
            rms_px: (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt(),
            clock_offset_ms: clock.map(|clock| clock.offset_s * 1e3),
            clock_sigma_ms: clock.map(|clock| clock.sigma_s * 1e3),
            line_delay_us: line_delay.map(|found| found.line_delay_s * 1e6),
            line_delay_sigma_us: line_delay.map(|found| found.sigma_s * 1e6),
        }
    }

    fn images_of(&self, camera: usize) -> usize {
        let views = self.seen.views.iter().zip(&self.seen.body_of);
        let own = views.filter(|(view, body)| view.camera == camera && body.is_some());
        let mut times: Vec<u64> = own.map(|(view, _)| view.capture_ns).collect();
        times.sort_unstable();
        times.dedup();
        times.len()
    }

    /// Share of the corners of the image that a tag of an object has reached.
    fn corners_covered(&self, camera: usize) -> f64 {
        let [width, height] = self.rig.cameras()[camera].resolution.map(f64::from);
        let mut covered = [false; 4];
        let views = self.seen.views.iter().zip(&self.seen.body_of);
        let own = views.filter(|(view, body)| view.camera == camera && body.is_some());
        let tags = own.flat_map(|(view, _)| &view.tags);
        for corner in tags.flat_map(|tag| &tag.corners.corners) {
            let side = |at: f64, size: f64| match at / size {
                share if share < CORNER => Some(0),
                share if share > 1.0 - CORNER => Some(1),
                _ => None,
            };
            if let (Some(x), Some(y)) = (side(corner.x, width), side(corner.y, height)) {
                covered[x + 2 * y] = true;
            }
        }
        covered.iter().filter(|is| **is).count() as f64 / 4.0
    }

    /// Name of the object of a body, by its first placed tag.
    pub(super) fn name_of(&self, body: usize) -> String {
        let first = self
            .members
            .tags_of(body)
            .find(|&tag| self.is_tag_placed(tag));
        let first = first
            .or(self.members.tags_of(body).next())
            .unwrap_or_default();
        format!("object-{}", self.members.wanted[first].tag.id)
    }

    /// The object of a body, in the frame of its tags' centroid, with its report; `None` if none of its tags was
    /// placed.
    fn object(
        &self,
        body: usize,
        covariance: &DMatrix<f64>,
        scale: &Scale,
    ) -> Result<Option<(ObjectModel, SiteObjectReport)>, SiteError> {
        let bundle = &self.adjusted.solution.bundle;
        let tags = self.members.tags_of(body);
        let tags: Vec<usize> = tags.filter(|&tag| self.is_tag_placed(tag)).collect();
        if tags.is_empty() {
            return Ok(None);
        }
        let poses = tags.iter().map(|&tag| bundle.tags[tag].object_from_tag);
        let poses: Vec<Pose> = poses.collect();
        let own = DMatrix::from_fn(6 * tags.len(), 6 * tags.len(), |i, j| {
            covariance[(6 * tags[i / 6] + i % 6, 6 * tags[j / 6] + j % 6)]
        });
        let own = aligned(&own, &poses);
        let middle = centroid(&poses);
        let frame = Pose::from_parts(middle.into(), poses[0].rotation);
        let own = turned(&own, &frame.rotation.inverse());
        let known_scale = self.adjusted.solution.covariance.at_known_scale();
        let mut worst = (0.0_f64, 0.0_f64);
        let placed = tags.iter().enumerate().map(|(row, &tag)| {
            let sigma = pose_sigma(&own, row);
            worst = (
                worst.0.max(sigma.position_m * 1e3),
                worst.1.max(sigma.orientation_rad.to_degrees()),
            );
            let size_m = bundle.tags[tag].size_m * scale.factor;
            let size_sigma = known_scale.sigma(KeptParameter::TagSize { tag });
            let pose = scale.apply(&(frame.inverse() * poses[row]));
            ObjectTag {
                pose_prior: Prior::Sigma(sigma),
                size_prior: size_sigma.map(|sigma| sigma.min(1.0) * size_m).into(),
                ..ObjectTag::new(self.members.wanted[tag].tag, size_m, Some(pose))
            }
        });
        let placed: Vec<ObjectTag> = placed.collect();
        let object = named(&self.name_of(body), placed, scale)?;
        let (images, shared) = self.views_of(body);
        let report = SiteObjectReport {
            object: object.id().to_string(),
            tags: object
                .tags()
                .iter()
                .map(|own| own.tag.to_string())
                .collect(),
            sigma_mm: worst.0,
            sigma_deg: worst.1,
            images,
            shared,
        };
        Ok(Some((object, report)))
    }

    /// Images of a body, and how many of them while another camera sees it.
    fn views_of(&self, body: usize) -> (usize, usize) {
        let views = self.seen.of_body(Some(body));
        let mut views: Vec<(u64, usize)> = views
            .map(|at| (self.seen.views[at].capture_ns, self.seen.views[at].camera))
            .collect();
        views.sort_unstable();
        let is_shared = |&(time, camera): &(u64, usize)| {
            let from = views.partition_point(|(other, _)| other + SHARED_NS < time);
            let near = views[from..].iter();
            let mut near = near.take_while(|(other, _)| *other <= time + SHARED_NS);
            near.any(|(_, other)| *other != camera)
        };
        let shared = views.iter().filter(|view| is_shared(view)).count();
        (views.len(), shared)
    }

    /// The static tags as an object whose frame is the world.
    fn room(&self, world: &WorldFrame, scale: &Scale) -> Result<Option<ObjectModel>, SiteError> {
        let bundle = &self.adjusted.solution.bundle;
        let tags = self.still_tags().into_iter().map(|still| {
            let pose = scale.apply(&(world.world_from_adjusted * still.adjusted_from_tag));
            let size_m = bundle.tags[still.tag].size_m * scale.factor;
            ObjectTag::new(self.members.wanted[still.tag].tag, size_m, Some(pose))
        });
        let tags: Vec<ObjectTag> = tags.collect();
        if tags.is_empty() {
            return Ok(None);
        }
        let room = named(ROOM, tags, scale)?;
        room.with_world_from_object(Some(Pose::identity()))
            .map(Some)
            .map_err(|error| SiteError::Result(error.to_string()))
    }
}

fn named(name: &str, tags: Vec<ObjectTag>, scale: &Scale) -> Result<ObjectModel, SiteError> {
    let wrong = |error: &dyn std::fmt::Display| SiteError::Result(error.to_string());
    let id: ObjectId = name.parse().map_err(|error| wrong(&error))?;
    let object = ObjectModel::new(id, tags).map_err(|error| wrong(&error))?;
    object
        .with_scale_sigma(Some(scale.sigma))
        .map_err(|error| wrong(&error))
}
