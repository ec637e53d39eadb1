//! Power spectral density of the white acceleration of a body, estimated from the innovations.
//!
//! Maximum likelihood by scoring on the logarithm of the density. With the innovation d of covariance S and D = dS/d ln
//! q the slope is (d S⁻¹ D S⁻¹ d - tr S⁻¹ D) / 2 and the information tr (S⁻¹ D)² / 2 (Harvey 1989, Forecasting, eqs.
//! 3.4.5, 3.4.69). D is the share of the predicted covariance that the density brings about. Where the prediction
//! hardly matters, the information is small.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Share of the predicted variance that changes with the density: between 1/4 where images rule and 1 where motion
/// does.
const SHARE: f64 = 0.4;
/// Time for which an acceleration persists, s. No acceleration is white: over a shorter step the change of speed goes
/// with the step and its variance with the square, as with a density proportional to the step.
const PERSISTS_S: f64 = 0.15;
/// Steps over which the usual one is averaged.
const USUAL_OF: f64 = 20.0;
/// Information before anything is seen: one sigma of the default is a factor of e^(1/sqrt(this)).
const FAITH: f64 = 0.5;
/// Updates that are remembered.
const MEMORY: f64 = 40.0;
/// Share of the earlier innovations that counts with the next: what goes on in one direction is an acceleration that
/// persists, of which a single innovation shows little. With white innovations the sum has mean zero.
const PERSISTENCE: f64 = 0.5;
/// How much innovations of opposite directions count, in roots of the information: they come from cameras that
/// disagree.
const MOST_OPPOSED: f64 = 0.8;
/// Largest step of one update, in standard deviations: a jolt is no change of the density.
const MOST_SIGMAS: f64 = 3.0;
/// Bounds of the logarithm about the default: from a body at rest to one shaken by hand. What is livelier is no motion
/// but images that contradict each other.
const BOUNDS: (f64, f64) = (-7.0, 4.5);

/// Share of a predicted variance that goes with the density; the rest was uncertain before.
fn share(variance: f64, noise: f64) -> f64 {
    SHARE.min(noise / variance.max(f64::MIN_POSITIVE))
}

/// Power density of the white acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ProcessNoisePsd {
    /// m²/s³.
    pub linear: f64,
    /// rad²/s³.
    pub angular: f64,
    /// Of the clocks' offsets: s²/s.
    pub clocks: f64,
}

/// Estimate of the densities of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ProcessNoise {
    default: ProcessNoisePsd,
    linear: PsdEstimate,
    angular: PsdEstimate,
    /// Seconds since nothing was known of the speed.
    age_s: f64,
    /// Seconds of a step as they go, for which the densities hold, and of how many that is the mean.
    usual_s: f64,
    steps: f64,
}

/// Innovation of the observed configuration and its covariance.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Innovation<const D: usize> {
    /// S⁻¹ d.
    pub pull: SVector<f64, D>,
    /// S⁻¹.
    pub weight: SMatrix<f64, D, D>,
    /// Inverse of the covariance of the prediction.
    pub information: SMatrix<f64, D, D>,
}

/// Logarithm of a density against its default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PsdEstimate {
    logarithm: f64,
    information: f64,
    /// Sum of the last innovations over their covariance, older ones less: what they have in common.
    persistent: Vector3<f64>,
}

impl Default for PsdEstimate {
    fn default() -> Self {
        Self {
            logarithm: 0.0,
            information: FAITH,
            persistent: Vector3::zeros(),
        }
    }
}

impl ProcessNoise {
    pub fn new(default: ProcessNoisePsd) -> Self {
        Self {
            default,
            linear: PsdEstimate::default(),
            angular: PsdEstimate::default(),
            age_s: 0.0,
            usual_s: 0.0,
            steps: 0.0,
        }
    }

    /// Counts a step of `dt` seconds in the time since the speed was unknown and in the mean of the steps.
    pub fn advance(&mut self, dt: f64) {
        let dt = dt.abs();
        self.age_s += dt;
        if dt > 0.0 {
            self.steps = (self.steps + 1.0).min(USUAL_OF);
            self.usual_s += (dt.min(PERSISTS_S) - self.usual_s) / self.steps;
        }
    }

    /// The densities that hold for a step of `dt` seconds, against those for the usual one.
    pub fn persistence(&self, dt: f64) -> f64 {
        if self.usual_s > 0.0 {
            dt.abs().min(PERSISTS_S) / self.usual_s
        } else {
            1.0
        }
    }

    /// The speed has changed by a blow, `dt` seconds ago.
    pub fn begin_anew(&mut self, dt: f64) {
        self.age_s = dt.abs();
    }

    /// The variance that a density of one has brought about in a position since the speed was unknown, at most.
    pub fn spread(&self) -> f64 {
        self.persistence(self.age_s) * self.age_s.powi(3) / 3.0
    }

    /// What holds for a step of `dt` seconds.
    pub fn process_noise_psd(&self, dt: f64) -> ProcessNoisePsd {
        let persistence = self.persistence(dt);
        ProcessNoisePsd {
            linear: self.default.linear * self.linear.factor() * persistence,
            angular: self.default.angular * self.angular.factor() * persistence,
            clocks: self.default.clocks,
        }
    }

    pub fn learn<const D: usize>(&mut self, innovation: &Innovation<D>) {
        let (density, spread) = (self.process_noise_psd(self.age_s), self.age_s.powi(3) / 3.0);
        self.linear.learn(innovation, 0, density.linear * spread);
        self.angular.learn(innovation, 3, density.angular * spread);
    }
}

/// Innovation of a single axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ScalarInnovation {
    /// Innovation over its variance.
    pub pull: f64,
    /// Inverse of its variance.
    pub weight: f64,
    /// Predicted variance of the axis, conditional on the others.
    pub conditional: f64,
}

impl PsdEstimate {
    /// Takes the three axes from `first` on in; `noise` is the variance along each that the density can have brought
    /// about.
    ///
    /// The predicted covariance is that of these axes conditional on the others: this density does not cause errors
    /// that are correlated with others.
    fn learn<const D: usize>(&mut self, innovation: &Innovation<D>, first: usize, noise: f64) {
        let block =
            |matrix: &SMatrix<f64, D, D>| matrix.fixed_view::<3, 3>(first, first).into_owned();
        let Some(alone) = block(&innovation.information).try_inverse() else {
            return;
        };
        let change: Matrix3<f64> = alone * share(alone.trace() / 3.0, noise);
        let pull = innovation.pull.fixed_rows::<3>(first).into_owned();
        let relative = block(&innovation.weight) * change;
        let information = 0.5 * (relative * relative).trace();
        let common = 2.0 * pull.dot(&(change * self.persistent));
        let common = common.max(-MOST_OPPOSED * information.sqrt());
        self.persistent = (self.persistent + pull) * PERSISTENCE;
        let slope = 0.5 * (pull.dot(&(change * pull)) + common - relative.trace());
        self.score(slope, information);
    }

    /// Updates with a single axis; `noise` is the variance that the density can have brought about.
    pub fn learn_one(&mut self, innovation: ScalarInnovation, noise: f64) {
        let ScalarInnovation {
            pull,
            weight,
            conditional,
        } = innovation;
        let change = conditional * share(conditional, noise);
        let relative = weight * change;
        self.score(
            0.5 * (pull * change * pull - relative),
            0.5 * relative * relative,
        );
    }

    /// The density against its default.
    pub fn factor(&self) -> f64 {
        self.logarithm.exp()
    }

    fn score(&mut self, slope: f64, information: f64) {
        if !slope.is_finite() || !information.is_finite() {
            return;
        }
        let most = MOST_SIGMAS * information.max(0.0).sqrt();
        self.information = self.information * (1.0 - 1.0 / MEMORY) + information + FAITH / MEMORY;
        let drawn = slope.clamp(-most, most) - self.logarithm * FAITH / MEMORY;
        let step = drawn / self.information;
        self.logarithm = (self.logarithm + step).clamp(BOUNDS.0, BOUNDS.1);
    }
}
