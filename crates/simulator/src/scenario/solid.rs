//! Bodies of objects: convex solids with flat faces.

use crate::pose_format;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};
use sextant_geometry::Pose;

/// A convex solid in its object's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Solid {
    /// A cuboid.
    Box {
        /// Edges in x, y, z of its own frame, m.
        size: [f64; 3],
        /// Where its centre is, and how it is turned.
        #[serde(with = "pose_format")]
        object_from_box: Pose,
        /// Share of the light that it sends back, 0 to 1.
        albedo: f64,
    },
    /// Any convex polyhedron.
    Polyhedron {
        /// Corners in the object's frame, m.
        vertices: Vec<[f64; 3]>,
        /// Each face's corners as indices into `vertices`, counter-clockwise as seen from outside.
        faces: Vec<Vec<usize>>,
        /// Share of the light that it sends back, 0 to 1.
        albedo: f64,
    },
}

/// A flat face of a solid, seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    /// Corners as indices into the solid's vertices, counter-clockwise as seen from outside.
    pub corners: Vec<usize>,
    /// Unit vector out of the solid.
    pub normal: Vector3<f64>,
    /// The face's plane: `normal . point = offset`, m.
    pub offset: f64,
}

/// Corner k of a box has x high where bit 0 of k is set, y where bit 1 is, z where bit 2 is.
const BOX_FACES: [[usize; 4]; 6] = [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
];

impl Solid {
    /// A prism over a convex polygon given counter-clockwise as seen from above, from height `bottom` to `top`; at the
    /// top the polygon is scaled by `taper`.
    pub fn prism(polygon: &[[f64; 2]], [bottom, top]: [f64; 2], taper: f64, albedo: f64) -> Self {
        let n = polygon.len();
        let below = polygon.iter().map(|&[x, y]| [x, y, bottom]);
        let above = polygon.iter().map(|&[x, y]| [x * taper, y * taper, top]);
        let sides = (0..n).map(|i| vec![i, (i + 1) % n, n + (i + 1) % n, n + i]);
        let ends = [(0..n).rev().collect(), (n..2 * n).collect()];
        Self::Polyhedron {
            vertices: below.chain(above).collect(),
            faces: ends.into_iter().chain(sides).collect(),
            albedo,
        }
    }

    /// Share of the light that it sends back.
    pub fn albedo(&self) -> f64 {
        match self {
            Self::Box { albedo, .. } | Self::Polyhedron { albedo, .. } => *albedo,
        }
    }

    /// Corners in the object's frame.
    pub fn vertices(&self) -> Vec<Point3<f64>> {
        match self {
            Self::Box {
                size,
                object_from_box,
                ..
            } => (0..8)
                .map(|corner| object_from_box * box_corner(*size, corner))
                .collect(),
            Self::Polyhedron { vertices, .. } => {
                vertices.iter().map(|&v| Point3::from(v)).collect()
            }
        }
    }

    /// Its faces; one with fewer than three corners or a corner that doesn't exist is left out.
    pub fn faces(&self) -> Vec<Face> {
        let vertices = self.vertices();
        let face = |corners: &[usize]| Face::through(&vertices, corners);
        match self {
            Self::Box { .. } => BOX_FACES
                .iter()
                .filter_map(|corners| face(corners))
                .collect(),
            Self::Polyhedron { faces, .. } => {
                faces.iter().filter_map(|corners| face(corners)).collect()
            }
        }
    }
}

fn box_corner(size: [f64; 3], corner: usize) -> Point3<f64> {
    let coordinate = |axis: usize| {
        let half = size[axis] / 2.0;
        if corner >> axis & 1 == 1 { half } else { -half }
    };
    Point3::new(coordinate(0), coordinate(1), coordinate(2))
}

impl Face {
    /// The plane by Newell's method, which takes all corners into account.
    fn through(vertices: &[Point3<f64>], corners: &[usize]) -> Option<Self> {
        let points: Vec<&Point3<f64>> = corners
            .iter()
            .map(|&i| vertices.get(i))
            .collect::<Option<_>>()?;
        let origin = *points.first()?;
        let fan = points
            .windows(2)
            .map(|pair| (pair[0] - origin).cross(&(pair[1] - origin)));
        let normal = fan.sum::<Vector3<f64>>().try_normalize(1e-12)?;
        let offset =
            points.iter().map(|p| normal.dot(&p.coords)).sum::<f64>() / points.len() as f64;
        Some(Self {
            corners: corners.to_vec(),
            normal,
            offset,
        })
    }

    /// How far a point lies in front of the face, m; negative behind it.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces_look_outwards(solid: &Solid) {
        let vertices = solid.vertices();
        let faces = solid.faces();
        for face in &faces {
            for (i, vertex) in vertices.iter().enumerate() {
                let distance = face.distance(vertex);
                let on_it = face.corners.contains(&i);
                assert!(if on_it {
                    distance.abs() < 1e-12
                } else {
                    distance < -1e-3
                });
            }
        }
        let edges: usize = faces.iter().map(|face| face.corners.len()).sum();
        assert_eq!(
            vertices.len() + faces.len(),
            edges / 2 + 2,
            "Euler's formula"
        );
    }

    #[test]
    fn faces_of_a_box_look_outwards_and_close_it() {
        faces_look_outwards(&Solid::Box {
            size: [0.1, 0.2, 0.3],
            object_from_box: Pose::identity(),
            albedo: 0.5,
        });
    }

    #[test]
    fn faces_of_a_prism_look_outwards_and_close_it() {
        let polygon = [[0.1, 0.0], [0.0, 0.1], [-0.1, 0.0], [0.0, -0.1]];
        faces_look_outwards(&Solid::prism(&polygon, [-0.05, 0.05], 0.6, 0.5));
    }
}
