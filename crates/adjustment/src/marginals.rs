//! Covariance of the kept parameters.

use crate::clusters::{Cluster, displacement, factors};
use crate::layout::Layout;
use crate::parameter::{ArmPose, KeptParameter};
use crate::prior_knowledge::PriorKnowledge;
use crate::values::Bundle;
use nalgebra::{DMatrix, DVector, Matrix6};

/// Covariance of the kept parameters by the noise of corners and by what clusters of images disagree by: poses over the
/// step of FRAMES.md (position along the outer frame's axes, rotation about the inner frame's origin), lenses in their
/// own units, clocks in seconds. Always finite.
#[derive(Clone, Debug, PartialEq)]
pub struct KeptCovariance {
    parameters: Vec<KeptParameter>,
    matrix: DMatrix<f64>,
    /// By the noise of corners alone.
    of_noise: DMatrix<f64>,
    information: DMatrix<f64>,
}

impl KeptCovariance {
    /// From the information matrix, and what each cluster of images says, both in units of the given noise, whose
    /// variance is off by
    /// `variance_factor`.
    pub(crate) fn new(
        bundle: &Bundle,
        layout: &Layout,
        information: &DMatrix<f64>,
        clusters: &[Cluster],
        variance_factor: f64,
        prior: &PriorKnowledge,
    ) -> Self {
        let information = information / variance_factor;
        let parameters = layout.parameters();
        let mut with_prior = information.clone();
        for (at, parameter) in parameters.iter().enumerate() {
            with_prior[(at, at)] += prior.sigma(bundle, parameter).powi(-2);
        }
        let of_noise = inverse(&with_prior, |at| prior.sigma(bundle, &parameters[at]));
        let mut of_images = DMatrix::zeros(parameters.len(), parameters.len());
        let displacements: Vec<_> = clusters
            .iter()
            .map(|cluster| {
                of_images += &cluster.information / variance_factor;
                displacement(&of_noise, &(&cluster.gradient / variance_factor), |step| {
                    &cluster.information * step / variance_factor
                })
            })
            .collect();
        // The part that is due to images alone: what only priors determine, no image can disagree about.
        let due_to_images = &of_noise * of_images * &of_noise;
        let (variances, sigmas) = (due_to_images.diagonal(), of_noise.diagonal().map(f64::sqrt));
        let factors = factors(&parameters, &variances, &sigmas, &displacements);
        let more = factors.map(|factor| (factor - 1.0).sqrt());
        let matrix = &of_noise + due_to_images.component_mul(&(&more * more.transpose()));
        Self {
            parameters,
            matrix,
            of_noise,
            information,
        }
    }

    /// The same if the common scale were known: the mean of the logarithms of all sizes that are sought. An error of it
    /// displaces everything alike, and no number of images makes it smaller.
    pub fn at_known_scale(&self) -> Self {
        let of_size = |p: &KeptParameter| f64::from(matches!(p, KeptParameter::TagSize { .. }));
        let sizes = self.parameters.iter().map(of_size);
        let mean = DVector::from_iterator(self.parameters.len(), sizes);
        let with_mean = &self.matrix * &mean;
        let variance = mean.dot(&with_mean);
        let known = if variance > 0.0 {
            &self.matrix - &with_mean * with_mean.transpose() / variance
        } else {
            self.matrix.clone()
        };
        Self {
            matrix: known,
            ..self.clone()
        }
    }

    /// By the noise of corners alone.
    pub(crate) fn by_noise(&self) -> &DMatrix<f64> {
        &self.of_noise
    }

    /// Information of images and anchors, without the prior.
    pub fn information(&self) -> &DMatrix<f64> {
        &self.information
    }

    /// The parameter of each row and column of [`KeptCovariance::matrix`].
    pub fn parameters(&self) -> &[KeptParameter] {
        &self.parameters
    }

    /// Covariance of all parameters that are not fixed, in their units.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// Standard deviation of a parameter; `None` if it was fixed.
    pub fn sigma(&self, parameter: KeptParameter) -> Option<f64> {
        let at = self.position(parameter)?;
        Some(self.matrix[(at, at)].max(0.0).sqrt())
    }

    /// Covariance of a camera pose; `None` if it was fixed.
    pub fn camera(&self, camera: usize) -> Option<Matrix6<f64>> {
        self.block(KeptParameter::CameraPosition { camera, axis: 0 })
    }

    /// Covariance of the pose of a tag in the object; `None` if it was fixed.
    pub fn tag(&self, tag: usize) -> Option<Matrix6<f64>> {
        self.block(KeptParameter::TagPosition { tag, axis: 0 })
    }

    /// Covariance of a pose of the robot; `None` without one.
    pub fn arm(&self, pose: ArmPose) -> Option<Matrix6<f64>> {
        self.block(KeptParameter::ArmPosition { pose, axis: 0 })
    }

    /// Covariance of the free parameters of a lens, in the order of `Lens::parameters`; empty if none was free.
    pub fn lens(&self, camera: usize) -> DMatrix<f64> {
        let of_lens =
            |p: &KeptParameter| matches!(p, KeptParameter::Lens { camera: c, .. } if *c == camera);
        let n = self.parameters.iter().filter(|p| of_lens(p)).count();
        let start = self.parameters.iter().position(of_lens).unwrap_or(0);
        self.matrix.view((start, start), (n, n)).into_owned()
    }

    fn block(&self, first: KeptParameter) -> Option<Matrix6<f64>> {
        let at = self.position(first)?;
        Some(self.matrix.fixed_view::<6, 6>(at, at).into_owned())
    }

    fn position(&self, parameter: KeptParameter) -> Option<usize> {
        self.parameters.iter().position(|&p| p == parameter)
    }
}

/// Inverse of a positive definite matrix whose diagonal spans many orders of magnitude, by scaling. If rounding makes
/// it indefinite, the covariance of the prior.
fn inverse(information: &DMatrix<f64>, sigma: impl Fn(usize) -> f64) -> DMatrix<f64> {
    let n = information.nrows();
    let scale: Vec<f64> = (0..n).map(|at| information[(at, at)].sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] / (scale[i] * scale[j]));
    let inverse = match scaled.cholesky() {
        Some(factor) if n > 0 => factor.inverse(),
        _ => DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                (sigma(i) * scale[i]).powi(2)
            } else {
                0.0
            }
        }),
    };
    DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j]))
}
