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
    /// Grows with the logarithm: gross outliers hardly count, but a good start is needed. `width` > 0.
    Cauchy {
        /// In sigma; 2.385 keeps 95 % of the efficiency for Gaussian noise of one dimension.
        width: f64,
    },
}

impl Kernel {
    /// The robust square of a residual whose square is `s`.
    pub fn rho(&self, s: f64) -> f64 {
        match *self {
            Self::Quadratic => s,
            Self::Huber { width } if s <= width * width => s,
            Self::Huber { width } => width * (2.0 * s.sqrt() - width),
            Self::Cauchy { width } => width * width * (s / (width * width)).ln_1p(),
        }
    }

    /// The weight of such a residual in the normal equations: the derivative of [`Kernel::rho`].
    pub fn weight(&self, s: f64) -> f64 {
        match *self {
            Self::Quadratic => 1.0,
            Self::Huber { width } if s <= width * width => 1.0,
            Self::Huber { width } => width / s.sqrt(),
            Self::Cauchy { width } => 1.0 / (1.0 + s / (width * width)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KERNELS: [Kernel; 3] = [
        Kernel::Quadratic,
        Kernel::Huber { width: 1.5 },
        Kernel::Cauchy { width: 2.0 },
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
