//! What the tags of one image add to the normal equations, before it is spread over instants, cameras and tags.

use super::layout::{CameraColumns, Layout};
use super::residuals::{LensColumns, View, linearise, object_at};
use super::state::{Bundle, BundleImage};
use nalgebra::{Const, DMatrix, DVector, Dyn, Matrix6, OMatrix, SMatrix, Vector6};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::lens::MAX_PARAMETERS;
use sextant_geometry::se3;

/// Derivative of the object's twist by the columns of something.
pub(super) type TwistBy = OMatrix<f64, Const<6>, Dyn>;
type LensByTwist = SMatrix<f64, MAX_PARAMETERS, 6>;

/// Normal equations of one tag over (object's twist, lens).
pub(super) struct TagSums {
    /// Index of the tag.
    pub tag: usize,
    /// By twist and twist.
    pub twist: Matrix6<f64>,
    /// Gradient by the twist.
    pub gradient: Vector6<f64>,
    /// By the camera's columns and twist.
    pub camera_by_twist: OMatrix<f64, Dyn, Const<6>>,
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

/// Sums of the parts that concern the lens.
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
            LensColumns::Wanted
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
            let transposed = equations.by_twist.transpose();
            let twist = transposed * equations.by_twist;
            let mut lens_by_twist = LensByTwist::zeros();
            if wanted == LensColumns::Wanted {
                let by_lens = equations.by_lens.transpose();
                lens_by_twist = by_lens * equations.by_twist;
                lens.lens += by_lens * equations.by_lens;
                lens.gradient += by_lens * equations.error;
            }
            sums.rho += equations.rho;
            let camera_by_twist = camera_rows(
                columns,
                &(twist_by_camera.transpose() * twist),
                &lens_by_twist,
            );
            sums.add(TagSums {
                tag: seen.tag,
                twist,
                gradient: transposed * equations.error,
                camera_by_twist,
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
        self.twist += tag.twist;
        self.gradient += tag.gradient;
        self.camera_by_twist += &tag.camera_by_twist;
        self.tags.push(tag);
    }

    /// The camera's own block, from the sums over the tags.
    fn close(&mut self, columns: &CameraColumns, twist_by_camera: &TwistBy, lens: &LensSums) {
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

/// How the object's frame seems to move when the camera steps (a twist of the world about its origin), or its clock.
fn twist_by_camera(bundle: &Bundle, image: &BundleImage, columns: &CameraColumns) -> TwistBy {
    let mut by = TwistBy::zeros(columns.moving());
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
fn camera_rows(
    columns: &CameraColumns,
    moving: &OMatrix<f64, Dyn, Const<6>>,
    lens: &LensByTwist,
) -> OMatrix<f64, Dyn, Const<6>> {
    let mut rows = OMatrix::<f64, Dyn, Const<6>>::zeros(columns.width());
    rows.rows_mut(0, columns.moving()).copy_from(moving);
    for (at, &parameter) in columns.lens_parameters.iter().enumerate() {
        rows.row_mut(columns.moving() + at)
            .copy_from(&lens.row(parameter));
    }
    rows
}
