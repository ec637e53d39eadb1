//! What is wrong for good: errors of the cameras' poses, of their lenses and of the tags' places, which no number of images
//! averages away (consider parameters; Schmidt 1966, Application of state-space methods to navigation problems).
//!
//! They are not estimated. How much the state would be off by a given error e of a source is carried along, S = d state / d e:
//! S' = F S in a prediction, S' = S - G (L H S + K) in an update with G = P⁺ Hᵀ, the information L of all corners and
//! K = J^T W dr/de of those that the source displaces. The covariance that is published is P + S C Sᵀ over all sources.

use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};
use sextant_geometry::Pose;

use super::kinematics::{Covariance, Kinematics, carry};
use crate::{LensSigma, PoseSigma, TagId};

type Sensitivity = SMatrix<f64, 12, 6>;

/// Share of a variance below which a source that no view shows any more is forgotten.
const FORGOTTEN: f64 = 1e-4;

/// What may be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    /// The pose of the camera of that index.
    Camera(usize),
    /// Its lens.
    Lens(usize),
    /// The place of the tag.
    Tag(TagId),
}

/// How the errors act on the state.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Considered {
    sources: Vec<Acting>,
}

#[derive(Debug, Clone, PartialEq)]
struct Acting {
    source: Source,
    /// Of each number of the error.
    variance: Vector6<f64>,
    sensitivity: Sensitivity,
}

/// What the corners that a source displaces said in an update.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    pub source: Source,
    pub variance: Vector6<f64>,
    /// J^T W dr/de about the pose that was seen.
    pub pull: Matrix6<f64>,
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
    /// Of (dt, dr).
    pub(crate) fn variance(self) -> Vector6<f64> {
        let (t, r) = (self.position_m.powi(2), self.orientation_rad.powi(2));
        Vector6::new(t, t, t, r, r, r)
    }
}

impl LensSigma {
    /// Of the errors of focal length and distortion; the other places are free.
    pub(crate) fn variance(self) -> Vector6<f64> {
        let (focal, distortion) = (self.focal_px.powi(2), self.distortion_px.powi(2));
        Vector6::new(focal, distortion, 0.0, 0.0, 0.0, 0.0)
    }
}

impl Part {
    /// Adds a part to those of the same source.
    pub fn join(self, parts: &mut Vec<Self>) {
        match parts.iter_mut().find(|other| other.source == self.source) {
            Some(other) => other.pull += self.pull,
            None => parts.push(self),
        }
    }
}

impl Considered {
    pub fn carry(&mut self, turn: &Matrix3<f64>, gain: &Matrix3<f64>, dt: f64) {
        for acting in &mut self.sources {
            carry(&mut acting.sensitivity, turn, gain, dt);
        }
    }

    /// About another root; `by_motion` is what the former one's motion does to it. Joints are left out.
    pub fn rooted(&mut self, by_motion: &Covariance) {
        for acting in &mut self.sources {
            acting.sensitivity = by_motion * acting.sensitivity;
        }
    }

    fn take(&mut self, gain: &Gain, parts: &[Part]) {
        for part in parts {
            if !self.sources.iter().any(|one| one.source == part.source) {
                self.sources.push(Acting {
                    source: part.source,
                    variance: part.variance,
                    sensitivity: Sensitivity::zeros(),
                });
            }
        }
        for acting in &mut self.sources {
            let sensitivity = &mut acting.sensitivity;
            let seen =
                sensitivity.fixed_rows::<6>(0) - sensitivity.fixed_rows::<6>(6) * gain.offset_s;
            let mut pull = gain.information * seen;
            if let Some(part) = parts.iter().find(|part| part.source == acting.source) {
                pull += part.pull;
                acting.variance = part.variance;
            }
            *sensitivity -= gain.covariance * pull;
        }
    }

    /// Forgets sources that act no more, next to the variances of the state.
    fn forget(&mut self, variances: &SMatrix<f64, 12, 1>, parts: &[Part]) {
        self.sources.retain(|acting| {
            let squares = acting.sensitivity.map(|slope| slope * slope);
            let caused = squares * acting.variance;
            parts.iter().any(|part| part.source == acting.source)
                || (0..12).any(|row| caused[row] > FORGOTTEN * variances[row])
        });
    }

    /// Covariance of the pose by them.
    fn covariance(&self) -> Matrix6<f64> {
        let caused = |acting: &Acting| {
            let pose = acting.sensitivity.fixed_rows::<6>(0);
            pose * Matrix6::from_diagonal(&acting.variance) * pose.transpose()
        };
        self.sources.iter().map(caused).sum()
    }
}

/// What an error of a camera's pose (its axes those of the world) does to a pose that it sees at `arm` from its centre:
/// dt = dt_c + dr_c x arm, dr = dr_c. The corners are displaced as if the object had moved the other way.
pub(crate) fn by_camera(arm: &Vector3<f64>) -> Matrix6<f64> {
    let mut displacement = Matrix6::identity();
    displacement
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&-arm.cross_matrix());
    -displacement
}

/// How a link would have to move for an error of a tag's place on it (its axes those of the link) to displace the tag's
/// corners as it does: by dt + dr x (p - c), with the tag's centre at c.
pub(crate) fn by_tag(world_from_link: &Pose, link_from_tag: &Pose) -> Matrix6<f64> {
    let turn = world_from_link.rotation.to_rotation_matrix().into_inner();
    let arm = turn * link_from_tag.translation.vector;
    let mut displacement = Matrix6::zeros();
    for (row, column, block) in [
        (0, 0, turn),
        (0, 3, arm.cross_matrix() * turn),
        (3, 3, turn),
    ] {
        displacement
            .fixed_view_mut::<3, 3>(row, column)
            .copy_from(&block);
    }
    displacement
}

impl Kinematics {
    /// Notes what lasting errors did in an update.
    pub fn consider(&mut self, gain: &Gain, parts: &[Part]) {
        let considered = self.considered.get_or_insert_default();
        considered.take(gain, parts);
        considered.forget(&self.covariance.diagonal(), parts);
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
