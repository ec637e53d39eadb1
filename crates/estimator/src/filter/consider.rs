//! What is wrong for good: errors of the cameras' poses, of their lenses and of the tags' places, which no number of images
//! averages away (consider parameters; Schmidt 1966, Application of state-space methods to navigation problems).
//!
//! They are not estimated. How much the state would be off by a given error e of a source is carried along, S = d state / d e:
//! S' = F S in a prediction, S' = S - G (L H S + K) in an update with its gain G, the information L of all corners and
//! K = J^T W dr/de of those that the source displaces. The covariance that is published is P + S C Sᵀ over all sources, P being as large
//! as Fisher's information of the last views makes it ([`Kinematics::own_told`]).

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use sextant_geometry::Pose;

use crate::articulation::MOST_JOINTS;
use crate::filter::clock_states::{Clocks, MOST_CLOCKS, Own};
use crate::filter::joint_states::{JointCross, WIDTH};
use crate::filter::observed_configuration::With;
use crate::filter::state::{Covariance, Kinematics, carry};
use crate::kinematics::configuration::{joint_places, rates_at};
use crate::measurement::view_equations::OF_FISHER;
use crate::{LensSigma, PoseSigma, TagId};

type Sensitivity = SMatrix<f64, 12, 6>;
/// Of the joints' values and speeds.
type OfJoints = SMatrix<f64, WIDTH, 6>;
/// Of the clocks' offsets.
pub(crate) type OfClocks = SMatrix<f64, MOST_CLOCKS, 6>;

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
    /// `None` for a rigid object. Joints hang together with the pose so closely that it would run away without them, and so do clocks
    /// while little is known of them.
    of_joints: Option<Box<OfJoints>>,
    of_clocks: Option<Box<OfClocks>>,
}

/// What the corners that a source displaces said in an update.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part<const D: usize> {
    pub source: Source,
    pub variance: Vector6<f64>,
    /// J^T W dr/de about what was seen; of the rates nothing, which the few milliseconds of an image hardly matter for.
    pub pull: SMatrix<f64, D, 6>,
}

/// What an error of a source does to a link's pose as a view shows it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Displacing {
    pub source: Source,
    pub variance: Vector6<f64>,
    pub by: Matrix6<f64>,
}

/// An update, as far as the sensitivities need it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Gain<const D: usize> {
    /// As [`crate::filter::update::Absorbed::gain`] has it.
    pub with: With<D>,
    /// Place of the camera's clock and seconds by which what was seen lies before the state, where that is estimated.
    pub clock: Option<(usize, f64)>,
    /// Of the configuration.
    pub rates: SVector<f64, D>,
    /// Of all corners.
    pub information: SMatrix<f64, D, D>,
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

impl Part<6> {
    /// About the configuration by which a link's pose changes so; `None` where it is the object's.
    pub fn about<const D: usize>(&self, link: Option<&SMatrix<f64, 6, D>>) -> Part<D> {
        let mut pull = SMatrix::<f64, D, 6>::zeros();
        match link {
            Some(link) => pull.copy_from(&link.tr_mul(&self.pull)),
            None => pull.fixed_rows_mut::<6>(0).copy_from(&self.pull),
        }
        Part {
            source: self.source,
            variance: self.variance,
            pull,
        }
    }
}

impl<const D: usize> Part<D> {
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
            if let Some(of_joints) = &mut acting.of_joints {
                let gone = of_joints.fixed_rows::<MOST_JOINTS>(MOST_JOINTS) * dt;
                let mut values = of_joints.fixed_rows_mut::<MOST_JOINTS>(0);
                values += gone;
            }
        }
    }

    /// About another root; `by_motion` and `by_joints` are what the former one's motion and the joints do to it.
    pub fn rooted(&mut self, by_motion: &Covariance, by_joints: &JointCross) {
        for acting in &mut self.sources {
            acting.sensitivity = by_motion * acting.sensitivity;
            if let Some(of_joints) = &acting.of_joints {
                acting.sensitivity += by_joints * **of_joints;
            }
        }
    }

    fn take<const D: usize>(&mut self, gain: &Gain<D>, parts: &[Part<D>], clocks: Option<&Clocks>) {
        for part in parts {
            if !self.sources.iter().any(|one| one.source == part.source) {
                self.sources.push(Acting {
                    source: part.source,
                    variance: part.variance,
                    sensitivity: Sensitivity::zeros(),
                    of_joints: (joint_places(D) > 0).then(|| Box::new(OfJoints::zeros())),
                    of_clocks: None,
                });
            }
        }
        for acting in &mut self.sources {
            let mut pull = gain.information * acting.seen_in(gain);
            if let Some(part) = parts.iter().find(|part| part.source == acting.source) {
                pull += part.pull;
                acting.variance = part.variance;
            }
            acting.sensitivity -= gain.with.motion.tr_mul(&pull);
            if let Some(of_joints) = &mut acting.of_joints {
                **of_joints -= gain.with.joints.tr_mul(&pull);
            }
            if let Some(clocks) = clocks {
                let of_clocks = acting.of_clocks.get_or_insert_default();
                **of_clocks -= clocks.told_apart(&gain.with.clocks.tr_mul(&pull));
            }
        }
    }

    /// Forgets sources that act no more, next to the variances of the state.
    fn forget<const D: usize>(&mut self, variances: &SMatrix<f64, 12, 1>, parts: &[Part<D>]) {
        self.sources.retain(|acting| {
            let squares = acting.sensitivity.map(|slope| slope * slope);
            let caused = squares * acting.variance;
            parts.iter().any(|part| part.source == acting.source)
                || (0..12).any(|row| caused[row] > FORGOTTEN * variances[row])
        });
    }

    /// Covariance of the configuration by them.
    fn covariance<const D: usize>(&self) -> SMatrix<f64, D, D> {
        let caused = |acting: &Acting| {
            let mut seen = acting.seen::<D>(0.0);
            for (mut column, variance) in seen.column_iter_mut().zip(&acting.variance) {
                column *= variance.sqrt();
            }
            seen * seen.transpose()
        };
        self.sources.iter().map(caused).sum()
    }
}

impl Displacing {
    /// The camera whose pose's error it is.
    pub fn of_camera(&self) -> Option<usize> {
        match self.source {
            Source::Camera(camera) => Some(camera),
            _ => None,
        }
    }

    /// Covariance of the displacement.
    pub fn covariance(&self) -> Matrix6<f64> {
        self.by * Matrix6::from_diagonal(&self.variance) * self.by.transpose()
    }
}

impl Acting {
    /// Of what an update is about.
    fn seen_in<const D: usize>(&self, gain: &Gain<D>) -> SMatrix<f64, D, 6> {
        self.seen_by(gain.clock, &gain.rates)
    }

    /// Of what a camera sees whose clock has that place and offset, at those rates.
    fn seen_by<const D: usize>(
        &self,
        clock: Option<(usize, f64)>,
        rates: &SVector<f64, D>,
    ) -> SMatrix<f64, D, 6> {
        let Some((slot, offset_s)) = clock else {
            return self.seen(0.0);
        };
        let seen = self.seen(offset_s);
        match &self.of_clocks {
            Some(of_clocks) => seen - rates * of_clocks.row(slot),
            None => seen,
        }
    }

    /// Of what is seen so many seconds before the state.
    fn seen<const D: usize>(&self, offset_s: f64) -> SMatrix<f64, D, 6> {
        let mut seen = SMatrix::<f64, D, 6>::zeros();
        let (pose, twist) = (
            self.sensitivity.fixed_rows::<6>(0),
            self.sensitivity.fixed_rows::<6>(6),
        );
        seen.fixed_rows_mut::<6>(0)
            .copy_from(&(pose - twist * offset_s));
        if let Some(first) = rates_at(D) {
            seen.fixed_rows_mut::<6>(first).copy_from(&twist);
        }
        let Some(of_joints) = &self.of_joints else {
            return seen;
        };
        for slot in 0..joint_places(D) {
            let (value, speed) = (of_joints.row(slot), of_joints.row(MOST_JOINTS + slot));
            seen.row_mut(6 + slot)
                .copy_from(&(value - speed * offset_s));
            if let Some(first) = rates_at(D) {
                seen.row_mut(first + 6 + slot).copy_from(&speed);
            }
        }
        seen
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
    pub fn consider<const D: usize>(&mut self, gain: &Gain<D>, parts: &[Part<D>]) {
        let considered = self.considered.get_or_insert_default();
        considered.take(gain, parts, self.clocks.as_deref());
        considered.forget(&self.covariance.diagonal(), parts);
    }

    /// By how much the covariance that is told is larger than that of the filter: as far as the last views brought it about.
    pub fn own_told(&self) -> f64 {
        1.0 + (OF_FISHER - 1.0) * self.news
    }

    /// Covariance of the pose, with what is wrong for good.
    pub fn pose_covariance(&self) -> Matrix6<f64> {
        let own = self.covariance.fixed_view::<6, 6>(0, 0).into_owned();
        own * self.own_told() + self.lasting_covariance::<6>()
    }

    /// What errors that last do to a link's pose as a view by a camera shows it: through the state and in the view itself, whose own
    /// sources these are. `link` is the derivative of its pose by the configuration; `None` where it is the object's.
    pub fn displacing<const D: usize>(
        &self,
        camera_index: usize,
        link: Option<&SMatrix<f64, 6, D>>,
        mut own: Vec<Displacing>,
    ) -> Vec<Displacing> {
        let acting = self.considered.iter().flat_map(|all| &all.sources);
        let clocks = self.clocks.as_deref();
        let clock = clocks.and_then(|clocks| Some((clocks, clocks.slot(camera_index)?)));
        let clock = clock.map(|(clocks, slot)| (slot, clocks.offset_s(slot)));
        let rates = self.rates::<D>();
        for one in acting {
            let seen = one.seen_by(clock, &rates);
            let by = match link {
                Some(link) => link * seen,
                None => seen.fixed_rows::<6>(0).into_owned(),
            };
            match own.iter_mut().find(|own| own.source == one.source) {
                Some(own) => own.by += by,
                None => own.push(Displacing {
                    source: one.source,
                    variance: one.variance,
                    by,
                }),
            }
        }
        own
    }

    /// Covariance of the clocks' offsets by what is wrong for good.
    pub(crate) fn clock_bias_covariance(&self) -> Own {
        let acting = self.considered.iter().flat_map(|all| &all.sources);
        let caused = |one: &Acting| {
            let of_clocks = one.of_clocks.as_deref()?;
            Some(of_clocks * Matrix6::from_diagonal(&one.variance) * of_clocks.transpose())
        };
        acting.filter_map(caused).sum()
    }

    /// Covariance of the configuration by what is wrong for good.
    pub fn lasting_covariance<const D: usize>(&self) -> SMatrix<f64, D, D> {
        let considered = self.considered.as_ref();
        considered.map_or_else(SMatrix::zeros, |considered| considered.covariance())
    }
}
