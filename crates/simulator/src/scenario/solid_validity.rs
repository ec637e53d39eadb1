//! What makes a solid possible: convex, closed, its faces seen from outside.

use super::{Face, Solid};
use nalgebra::Point3;
use std::collections::BTreeSet;

/// How far a point may be off the plane of its face, or beyond its edges, m.
const TOLERANCE_M: f64 = 1e-4;
/// The most corners; a solid with more is better cut in two.
const MAX_VERTICES: usize = 16;

impl Face {
    /// True for a point in the plane of the face and within its edges.
    pub(super) fn holds(&self, vertices: &[Point3<f64>], point: &Point3<f64>) -> bool {
        let next = self.corners.iter().cycle().skip(1);
        let within_edges = self.corners.iter().zip(next).all(|(&a, &b)| {
            let inwards = self.normal.cross(&(vertices[b] - vertices[a])).normalize();
            inwards.dot(&(point - vertices[a])) >= -TOLERANCE_M
        });
        within_edges && self.distance(point).abs() <= TOLERANCE_M
    }
}

impl Solid {
    pub(super) fn validate(&self) -> Result<(), &'static str> {
        let vertices = self.vertices();
        if vertices.len() > MAX_VERTICES {
            return Err("it has more than 16 corners");
        }
        let in_range = |x: &f64| x.is_finite() && x.abs() < 1e3;
        if !vertices.iter().all(|v| v.coords.iter().all(in_range)) {
            return Err("a corner is not finite");
        }
        if let Self::Box { size, .. } = self
            && size.iter().any(|&edge| edge < 1e-4)
        {
            return Err("an edge of the box is below 0.1 mm");
        }
        let faces = self.faces();
        if let Self::Polyhedron { faces: given, .. } = self
            && given.len() != faces.len()
        {
            return Err("a face has fewer than three corners or a corner that doesn't exist");
        }
        closed_and_convex(&vertices, &faces)
    }
}

fn closed_and_convex(vertices: &[Point3<f64>], faces: &[Face]) -> Result<(), &'static str> {
    let mut directed = BTreeSet::new();
    for face in faces {
        if vertices.iter().any(|v| face.distance(v) > TOLERANCE_M) {
            return Err("it isn't convex, or a face's corners run clockwise as seen from outside");
        }
        if face
            .corners
            .iter()
            .any(|&c| face.distance(&vertices[c]) < -TOLERANCE_M)
        {
            return Err("a face isn't flat");
        }
        let next = face.corners.iter().cycle().skip(1);
        directed.extend(face.corners.iter().copied().zip(next.copied()));
    }
    let closed = directed.iter().all(|&(a, b)| directed.contains(&(b, a)));
    if closed && faces.len() >= 4 {
        Ok(())
    } else {
        Err("its faces don't close it")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dented_or_open_solid_is_refused() {
        let cube = [[0.0, 0.1], [-0.1, -0.1], [0.1, -0.1]];
        let solid = |change: fn(&mut Vec<Vec<usize>>, &mut Vec<[f64; 3]>)| {
            let mut solid = Solid::prism(&cube, [0.0, 0.1], 1.0, 0.5);
            if let Solid::Polyhedron {
                faces, vertices, ..
            } = &mut solid
            {
                change(faces, vertices);
            }
            solid.validate()
        };
        assert_eq!(solid(|_, _| ()), Ok(()));
        assert!(solid(|faces, _| drop(faces.pop())).is_err());
        assert!(solid(|faces, _| faces[0].reverse()).is_err());
        assert!(solid(|faces, _| faces[0][0] = 99).is_err());
        assert!(solid(|_, vertices| vertices[0] = [f64::NAN; 3]).is_err());
    }
}
