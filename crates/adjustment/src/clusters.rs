//! How far estimates depend on which images there are: the delete-one-group jackknife over clusters of images that
//! follow one another (B. Efron, The jackknife, the bootstrap and other resampling plans, 1982, ch. 2; for clusters: C.
//! F. J. Wu, Annals of Statistics 14, 1986).
//!
//! Corners of an image share what no model has: the bend of a board, blur, a lens of another form. Their errors are no
//! independent noise, so that the information of all corners states more than is known. What clusters disagree by does
//! not: with g and I a cluster's gradient and information at the optimum and A the information of all, the estimate
//! without it lies (A - I)^-1 g aside.

use crate::elimination::ReducedSystem;
use crate::equations::NormalEquations;
use crate::layout::Layout;
use crate::parameter::KeptParameter;
use crate::values::Bundle;
use nalgebra::{DMatrix, DVector};
use sextant_geometry::least_squares::Kernel;
use std::collections::BTreeMap;
use std::ops::Range;

/// Clusters of an adjustment.
const CLUSTERS: usize = 40;
/// Instants of a cluster at least, where they are tied.
const TIED: usize = 10;
/// Fewer of them say nothing.
const LEAST_CLUSTERS: usize = 5;
/// Steps of the fixed point x = A^-1 (g + I x), the estimate without the cluster.
const STEPS: usize = 20;

/// What the images of a cluster say of the kept parameters.
pub(crate) struct Cluster {
    pub information: DMatrix<f64>,
    pub gradient: DVector<f64>,
}

/// The clusters of a bundle, at its estimates.
pub(crate) fn clusters<const D: usize>(
    bundle: &Bundle,
    layout: &Layout,
    kernel: &Kernel,
) -> impl Iterator<Item = Cluster> {
    let n = bundle.instants.len();
    // Where instants are tied to one another, a cluster must have a motion of its own.
    let most = if bundle.motion.is_some() { n / TIED } else { n };
    let n_clusters = if most < LEAST_CLUSTERS {
        0
    } else {
        most.min(CLUSTERS)
    };
    let instants = (0..n_clusters).map(move |k| k * n / n_clusters..(k + 1) * n / n_clusters);
    instants.filter_map(|instants| {
        let part = part(bundle, &instants);
        let equations = NormalEquations::<D>::new(&part, layout, kernel);
        let reduced = ReducedSystem::new(&equations, 0.0)?;
        Some(Cluster {
            information: reduced.information,
            gradient: reduced.gradient,
        })
    })
}

/// The instants of a range with their images, and nothing else that is known.
fn part(bundle: &Bundle, instants: &Range<usize>) -> Bundle {
    let first = |instant: usize| {
        bundle
            .images
            .partition_point(|image| image.instant < instant)
    };
    let mut images = bundle.images[first(instants.start)..first(instants.end)].to_vec();
    for image in &mut images {
        image.instant -= instants.start;
    }
    Bundle {
        cameras: bundle.cameras.clone(),
        tags: bundle.tags.clone(),
        scales: bundle.scales.clone(),
        instants: bundle.instants[instants.clone()].to_vec(),
        images,
        motion: bundle.motion,
        anchors: Vec::new(),
        arm: bundle.arm.as_ref().map(|arm| arm.part(instants.clone())),
    }
}

/// Factors on the variances, at least 1: the ratio of the jackknife's variances to those due to corner noise, summed
/// over a class. One class holds all camera poses, one all tag poses, one all tag sizes and one the robot, since each
/// is known relative to the others; every lens, every clock and every line delay is a class of its own. `variances` are
/// those due to corner noise, `sigmas` the standard deviations that make parameters of different units comparable, and
/// `displacements` the steps of the estimates without one cluster each.
pub(crate) fn factors(
    parameters: &[KeptParameter],
    variances: &DVector<f64>,
    sigmas: &DVector<f64>,
    displacements: &[DVector<f64>],
) -> DVector<f64> {
    let mut factors = DVector::from_element(parameters.len(), 1.0);
    if displacements.len() < LEAST_CLUSTERS {
        return factors;
    }
    let n = displacements.len() as f64;
    let mean: DVector<f64> = displacements.iter().sum::<DVector<f64>>() / n;
    // By class: the sums of the jackknife's variances and of those of noise.
    let mut classes: BTreeMap<Class, (f64, f64)> = BTreeMap::new();
    for (at, parameter) in parameters.iter().enumerate() {
        let squares = displacements
            .iter()
            .map(|step| (step[at] - mean[at]).powi(2));
        let sum = classes.entry(Class::containing(*parameter)).or_default();
        sum.0 += squares.sum::<f64>() * (n - 1.0) / n / sigmas[at].powi(2);
        sum.1 += variances[at] / sigmas[at].powi(2);
    }
    for (factor, parameter) in factors.iter_mut().zip(parameters) {
        if let Some((found, of_noise)) = classes.get(&Class::containing(*parameter))
            && *of_noise > 0.0
        {
            *factor = (found / of_noise).max(1.0);
        }
    }
    factors
}

/// The step of the estimates without a cluster: `inverse` is that of the information of all.
pub(crate) fn displacement(
    inverse: &DMatrix<f64>,
    gradient: &DVector<f64>,
    information: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> DVector<f64> {
    let mut step = inverse * gradient;
    for _ in 0..STEPS {
        step = inverse * (gradient + information(&step));
    }
    step
}

/// Parameters with one factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    CameraPoses,
    TagPoses,
    TagSizes,
    Lens(usize),
    Clock(usize),
    LineDelay(usize),
    Arm,
}

impl Class {
    fn containing(parameter: KeptParameter) -> Self {
        match parameter {
            KeptParameter::CameraPosition { .. } | KeptParameter::CameraRotation { .. } => {
                Self::CameraPoses
            }
            KeptParameter::TagPosition { .. } | KeptParameter::TagRotation { .. } => Self::TagPoses,
            KeptParameter::TagSize { .. } | KeptParameter::Scale { .. } => Self::TagSizes,
            KeptParameter::Lens { camera, .. } => Self::Lens(camera),
            KeptParameter::Clock { camera } => Self::Clock(camera),
            KeptParameter::LineDelay { camera } => Self::LineDelay(camera),
            KeptParameter::ArmPosition { .. }
            | KeptParameter::ArmRotation { .. }
            | KeptParameter::ArmDelay => Self::Arm,
        }
    }
}
