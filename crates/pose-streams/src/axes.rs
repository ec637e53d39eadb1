//! The world's axes as other tools have them. The axes of objects are renamed like those of the world, so that an
//! object that is aligned with the world is aligned with it everywhere.
//!
//! With M the matrix whose rows are the new axes, a point is p' = M p and a rotation R' = M R Mᵀ. M may be a reflection
//! (left-handed axes); the rotation axis of R' is then det(M) M a, where a is that of R, and its angle the same.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use sextant_geometry::Pose;

/// A convention for axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axes {
    /// Sextant's own, and those of ROS: right-handed, z up.
    ZUp,
    /// OpenGL and OpenVR: right-handed, y up: (x, z, -y).
    YUp,
    /// Unity: left-handed, x right, y up, z forward, where Sextant's x is forward and y left: (-y, z, x).
    Unity,
}

/// A pose in some convention.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvertedPose {
    /// Metres.
    pub position: [f64; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

impl Axes {
    /// The new axes in terms of Sextant's, one a row.
    #[rustfmt::skip]
    fn matrix(self) -> Matrix3<f64> {
        match self {
            Self::ZUp => Matrix3::identity(),
            Self::YUp => Matrix3::new(
                1.0, 0.0, 0.0,
                0.0, 0.0, 1.0,
                0.0, -1.0, 0.0,
            ),
            Self::Unity => Matrix3::new(
                0.0, -1.0, 0.0,
                0.0, 0.0, 1.0,
                1.0, 0.0, 0.0,
            ),
        }
    }

    /// A direction of the world in these axes.
    #[must_use]
    pub fn direction(self, in_world: [f64; 3]) -> [f64; 3] {
        (self.matrix() * Vector3::from(in_world)).into()
    }

    /// `world_from_object` in these axes.
    #[must_use]
    pub fn convert(self, world_from_object: &Pose) -> ConvertedPose {
        let matrix = self.matrix();
        let q = &world_from_object.rotation;
        let axis = matrix * Vector3::new(q.i, q.j, q.k) * matrix.determinant();
        ConvertedPose {
            position: (matrix * world_from_object.translation.vector).into(),
            orientation: [axis.x, axis.y, axis.z, q.w],
        }
    }
}

/// Euler angles in degrees about x, y and z of the rotation that turns about z first, then x, then y, all of them fixed
/// axes: R = R_y R_x R_z, as Unity and VRChat have it. Where x is 90° up or down, z is 0.
#[must_use]
pub fn euler_zxy_deg([x, y, z, w]: [f64; 4]) -> [f64; 3] {
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    let r = rotation.to_rotation_matrix().into_inner();
    let about_x = (-r[(1, 2)]).clamp(-1.0, 1.0).asin();
    let is_locked = r[(0, 2)].hypot(r[(2, 2)]) < 1e-9;
    let (about_y, about_z) = if is_locked {
        ((-r[(2, 0)]).atan2(r[(0, 0)]), 0.0)
    } else {
        (r[(0, 2)].atan2(r[(2, 2)]), r[(1, 0)].atan2(r[(1, 1)]))
    };
    [about_x, about_y, about_z].map(f64::to_degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Translation3;

    const ALL: [Axes; 3] = [Axes::ZUp, Axes::YUp, Axes::Unity];

    fn pose(axis: [f64; 3], position: [f64; 3]) -> Pose {
        Pose::from_parts(
            Translation3::from(position),
            UnitQuaternion::new(Vector3::from(axis)),
        )
    }

    #[test]
    fn up_forward_and_left_are_where_each_convention_has_them() {
        let at = |axes: Axes, point: [f64; 3]| axes.convert(&pose([0.0; 3], point)).position;
        let (forward, left, up) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(at(Axes::YUp, up), [0.0, 1.0, 0.0]);
        assert_eq!(at(Axes::YUp, forward), [1.0, 0.0, 0.0]);
        assert_eq!(at(Axes::YUp, left), [0.0, 0.0, -1.0]);
        assert_eq!(at(Axes::Unity, up), [0.0, 1.0, 0.0]);
        assert_eq!(at(Axes::Unity, forward), [0.0, 0.0, 1.0]);
        assert_eq!(at(Axes::Unity, left), [-1.0, 0.0, 0.0]);
    }

    /// A point of the object lies at the same place of the room, whether it is converted before or after the object is
    /// placed.
    #[test]
    fn conversion_commutes_with_the_motion() {
        let world_from_object = pose([0.3, -1.1, 0.7], [1.0, -2.0, 0.5]);
        let point = Vector3::new(0.2, 0.4, -0.6);
        for axes in ALL {
            let matrix = axes.matrix();
            let in_world = world_from_object.rotation * point;
            let in_world = matrix * (in_world + world_from_object.translation.vector);
            let converted = axes.convert(&world_from_object);
            let [x, y, z, w] = converted.orientation;
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            let there = rotation * (matrix * point) + Vector3::from(converted.position);
            assert!((there - in_world).norm() < 1e-12, "{axes:?}");
        }
    }

    #[test]
    fn a_turn_to_the_left_is_negative_about_the_up_axis_of_unity() {
        let turned = Axes::Unity.convert(&pose([0.0, 0.0, 0.5], [0.0; 3]));
        let euler = euler_zxy_deg(turned.orientation);
        assert!((euler[1] + 0.5_f64.to_degrees()).abs() < 1e-9, "{euler:?}");
        assert!(euler[0].abs() < 1e-9 && euler[2].abs() < 1e-9);
    }

    #[test]
    fn euler_angles_compose_to_the_rotation() {
        for [x, y, z] in [
            [10.0, 20.0, 30.0],
            [-80.0, 170.0, -100.0],
            [0.0, -45.0, 179.0],
            [90.0, 35.0, 0.0],
            [-90.0, -120.0, 0.0],
        ] {
            let about = |axis: Vector3<f64>, degrees: f64| {
                UnitQuaternion::new(axis * f64::to_radians(degrees))
            };
            let rotation = about(Vector3::y(), y) * about(Vector3::x(), x) * about(Vector3::z(), z);
            let q = rotation.quaternion();
            let euler = euler_zxy_deg([q.i, q.j, q.k, q.w]);
            for (found, wanted) in euler.iter().zip([x, y, z]) {
                assert!((found - wanted).abs() < 1e-6, "{euler:?} for {x} {y} {z}");
            }
        }
    }
}
