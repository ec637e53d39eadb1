//! What is wrong for good: the errors of the cameras' poses, which no number of images averages away (consider parameters;
//! Schmidt 1966, Application of state-space methods to navigation problems).
//!
//! They are not estimated. How much the state would be off by a given error of a camera's pose is carried along, S = d state /
//! d error: S' = F S in a prediction, S' = S - G (L H S - L_c A_c) in an update with G = P⁺ Hᵀ, the information L of all and
//! L_c of that camera's corners, and A_c by which an error of the camera displaces what it sees:
//! dt = dt_c + dr_c x (p - c), dr = dr_c. The covariance that is published is P + S C Sᵀ.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};

use super::kinematics::{Kinematics, carried};
use crate::PoseSigma;

type Sensitivity = SMatrix<f64, 12, 6>;

/// How the errors of the cameras' poses act on the state.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Considered {
    /// By camera index.
    cameras: Vec<(usize, PoseSigma, Sensitivity)>,
}

/// What one camera's corners said in an update.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CameraPart {
    pub camera_index: usize,
    pub sigma: PoseSigma,
    /// From the camera's centre to the object's origin, world axes, in m.
    pub arm: Vector3<f64>,
    /// About the pose that was seen.
    pub information: Matrix6<f64>,
}

/// An update, as far as the sensitivities need it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Gain {
    /// P⁺ Hᵀ.
    pub covariance: SMatrix<f64, 12, 6>,
    /// Seconds by which the pose that was seen lies before the state's.
    pub offset_s: f64,
    /// Of all corners.
    pub information: Matrix6<f64>,
}

impl PoseSigma {
    fn covariance(self) -> Matrix6<f64> {
        let variance = |axis: usize| {
            if axis < 3 {
                self.position_m.powi(2)
            } else {
                self.orientation_rad.powi(2)
            }
        };
        Matrix6::from_fn(|row, column| if row == column { variance(row) } else { 0.0 })
    }
}

impl Considered {
    pub fn carry(&mut self, turn: &Matrix3<f64>, gain: &Matrix3<f64>, dt: f64) {
        for (_, _, sensitivity) in &mut self.cameras {
            *sensitivity = carried(sensitivity, turn, gain, dt);
        }
    }

    fn take(&mut self, gain: &Gain, parts: &[CameraPart]) {
        for part in parts {
            let known = self
                .cameras
                .iter()
                .any(|(camera, ..)| *camera == part.camera_index);
            if !known {
                self.cameras
                    .push((part.camera_index, part.sigma, Sensitivity::zeros()));
            }
        }
        for (camera, _, sensitivity) in &mut self.cameras {
            let seen =
                sensitivity.fixed_rows::<6>(0) - sensitivity.fixed_rows::<6>(6) * gain.offset_s;
            let mut pull = gain.information * seen;
            for part in parts.iter().filter(|part| part.camera_index == *camera) {
                pull -= part.information * displacement(&part.arm);
            }
            *sensitivity -= gain.covariance * pull;
        }
    }

    /// Covariance of the pose by them.
    fn covariance(&self) -> Matrix6<f64> {
        let of_camera = |(_, sigma, sensitivity): &(usize, PoseSigma, Sensitivity)| {
            let pose = sensitivity.fixed_rows::<6>(0);
            pose * sigma.covariance() * pose.transpose()
        };
        self.cameras.iter().map(of_camera).sum()
    }
}

/// What an error of the camera's pose does to what it sees at `arm`.
fn displacement(arm: &Vector3<f64>) -> Matrix6<f64> {
    let mut displacement = Matrix6::identity();
    displacement
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&-arm.cross_matrix());
    displacement
}

impl Kinematics {
    /// Notes what the errors of the cameras' poses did in an update.
    pub fn consider(&mut self, gain: &Gain, parts: &[CameraPart]) {
        self.considered.get_or_insert_default().take(gain, parts);
    }

    /// Covariance of the pose, with what is wrong for good.
    pub fn pose_covariance(&self) -> Matrix6<f64> {
        let own = self.covariance.fixed_view::<6, 6>(0, 0).into_owned();
        match &self.considered {
            Some(considered) => own + considered.covariance(),
            None => own,
        }
    }
}
