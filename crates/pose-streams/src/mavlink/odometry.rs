//! `ODOMETRY` (331): pose in a local frame with its axes forward, right, down (or north, east, down), velocities in the
//! body's axes forward, right, down.
//!
//! Sextant's world and objects have z up; x is an object's forward and y its left, as in ROS. With N the matrix from
//! the world's to the local axes and F = diag(1, -1, -1) from the object's to the body's: p' = N p, R' = N R F, and
//! covariances are turned by N.

use crate::narrowed;
use nalgebra::{Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3};
use sextant_proto::ObjectPose;

/// `MAV_FRAME_LOCAL_NED`, `MAV_FRAME_LOCAL_FRD` and `MAV_FRAME_BODY_FRD`.
const LOCAL_NED: u8 = 1;
const LOCAL_FRD: u8 = 20;
const BODY_FRD: u8 = 12;
/// `MAV_ESTIMATOR_TYPE_MOCAP`.
const MOTION_CAPTURE: u8 = 6;
/// The definition's word for "unknown".
const QUALITY_UNKNOWN: u8 = 0;

/// The frame of positions and attitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LocalFrame {
    /// Forward, right, down: the world turned about its x axis.
    Frd,
    /// North, east, down.
    Ned {
        /// Angle of north from the world's x axis towards its y axis, rad; a quarter turn where x is east and y is
        /// north.
        north_rad: f64,
    },
}

impl LocalFrame {
    fn id(&self) -> u8 {
        match self {
            Self::Frd => LOCAL_FRD,
            Self::Ned { .. } => LOCAL_NED,
        }
    }

    /// The local axes in terms of the world's, one a row.
    #[rustfmt::skip]
    fn axes_in_world(&self) -> Matrix3<f64> {
        let north_rad = match self {
            Self::Frd => 0.0,
            Self::Ned { north_rad } => *north_rad,
        };
        let (sin, cos) = north_rad.sin_cos();
        Matrix3::new(
            cos, sin, 0.0,
            sin, -cos, 0.0,
            0.0, 0.0, -1.0,
        )
    }
}

fn flu_from_frd() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0))
}

/// All 233 bytes.
pub(super) fn payload(pose: &ObjectPose, frame: &LocalFrame, reset_counter: u8) -> Vec<u8> {
    let local_from_world = frame.axes_in_world();
    let world_from_object = pose.world_from_object();
    let world_from_flu = world_from_object.rotation.to_rotation_matrix().into_inner();
    let world_from_body = world_from_flu * flu_from_frd();
    let position = local_from_world * world_from_object.translation.vector;
    let attitude = Rotation3::from_matrix_unchecked(local_from_world * world_from_body);
    let attitude = UnitQuaternion::from_rotation_matrix(&attitude);
    let [vx, vy, vz, wx, wy, wz] = pose.twist;
    let in_body = |v: Vector3<f64>| world_from_body.transpose() * v;
    let (velocity, rates) = (
        in_body(Vector3::new(vx, vy, vz)),
        in_body(Vector3::new(wx, wy, wz)),
    );
    let mut bytes = (pose.capture_ns / 1000).to_le_bytes().to_vec();
    let q = attitude.quaternion();
    let floats = position.iter().copied().chain([q.w, q.i, q.j, q.k]);
    let floats = floats.chain(velocity.iter().copied());
    let floats = floats.chain(rates.iter().copied()).map(narrowed);
    let floats = floats.chain(turned_covariance(pose, &local_from_world).map(narrowed));
    floats
        .chain(unknown_covariance())
        .for_each(|float| bytes.extend(float.to_le_bytes()));
    bytes.extend([
        frame.id(),
        BODY_FRD,
        reset_counter,
        MOTION_CAPTURE,
        QUALITY_UNKNOWN,
    ]);
    bytes
}

/// Upper right triangle, row by row, over (x, y, z, rotation about x, y, z) of the local frame.
fn turned_covariance(
    pose: &ObjectPose,
    local_from_world: &Matrix3<f64>,
) -> impl Iterator<Item = f64> {
    let mut turn = Matrix6::zeros();
    turn.fixed_view_mut::<3, 3>(0, 0)
        .copy_from(local_from_world);
    turn.fixed_view_mut::<3, 3>(3, 3)
        .copy_from(local_from_world);
    let turned = turn * Matrix6::from_row_slice(&pose.covariance) * turn.transpose();
    (0..6).flat_map(move |row| (row..6).map(move |column| turned[(row, column)]))
}

/// Nothing is published of the velocity's covariance; the definition has NaN in the first place for that.
fn unknown_covariance() -> impl Iterator<Item = f32> {
    std::iter::once(f32::NAN).chain(std::iter::repeat_n(0.0, 20))
}
