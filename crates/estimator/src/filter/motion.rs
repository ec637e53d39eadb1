//! How restless a body is: the power density of its white acceleration, learned from how far predictions miss.
//!
//! Maximum likelihood by scoring on the logarithm of the density. With the innovation d of covariance S and D = dS/d ln q
//! the slope is (d S⁻¹ D S⁻¹ d - tr S⁻¹ D) / 2 and the information tr (S⁻¹ D)² / 2 (Harvey 1989, Forecasting, eqs. 3.4.5,
//! 3.4.69). D is a share of the predicted covariance, which is what the density brings about in a filter at work; where the
//! prediction hardly matters, the information is small and little is learned.

use nalgebra::{Matrix3, SMatrix, SVector};

/// Share of the predicted variance that changes with the density: between 1/4 where images rule and 1 where motion does.
const SHARE: f64 = 0.4;
/// Information before anything is seen: one sigma of the default is a factor of e^(1/sqrt(this)).
const FAITH: f64 = 0.5;
/// Updates that are remembered.
const MEMORY: f64 = 40.0;
/// Most that one update may count, in sigmas: a jolt is not restlessness.
const MOST_SIGMAS: f64 = 3.0;
/// Bounds of the logarithm about the default: from a body at rest to one shaken by hand. What is livelier is no motion but
/// images that contradict each other.
const BOUNDS: (f64, f64) = (-7.0, 3.5);

/// Power density of the white acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Restlessness {
    /// m²/s³.
    pub linear: f64,
    /// rad²/s³.
    pub angular: f64,
    /// Of the clocks' offsets: s²/s.
    pub clocks: f64,
}

/// What is held of a body's restlessness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Motion {
    default: Restlessness,
    linear: Learned,
    angular: Learned,
}

/// An innovation and what was expected of it, for the configuration that a camera saw.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Innovation<const D: usize> {
    /// S⁻¹ d.
    pub pull: SVector<f64, D>,
    /// S⁻¹.
    pub weight: SMatrix<f64, D, D>,
    /// Covariance of the prediction.
    pub expected: SMatrix<f64, D, D>,
}

/// Logarithm of a density against its default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Learned {
    logarithm: f64,
    information: f64,
}

impl Default for Learned {
    fn default() -> Self {
        Self {
            logarithm: 0.0,
            information: FAITH,
        }
    }
}

impl Motion {
    pub fn new(default: Restlessness) -> Self {
        Self {
            default,
            linear: Learned::default(),
            angular: Learned::default(),
        }
    }

    pub fn restlessness(&self) -> Restlessness {
        Restlessness {
            linear: self.default.linear * self.linear.factor(),
            angular: self.default.angular * self.angular.factor(),
            clocks: self.default.clocks,
        }
    }

    pub fn learn<const D: usize>(&mut self, innovation: &Innovation<D>) {
        self.linear.learn(innovation, 0);
        self.angular.learn(innovation, 3);
    }
}

impl Learned {
    /// Takes the three axes from `first` on in.
    fn learn<const D: usize>(&mut self, innovation: &Innovation<D>, first: usize) {
        let block =
            |matrix: &SMatrix<f64, D, D>| matrix.fixed_view::<3, 3>(first, first).into_owned();
        let change: Matrix3<f64> = block(&innovation.expected) * SHARE;
        let pull = innovation.pull.fixed_rows::<3>(first);
        let relative = block(&innovation.weight) * change;
        let slope = 0.5 * (pull.dot(&(change * pull)) - relative.trace());
        let information = 0.5 * (relative * relative).trace();
        self.score(slope, information);
    }

    /// Takes a single axis in.
    pub fn learn_one(&mut self, pull: f64, weight: f64, expected: f64) {
        let change = expected * SHARE;
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
        let step = slope.clamp(-most, most) / self.information;
        self.logarithm = (self.logarithm + step).clamp(BOUNDS.0, BOUNDS.1);
    }
}
