//! What one camera has before it at one instant: solids in normalised coordinates, and which hides which.
//!
//! Normalised coordinates are (x/z, y/z) of the camera frame: outlines of convex solids are convex there, whatever the
//! lens does. The lens is not known here. A solid that isn't wholly before the camera is left out.

use crate::model::Model;
use crate::polygon::{Bounds, Polygon, convex_hull};
use nalgebra::{Point2, Point3, Vector3};
use sextant_geometry::Pose;

/// Nearer to the camera's plane than this nothing is seen, m.
pub(crate) const NEAR_M: f64 = 0.02;
/// How far solids that touch may cut one another by rounding, m.
const TOUCHING_M: f64 = 1e-6;

/// The solids of a model as a camera sees them. Made once, placed for each instant; no heap growth after the first.
pub(crate) struct SolidsView {
    pub solids: Vec<PlacedSolid>,
    /// Those that are in view.
    pub in_view: Vec<usize>,
}

/// A solid at an instant.
pub(crate) struct PlacedSolid {
    pub world_from_object: Pose,
    pub camera_from_object: Pose,
    /// The outline in normalised coordinates, the positive way round; empty where the solid isn't in view.
    pub outline: Polygon,
    pub bounds: Bounds,
    /// Solids that hide part of it.
    pub hiders: Vec<usize>,
    points_in_camera: Vec<Point3<f64>>,
    planes_in_camera: Vec<(Vector3<f64>, f64)>,
}

impl SolidsView {
    pub fn new(model: &Model) -> Self {
        let placed = |_| PlacedSolid {
            world_from_object: Pose::identity(),
            camera_from_object: Pose::identity(),
            outline: Polygon::empty(),
            bounds: Bounds::NOTHING,
            hiders: Vec::with_capacity(model.solids.len()),
            points_in_camera: Vec::new(),
            planes_in_camera: Vec::new(),
        };
        Self {
            solids: model.solids.iter().map(placed).collect(),
            in_view: Vec::with_capacity(model.solids.len()),
        }
    }

    /// Puts all solids where they are at `true_ns`.
    pub fn place(&mut self, model: &Model, camera_from_world: &Pose, true_ns: u64) {
        for (placed, solid) in self.solids.iter_mut().zip(&model.solids) {
            placed.world_from_object = model.paths[solid.object].world_from_object(true_ns);
            placed.camera_from_object = camera_from_world * placed.world_from_object;
            placed.place(solid);
        }
        self.in_view.clear();
        self.in_view
            .extend((0..self.solids.len()).filter(|&solid| self.solids[solid].in_view()));
        for hidden in 0..self.solids.len() {
            self.find_hiders(hidden);
        }
    }

    fn find_hiders(&mut self, hidden: usize) {
        let mut hiders = std::mem::take(&mut self.solids[hidden].hiders);
        hiders.clear();
        let back = &self.solids[hidden];
        let hides = |&front: &usize| {
            let front_solid = &self.solids[front];
            front != hidden
                && front_solid.bounds.overlaps(&back.bounds)
                && front_solid.is_before(back)
        };
        hiders.extend(self.in_view.iter().copied().filter(hides));
        self.solids[hidden].hiders = hiders;
    }
}

impl PlacedSolid {
    pub fn in_view(&self) -> bool {
        !self.outline.corners().is_empty()
    }

    /// True where the camera looks at the outer side of a face.
    pub fn faces_camera(&self, face: usize) -> bool {
        let (_, offset) = self.planes_in_camera[face];
        offset < 0.0
    }

    fn place(&mut self, solid: &crate::model::SolidModel) {
        let pose = self.camera_from_object;
        self.points_in_camera.clear();
        self.points_in_camera
            .extend(solid.vertices.iter().map(|v| pose * v));
        self.planes_in_camera.clear();
        self.planes_in_camera.extend(solid.faces.iter().map(|face| {
            let normal = pose.rotation * face.normal;
            (normal, face.offset + normal.dot(&pose.translation.vector))
        }));
        self.find_outline();
    }

    fn find_outline(&mut self) {
        let mut points = normalised_polygon(self.points_in_camera.iter().copied());
        self.outline = convex_hull(points.corners_mut());
        self.bounds = self.outline.bounds();
    }

    /// True where this solid may hide the other: a face plane of either separates them, and this one is on the camera's
    /// side. Where only an edge of each separates them, the nearer centre counts.
    fn is_before(&self, other: &Self) -> bool {
        if let Some(camera_is_outside) = other.separated_from(self) {
            return camera_is_outside;
        }
        if let Some(camera_is_outside) = self.separated_from(other) {
            return !camera_is_outside;
        }
        self.centre().norm_squared() < other.centre().norm_squared()
    }

    /// Looks for a face with all of `other` on its outer side; tells whether the camera is on that side too.
    fn separated_from(&self, other: &Self) -> Option<bool> {
        let separates = |(normal, offset): &&(Vector3<f64>, f64)| {
            let mut points = other.points_in_camera.iter();
            points.all(|p| normal.dot(&p.coords) - offset >= -TOUCHING_M)
        };
        let (_, offset) = self.planes_in_camera.iter().find(separates)?;
        Some(*offset < 0.0)
    }

    fn centre(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = self.points_in_camera.iter().map(|p| p.coords).sum();
        sum / self.points_in_camera.len().max(1) as f64
    }
}

/// (x/z, y/z) of a point before the camera.
pub(crate) fn normalised(point_in_camera: &Point3<f64>) -> Option<Point2<f64>> {
    let z = point_in_camera.z;
    (z > NEAR_M).then(|| Point2::new(point_in_camera.x / z, point_in_camera.y / z))
}

/// A flat convex polygon in normalised coordinates; empty where a corner isn't before the camera.
pub(crate) fn normalised_polygon(points_in_camera: impl Iterator<Item = Point3<f64>>) -> Polygon {
    let mut polygon = Polygon::empty();
    for point in points_in_camera {
        match normalised(&point) {
            Some(point) => polygon.push(point),
            None => return Polygon::empty(),
        }
    }
    polygon
}
