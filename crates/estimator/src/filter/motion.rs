//! How restless a body is: the power density of its white acceleration, learned from how far predictions miss.
//!
//! Maximum likelihood by scoring on the logarithm of the density. With the innovation d of covariance S and D = dS/d ln q
//! the slope is (d S⁻¹ D S⁻¹ d - tr S⁻¹ D) / 2 and the information tr (S⁻¹ D)² / 2 (Harvey 1989, Forecasting, eqs. 3.4.5,
//! 3.4.69). D is a share of the predicted covariance, which is what the density brings about in a filter at work; where the
//! prediction hardly matters, the information is small and little is learned.

use nalgebra::{Matrix3, Matrix6, Vector6};

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

/// An innovation and what was expected of it, for the pose that a camera saw.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Innovation {
    /// S⁻¹ d.
    pub pull: Vector6<f64>,
    /// S⁻¹.
    pub weight: Matrix6<f64>,
    /// Covariance of the prediction.
    pub expected: Matrix6<f64>,
}

/// Logarithm of a density against its default.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Learned {
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
            linear: self.default.linear * self.linear.logarithm.exp(),
            angular: self.default.angular * self.angular.logarithm.exp(),
            clocks: self.default.clocks,
        }
    }

    pub fn learn(&mut self, innovation: &Innovation) {
        self.linear.learn(innovation, 0);
        self.angular.learn(innovation, 3);
    }
}

impl Learned {
    /// Takes the three axes from `first` on in.
    fn learn(&mut self, innovation: &Innovation, first: usize) {
        let block = |matrix: &Matrix6<f64>| matrix.fixed_view::<3, 3>(first, first).into_owned();
        let change: Matrix3<f64> = block(&innovation.expected) * SHARE;
        let pull = innovation.pull.fixed_rows::<3>(first);
        let relative = block(&innovation.weight) * change;
        let slope = 0.5 * (pull.dot(&(change * pull)) - relative.trace());
        let information = 0.5 * (relative * relative).trace();
        if !slope.is_finite() || !information.is_finite() {
            return;
        }
        let most = MOST_SIGMAS * information.max(0.0).sqrt();
        self.information = self.information * (1.0 - 1.0 / MEMORY) + information + FAITH / MEMORY;
        let step = slope.clamp(-most, most) / self.information;
        self.logarithm = (self.logarithm + step).clamp(BOUNDS.0, BOUNDS.1);
    }
}
