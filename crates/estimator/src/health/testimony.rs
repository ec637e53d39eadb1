//! What one view says of possible faults, each a displacement of the tag before the camera that the models don't know of.
//!
//! A view's residuals r with its weights W and derivatives K by the link's pose are known by N = Kᵀ W K and g = Kᵀ W r. That the
//! link is not known better than its covariance P takes from them: with the view among what P knows, N - N P N and g are left;
//! without it N (I + P N)⁻¹ and (I + N P)⁻¹ g are (the Schur complement of the pose), and of the sum of squares what g P g of both
//! leaves: else what the pose's uncertainty explains would seem to be left by every fault. What is stated of cameras' poses and
//! tags' places takes from them likewise, view by view; what it makes all views show is no fault either, as far as it is likely. A fault displaces what is seen by K T x, x its parameters, so that r = -K T x: it is known by Tᵀ N T and -Tᵀ g.

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};
use sextant_geometry::{Pose, so3};

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
    /// Covariance of the displacement that may be by what is stated of all cameras' poses and tags' places.
    pub stated: Matrix6<f64>,
}

/// The same as the parameters of a fault see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Told<const D: usize> {
    pub information: SMatrix<f64, D, D>,
    pub pull: SVector<f64, D>,
    /// Covariance of the parameters by what is stated to be uncertain.
    pub stated: SMatrix<f64, D, D>,
}

impl Testimony {
    /// Takes off what the pose's own uncertainty and what is stated explain; `None` where nothing is left.
    pub fn apart_from(mut self, covariance: &Matrix6<f64>, took_part: bool) -> Option<Self> {
        self.allow_for(&self.stated.clone())?;
        if took_part {
            let n = self.information;
            self.information = n - n * covariance * n;
        } else {
            self.allow_for(covariance)?;
        }
        let mut numbers = self.information.iter().chain(self.gradient.iter());
        (self.weight > 0.0 && numbers.all(|x| x.is_finite())).then_some(self)
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
            stated: SMatrix::zeros(),
        }
    }

    /// The same with what may be by what is stated.
    fn told_against_stated(&self, by: &Matrix6<f64>) -> Told<6> {
        let mut told = self.told(by);
        if self.stated != Matrix6::zeros() {
            let back = by.try_inverse().unwrap_or_default();
            told.stated = back * self.stated * back.transpose();
        }
        told
    }

    fn origin(&self) -> Vector3<f64> {
        self.world_from_link.translation.vector
    }

    /// The camera is displaced: dt, dr about its centre, world axes.
    pub(super) fn of_camera(&self) -> Told<6> {
        let mut by = -Matrix6::identity();
        let arm = so3::hat(&(self.origin() - self.centre));
        by.fixed_view_mut::<3, 3>(0, 3).copy_from(&arm);
        self.told_against_stated(&by)
    }

    /// The tag is displaced on its object: dt, dr about its centre, axes of the tag.
    pub(super) fn of_place(&self) -> Told<6> {
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
        self.told_against_stated(&by)
    }

    /// The tag is larger by a share of its size: as if it were nearer by that share of its distance.
    pub(super) fn of_size(&self) -> Told<1> {
        let away = self.world_from_tag.translation.vector - self.centre;
        self.told(&Vector6::new(-away.x, -away.y, -away.z, 0.0, 0.0, 0.0))
    }

    /// The stamps lie so many seconds after the truth.
    pub(super) fn of_clock(&self) -> Told<1> {
        self.told(&(-self.twist))
    }

    /// By which angles the camera's displacement displaces the tag in its eyes and turns it.
    pub(super) fn angles(&self, displaced: &Vector6<f64>) -> [f64; 2] {
        let (moved, turned) = (displaced.fixed_rows::<3>(0), displaced.fixed_rows::<3>(3));
        let away = self.world_from_tag.translation.vector - self.centre;
        let step = moved + turned.cross(&away);
        let distance = away.norm().max(1e-9);
        [step.norm() / distance, turned.norm()]
    }
}
