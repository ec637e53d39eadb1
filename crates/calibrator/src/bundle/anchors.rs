//! What is known of kept parameters before the images: poses with their deviations, as further squares.
//!
//! The error of a pose is its step of FRAMES.md from where it is believed to be (`dt`, `dr` over the outer frame's axes); the
//! solver's step is a twist `(v, w)` of the outer frame, so that `dt` grows by `v - t x w` and `dr`, for small errors, by `w`.

use super::layout::Layout;
use super::state::Bundle;
use nalgebra::{DMatrix, DVector, Matrix6, Vector6};
use sextant_estimator::PoseSigma;
use sextant_geometry::{Pose, se3, so3};

/// A belief about a kept parameter; without effect where the parameter is not sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// Where a camera is.
    Camera {
        /// Index into [`Bundle::cameras`].
        camera: usize,
        /// Maps points of the camera into the world.
        world_from_camera: Pose,
        /// One deviation an axis.
        sigma: PoseSigma,
    },
    /// Where a tag is.
    Tag {
        /// Index into [`Bundle::tags`].
        tag: usize,
        /// Maps points of the tag into the object.
        object_from_tag: Pose,
        /// One deviation an axis.
        sigma: PoseSigma,
    },
}

/// Adds every anchor to the equations of the kept parameters; gives the sum of their squares.
pub(super) fn hold(
    bundle: &Bundle,
    layout: &Layout,
    kept: &mut DMatrix<f64>,
    gradient: &mut DVector<f64>,
) -> f64 {
    for anchor in &bundle.anchors {
        match anchor {
            Anchor::Camera { camera, sigma, .. } => {
                let columns = layout.cameras[*camera].pose;
                hold_pose(bundle, anchor, sigma, columns, (kept, gradient));
            }
            Anchor::Tag { tag, sigma, .. } => {
                let columns = layout.tags[*tag].pose;
                hold_pose(bundle, anchor, sigma, columns, (kept, gradient));
            }
        }
    }
    rho(bundle)
}

fn hold_pose(
    bundle: &Bundle,
    anchor: &Anchor,
    sigma: &PoseSigma,
    columns: Option<usize>,
    (kept, gradient): (&mut DMatrix<f64>, &mut DVector<f64>),
) {
    let Some(at) = columns else { return };
    let (pose, believed) = anchor.poses(bundle);
    let mut by_step = Matrix6::identity();
    by_step
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&-so3::hat(&pose.translation.vector));
    let weights = Matrix6::from_diagonal(&weights(sigma));
    let weighted = by_step.transpose() * weights;
    let mut own = kept.fixed_view_mut::<6, 6>(at, at);
    own += weighted * by_step;
    let mut pull = gradient.fixed_rows_mut::<6>(at);
    pull += weighted * se3::difference(pose, believed);
}

/// The sum of the squares of all anchors.
pub(super) fn rho(bundle: &Bundle) -> f64 {
    let squares = bundle.anchors.iter().map(|anchor| {
        let (Anchor::Camera { sigma, .. } | Anchor::Tag { sigma, .. }) = anchor;
        let (pose, believed) = anchor.poses(bundle);
        let error = se3::difference(pose, believed);
        error.component_mul(&error).dot(&weights(sigma))
    });
    squares.sum()
}

fn weights(sigma: &PoseSigma) -> Vector6<f64> {
    let (position, orientation) = (sigma.position_m.powi(-2), sigma.orientation_rad.powi(-2));
    Vector6::from_fn(|axis, _| if axis < 3 { position } else { orientation })
}

impl Anchor {
    /// The pose in the bundle and where it is believed to be.
    fn poses<'a>(&'a self, bundle: &'a Bundle) -> (&'a Pose, &'a Pose) {
        match self {
            Self::Camera {
                camera,
                world_from_camera,
                ..
            } => (
                &bundle.cameras[*camera].world_from_camera,
                world_from_camera,
            ),
            Self::Tag {
                tag,
                object_from_tag,
                ..
            } => (&bundle.tags[*tag].object_from_tag, object_from_tag),
        }
    }

    /// Whether it names something that is there and its deviations are usable.
    pub(super) fn is_sound(&self, bundle: &Bundle) -> bool {
        let usable = |sigma: f64| sigma > 0.0 && sigma.powi(-2).is_finite();
        match self {
            Self::Camera { camera, sigma, .. } => {
                *camera < bundle.cameras.len()
                    && usable(sigma.position_m)
                    && usable(sigma.orientation_rad)
            }
            Self::Tag { tag, sigma, .. } => {
                *tag < bundle.tags.len()
                    && usable(sigma.position_m)
                    && usable(sigma.orientation_rad)
            }
        }
    }
}
