//! A robot's poses as observations: the hand carries the object before the cameras, or a camera before the object.
//!
//! With the base's pose P, the carried frame's pose H on the hand and what an image shows, M, the hand is at `P M H^-1` in the base. The
//! residual of an instant is its difference from the robot's pose B as a twist of the hand's axes, `log(B^-1 P M H^-1)`. M is
//! `world_from_object` where the hand carries the object, and its inverse where it carries the camera: then the frame of the cameras rides on
//! the hand, and P maps points of the object into the base. Both hand-eye problems, `A X = X B` and `A X = Y B` (F. Dornaika, R. Horaud,
//! Simultaneous robot-world and hand-eye calibration, 1998), are this one residual.

use super::equations::Equations;
use super::layout::Layout;
use super::solver::moved;
use super::state::{Bundle, Freedom};
use nalgebra::{Matrix6, SMatrix, SVector, Vector6};
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
    pub delay: Freedom,
    /// The hand at each instant; `None` where the robot says nothing.
    pub hands: Vec<Option<Hand>>,
    /// Standard deviation of the robot's poses, per axis.
    pub sigma: PoseSigma,
    /// Standard deviation of the position of what is carried about the hand's origin, m, before any image: it decides what the motions leave
    /// open. Infinite for none.
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
    /// Index into [`Bundle::instants`].
    pub instant: usize,
    /// From the robot's pose to that of the images, a twist of the hand's axes.
    pub error: Vector6<f64>,
    /// Covariance of the error, given the kept parameters.
    pub covariance: Matrix6<f64>,
    /// Sum of the squared errors in units of [`Arm::sigma`]; 6 is expected.
    pub chi_square: f64,
}

/// A pose with a larger error counts less; one of 20 sigma hardly.
const KERNEL: Kernel = Kernel::Cauchy { width: 5.0 };

/// A residual with its derivatives.
pub(crate) struct HandError {
    pub error: Vector6<f64>,
    /// With respect to a twist of the base about its origin, which is added from the left.
    pub by_base: Matrix6<f64>,
    /// With respect to a twist of the hand, added from the left to `hand_from_carried`.
    pub by_hand: Matrix6<f64>,
    /// With respect to a twist added from the right to `P M H^-1`.
    by_right: Matrix6<f64>,
}

impl HandError {
    /// `log(B^-1 P M H^-1)`; derivatives by J. Sola et al., A micro Lie theory, 2018, eq. 71 and 180.
    pub(crate) fn of(
        base_from_hand: &Pose,
        (base_from_site, site_from_carried): (&Pose, &Pose),
        hand_from_carried: &Pose,
    ) -> Self {
        let seen = base_from_site * site_from_carried * hand_from_carried.inverse();
        let error = se3::log(&(base_from_hand.inverse() * seen));
        // The right Jacobian is the left one of the inverse motion.
        let by_right = se3::left_jacobian_inverse(&-error);
        Self {
            error,
            by_base: by_right * se3::adjoint(&seen.inverse()),
            by_hand: -by_right,
            by_right,
        }
    }
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
    pub(crate) fn predicted(&self, base_from_hand: &Pose) -> Pose {
        let site_from_carried =
            self.base_from_site.inverse() * base_from_hand * self.hand_from_carried;
        match self.mount {
            Mount::Object => site_from_carried,
            Mount::Camera => site_from_carried.inverse(),
        }
    }

    /// The error of a pose of the hand where the images show the object at `world_from_object`.
    pub(crate) fn error(&self, base_from_hand: &Pose, world_from_object: &Pose) -> HandError {
        HandError::of(
            base_from_hand,
            (
                &self.base_from_site,
                &self.site_from_carried(world_from_object),
            ),
            &self.hand_from_carried,
        )
    }

    /// Whether there is an entry an instant and every number is usable.
    pub(super) fn is_sound(&self, bundle: &Bundle) -> bool {
        let sigmas = [self.sigma.position_m, self.sigma.orientation_rad];
        let are_usable =
            sigmas.iter().all(|s| *s > 0.0 && s.powi(-2).is_finite()) && self.reach_m > 0.0;
        let hands = self.hands.iter().flatten();
        let are_finite = hands.clone().all(|hand| {
            let pose = hand.base_from_hand.to_homogeneous();
            pose.iter().chain(&hand.twist).all(|x| x.is_finite())
        });
        are_usable && are_finite && self.hands.len() == bundle.instants.len()
    }

    /// The hands of some of the instants.
    pub(super) fn part(&self, instants: std::ops::Range<usize>) -> Self {
        Self {
            hands: self.hands[instants].to_vec(),
            reach_m: f64::INFINITY,
            ..self.clone()
        }
    }

    /// After a step of the kept parameters.
    pub(super) fn stepped(&self, layout: &Layout, kept: &[f64]) -> Self {
        let pose = layout.arm.pose;
        let delay_step = layout.arm.delay.map_or(0.0, |at| kept[at]);
        Self {
            base_from_site: moved(&self.base_from_site, pose, kept),
            hand_from_carried: moved(&self.hand_from_carried, pose.map(|at| at + 6), kept),
            delay_s: self.delay_s + delay_step,
            hands: self
                .hands
                .iter()
                .map(|hand| hand.map(|hand| hand.after(delay_step)))
                .collect(),
            ..self.clone()
        }
    }

    fn reach_square(&self) -> f64 {
        self.hand_from_carried.translation.vector.norm_squared() / self.reach_m.powi(2)
    }

    fn information(&self) -> Matrix6<f64> {
        let [p, r] = [self.sigma.position_m, self.sigma.orientation_rad].map(|s| s.powi(-2));
        Matrix6::from_diagonal(&Vector6::new(p, p, p, r, r, r))
    }

    /// Each instant with a pose of the hand, and its error.
    fn errors<'a>(
        &'a self,
        bundle: &'a Bundle,
    ) -> impl Iterator<Item = (usize, &'a Hand, HandError)> {
        let hands = self.hands.iter().zip(&bundle.instants).enumerate();
        hands.filter_map(|(at, (hand, instant))| {
            let hand = hand.as_ref()?;
            let error = self.error(&hand.base_from_hand, &instant.world_from_object);
            Some((at, hand, error))
        })
    }

    /// Derivative of an error with respect to a twist of the object's own frame.
    fn by_object(&self, found: &HandError) -> Matrix6<f64> {
        match self.mount {
            Mount::Object => found.by_right * se3::adjoint(&self.hand_from_carried),
            // M becomes exp(-d) M, which is P exp(-d) P^-1 from the left.
            Mount::Camera => -found.by_base * se3::adjoint(&self.base_from_site),
        }
    }

    /// The errors at the solution, whose equations are given.
    pub(super) fn residuals<const D: usize>(
        &self,
        bundle: &Bundle,
        equations: &Equations<D>,
    ) -> Vec<ArmResidual> {
        let information = self.information();
        let residuals = self.errors(bundle).map(|(instant, _, found)| {
            let own = equations.nodes[instant].own.fixed_view::<6, 6>(0, 0);
            let of_object = own.into_owned().cholesky().map(|factor| factor.inverse());
            let by_object = self.by_object(&found);
            ArmResidual {
                instant,
                error: found.error,
                covariance: of_object
                    .map_or_else(Matrix6::zeros, |c| by_object * c * by_object.transpose()),
                chi_square: found.error.dot(&(information * found.error)),
            }
        });
        residuals.collect()
    }
}

impl Hand {
    fn after(&self, seconds: f64) -> Self {
        let mut later = *self;
        later.base_from_hand *= se3::exp(&(self.twist * seconds));
        later.base_from_hand.rotation.renormalize();
        later
    }
}

/// Kept columns of an arm: base and hand, and the delay.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ArmColumns {
    /// First of twelve columns.
    pub pose: Option<usize>,
    /// Column of the delay, after them.
    pub delay: Option<usize>,
}

impl ArmColumns {
    /// All of them, ascending.
    pub(super) fn all(&self) -> impl Iterator<Item = usize> {
        let pose = self.pose.map_or(0..0, |at| at..at + 12);
        pose.chain(self.delay)
    }
}

/// Adds the residuals of the robot's poses; returns the sum of their robust squares.
pub(super) fn add<const D: usize>(
    bundle: &Bundle,
    layout: &Layout,
    equations: &mut Equations<D>,
) -> f64 {
    let (Some(arm), Some(first)) = (&bundle.arm, layout.arm.pose) else {
        return 0.0;
    };
    let columns: Vec<usize> = layout.arm.all().collect();
    let information = arm.information();
    let mut sum = arm.reach_square();
    let shift = arm.hand_from_carried.translation.vector;
    let mut by_hand = SMatrix::<f64, 3, 6>::identity();
    by_hand
        .fixed_columns_mut::<3>(3)
        .copy_from(&-so3::hat(&shift));
    let weighted = by_hand.transpose() / arm.reach_m.powi(2);
    let mut own = equations.kept.fixed_view_mut::<6, 6>(first + 6, first + 6);
    own += weighted * by_hand;
    let mut gradient = equations.gradient.fixed_rows_mut::<6>(first + 6);
    gradient += weighted * shift;
    for (at, hand, found) in arm.errors(bundle) {
        let square = found.error.dot(&(information * found.error));
        sum += KERNEL.rho(square);
        let weights = information * KERNEL.weight(square);
        let mut by_kept = SMatrix::<f64, 6, 13>::zeros();
        by_kept.fixed_columns_mut::<6>(0).copy_from(&found.by_base);
        by_kept.fixed_columns_mut::<6>(6).copy_from(&found.by_hand);
        // A later robot pose is B exp(x ds): the error becomes log(exp(-x ds) E).
        let by_delay = -se3::left_jacobian_inverse(&found.error) * hand.twist;
        by_kept.column_mut(12).copy_from(&by_delay);
        let by_object = arm.by_object(&found);
        let by_instant = SMatrix::<f64, 6, D>::from_fn(|row, column| match column {
            0..6 => by_object[(row, column)],
            _ => 0.0,
        });
        let by_kept = by_kept.columns(0, columns.len());
        let weighted = weights * by_kept;
        let node = &mut equations.nodes[at];
        node.own += by_instant.transpose() * weights * by_instant;
        node.gradient += by_instant.transpose() * (weights * found.error);
        let start = node.local(first);
        let mut coupling = node.coupling.columns_mut(start, columns.len());
        coupling += by_instant.transpose() * &weighted;
        let n = columns.len();
        let mut own = equations.kept.view_mut((first, first), (n, n));
        own += by_kept.transpose() * &weighted;
        let mut gradient = equations.gradient.rows_mut(first, n);
        gradient += weighted.transpose() * SVector::from(found.error);
    }
    sum
}

/// The sum of the robust squares alone.
pub(super) fn rho(bundle: &Bundle) -> f64 {
    let Some(arm) = &bundle.arm else { return 0.0 };
    let information = arm.information();
    let squares = arm.errors(bundle);
    squares
        .map(|(_, _, found)| KERNEL.rho(found.error.dot(&(information * found.error))))
        .sum::<f64>()
        + arm.reach_square()
}

/// Standard deviations below these are those of rounding, m and rad.
const LEAST_SIGMA: [f64; 2] = [1e-6, 1e-6];
/// Rounds of the fixed point of the deviations, at known residuals.
const ROUNDS: usize = 10;
/// Numbers that the two transforms take from the residuals, of positions and of attitudes alike.
const DETERMINED: f64 = 6.0;

impl Arm {
    /// Estimates the standard deviations of the robot's poses from the residuals of a solution, as variance components (D. MacKay, Bayesian
    /// interpolation, 1992), with those that disagree down-weighted. Returns the largest change of a logarithm.
    pub(crate) fn learn_sigma(&mut self, residuals: &[ArmResidual]) -> f64 {
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
