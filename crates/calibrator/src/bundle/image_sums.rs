//! Contribution of the tags of one image to the normal equations.

use super::layout::{CameraColumns, Layout};
use super::residuals::{LensColumns, View, linearise, object_at};
use super::state::{Bundle, BundleImage};
use nalgebra::{Const, DMatrix, DVector, Dyn, Matrix6, OMatrix, SMatrix, SVector, Vector6};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::lens::MAX_PARAMETERS;
use sextant_geometry::se3;

/// Derivative of the object's twist with columns of parameters.
pub(super) type TwistJacobian = OMatrix<f64, Const<6>, Dyn>;
type LensTagBlock = SMatrix<f64, MAX_PARAMETERS, 7>;
type TagBlock = OMatrix<f64, Dyn, Const<7>>;

/// Normal equations of one tag over its seven parameters (the object's twist, which is a step of its pose, and its size).
pub(super) struct TagSums {
    /// Index of the tag.
    pub tag: usize,
    pub own: SMatrix<f64, 7, 7>,
    pub gradient: SVector<f64, 7>,
    /// Over the camera's columns and the tag's parameters.
    pub camera_by_tag: OMatrix<f64, Dyn, Const<7>>,
}

/// Normal equations of an image over (object's twist, the camera's columns), and of each of its tags.
pub(super) struct ImageSums {
    pub tags: Vec<TagSums>,
    pub twist: Matrix6<f64>,
    pub gradient: Vector6<f64>,
    pub camera_by_twist: OMatrix<f64, Dyn, Const<6>>,
    pub camera: DMatrix<f64>,
    pub camera_gradient: DVector<f64>,
    /// Sum of the robust squares.
    pub rho: f64,
}

/// Sums of the terms that involve the lens.
struct LensSums {
    lens: SMatrix<f64, MAX_PARAMETERS, MAX_PARAMETERS>,
    gradient: SMatrix<f64, MAX_PARAMETERS, 1>,
}

impl ImageSums {
    pub(super) fn of(
        bundle: &Bundle,
        layout: &Layout,
        image: &BundleImage,
        kernel: &Kernel,
    ) -> Self {
        let columns = &layout.cameras[image.camera];
        let twist_by_camera = twist_by_camera(bundle, image, columns);
        let wanted = if columns.lens_parameters.is_empty() {
            LensColumns::Unwanted
        } else {
            LensColumns::TagSpec
        };
        let view = View::of(bundle, image, wanted);
        let mut sums = Self::empty(columns.width());
        let mut lens = LensSums {
            lens: SMatrix::zeros(),
            gradient: SMatrix::zeros(),
        };
        for seen in &image.tags {
            let tag = &bundle.tags[seen.tag];
            let equations = linearise(&view, &tag.object_from_tag, tag.size_m, seen, kernel);
            let mut by_tag = SMatrix::<f64, 8, 7>::zeros();
            by_tag
                .fixed_columns_mut::<6>(0)
                .copy_from(&equations.by_twist);
            by_tag.set_column(6, &equations.by_size);
            let own = by_tag.transpose() * by_tag;
            let mut lens_by_tag = LensTagBlock::zeros();
            if wanted == LensColumns::TagSpec {
                let by_lens = equations.by_lens.transpose();
                lens_by_tag = by_lens * by_tag;
                lens.lens += by_lens * equations.by_lens;
                lens.gradient += by_lens * equations.error;
            }
            sums.rho += equations.rho;
            let moving = twist_by_camera.transpose() * own.fixed_rows::<6>(0);
            sums.add(TagSums {
                tag: seen.tag,
                own,
                gradient: by_tag.transpose() * equations.error,
                camera_by_tag: camera_rows(columns, &moving, &lens_by_tag),
            });
        }
        sums.close(columns, &twist_by_camera, &lens);
        sums
    }

    fn empty(width: usize) -> Self {
        Self {
            tags: Vec::new(),
            twist: Matrix6::zeros(),
            gradient: Vector6::zeros(),
            camera_by_twist: OMatrix::<f64, Dyn, Const<6>>::zeros(width),
            camera: DMatrix::zeros(width, width),
            camera_gradient: DVector::zeros(width),
            rho: 0.0,
        }
    }

    fn add(&mut self, tag: TagSums) {
        self.twist += tag.own.fixed_view::<6, 6>(0, 0);
        self.gradient += tag.gradient.fixed_rows::<6>(0);
        self.camera_by_twist += tag.camera_by_tag.fixed_columns::<6>(0);
        self.tags.push(tag);
    }

    /// The camera's own block, from the sums over the tags.
    fn close(&mut self, columns: &CameraColumns, twist_by_camera: &TwistJacobian, lens: &LensSums) {
        let moving = columns.moving();
        let own = &self.camera_by_twist * twist_by_camera; // all columns by pose and clock
        self.camera.columns_mut(0, moving).copy_from(&own);
        let across = own.rows(moving, own.nrows() - moving).transpose();
        self.camera
            .view_mut((0, moving), (moving, columns.lens_parameters.len()))
            .copy_from(&across);
        let pull = twist_by_camera.transpose() * self.gradient;
        self.camera_gradient.rows_mut(0, moving).copy_from(&pull);
        for (row, &of) in columns.lens_parameters.iter().enumerate() {
            self.camera_gradient[moving + row] = lens.gradient[of];
            for (column, &by) in columns.lens_parameters.iter().enumerate() {
                self.camera[(moving + row, moving + column)] = lens.lens[(of, by)];
            }
        }
    }
}

/// Apparent motion of the object's frame for a step of the camera (a twist of the world about its origin), or of its clock.
fn twist_by_camera(bundle: &Bundle, image: &BundleImage, columns: &CameraColumns) -> TwistJacobian {
    let mut by = TwistJacobian::zeros(columns.moving());
    if columns.pose.is_some() {
        let object_from_world = object_at(bundle, image).inverse();
        by.columns_mut(0, 6)
            .copy_from(&-se3::adjoint(&object_from_world));
    }
    if columns.clock.is_some() {
        by.column_mut(columns.moving() - 1)
            .copy_from(&bundle.instants[image.instant].twist);
    }
    by
}

/// Rows of pose and clock above rows of the free lens parameters.
fn camera_rows(columns: &CameraColumns, moving: &TagBlock, lens: &LensTagBlock) -> TagBlock {
    let mut rows = TagBlock::zeros(columns.width());
    rows.rows_mut(0, columns.moving()).copy_from(moving);
    for (at, &parameter) in columns.lens_parameters.iter().enumerate() {
        rows.row_mut(columns.moving() + at)
            .copy_from(&lens.row(parameter));
    }
    rows
}
