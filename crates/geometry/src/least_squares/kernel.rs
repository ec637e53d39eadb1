//! Robust kernels: how much a residual counts once it is larger than noise explains.

/// A kernel over the squared residual in units of sigma squared (Z. Zhang, Parameter estimation techniques, 1997).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Kernel {
    /// Plain least squares.
    #[default]
    Quadratic,
    /// Quadratic up to `width` sigma, linear beyond: still convex. `width` > 0.
    Huber {
        /// In sigma; 1.345 keeps 95 % of the efficiency for Gaussian noise of one dimension.
        width: f64,
    },
    /// Quadratic up to `width` sigma, logarithmic beyond (Gaussian core with Cauchy tails): noise counts in full, gross
    /// outliers hardly, but a good start is needed. `width` > 0.
    CauchyTails {
        /// In sigma; 3 keeps 98.9 % of the Gaussian errors of two dimensions within the core.
        width: f64,
    },
}

impl Kernel {
    /// The robust square of a residual whose square is `s`.
    #[inline]
    pub fn rho(&self, s: f64) -> f64 {
        match *self {
            Self::Quadratic => s,
            Self::Huber { width } if s <= width * width => s,
            Self::Huber { width } => width * (2.0 * s.sqrt() - width),
            Self::CauchyTails { width } if s <= width * width => s,
            Self::CauchyTails { width } => width * width * (1.0 + (s / (width * width)).ln()),
        }
    }

    /// The weight of such a residual in the normal equations: the derivative of [`Kernel::rho`].
    #[inline]
    pub fn weight(&self, s: f64) -> f64 {
        match *self {
            Self::Quadratic => 1.0,
            Self::Huber { width } if s <= width * width => 1.0,
            Self::Huber { width } => width / s.sqrt(),
            Self::CauchyTails { width } if s <= width * width => 1.0,
            Self::CauchyTails { width } => width * width / s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KERNELS: [Kernel; 3] = [
        Kernel::Quadratic,
        Kernel::Huber { width: 1.5 },
        Kernel::CauchyTails { width: 2.0 },
    ];

    #[test]
    fn weight_is_the_slope_of_rho() {
        for kernel in KERNELS {
            for s in [0.1, 1.0, 3.0, 40.0] {
                let slope = (kernel.rho(s + 1e-6) - kernel.rho(s - 1e-6)) / 2e-6;
                assert!((slope - kernel.weight(s)).abs() < 1e-8, "{kernel:?} at {s}");
            }
        }
    }

    #[test]
    fn small_residuals_count_in_full() {
        for kernel in KERNELS {
            assert!((kernel.weight(1e-12) - 1.0).abs() < 1e-9);
            assert_eq!(kernel.rho(0.0), 0.0);
        }
    }
}
