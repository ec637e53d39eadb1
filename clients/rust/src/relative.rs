//! Where one object is as seen from another.

use crate::Pose;
use crate::interpolation::worse;
use nalgebra::{Isometry3, Matrix3, Matrix6, UnitQuaternion, Vector3};
use sextant_geometry::so3;
use sextant_proto::State;

/// Pose of object b in the frame of object a, at one instant: `a_from_b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Transform {
    /// The object whose frame it is in.
    pub a: String,
    /// The object that is described.
    pub b: String,
    /// The instant, ns since the Unix epoch.
    pub t_ns: u64,
    /// The state that promises less of the two.
    pub state: State,
    /// The origin of b in a, metres.
    pub position: Vector3<f64>,
    /// The axes of b in a.
    pub orientation: UnitQuaternion<f64>,
    /// Covariance over (x, y, z, rx, ry, rz), m and rad, in the axes of a, about the origin of b. It takes the errors
    /// of both objects for independent; errors that the cameras have in common cancel in part, so that it is rather too
    /// large.
    pub covariance: Matrix6<f64>,
}

impl Transform {
    /// The rigid motion that maps points of b into a.
    #[must_use]
    pub fn a_from_b(&self) -> Isometry3<f64> {
        Isometry3::from_parts(self.position.into(), self.orientation)
    }

    /// From two poses at the same instant.
    pub(crate) fn between(a: &Pose, b: &Pose) -> Self {
        let a_from_b = a.world_from_object().inv_mul(&b.world_from_object());
        Self {
            a: a.object.clone(),
            b: b.object.clone(),
            t_ns: b.t_ns,
            state: worse(a.state, b.state),
            position: a_from_b.translation.vector,
            orientation: a_from_b.rotation,
            covariance: covariance(a, b),
        }
    }
}

/// To first order the error of `a_from_b` is `R_a' (e_b - e_a + d x r_a, r_b - r_a)` with errors `(e, r)` of both poses
/// and `d` from a to b, all in world axes.
fn covariance(a: &Pose, b: &Pose) -> Matrix6<f64> {
    let lever = so3::hat(&(b.position - a.position));
    let mut by_a = -Matrix6::<f64>::identity();
    by_a.fixed_view_mut::<3, 3>(0, 3).copy_from(&lever);
    let in_world = by_a * a.covariance * by_a.transpose() + b.covariance;
    let a_from_world = a.orientation.inverse().to_rotation_matrix();
    let turn = on_diagonal(a_from_world.matrix());
    turn * in_world * turn.transpose()
}

fn on_diagonal(block: &Matrix3<f64>) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(block);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(block);
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolation::tests::pose;
    use nalgebra::Vector6;
    use sextant_geometry::se3;

    fn two() -> (Pose, Pose) {
        let mut a = pose(
            0.0,
            Vector3::new(0.3, -0.2, 1.0),
            Vector3::new(0.4, 1.1, -0.3),
        );
        let mut b = pose(
            0.0,
            Vector3::new(-0.5, 0.7, 0.2),
            Vector3::new(-1.0, 0.2, 0.8),
        );
        let root = |seed: f64| {
            Matrix6::from_fn(|row, column| (seed + (row * 6 + column) as f64).sin() * 1e-3)
        };
        a.covariance = root(1.0) * root(1.0).transpose();
        b.covariance = root(2.0) * root(2.0).transpose();
        (a, b)
    }

    /// Derivative of the error of `a_from_b` by a step of one of the two, by differences.
    fn jacobian(
        a: &Pose,
        b: &Pose,
        moved: fn(&Pose, &Pose, &Vector6<f64>) -> Isometry3<f64>,
    ) -> Matrix6<f64> {
        const STEP: f64 = 1e-6;
        let still = moved(a, b, &Vector6::zeros());
        let column = |index| {
            let mut step = Vector6::zeros();
            step[index] = STEP;
            se3::difference(&moved(a, b, &step), &still) / STEP
        };
        Matrix6::from_columns(&[0, 1, 2, 3, 4, 5].map(column))
    }

    #[test]
    fn the_covariance_is_that_of_the_numeric_jacobians() {
        let (a, b) = two();
        let by_a = jacobian(&a, &b, |a, b, step| {
            se3::perturb(&a.world_from_object(), step).inv_mul(&b.world_from_object())
        });
        let by_b = jacobian(&a, &b, |a, b, step| {
            a.world_from_object()
                .inv_mul(&se3::perturb(&b.world_from_object(), step))
        });
        let expected =
            by_a * a.covariance * by_a.transpose() + by_b * b.covariance * by_b.transpose();
        let error = Transform::between(&a, &b).covariance - expected;
        assert!(error.norm() < 1e-5 * expected.norm(), "{error}");
    }

    #[test]
    fn the_transform_maps_points_of_b_into_a() {
        let (a, b) = two();
        let point = nalgebra::Point3::new(0.1, 0.2, 0.3);
        let in_a = Transform::between(&a, &b).a_from_b() * point;
        let in_world = b.world_from_object() * point;
        assert!((a.world_from_object() * in_a - in_world).norm() < 1e-12);
    }
}
