//! The residuals of priors.
//!
//! The error of a pose is its step of FRAMES.md from its prior, `(dt, dr)` over the outer frame's axes; a further step
//! changes it by `(dt, J_l^-1(dr) dr)`. The error of a size is that of its logarithm, as its step is.

use crate::anchor::Anchor;
use crate::layout::Layout;
use crate::values::{Bundle, Freedom};
use nalgebra::{DMatrix, DVector, Matrix6, Vector6};
use sextant_geometry::{se3, so3};

/// Adds every anchor to the equations of the kept parameters.
pub(crate) fn add(
    bundle: &Bundle,
    layout: &Layout,
    kept: &mut DMatrix<f64>,
    gradient: &mut DVector<f64>,
) {
    for anchor in &bundle.anchors {
        let Some((at, width)) = anchor.columns(layout) else {
            continue;
        };
        let error = anchor.error(bundle);
        let mut by_step = Matrix6::identity();
        if width == 6 {
            let turn = error.fixed_rows::<3>(3).into_owned();
            let by_turn = so3::left_jacobian_inverse(&turn);
            by_step.fixed_view_mut::<3, 3>(3, 3).copy_from(&by_turn);
        }
        let weights = Matrix6::from_diagonal(&anchor.sigmas().map(|sigma| sigma.powi(-2)));
        let weighted = by_step.transpose() * weights;
        let mut own = kept.view_mut((at, at), (width, width));
        own += (weighted * by_step).view((0, 0), (width, width));
        let mut pull = gradient.rows_mut(at, width);
        pull += (weighted * error).rows(0, width);
    }
}

/// The sum of the squares of all anchors.
pub(crate) fn rho(bundle: &Bundle) -> f64 {
    let squares = bundle.anchors.iter().map(|anchor| {
        let errors = anchor.error(bundle).component_div(&anchor.sigmas());
        errors.norm_squared()
    });
    squares.sum()
}

/// Sum of the logarithms of the precisions of the clocks' anchors: those of the others are the same in all models that
/// are compared.
pub(crate) fn log_prior(bundle: &Bundle) -> f64 {
    let precisions = bundle.anchors.iter().map(|anchor| match anchor {
        Anchor::Clock { camera, sigma, .. } if bundle.cameras[*camera].clock == Freedom::Free => {
            -2.0 * sigma.ln()
        }
        _ => 0.0,
    });
    precisions.sum()
}

impl Anchor {
    /// First column of its parameters and their number; `None` where they are not sought.
    fn columns(&self, layout: &Layout) -> Option<(usize, usize)> {
        let pose = |at: Option<usize>| at.map(|at| (at, 6));
        let scalar = |at: Option<usize>| at.map(|at| (at, 1));
        match *self {
            Self::Camera { camera, .. } => pose(layout.cameras[camera].pose),
            Self::Tag { tag, .. } => pose(layout.tags[tag].pose),
            Self::Size { tag, .. } => scalar(layout.tags[tag].size),
            Self::Lens {
                camera, parameter, ..
            } => scalar(layout.cameras[camera].lens_column(parameter)),
            Self::Scale { scale, .. } => scalar(layout.scales[scale]),
            Self::Clock { camera, .. } => scalar(layout.cameras[camera].clock),
            Self::LineDelay { camera, .. } => scalar(layout.cameras[camera].line_delay),
        }
    }

    /// Difference of the bundle from the prior, in the units of the anchor; a scalar is the first element.
    pub fn error(&self, bundle: &Bundle) -> Vector6<f64> {
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
            Self::Scale { scale, .. } => single(bundle.scales[*scale].log_factor),
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

    /// Whether its indices and deviations are valid.
    pub(crate) fn is_sound(&self, bundle: &Bundle) -> bool {
        let usable = |sigma: f64| sigma > 0.0 && sigma.powi(-2).is_finite();
        let is_there = match self {
            Self::Camera { camera, .. }
            | Self::Clock { camera, .. }
            | Self::LineDelay { camera, .. } => *camera < bundle.cameras.len(),
            Self::Tag { tag, .. } => *tag < bundle.tags.len(),
            Self::Scale { scale, .. } => *scale < bundle.scales.len(),
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
