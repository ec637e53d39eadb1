//! Levenberg-Marquardt over the kept parameters and the instants with a robust kernel (iteratively reweighted).

use crate::arm::ArmResidual;
use crate::clusters::clusters;
use crate::elimination::{ReducedSystem, Step};
use crate::equations::{self, NormalEquations};
use crate::layout::Layout;
use crate::marginals::KeptCovariance;
use crate::observability::{WeakDirection, weak_directions};
use crate::prior_knowledge::PriorKnowledge;
use crate::residuals::corners::KERNEL;
use crate::residuals::prior;
use crate::stamps;
use crate::tie;
use crate::values::{Bundle, BundleError, Instant};
use sextant_geometry::least_squares::Kernel;

/// Options of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BundleOptions {
    /// Robust kernel of corners. Default [`KERNEL`].
    pub kernel: Kernel,
    /// Most iterations. Default 60.
    pub max_iterations: usize,
    /// The iteration ends when a step lowers the sum of squared errors (in sigma squared) by less. Default 1e-3: a
    /// thirtieth of a standard deviation.
    pub tolerance: f64,
    /// Prior standard deviations; they bound what noise leaves and determine which directions are weak.
    pub prior: PriorKnowledge,
    /// Whether the covariance counts what clusters of images disagree by. Default true; it costs about an iteration.
    pub by_clusters: bool,
}

impl Default for BundleOptions {
    fn default() -> Self {
        Self {
            kernel: KERNEL,
            max_iterations: 60,
            tolerance: 1e-3,
            prior: PriorKnowledge::default(),
            by_clusters: true,
        }
    }
}

/// The result of the adjustment.
#[derive(Clone, Debug)]
pub struct BundleSolution {
    /// The bundle with its estimates.
    pub bundle: Bundle,
    /// Covariance of the kept parameters.
    pub covariance: KeptCovariance,
    /// Directions that the images hardly determine, weakest first; empty for good images.
    pub weak: Vec<WeakDirection>,
    /// Root mean square over all corners of the distance between model and seen corner, each with the weight that the
    /// kernel leaves it, pixels.
    pub rms_px: f64,
    /// The variance of the corners' errors in units of what was stated: 1 if the stated noise is right.
    pub variance_factor: f64,
    /// Errors of the robot's poses, by instant; empty without a robot.
    pub arm: Vec<ArmResidual>,
    /// Sum of the robust squares.
    pub cost: f64,
    /// Logarithm of the evidence for the model (Laplace's approximation), up to what models of the same images have in
    /// common. `None` where something is not determined at all.
    pub log_evidence: Option<f64>,
    /// Steps tried.
    pub iterations: usize,
    /// Whether the last step was within the tolerance.
    pub converged: bool,
}

/// Adjusts everything that is free.
///
/// # Errors
/// A bundle with wrong indices or numbers; not what the images fail to determine, which [`BundleSolution::weak`] names.
pub fn solve(bundle: Bundle, options: &BundleOptions) -> Result<BundleSolution, BundleError> {
    bundle.check()?;
    if bundle.motion.is_some() {
        Descent::<12>::run(bundle, options)
    } else {
        Descent::<6>::run(bundle, options)
    }
}

/// The covariance of the kept parameters where the bundle is; nothing is adjusted.
///
/// # Errors
/// As of [`solve`].
pub fn covariance(bundle: Bundle, options: &BundleOptions) -> Result<KeptCovariance, BundleError> {
    let still = BundleOptions {
        max_iterations: 0,
        ..*options
    };
    Ok(solve(bundle, &still)?.covariance)
}

const FIRST_DAMPING: f64 = 1e-4;
const LEAST_DAMPING: f64 = 1e-9;
/// With more damping than this a small step says nothing about having arrived.
const ARRIVING_DAMPING: f64 = 1e-2;
const MOST_DAMPING: f64 = 1e9;
/// Factor on the damping after a step that was taken at once.
const BETTER: f64 = 1.0 / 3.0;
/// Factor on the damping after a rejected step, doubled with each one in a row (H. B. Nielsen, Damping parameter in
/// Marquardt's method, 1999).
const WORSE: f64 = 2.0;
/// A decrease below this part of the cost drowns in rounding.
const ROUNDING: f64 = 1e-12;

pub(crate) struct Descent<'a, const D: usize> {
    pub(crate) bundle: Bundle,
    layout: Layout,
    options: &'a BundleOptions,
    damping: f64,
    /// Factor on the damping where the next step is rejected.
    worse: f64,
}

/// What moves, apart from the images: a bundle without them, and the errors of the stamps by image.
pub(crate) struct Estimates {
    pub(crate) site: Bundle,
    pub(crate) instants: Vec<Instant>,
    stamp_errors_s: Vec<f64>,
}

impl<'a, const D: usize> Descent<'a, D> {
    pub(crate) fn new(bundle: Bundle, options: &'a BundleOptions) -> Self {
        Self {
            layout: Layout::new(&bundle),
            bundle,
            options,
            damping: FIRST_DAMPING,
            worse: WORSE,
        }
    }

    fn run(bundle: Bundle, options: &'a BundleOptions) -> Result<BundleSolution, BundleError> {
        let mut descent = Self::new(bundle, options);
        let (mut iterations, mut converged) = (0, false);
        let mut equations = descent.linearise();
        if !equations.is_finite() {
            return Err(BundleError::BadStart);
        }
        while iterations < options.max_iterations && !converged {
            iterations += 1;
            match descent.advance(&equations) {
                Some(gain) => {
                    converged = gain <= options.tolerance + ROUNDING * equations.rho
                        && descent.damping <= ARRIVING_DAMPING;
                    equations = descent.linearise();
                }
                None => converged = descent.damping > MOST_DAMPING,
            }
        }
        descent.rest(&equations, iterations, converged)
    }

    #[cfg(test)]
    pub(crate) fn no_step(&self) -> Step<D> {
        Step {
            kept: nalgebra::DVector::zeros(self.layout.n),
            instants: vec![nalgebra::SVector::zeros(); self.bundle.instants.len()],
            stamps: vec![0.0; self.bundle.images.len()],
        }
    }

    fn linearise(&self) -> NormalEquations<D> {
        NormalEquations::new(&self.bundle, &self.layout, &self.options.kernel)
    }

    /// Tries one step; the gain where it was taken. The damping stays where a step before was rejected: in a curved
    /// valley every other one would be lost.
    fn advance(&mut self, equations: &NormalEquations<D>) -> Option<f64> {
        let taken = ReducedSystem::new(equations, self.damping)
            .and_then(|reduced| reduced.step(equations))
            .and_then(|step| self.take_if_better(&step, equations.rho));
        match taken {
            Some(_) if self.worse > WORSE => self.worse = WORSE,
            Some(_) => self.damping = (self.damping * BETTER).max(LEAST_DAMPING),
            None => {
                self.damping *= self.worse;
                self.worse *= 2.0;
            }
        }
        taken
    }

    fn take_if_better(&mut self, step: &Step<D>, rho: f64) -> Option<f64> {
        let mut trial = self.stepped(step)?;
        trial.swap(&mut self.bundle);
        stamps::settle(&mut self.bundle, &self.options.kernel);
        let new = equations::rho(&self.bundle, &self.options.kernel);
        if new <= rho {
            return Some(rho - new);
        }
        trial.swap(&mut self.bundle);
        None
    }

    pub(crate) fn stepped(&self, step: &Step<D>) -> Option<Estimates> {
        let instants = self.bundle.instants.iter().zip(&step.instants);
        let stamps = self.bundle.images.iter().zip(&step.stamps);
        Some(Estimates {
            site: self
                .bundle
                .stepped_site(&self.layout, step.kept.as_slice())?,
            instants: instants.map(|(at, step)| at.stepped(step)).collect(),
            stamp_errors_s: stamps
                .map(|(image, step)| image.stamp_error_s + step)
                .collect(),
        })
    }

    fn rest(
        self,
        equations: &NormalEquations<D>,
        iterations: usize,
        converged: bool,
    ) -> Result<BundleSolution, BundleError> {
        let reduced =
            ReducedSystem::new(equations, 0.0).or_else(|| ReducedSystem::new(equations, 1e-9));
        let reduced = reduced.ok_or(BundleError::BadStart)?;
        let log_evidence = reduced.log_information(equations).map(|information| {
            let prior = stamps::log_prior(&self.bundle)
                + prior::log_prior(&self.bundle)
                + tie::log_prior(&self.bundle);
            0.5 * (prior - information - equations.rho)
        });
        let fit = self.fit();
        let parameters = self.layout.n + D * self.bundle.instants.len();
        let variance_factor = fit.variance_factor(parameters);
        let clusters = match self.options.by_clusters {
            true => clusters::<D>(&self.bundle, &self.layout, &self.options.kernel).collect(),
            false => Vec::new(),
        };
        let covariance = KeptCovariance::new(
            &self.bundle,
            &self.layout,
            &reduced.information,
            &clusters,
            variance_factor,
            &self.options.prior,
        );
        Ok(BundleSolution {
            weak: weak_directions(&covariance, &self.options.prior),
            covariance,
            arm: self
                .bundle
                .arm
                .as_ref()
                .map(|arm| arm.residuals(&self.bundle, &equations.nodes))
                .unwrap_or_default(),
            bundle: self.bundle,
            rms_px: fit.rms_px(),
            variance_factor,
            cost: equations.rho,
            log_evidence,
            iterations,
            converged,
        })
    }

    fn fit(&self) -> Fit {
        let mut fit = Fit::default();
        for residual in self.bundle.residuals() {
            let seen = &self.bundle.images[residual.image].tags[residual.seen];
            for (error, whitening) in residual.corners_px.iter().zip(&seen.whitening) {
                let Some(error) = error else { continue };
                let square = (whitening * error).norm_squared();
                fit.add(
                    self.options.kernel.weight(square),
                    square,
                    error.norm_squared(),
                );
            }
        }
        fit
    }
}

/// Sums over the corners, with the weights that the kernel leaves them.
#[derive(Default)]
struct Fit {
    weights: f64,
    squares: f64,
    squares_px: f64,
}

impl Fit {
    fn add(&mut self, weight: f64, square: f64, square_px: f64) {
        self.weights += weight;
        self.squares += weight * square;
        self.squares_px += weight * square_px;
    }

    fn rms_px(&self) -> f64 {
        (self.squares_px / self.weights.max(f64::MIN_POSITIVE)).sqrt()
    }

    /// Two rows a corner, less the parameters that they determine; at least a tenth of the rows, since a modelled
    /// motion determines parameters too.
    fn variance_factor(&self, parameters: usize) -> f64 {
        let rows = 2.0 * self.weights;
        let freedom = (rows - parameters as f64).max(0.1 * rows);
        let factor = self.squares / freedom;
        if factor.is_finite() {
            factor.max(1e-6)
        } else {
            1.0
        }
    }
}

impl Estimates {
    fn swap(&mut self, bundle: &mut Bundle) {
        std::mem::swap(&mut self.site.cameras, &mut bundle.cameras);
        std::mem::swap(&mut self.site.tags, &mut bundle.tags);
        std::mem::swap(&mut self.site.scales, &mut bundle.scales);
        std::mem::swap(&mut self.site.arm, &mut bundle.arm);
        std::mem::swap(&mut self.instants, &mut bundle.instants);
        for (own, image) in self.stamp_errors_s.iter_mut().zip(&mut bundle.images) {
            std::mem::swap(own, &mut image.stamp_error_s);
        }
    }
}
