//! Priors of kept parameters: values with standard deviations, as additional residuals.
//!
//! The error of a pose is its step of FRAMES.md from its prior (`dt`, `dr` over the outer frame's axes); the
//! solver's step is a twist `(v, w)` of the outer frame, so that `dt` grows by `v - t x w` and `dr`, for small errors,
//! by `w`. The error of a size is that of its logarithm, as its step is.

use super::layout::{KeptParameter, Layout};
use super::state::{Anchor, Bundle, Freedom};
use nalgebra::{DMatrix, DVector, Matrix6, Vector6};
use sextant_geometry::{se3, so3};
use sextant_site_model::PoseSigma;

/// Adds every anchor to the equations of the kept parameters; returns the sum of their squares.
pub(super) fn add(
    bundle: &Bundle,
    layout: &Layout,
    kept: &mut DMatrix<f64>,
    gradient: &mut DVector<f64>,
) -> f64 {
    for anchor in &bundle.anchors {
        let scalar = |at: Option<usize>| at.map(|at| (at, 1));
        let (pose, columns) = match *anchor {
            Anchor::Camera { camera, .. } => (
                Some(&bundle.cameras[camera].world_from_camera),
                layout.cameras[camera].pose.map(|at| (at, 6)),
            ),
            Anchor::Tag { tag, .. } => (
                Some(&bundle.tags[tag].object_from_tag),
                layout.tags[tag].pose.map(|at| (at, 6)),
            ),
            Anchor::Size { tag, .. } => (None, scalar(layout.tags[tag].size)),
            Anchor::Lens {
                camera, parameter, ..
            } => (None, scalar(layout.cameras[camera].lens_column(parameter))),
            Anchor::Clock { camera, .. } => (None, scalar(layout.cameras[camera].clock)),
            Anchor::LineDelay { camera, .. } => (None, scalar(layout.cameras[camera].line_delay)),
        };
        let Some((at, width)) = columns else { continue };
        let mut by_step = Matrix6::identity();
        if let Some(pose) = pose {
            by_step
                .fixed_view_mut::<3, 3>(0, 3)
                .copy_from(&-so3::hat(&pose.translation.vector));
        }
        let weights = Matrix6::from_diagonal(&anchor.sigmas().map(|sigma| sigma.powi(-2)));
        let weighted = by_step.transpose() * weights;
        let mut own = kept.view_mut((at, at), (width, width));
        own += (weighted * by_step).view((0, 0), (width, width));
        let mut pull = gradient.rows_mut(at, width);
        pull += (weighted * anchor.error(bundle)).rows(0, width);
    }
    rho(bundle)
}

/// The sum of the squares of all anchors.
pub(super) fn rho(bundle: &Bundle) -> f64 {
    let squares = bundle.anchors.iter().map(|anchor| {
        let errors = anchor.error(bundle).component_div(&anchor.sigmas());
        errors.norm_squared()
    });
    squares.sum()
}

/// Sum of the logarithms of the precisions of the clocks' anchors: those of the others are the same in all models that
/// are compared.
pub(super) fn log_prior(bundle: &Bundle) -> f64 {
    let precisions = bundle.anchors.iter().map(|anchor| match anchor {
        Anchor::Clock { camera, sigma, .. } if bundle.cameras[*camera].clock == Freedom::Free => {
            -2.0 * sigma.ln()
        }
        _ => 0.0,
    });
    precisions.sum()
}

fn of_pose(sigma: PoseSigma, across: f64) -> Vector6<f64> {
    let (position, orientation) = (sigma.position_m, sigma.orientation_rad);
    let bent = orientation * across;
    Vector6::new(
        position,
        position,
        position * across,
        bent,
        bent,
        orientation,
    )
}

impl Anchor {
    /// Difference of the bundle from the prior, in the units of the anchor; a scalar is the first element.
    pub(crate) fn error(&self, bundle: &Bundle) -> Vector6<f64> {
        let single = |error: f64| Vector6::new(error, 0.0, 0.0, 0.0, 0.0, 0.0);
        match self {
            Self::Camera {
                camera,
                world_from_camera,
                ..
            } => se3::difference(
                &bundle.cameras[*camera].world_from_camera,
                world_from_camera,
            ),
            Self::Tag {
                tag,
                object_from_tag,
                ..
            } => se3::difference(&bundle.tags[*tag].object_from_tag, object_from_tag),
            Self::Size { tag, size_m, .. } => single((bundle.tags[*tag].size_m / size_m).ln()),
            Self::Lens {
                camera,
                parameter,
                value,
                ..
            } => single(bundle.cameras[*camera].lens.parameters()[*parameter] - value),
            Self::Clock {
                camera, offset_s, ..
            } => single(bundle.cameras[*camera].clock_offset_s - offset_s),
            Self::LineDelay {
                camera,
                line_delay_s,
                ..
            } => single(bundle.cameras[*camera].line_delay_s - line_delay_s),
        }
    }

    /// Standard deviation of each element; a scalar's is repeated six times.
    pub(crate) fn sigmas(&self) -> Vector6<f64> {
        match *self {
            Self::Camera { sigma, .. } => of_pose(sigma, 1.0),
            Self::Tag { sigma, across, .. } => of_pose(sigma, across),
            Self::Size { sigma, .. }
            | Self::Lens { sigma, .. }
            | Self::Clock { sigma, .. }
            | Self::LineDelay { sigma, .. } => Vector6::repeat(sigma),
        }
    }

    /// The anchor with scaled deviations: that of the position or scalar, and that of the orientation.
    pub(crate) fn scaled(mut self, first: f64, orientation: f64) -> Self {
        match &mut self {
            Self::Camera { sigma, .. } | Self::Tag { sigma, .. } => {
                sigma.position_m *= first;
                sigma.orientation_rad *= orientation;
            }
            Self::Size { sigma, .. }
            | Self::Lens { sigma, .. }
            | Self::Clock { sigma, .. }
            | Self::LineDelay { sigma, .. } => *sigma *= first,
        }
        self
    }

    /// Its parameters, in the order of its errors.
    pub(crate) fn parameters(&self) -> Vec<KeptParameter> {
        let axes = || 0..3;
        match *self {
            Self::Camera { camera, .. } => {
                let position = axes().map(|axis| KeptParameter::CameraPosition { camera, axis });
                let rotation = axes().map(|axis| KeptParameter::CameraRotation { camera, axis });
                position.chain(rotation).collect()
            }
            Self::Tag { tag, .. } => {
                let position = axes().map(|axis| KeptParameter::TagPosition { tag, axis });
                let rotation = axes().map(|axis| KeptParameter::TagRotation { tag, axis });
                position.chain(rotation).collect()
            }
            Self::Size { tag, .. } => vec![KeptParameter::TagSize { tag }],
            Self::Lens {
                camera, parameter, ..
            } => vec![KeptParameter::Lens { camera, parameter }],
            Self::Clock { camera, .. } => vec![KeptParameter::Clock { camera }],
            Self::LineDelay { camera, .. } => vec![KeptParameter::LineDelay { camera }],
        }
    }

    /// Whether its indices and deviations are valid.
    pub(super) fn is_sound(&self, bundle: &Bundle) -> bool {
        let usable = |sigma: f64| sigma > 0.0 && sigma.powi(-2).is_finite();
        let is_there = match self {
            Self::Camera { camera, .. }
            | Self::Clock { camera, .. }
            | Self::LineDelay { camera, .. } => *camera < bundle.cameras.len(),
            Self::Tag { tag, .. } => *tag < bundle.tags.len(),
            Self::Size { tag, size_m, .. } => *tag < bundle.tags.len() && *size_m > 0.0,
            Self::Lens {
                camera, parameter, ..
            } => bundle
                .cameras
                .get(*camera)
                .is_some_and(|camera| *parameter < camera.lens.n_parameters()),
        };
        is_there && self.sigmas().iter().all(|&sigma| usable(sigma))
    }
}
