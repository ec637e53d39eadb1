//! A robot's poses as observations: the hand carries the object before the cameras, or a camera before the object.
//!
//! With the base's pose P, the carried frame's pose H on the hand and what an image shows, M, the hand is at `P M H^-1`
//! in the base. The residual of an instant is its difference from the robot's pose B as a twist of the hand's axes,
//! `log(B^-1 P M H^-1)`. M is `world_from_object` where the hand carries the object, and its inverse where it carries
//! the camera: then the frame of the cameras rides on the hand, and P maps points of the object into the base. Both
//! hand-eye problems, `A X = X B` and `A X = Y B` (F. Dornaika, R. Horaud, Simultaneous robot-world and hand-eye
//! calibration, 1998), are this one residual.

use nalgebra::{Matrix6, SMatrix, Vector6};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::{Pose, se3, so3};
use sextant_site_model::PoseSigma;

/// What the hand carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mount {
    /// The object, seen by cameras that stand still.
    Object,
    /// A camera, which sees an object that lies still.
    Camera,
}

/// A robot: its poses and the two transforms between it and what the images show.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// What the hand carries.
    pub mount: Mount,
    /// Maps points of the world, or of the object where the hand carries the camera, into the robot's base.
    pub base_from_site: Pose,
    /// Maps points of the object, or of the world where the hand carries the camera, into the hand.
    pub hand_from_carried: Pose,
    /// Added to the time of an image to get the robot's, seconds.
    pub delay_s: f64,
    /// Whether that is sought.
    pub seeks_delay: bool,
    /// The hand at each instant; `None` where the robot says nothing.
    pub hands: Vec<Option<Hand>>,
    /// Standard deviation of the robot's poses, per axis.
    pub sigma: PoseSigma,
    /// Standard deviation of the position of what is carried about the hand's origin, m, before any image: it decides
    /// what the motions leave open. Infinite for none.
    pub reach_m: f64,
}

/// The hand at an instant, by the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Maps points of the hand into the base, at the time of the image.
    pub base_from_hand: Pose,
    /// (velocity, angular velocity) in the hand's axes.
    pub twist: Vector6<f64>,
}

/// The error of the robot's pose at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmResidual {
    /// Index into [`Bundle::instants`](crate::Bundle::instants).
    pub instant: usize,
    /// From the robot's pose to that of the images, a twist of the hand's axes.
    pub error: Vector6<f64>,
    /// Covariance of the error, given the kept parameters.
    pub covariance: Matrix6<f64>,
    /// Sum of the squared errors in units of [`Arm::sigma`]; 6 is expected.
    pub chi_square: f64,
}

/// A pose with a larger error has less weight; one of 20 sigma almost none.
pub(crate) const KERNEL: Kernel = Kernel::CauchyTails { width: 5.0 };

/// A residual with its derivatives by steps of FRAMES.md.
pub struct HandError {
    /// From the robot's pose to that of the images, a twist of the hand's axes.
    pub error: Vector6<f64>,
    /// By a step of `base_from_site`.
    pub by_base: Matrix6<f64>,
    /// By a step of `hand_from_carried`.
    pub by_hand: Matrix6<f64>,
    /// By a twist of the hand's axes, from the right of `P M H^-1`.
    by_right: Matrix6<f64>,
    /// By a twist of the base's axes, from the left of `P M H^-1`.
    by_left: Matrix6<f64>,
}

impl HandError {
    /// `log(B^-1 P M H^-1)`, with B `base_from_hand`, P `base_from_site`, M `site_from_carried` and H
    /// `hand_from_carried`; derivatives by J. Sola et al., A micro Lie theory, 2018, eq. 71 and 180.
    pub fn new(
        base_from_hand: &Pose,
        base_from_site: &Pose,
        site_from_carried: &Pose,
        hand_from_carried: &Pose,
    ) -> Self {
        let seen = base_from_site * site_from_carried * hand_from_carried.inverse();
        let error = se3::log(&(base_from_hand.inverse() * seen));
        // The right Jacobian is the left one of the inverse motion.
        let by_right = se3::left_jacobian_inverse(&-error);
        let by_left = by_right * se3::adjoint(&seen.inverse());
        Self {
            error,
            by_base: by_left * twist_by_step(base_from_site),
            by_hand: -by_right * twist_by_step(hand_from_carried),
            by_right,
            by_left,
        }
    }
}

/// Derivative of the twist of the outer axes, from the left of a pose, by the pose's step: `v = dt + t x dr`, `w = dr`.
fn twist_by_step(pose: &Pose) -> Matrix6<f64> {
    let mut by_step = Matrix6::identity();
    let turn = so3::hat(&pose.translation.vector);
    by_step.fixed_view_mut::<3, 3>(0, 3).copy_from(&turn);
    by_step
}

impl Arm {
    /// The pose of the carried frame in the site that an instant shows.
    fn site_from_carried(&self, world_from_object: &Pose) -> Pose {
        match self.mount {
            Mount::Object => *world_from_object,
            Mount::Camera => world_from_object.inverse(),
        }
    }

    /// `world_from_object` for a pose of the hand.
    pub fn predicted(&self, base_from_hand: &Pose) -> Pose {
        let site_from_carried =
            self.base_from_site.inverse() * base_from_hand * self.hand_from_carried;
        match self.mount {
            Mount::Object => site_from_carried,
            Mount::Camera => site_from_carried.inverse(),
        }
    }

    /// The error of a pose of the hand where the images show the object at `world_from_object`.
    pub fn error(&self, base_from_hand: &Pose, world_from_object: &Pose) -> HandError {
        let carried = self.site_from_carried(world_from_object);
        HandError::new(
            base_from_hand,
            &self.base_from_site,
            &carried,
            &self.hand_from_carried,
        )
    }

    /// Derivative of an error by a step of `world_from_object`.
    pub(crate) fn by_object(&self, found: &HandError, world_from_object: &Pose) -> Matrix6<f64> {
        let by_twist = match self.mount {
            // P exp(x) M is exp(Ad(P) x) P M.
            Mount::Object => found.by_left * se3::adjoint(&self.base_from_site),
            // M exp(-x) H^-1 is M H^-1 exp(-Ad(H) x).
            Mount::Camera => -found.by_right * se3::adjoint(&self.hand_from_carried),
        };
        by_twist * twist_by_step(world_from_object)
    }

    /// Whether there is an entry an instant and every number is usable.
    pub(crate) fn is_sound(&self, n_instants: usize) -> bool {
        let sigmas = [self.sigma.position_m, self.sigma.orientation_rad];
        let are_usable =
            sigmas.iter().all(|s| *s > 0.0 && s.powi(-2).is_finite()) && self.reach_m > 0.0;
        let hands = self.hands.iter().flatten();
        let are_finite = hands.clone().all(|hand| {
            let pose = hand.base_from_hand.to_homogeneous();
            pose.iter().chain(&hand.twist).all(|x| x.is_finite())
        });
        are_usable && are_finite && self.hands.len() == n_instants
    }

    /// The hands of some of the instants.
    pub(crate) fn part(&self, instants: std::ops::Range<usize>) -> Self {
        Self {
            hands: self.hands[instants].to_vec(),
            reach_m: f64::INFINITY,
            ..self.clone()
        }
    }

    pub(crate) fn reach_square(&self) -> f64 {
        self.hand_from_carried.translation.vector.norm_squared() / self.reach_m.powi(2)
    }

    /// Inverse covariance of the robot's poses.
    pub(crate) fn information(&self) -> Matrix6<f64> {
        let [p, r] = [self.sigma.position_m, self.sigma.orientation_rad].map(|s| s.powi(-2));
        Matrix6::from_diagonal(&Vector6::new(p, p, p, r, r, r))
    }
}

impl Hand {
    pub(crate) fn after(&self, seconds: f64) -> Self {
        let mut later = *self;
        later.base_from_hand *= se3::exp(&(self.twist * seconds));
        later.base_from_hand.rotation.renormalize();
        later
    }

    /// Derivatives of an error by base, hand and delay.
    pub(crate) fn by_kept(&self, found: &HandError) -> SMatrix<f64, 6, 13> {
        let mut by_kept = SMatrix::<f64, 6, 13>::zeros();
        by_kept.fixed_columns_mut::<6>(0).copy_from(&found.by_base);
        by_kept.fixed_columns_mut::<6>(6).copy_from(&found.by_hand);
        // A later robot pose is B exp(x ds): the error becomes log(exp(-x ds) E).
        let by_delay = -se3::left_jacobian_inverse(&found.error) * self.twist;
        by_kept.column_mut(12).copy_from(&by_delay);
        by_kept
    }
}

/// Standard deviations below these are those of rounding, m and rad.
const LEAST_SIGMA: [f64; 2] = [1e-6, 1e-6];
/// Rounds of the fixed point of the deviations, at known residuals.
const ROUNDS: usize = 10;
/// Numbers that the two transforms take from the residuals, of positions and of attitudes alike.
const DETERMINED: f64 = 6.0;

impl Arm {
    /// Estimates the standard deviations of the robot's poses from the residuals of a solution, as variance components
    /// (D. MacKay, Bayesian interpolation, 1992), with those that disagree down-weighted. Returns the largest change of
    /// a logarithm.
    pub fn learn_sigma(&mut self, residuals: &[ArmResidual]) -> f64 {
        let before = [self.sigma.position_m, self.sigma.orientation_rad];
        let mut sigmas = before;
        for _ in 0..ROUNDS {
            for (part, sigma) in sigmas.iter_mut().enumerate() {
                let (mut squares, mut determined) = (0.0, -DETERMINED);
                for residual in residuals {
                    let axes = 3 * part..3 * part + 3;
                    let variances: f64 = axes.clone().map(|k| residual.covariance[(k, k)]).sum();
                    let square: f64 = axes.map(|k| residual.error[k].powi(2)).sum();
                    // As if the error had three numbers: the other three may have another unit.
                    let weight = KERNEL.weight(2.0 * square / sigma.powi(2));
                    squares += weight * square;
                    determined += weight * (3.0 - variances / before[part].powi(2)).max(0.0);
                }
                let estimate = (squares / determined.max(1.0)).sqrt();
                *sigma = estimate.clamp(LEAST_SIGMA[part], 1.0);
            }
        }
        [self.sigma.position_m, self.sigma.orientation_rad] = sigmas;
        let changes = sigmas.iter().zip(before);
        changes.fold(0.0, |most: f64, (is, was)| most.max((is / was).ln().abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn derivatives_are_those_of_small_steps() {
        let pose = |x: f64| Pose::new(Vector3::new(x, 0.3, -x), Vector3::new(0.4, x, -0.7));
        for mount in [Mount::Object, Mount::Camera] {
            let arm = Arm {
                mount,
                base_from_site: pose(0.9),
                hand_from_carried: pose(-0.2),
                delay_s: 0.0,
                seeks_delay: false,
                hands: Vec::new(),
                sigma: PoseSigma::OF_TAG,
                reach_m: 1.0,
            };
            let object = pose(0.5);
            let carried = arm.site_from_carried(&object);
            let hand = arm.base_from_site * carried * arm.hand_from_carried.inverse() * pose(0.1);
            let found = arm.error(&hand, &object);
            for k in 0..6 {
                let slope = |error: &dyn Fn(&Vector6<f64>) -> Vector6<f64>| {
                    let step = |h: f64| Vector6::from_fn(|row, _| h * f64::from(row == k));
                    (error(&step(1e-6)) - error(&step(-1e-6))) / 2e-6
                };
                let with = |arm: Arm| move |object: &Pose| arm.error(&hand, object).error;
                let by_base = slope(&|step| {
                    let base_from_site = se3::perturb(&arm.base_from_site, step);
                    with(Arm {
                        base_from_site,
                        ..arm.clone()
                    })(&object)
                });
                let by_hand = slope(&|step| {
                    let hand_from_carried = se3::perturb(&arm.hand_from_carried, step);
                    with(Arm {
                        hand_from_carried,
                        ..arm.clone()
                    })(&object)
                });
                let by_object = slope(&|step| with(arm.clone())(&se3::perturb(&object, step)));
                for (numeric, exact) in [
                    (by_base, found.by_base.column(k)),
                    (by_hand, found.by_hand.column(k)),
                    (by_object, arm.by_object(&found, &object).column(k)),
                ] {
                    assert!(
                        (numeric - exact).amax() < 1e-8,
                        "{mount:?} {k}: {numeric} {exact}"
                    );
                }
            }
            let predicted =
                arm.predicted(&(arm.base_from_site * carried * arm.hand_from_carried.inverse()));
            assert!(se3::difference(&predicted, &object).amax() < 1e-12);
        }
    }
}
