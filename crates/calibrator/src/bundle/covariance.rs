//! Covariance of the kept parameters.

use super::clusters::{Cluster, displacement, factors};
use super::layout::{ArmPose, KeptParameter, Layout};
use super::prior_knowledge::PriorKnowledge;
use super::state::Bundle;
use nalgebra::{DMatrix, DVector, Matrix6};
use sextant_geometry::{Pose, so3};

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
    /// From the information matrix over the solver's steps, and what each cluster of images says, both in units of the
    /// stated noise, whose variance is off by `variance_factor`.
    pub(super) fn of(
        (bundle, layout): (&Bundle, &Layout),
        (information, clusters): (DMatrix<f64>, impl Iterator<Item = Cluster>),
        variance_factor: f64,
        prior: &PriorKnowledge,
    ) -> Self {
        let information = information / variance_factor;
        let parameters = layout.parameters();
        let steps = steps_from_framed(bundle, layout);
        let information = steps.transpose() * information * &steps;
        let mut with_prior = information.clone();
        for (at, parameter) in parameters.iter().enumerate() {
            with_prior[(at, at)] += prior.sigma(bundle, parameter).powi(-2);
        }
        let of_noise = inverse(with_prior, |at| prior.sigma(bundle, &parameters[at]));
        let mut of_images = DMatrix::zeros(parameters.len(), parameters.len());
        let displacements: Vec<_> = clusters
            .map(|cluster| {
                of_images += &cluster.information / variance_factor;
                let gradient = steps.tr_mul(&cluster.gradient) / variance_factor;
                displacement(&of_noise, &gradient, |step| {
                    steps.tr_mul(&(&cluster.information * (&steps * step))) / variance_factor
                })
            })
            .collect();
        // The part that is due to images alone: what only priors determine, no image can disagree about.
        let due_to_images = &of_noise * (steps.tr_mul(&of_images) * &steps) * &of_noise;
        let (variances, sigmas) = (due_to_images.diagonal(), of_noise.diagonal().map(f64::sqrt));
        let factors = factors(&parameters, (&variances, &sigmas), &displacements);
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
    pub(super) fn of_noise(&self) -> &DMatrix<f64> {
        &self.of_noise
    }

    /// Information of images and anchors, without the prior.
    pub(crate) fn information(&self) -> &DMatrix<f64> {
        &self.information
    }

    /// The parameter of each row and column of [`KeptCovariance::matrix`].
    pub fn parameters(&self) -> &[KeptParameter] {
        &self.parameters
    }

    /// The whole matrix.
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
fn inverse(information: DMatrix<f64>, sigma: impl Fn(usize) -> f64) -> DMatrix<f64> {
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

/// Maps a step of FRAMES.md to the solver's step (a twist of the outer frame about its origin), block by block:
/// `v = dt - w x t`, `w = dr`.
fn steps_from_framed(bundle: &Bundle, layout: &Layout) -> DMatrix<f64> {
    let mut steps = DMatrix::identity(layout.n, layout.n);
    let mut put = |columns: Option<usize>, pose: &Pose| {
        if let Some(at) = columns {
            steps
                .fixed_view_mut::<3, 3>(at, at + 3)
                .copy_from(&so3::hat(&pose.translation.vector));
        }
    };
    for (camera, columns) in bundle.cameras.iter().zip(&layout.cameras) {
        put(columns.pose, &camera.world_from_camera);
    }
    for (tag, columns) in bundle.tags.iter().zip(&layout.tags) {
        put(columns.pose, &tag.object_from_tag);
    }
    if let Some(arm) = &bundle.arm {
        put(layout.arm.pose, &arm.base_from_site);
        put(layout.arm.pose.map(|at| at + 6), &arm.hand_from_carried);
    }
    steps
}
