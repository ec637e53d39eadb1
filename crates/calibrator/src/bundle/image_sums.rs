//! Contribution of the tags of one image to the normal equations.
//!
//! The columns of an image are those of its camera, the `D` of its instant, and one for the error of its stamp; each
//! tag has seven of its own.

use super::layout::{CameraColumns, Layout};
use super::residuals::{LensColumns, TagEquations, View, lever, linearise, object_at};
use super::state::{Bundle, BundleImage, TagObservation};
use nalgebra::{Const, DMatrix, DVector, Dyn, OMatrix, SMatrix, SVector};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::{Pose, se3};

/// Rows of a tag by columns of its image.
type TagRows = OMatrix<f64, Const<8>, Dyn>;

/// Normal equations of one tag over its seven parameters (a twist of the object's frame, which is a step of its pose,
/// and its size).
pub(super) struct TagSums {
    /// Index of the tag.
    pub tag: usize,
    pub own: SMatrix<f64, 7, 7>,
    pub gradient: SVector<f64, 7>,
    /// Over the image's columns and the tag's parameters.
    pub image_by_tag: OMatrix<f64, Dyn, Const<7>>,
}

/// Normal equations of an image over its columns, and of each of its tags.
pub(super) struct ImageSums<const D: usize> {
    pub tags: Vec<TagSums>,
    pub whole: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// Number of the camera's columns, which come first.
    pub width: usize,
    /// Sum of the robust squares.
    pub rho: f64,
}

impl<const D: usize> ImageSums<D> {
    pub(super) fn of(
        bundle: &Bundle,
        layout: &Layout,
        image: &BundleImage,
        kernel: &Kernel,
    ) -> Self {
        let columns = &layout.cameras[image.camera];
        let wanted = if columns.lens_parameters.is_empty() {
            LensColumns::Unwanted
        } else {
            LensColumns::TagSpec
        };
        let image_columns = ImageColumns::<D> {
            view: View::of(bundle, image, wanted),
            columns,
            lever: lever::<D>(bundle, image),
            object_from_world: object_at(bundle, image).inverse(),
        };
        let n = columns.width() + D + 1;
        let mut sums = Self {
            tags: Vec::with_capacity(image.tags.len()),
            whole: DMatrix::zeros(n, n),
            gradient: DVector::zeros(n),
            width: columns.width(),
            rho: 0.0,
        };
        for seen in &image.tags {
            let tag = &bundle.tags[seen.tag];
            let equations = linearise(
                &image_columns.view,
                &tag.object_from_tag,
                tag.size_m,
                seen,
                kernel,
            );
            sums.add(seen, &equations, &image_columns.rows(seen, &equations));
        }
        sums
    }

    fn add(&mut self, seen: &TagObservation, equations: &TagEquations, rows: &TagRows) {
        let mut by_tag = SMatrix::<f64, 8, 7>::zeros();
        by_tag
            .fixed_columns_mut::<6>(0)
            .copy_from(&equations.by_tag);
        by_tag.set_column(6, &equations.by_size);
        let transposed = rows.transpose();
        self.whole += &transposed * rows;
        self.gradient += &transposed * equations.error;
        self.rho += equations.rho;
        self.tags.push(TagSums {
            tag: seen.tag,
            own: by_tag.transpose() * by_tag,
            gradient: by_tag.transpose() * equations.error,
            image_by_tag: transposed * by_tag,
        });
    }

    /// Column of the error of the stamp.
    pub(super) fn stamp(&self) -> usize {
        self.width + D
    }
}

/// What the columns of an image are computed from.
struct ImageColumns<'a, const D: usize> {
    view: View,
    columns: &'a CameraColumns,
    lever: SMatrix<f64, 6, D>,
    object_from_world: Pose,
}

impl<const D: usize> ImageColumns<'_, D> {
    /// Derivatives of a tag's corners by the columns of the image.
    fn rows(&self, seen: &TagObservation, equations: &TagEquations) -> TagRows {
        let (columns, shutter) = (self.columns, &self.view.shutter);
        let width = columns.width();
        let mut rows = TagRows::zeros(width + D + 1);
        let by_time = equations.by_twist * shutter.twist;
        let mut at = 0;
        if columns.pose.is_some() {
            // A twist of the world about its origin moves the camera, and the object the other way.
            let by_pose = -equations.by_twist * se3::adjoint(&self.object_from_world);
            rows.columns_mut(0, 6).copy_from(&by_pose);
            at += 6;
        }
        if columns.clock.is_some() {
            rows.set_column(at, &by_time);
            at += 1;
        }
        if columns.line_delay.is_some() {
            for (corner, pixel) in seen.corners.iter().enumerate() {
                for row in 2 * corner..2 * corner + 2 {
                    rows[(row, at)] = by_time[row] * shutter.rows(pixel);
                }
            }
            at += 1;
        }
        for &parameter in &columns.lens_parameters {
            rows.set_column(at, &equations.by_lens.column(parameter));
            at += 1;
        }
        let by_instant = equations.by_twist * self.lever;
        rows.columns_mut(width, D).copy_from(&by_instant);
        if D > 6 && equations.after_s.amax() > 0.0 {
            self.add_motion_within_image(equations, &mut rows);
        }
        rows.set_column(width + D, &by_time);
        rows
    }

    /// The effect of the instant's twist between the capture time and the times of rows.
    fn add_motion_within_image(&self, equations: &TagEquations, rows: &mut TagRows) {
        let first = self.columns.width() + 6;
        for row in 0..8 {
            let after_s = equations.after_s[row];
            let by_twist = se3::left_jacobian(&(self.view.shutter.twist * after_s)) * after_s;
            let more = equations.by_twist.row(row) * by_twist;
            for (column, more) in more.iter().enumerate() {
                rows[(row, first + column)] += more;
            }
        }
    }
}
