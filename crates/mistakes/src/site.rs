//! The site as its files have it, and the views that may contradict it.

use nalgebra::{Point2, Vector2};
use sextant_geometry::{Lens, Pose};
use sextant_site_model::PoseSigma;

/// Cameras and tags by index.
#[derive(Debug, Clone, Default)]
pub struct NominalSite {
    /// The cameras; `None` where one has no pose.
    pub cameras: Vec<Option<SiteCamera>>,
    /// The tags.
    pub tags: Vec<SiteTag>,
}

/// A camera as its file has it.
#[derive(Debug, Clone)]
pub struct SiteCamera {
    /// Camera frame to pixels.
    pub lens: Lens,
    /// Maps points of the camera into the world.
    pub world_from_camera: Pose,
    /// Standard deviation of its pose: errors of this size are no mistake.
    pub sigma: PoseSigma,
    /// By how much its clock is ahead, s.
    pub clock_s: f64,
}

/// A tag as its object's file has it.
#[derive(Debug, Clone)]
pub struct SiteTag {
    /// The rigid body that has it.
    pub body: usize,
    /// Maps points of the tag into the body.
    pub body_from_tag: Pose,
    /// Edge of the black square, m.
    pub size_m: f64,
    /// Standard deviation of its place: errors of this size are no mistake.
    pub sigma: PoseSigma,
}

/// A rigid body at one time as all cameras saw it.
#[derive(Debug, Clone)]
pub struct Instant {
    /// Which body.
    pub body: usize,
    /// Its tags in the images.
    pub views: Vec<View>,
}

/// One tag in one image.
#[derive(Debug, Clone)]
pub struct View {
    /// Index into [`NominalSite::cameras`].
    pub camera: usize,
    /// Index into [`NominalSite::tags`].
    pub tag: usize,
    /// Top left, top right, bottom right, bottom left, px.
    pub corners: [Point2<f64>; 4],
    /// Their velocities, px/s; zero where they are unknown.
    pub velocities: [Vector2<f64>; 4],
    /// Standard deviation of a coordinate, px.
    pub sigma_px: f64,
}

impl View {
    /// The corners at the time of the stamp, px, if the camera's clock is ahead by so many seconds: they were taken
    /// before it.
    pub(crate) fn corners_at(&self, clock_s: f64) -> [Point2<f64>; 4] {
        std::array::from_fn(|corner| self.corners[corner] + self.velocities[corner] * clock_s)
    }
}
