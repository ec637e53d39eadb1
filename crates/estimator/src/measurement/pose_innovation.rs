//! What one view says of possible faults, each a displacement of the tag before the camera that the models don't know of.
//!
//! A view's residuals r with its weights W and derivatives K by the link's pose are known by N = Kᵀ W K and g = Kᵀ W r. That the
//! link is not known better than its covariance P takes from them: with the view among what P knows, N - N P N and g are left;
//! without it N (I + P N)⁻¹ and (I + N P)⁻¹ g are (the Schur complement of the pose), and of the sum of squares what g P g of both
//! leaves: else what the pose's uncertainty explains would seem to be left by every fault. Errors that are stated displace the link by
//! B e as the view shows it, which adds N B e to g; what is expected of that is taken off, and what is unknown of it likewise
//! ([`crate::diagnosis::lasting`]). A fault displaces what is seen by K T x, x its parameters, so that r = -K T x: it is known by Tᵀ N T and -Tᵀ g.

use nalgebra::{Matrix6, Vector3, Vector6};
use sextant_geometry::Pose;

use crate::measurement::biases::BiasJacobian;

/// Of eight coordinates: what a view is expected to leave.
pub(crate) const USUAL: f64 = 8.0;
/// Degrees of freedom of the weights of views by what is left of them.
pub(crate) const FREEDOM: f64 = 12.0;

/// What one view says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PoseInnovation {
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
    /// Variances of the camera's pose and of the tag's pose on its object as given in the files; zero where none are.
    pub camera_variance: Vector6<f64>,
    pub tag_variance: Vector6<f64>,
}

/// What one view says before what is known of the pose and of lasting errors is taken off.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ViewResidual {
    pub innovation: PoseInnovation,
    /// Of the link's pose, and whether the view is part of what is known of it.
    pub covariance: Matrix6<f64>,
    pub took_part: bool,
    /// What lasting errors do to it.
    pub displacing: Vec<BiasJacobian>,
}

impl ViewResidual {
    /// Covariance of the link's displacement by lasting errors.
    pub(crate) fn bias_covariance(&self) -> Matrix6<f64> {
        self.displacing.iter().map(BiasJacobian::covariance).sum()
    }

    /// What it says where no errors are stated; `None` where nothing is left.
    pub(crate) fn marginalised(&self) -> Option<PoseInnovation> {
        let mut marginalised = self.innovation;
        marginalised.allow_for_pose(&self.covariance, self.took_part)?;
        marginalised.is_sound().then_some(marginalised)
    }

    /// The same apart from what errors of such a covariance explain. How much a view counts is by what these leave.
    pub(crate) fn apart_from(&self, biases: &Matrix6<f64>) -> Option<PoseInnovation> {
        let mut marginalised = self.innovation;
        marginalised.scale(marginalised.weight.recip());
        marginalised.allow_for(biases)?;
        marginalised.weigh();
        marginalised.allow_for_pose(&self.covariance, self.took_part)?;
        marginalised.is_sound().then_some(marginalised)
    }
}

#[cfg(test)]
impl PoseInnovation {
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
            camera_variance: Vector6::zeros(),
            tag_variance: Vector6::zeros(),
        }
    }
}

impl PoseInnovation {
    /// Origin of the link in the world, m.
    pub fn link_origin(&self) -> Vector3<f64> {
        self.world_from_link.translation.vector
    }

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
}
