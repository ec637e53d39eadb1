//! What one view says of possible faults, each a displacement of the tag before the camera that the models don't know of.
//!
//! A view's residuals r with its weights W and derivatives K by the link's pose are known by N = Kᵀ W K and g = Kᵀ W r. That the
//! link is not known better than its covariance P takes from them: with the view among what P knows, N - N P N and g are left;
//! without it N (I + P N)⁻¹ and (I + N P)⁻¹ g are (the Schur complement of the pose), and of the sum of squares what g P g of both
//! leaves: else what the pose's uncertainty explains would seem to be left by every fault. Errors that are stated displace the link by
//! B e as the view shows it, which adds N B e to g; what is expected of that is taken off, and what is unknown of it likewise
//! ([`crate::diagnosis::lasting`]). A fault displaces what is seen by K T x, x its parameters, so that r = -K T x: it is known by Tᵀ N T and -Tᵀ g.

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use sextant_geometry::{Pose, so3};

use crate::diagnosis::recursive_estimate::{FREEDOM, USUAL};
use crate::filter::consider::Displacing;

/// What one view says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Testimony {
    /// N of the link's displacement (dt, dr), world axes about the link's origin, and g.
    pub information: Matrix6<f64>,
    pub gradient: Vector6<f64>,
    /// Weighted sum of squared residuals, and the weight.
    pub square: f64,
    pub weight: f64,
    /// The link and its twist in the world, and its tag.
    pub world_from_link: Pose,
    pub twist: Vector6<f64>,
    pub world_from_tag: Pose,
    /// The camera's centre in the world.
    pub centre: Vector3<f64>,
    /// Variances that are stated of its camera's pose and of its tag's place; zero where nothing is.
    pub stated: [Vector6<f64>; 2],
}

/// The same as the parameters of a fault see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Told<const D: usize> {
    pub information: SMatrix<f64, D, D>,
    pub pull: SVector<f64, D>,
    /// Variances of the parameters by what is stated to be uncertain.
    pub stated: SVector<f64, D>,
}

/// What one view says before what is known of the pose and of lasting errors is taken off.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Account {
    pub testimony: Testimony,
    /// Of the link's pose, and whether the view is part of what is known of it.
    pub covariance: Matrix6<f64>,
    pub took_part: bool,
    /// What lasting errors do to it.
    pub displacing: Vec<Displacing>,
}

impl Account {
    /// Covariance of the link's displacement by lasting errors.
    pub(crate) fn bias_covariance(&self) -> Matrix6<f64> {
        self.displacing.iter().map(Displacing::covariance).sum()
    }

    /// What it says where no errors are stated; `None` where nothing is left.
    pub(crate) fn told(&self) -> Option<Testimony> {
        let mut told = self.testimony;
        told.allow_for_pose(&self.covariance, self.took_part)?;
        told.is_sound().then_some(told)
    }

    /// The same apart from what errors of such a covariance explain. How much a view counts is by what these leave.
    pub(crate) fn apart_from(&self, biases: &Matrix6<f64>) -> Option<Testimony> {
        let mut told = self.testimony;
        told.scale(told.weight.recip());
        told.allow_for(biases)?;
        told.weigh();
        told.allow_for_pose(&self.covariance, self.took_part)?;
        told.is_sound().then_some(told)
    }
}

#[cfg(test)]
impl Testimony {
    /// Of a link at the origin that seems to be displaced by so much, without noise.
    pub fn of_displaced(information: Matrix6<f64>, displaced: &Vector6<f64>) -> Self {
        Self {
            information,
            gradient: information * displaced,
            square: displaced.dot(&(information * displaced)),
            weight: 1.0,
            world_from_link: Pose::identity(),
            twist: Vector6::zeros(),
            world_from_tag: Pose::identity(),
            centre: Vector3::x(),
            stated: [Vector6::zeros(); 2],
        }
    }
}

impl Testimony {
    fn is_sound(&self) -> bool {
        let mut numbers = self.information.iter().chain(self.gradient.iter());
        self.weight > 0.0 && numbers.all(|x| x.is_finite())
    }

    pub(crate) fn scale(&mut self, by: f64) {
        self.information *= by;
        self.gradient *= by;
        self.square *= by;
    }

    /// A view of which much is left counts little, as where corners are fitted.
    fn weigh(&mut self) {
        self.weight = (FREEDOM + USUAL) / (FREEDOM + self.square.max(0.0));
        self.scale(self.weight);
    }

    /// Takes off what the pose's own uncertainty explains.
    fn allow_for_pose(&mut self, covariance: &Matrix6<f64>, took_part: bool) -> Option<()> {
        if took_part {
            let n = self.information;
            self.information = n - n * covariance * n;
            return Some(());
        }
        self.allow_for(covariance)
    }

    fn allow_for(&mut self, covariance: &Matrix6<f64>) -> Option<()> {
        let (n, gradient) = (self.information, self.gradient);
        let inverse = (Matrix6::identity() + n * covariance).try_inverse()?;
        self.information = inverse * n;
        self.gradient = inverse * gradient;
        self.square -= gradient.dot(&(covariance * self.gradient));
        Some(())
    }

    fn told<const D: usize>(&self, by: &SMatrix<f64, 6, D>) -> Told<D> {
        let turned = self.information * by;
        Told {
            information: by.transpose() * turned,
            pull: -(by.transpose() * self.gradient),
            stated: SVector::zeros(),
        }
    }

    fn origin(&self) -> Vector3<f64> {
        self.world_from_link.translation.vector
    }

    /// The camera is displaced: dt, dr about its centre, world axes.
    pub(crate) fn of_camera(&self) -> Told<6> {
        let mut by = -Matrix6::identity();
        let arm = so3::hat(&(self.origin() - self.centre));
        by.fixed_view_mut::<3, 3>(0, 3).copy_from(&arm);
        Told {
            stated: self.stated[0],
            ..self.told(&by)
        }
    }

    /// The tag is displaced on its object: dt, dr about its centre, axes of the tag.
    pub(crate) fn of_place(&self) -> Told<6> {
        let turn: Matrix3<f64> = self
            .world_from_tag
            .rotation
            .to_rotation_matrix()
            .into_inner();
        let arm = so3::hat(&(self.origin() - self.world_from_tag.translation.vector));
        let mut by = Matrix6::zeros();
        by.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
        by.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
        by.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-arm * turn));
        Told {
            stated: self.stated[1],
            ..self.told(&by)
        }
    }

    /// The tag is larger by a share of its size: as if it were nearer by that share of its distance.
    pub(crate) fn of_size(&self) -> Told<1> {
        let away = self.world_from_tag.translation.vector - self.centre;
        self.told(&Vector6::new(-away.x, -away.y, -away.z, 0.0, 0.0, 0.0))
    }

    /// The stamps lie so many seconds after the truth.
    pub(crate) fn of_clock(&self) -> Told<1> {
        self.told(&(-self.twist))
    }

    /// By which angles the camera's displacement displaces the tag in its eyes and turns it.
    pub(crate) fn angles(&self, displaced: &Vector6<f64>) -> [f64; 2] {
        let (moved, turned) = (displaced.fixed_rows::<3>(0), displaced.fixed_rows::<3>(3));
        let away = self.world_from_tag.translation.vector - self.centre;
        let step = moved + turned.cross(&away);
        let distance = away.norm().max(1e-9);
        [step.norm() / distance, turned.norm()]
    }
}
