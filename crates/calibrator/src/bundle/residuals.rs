//! The reprojection error of one tag in one image and its derivatives.
//!
//! Every derivative uses the motion of the corner in the object's frame: a small twist `(v, w)` of the object's
//! frame moves the point `X` by `v + w x X`. Steps of the object's pose and of a tag are such twists, and a camera's
//! is its adjoint, so one 8x6 Jacobian serves all of them (`J = J_pi R [I | -hat X]`).

use super::state::{Bundle, BundleImage, TagObservation};
use nalgebra::{Matrix2, Matrix2x3, SMatrix, SVector, Vector2};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::lens::MAX_PARAMETERS;
use sextant_geometry::{Lens, Pose, se3, so3, tag_corners_in_tag};

/// Chi-square of a corner that cannot be projected, which makes it an outlier.
const UNSEEN: f64 = 1e8;

/// The error of one tag in one image at the solution.
#[derive(Clone, Debug, PartialEq)]
pub struct TagResidual {
    /// Index into [`Bundle::images`].
    pub image: usize,
    /// Index into the image's tags.
    pub seen: usize,
    /// Projected minus detected corner, pixels; `None` if the corner cannot be projected or has zero weight.
    pub corners_px: [Option<Vector2<f64>>; 4],
    /// Sum over its corners of the squared errors in units of the detector's noise; 8 is expected.
    pub chi_square: f64,
}

impl TagResidual {
    /// Root mean square over the corners of the distance between model and seen corner, pixels.
    pub fn rms_px(&self) -> f64 {
        let seen = || self.corners_px.iter().flatten();
        let sum: f64 = seen().map(Vector2::norm_squared).sum();
        (sum / seen().count().max(1) as f64).sqrt()
    }
}

/// Whitened, weighted error and derivatives of a tag.
pub(super) struct TagEquations {
    pub error: SVector<f64, 8>,
    /// With respect to a twist of the object's frame.
    pub by_twist: SMatrix<f64, 8, 6>,
    /// With respect to the logarithm of the tag's size.
    pub by_size: SVector<f64, 8>,
    /// With respect to the lens parameters; only filled where these are free.
    pub by_lens: SMatrix<f64, 8, MAX_PARAMETERS>,
    /// Robust cost, in units of the noise squared.
    pub rho: f64,
}

/// Whether to compute derivatives with respect to the lens.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum LensColumns {
    TagSpec,
    Unwanted,
}

/// Projection of the object into one image.
pub(super) struct View {
    pub lens: Lens,
    pub camera_from_object: Pose,
    pub columns: LensColumns,
}

impl View {
    pub(super) fn of(bundle: &Bundle, image: &BundleImage, columns: LensColumns) -> Self {
        let camera = &bundle.cameras[image.camera];
        let world_from_object = object_at(bundle, image);
        Self {
            lens: camera.lens,
            camera_from_object: camera.world_from_camera.inverse() * world_from_object,
            columns,
        }
    }
}

/// Seconds from the instant to the image, by the world's clock.
pub(super) fn delay(bundle: &Bundle, image: &BundleImage) -> f64 {
    let offset_s = bundle.cameras[image.camera].clock_offset_s;
    image.seconds_after_instant + offset_s + image.stamp_error_s
}

/// Pose of the object at the capture time of the image.
pub(super) fn object_at(bundle: &Bundle, image: &BundleImage) -> Pose {
    let instant = &bundle.instants[image.instant];
    match bundle.motion {
        None => instant.world_from_object,
        Some(_) => {
            let delay = delay(bundle, image);
            instant.world_from_object * se3::exp(&(instant.twist * delay))
        }
    }
}

/// Robust equations of a tag. A corner that cannot be projected counts as an outlier without derivatives.
pub(super) fn linearise(
    view: &View,
    object_from_tag: &Pose,
    size_m: f64,
    seen: &TagObservation,
    kernel: &Kernel,
) -> TagEquations {
    let mut equations = TagEquations {
        error: SVector::zeros(),
        by_twist: SMatrix::zeros(),
        by_size: SVector::zeros(),
        by_lens: SMatrix::zeros(),
        rho: 0.0,
    };
    let rotation = view.camera_from_object.rotation.to_rotation_matrix();
    for (corner, in_tag) in tag_corners_in_tag(size_m).iter().enumerate() {
        let in_object = object_from_tag * in_tag;
        let in_camera = view.camera_from_object * in_object;
        let Some((pixel, by_point)) = view.lens.project_with_jacobian(&in_camera) else {
            equations.rho += kernel.rho(UNSEEN);
            continue;
        };
        let whitening: &Matrix2<f64> = &seen.whitening[corner];
        let error = whitening * (pixel - seen.corners[corner]);
        let square = error.norm_squared();
        equations.rho += kernel.rho(square);
        let weight = kernel.weight(square).sqrt();
        let weighted = whitening * weight;
        let by_object: Matrix2x3<f64> = weighted * (by_point * rotation.matrix());
        let by_turn: Matrix2x3<f64> = -by_object * so3::hat(&in_object.coords);
        let row = 2 * corner;
        equations
            .error
            .fixed_rows_mut::<2>(row)
            .copy_from(&(error * weight));
        let from_centre = object_from_tag.rotation * in_tag.coords;
        equations
            .by_size
            .fixed_rows_mut::<2>(row)
            .copy_from(&(by_object * from_centre));
        let mut rows = equations.by_twist.fixed_view_mut::<2, 6>(row, 0);
        rows.fixed_columns_mut::<3>(0).copy_from(&by_object);
        rows.fixed_columns_mut::<3>(3).copy_from(&by_turn);
        if view.columns == LensColumns::TagSpec
            && let Some(by_lens) = view.lens.parameter_jacobian(&in_camera)
        {
            equations
                .by_lens
                .fixed_view_mut::<2, MAX_PARAMETERS>(row, 0)
                .copy_from(&(weighted * by_lens));
        }
    }
    equations
}

/// Robust cost of a tag alone.
pub(super) fn rho(
    view: &View,
    object_from_tag: &Pose,
    size_m: f64,
    seen: &TagObservation,
    kernel: &Kernel,
) -> f64 {
    let errors = errors_px(view, object_from_tag, size_m, seen);
    let squares = errors.iter().zip(&seen.whitening);
    squares
        .map(|(error, whitening)| {
            let square = error.map_or(UNSEEN, |error| (whitening * error).norm_squared());
            kernel.rho(square)
        })
        .sum()
}

/// Model less seen corners, pixels.
fn errors_px(
    view: &View,
    object_from_tag: &Pose,
    size_m: f64,
    seen: &TagObservation,
) -> [Option<Vector2<f64>>; 4] {
    let camera_from_tag = view.camera_from_object * object_from_tag;
    let mut errors = [None; 4];
    let corners = tag_corners_in_tag(size_m);
    for ((error, in_tag), at) in errors.iter_mut().zip(corners).zip(&seen.corners) {
        *error = view
            .lens
            .project(&(camera_from_tag * in_tag))
            .map(|pixel| pixel - at);
    }
    errors
}

impl Bundle {
    /// Residuals of every tag of every image, in order.
    pub fn residuals(&self) -> impl Iterator<Item = TagResidual> {
        self.images
            .iter()
            .enumerate()
            .flat_map(move |(index, image)| {
                let view = View::of(self, image, LensColumns::Unwanted);
                let seen = image.tags.iter().enumerate();
                seen.map(move |(at, seen)| self.residual(&view, (index, at), seen))
            })
    }

    fn residual(
        &self,
        view: &View,
        (image, at): (usize, usize),
        seen: &TagObservation,
    ) -> TagResidual {
        let tag = &self.tags[seen.tag];
        let mut corners_px = errors_px(view, &tag.object_from_tag, tag.size_m, seen);
        let squares = corners_px.iter().zip(&seen.whitening);
        let chi_square = squares
            .map(|(error, whitening)| error.map_or(UNSEEN, |e| (whitening * e).norm_squared()))
            .sum();
        for (error, whitening) in corners_px.iter_mut().zip(&seen.whitening) {
            *error = error.filter(|_| *whitening != Matrix2::zeros());
        }
        TagResidual {
            image,
            seen: at,
            corners_px,
            chi_square,
        }
    }
}
