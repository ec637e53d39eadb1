//! The normal equations of an adjustment: what the views of keyframes say of the site's errors, the pose of each
//! keyframe eliminated (Schur complement), and their solution with priors.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{
    Const, DMatrix, DVector, Dyn, Matrix6, OMatrix, SMatrix, SVector, Vector3, Vector6,
};

use crate::measurement::biases::by_camera;
use crate::measurement::corners::{OF_VIEW, VIEW_SCALE, VIEW_SIZE};
use crate::self_calibration::arrow::{Arrow, ArrowFactor, ArrowInverse};
use crate::self_calibration::evidence::Evidence;
use crate::self_calibration::keyframes::KeyframeView;
use crate::self_calibration::parameters::{
    CLOCK, Class, LENS, OF_CAMERA, OF_SCALE, OF_TAG, ParameterLayout, SIZE,
};

/// Least factor that [`independence`] gives.
const LEAST_INDEPENDENCE: f64 = 0.01;
type ViewMatrix = SMatrix<f64, OF_VIEW, OF_VIEW>;
type ViewVector = SVector<f64, OF_VIEW>;
/// Coupling of a keyframe's own unknowns with the errors of a camera, or of a tag, whose places come first.
pub(super) type OwnCoupling = OMatrix<f64, Dyn, Const<OF_CAMERA>>;

/// What the views of all keyframes say, and the square of each.
pub(super) struct EliminationEquations {
    pub(super) information: Arrow,
    pub(super) gradient: DVector<f64>,
    pub(super) eliminated: Vec<Eliminated>,
    /// What the views leave: the sum of their squares.
    pub(super) left: f64,
}

/// The equations of a step with their priors, solved.
pub(super) struct Solution {
    pub(super) equations: EliminationEquations,
    /// Of the priors.
    pub(super) precision: DVector<f64>,
    pub(super) factor: ArrowFactor,
    /// The step to the minimum of the linearised equations, and the errors there.
    pub(super) step: DVector<f64>,
    pub(super) minimum: DVector<f64>,
    pub(super) covariance: ArrowInverse,
    pub(super) variances: DVector<f64>,
}

/// The unknowns of one keyframe, eliminated: its pose first.
pub(super) struct Eliminated {
    inverse: DMatrix<f64>,
    gradient: DVector<f64>,
    columns: Vec<usize>,
    coupling: DMatrix<f64>,
}

/// How views are weighted besides the noise of their corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighting {
    /// Factor on squares before the robust weight is taken: the median of all views' squares to that of chi-square.
    pub(super) excess: f64,
    /// Views that count as one.
    pub(super) design_effect: f64,
}

impl Weighting {
    /// By the robust weight alone.
    pub(super) const PLAIN: Self = Self {
        excess: 1.0,
        design_effect: 1.0,
    };
}

/// How a camera's errors act on a view that is `arm` from its centre.
pub(super) fn camera_map(
    arm: &Vector3<f64>,
    twist: &Vector6<f64>,
) -> SMatrix<f64, OF_VIEW, OF_CAMERA> {
    let mut map = SMatrix::<f64, OF_VIEW, OF_CAMERA>::zeros();
    map.fixed_view_mut::<6, 6>(0, 0).copy_from(&by_camera(arm));
    map[(6, LENS)] = 1.0;
    map[(7, LENS + 1)] = 1.0;
    map.fixed_view_mut::<6, 1>(0, CLOCK).copy_from(&-twist);
    map
}

pub(super) fn tag_map(by_pose: &Matrix6<f64>) -> SMatrix<f64, OF_VIEW, OF_TAG> {
    let mut map = SMatrix::<f64, OF_VIEW, OF_TAG>::zeros();
    map.fixed_view_mut::<6, 6>(0, 0).copy_from(by_pose);
    map[(VIEW_SIZE, SIZE)] = 1.0;
    map
}

/// Where the errors of a view's camera and tag are in the equations, and how they act on the view.
pub(super) struct ViewMaps {
    /// First place of the camera.
    pub(super) at_camera: usize,
    /// First place of the tag.
    pub(super) at_tag: usize,
    /// As [`camera_map`].
    pub(super) of_camera: SMatrix<f64, OF_VIEW, OF_CAMERA>,
    /// As [`tag_map`].
    pub(super) of_tag: SMatrix<f64, OF_VIEW, OF_TAG>,
}

impl ViewMaps {
    fn camera_places(&self) -> Range<usize> {
        self.at_camera..self.at_camera + OF_CAMERA
    }

    fn tag_places(&self) -> Range<usize> {
        self.at_tag..self.at_tag + OF_TAG
    }
}

/// Normal equations of a view.
pub(super) struct ViewNormal {
    /// J' W J.
    pub(super) matrix: ViewMatrix,
    /// J' W r.
    pub(super) pull: ViewVector,
    /// r' W r.
    pub(super) square: f64,
}

/// The normal equations of a view with its weight; a step of the object that is not known exactly is
/// marginalised first, so that the gradient is that of [`cost`].
pub(super) fn normal(
    rows: &[[f64; OF_VIEW + 1]; 8],
    one: &KeyframeView,
    weighting: Weighting,
) -> ViewNormal {
    let ViewNormal {
        matrix,
        pull,
        square,
    } = marginalised(unweighted(rows), one);
    let weight = one.view.noise_source.weight(square / weighting.excess) / weighting.design_effect;
    ViewNormal {
        matrix: matrix * weight,
        pull: pull * weight,
        square: square * weight,
    }
}

/// Twice the robust cost of a view, weighted as by [`normal`].
pub(super) fn cost(
    rows: &[[f64; OF_VIEW + 1]; 8],
    one: &KeyframeView,
    weighting: Weighting,
) -> f64 {
    let square = marginalised(unweighted(rows), one).square;
    let chi2 = one.view.noise_source.chi2(square / weighting.excess);
    chi2 * weighting.excess / weighting.design_effect
}

fn unweighted(rows: &[[f64; OF_VIEW + 1]; 8]) -> ViewNormal {
    let rows = SMatrix::<f64, 8, { OF_VIEW + 1 }>::from_fn(|row, column| rows[row][column]);
    let residual = rows.column(OF_VIEW).into_owned();
    let slopes = rows.fixed_columns::<OF_VIEW>(0);
    let matrix = slopes.tr_mul(&slopes);
    ViewNormal {
        matrix,
        pull: slopes.tr_mul(&residual),
        square: residual.norm_squared(),
    }
}

/// N - N (N + Q^-1)^-1 N = N (I + Q N)^-1, for the displacement and what goes with it, Q the covariance of the step of
/// the object.
fn marginalised(normal: ViewNormal, one: &KeyframeView) -> ViewNormal {
    let Some(motion) = &one.motion else {
        return normal;
    };
    let ViewNormal {
        matrix,
        pull,
        square,
    } = normal;
    let of_pose = matrix.fixed_view::<6, 6>(0, 0).into_owned();
    let Some(inverse) = (Matrix6::identity() + motion.covariance * of_pose).try_inverse() else {
        return ViewNormal {
            matrix: ViewMatrix::zeros(),
            pull: ViewVector::zeros(),
            square: 0.0,
        };
    };
    let taken = inverse * motion.covariance;
    let with_pose = matrix.fixed_rows::<6>(0).into_owned();
    let pulled = taken * pull.fixed_rows::<6>(0);
    ViewNormal {
        matrix: matrix - with_pose.tr_mul(&(taken * with_pose)),
        pull: pull - with_pose.tr_mul(&pulled),
        square: square - pull.fixed_rows::<6>(0).dot(&pulled),
    }
}

impl EliminationEquations {
    /// Adds what a view says of the errors of its camera and its tag.
    pub(super) fn add(&mut self, view: &ViewNormal, maps: &ViewMaps) {
        let ViewMaps {
            of_camera, of_tag, ..
        } = maps;
        let with_camera = view.matrix * of_camera;
        let with_tag = view.matrix * of_tag;
        let (camera, tag) = (|| maps.camera_places(), || maps.tag_places());
        let mut own = self.information.block_mut(camera(), camera());
        own += of_camera.tr_mul(&with_camera);
        let mut own = self.information.block_mut(tag(), tag());
        own += of_tag.tr_mul(&with_tag);
        let mut across = self.information.block_mut(tag(), camera());
        across += with_tag.tr_mul(of_camera);
        let mut gradient = self.gradient.fixed_rows_mut::<OF_CAMERA>(maps.at_camera);
        gradient += of_camera.tr_mul(&view.pull);
        let mut gradient = self.gradient.fixed_rows_mut::<OF_TAG>(maps.at_tag);
        gradient += of_tag.tr_mul(&view.pull);
    }

    /// Adds what a view says of the scale of its body.
    pub(super) fn add_scale(&mut self, at_scale: usize, view: &ViewNormal, maps: &ViewMaps) {
        let with_scale = view.matrix.row(VIEW_SCALE).into_owned();
        let scale = || at_scale..at_scale + OF_SCALE;
        let mut own = self.information.block_mut(scale(), scale());
        own[(0, 0)] += with_scale[VIEW_SCALE];
        let with_tag = with_scale * maps.of_tag;
        let mut across = self.information.block_mut(scale(), maps.tag_places());
        across += with_tag;
        let mut across = self.information.block_mut(maps.tag_places(), scale());
        across += with_tag.transpose();
        let mut across = self.information.block_mut(scale(), maps.camera_places());
        across += with_scale * maps.of_camera;
        self.gradient[at_scale] += view.pull[VIEW_SCALE];
    }

    /// The Schur complement of a keyframe's own unknowns.
    pub(super) fn eliminate(
        &mut self,
        own: DMatrix<f64>,
        gradient: DVector<f64>,
        couplings: &BTreeMap<usize, OwnCoupling>,
        layout: &ParameterLayout,
    ) {
        let n_own = own.nrows();
        let inverse = own
            .try_inverse()
            .unwrap_or_else(|| DMatrix::zeros(n_own, n_own));
        let is_camera = |first: usize| layout.classes[first] == Class::CameraPose;
        let width = |first: usize| layout.width(first);
        let mut eliminated = Eliminated {
            inverse,
            gradient,
            columns: Vec::new(),
            coupling: DMatrix::zeros(n_own, 0),
        };
        for (row, of_row) in couplings {
            let weighted = &eliminated.inverse * of_row;
            let pulled = weighted.tr_mul(&eliminated.gradient);
            let mut rows = self.gradient.rows_mut(*row, width(*row));
            rows -= pulled.rows(0, width(*row));
            for (column, of_column) in couplings {
                // The transpose of a block that is kept.
                if is_camera(*row) && !is_camera(*column) {
                    continue;
                }
                let size = (width(*row), width(*column));
                let taken = weighted.tr_mul(of_column);
                let mut block = self
                    .information
                    .block_mut(*row..row + size.0, *column..column + size.1);
                block -= taken.view((0, 0), size);
            }
            eliminated.columns.extend(*row..*row + width(*row));
        }
        eliminated.coupling = DMatrix::zeros(n_own, eliminated.columns.len());
        let blocks = couplings.iter();
        let columns = blocks.flat_map(|(first, block)| block.column_iter().take(width(*first)));
        for (mut column, own) in eliminated.coupling.column_iter_mut().zip(columns) {
            column.copy_from(&own);
        }
        self.eliminated.push(eliminated);
    }
}

impl Solution {
    /// Solves for the errors with their priors; `None` where numbers end.
    pub(super) fn solve(
        mut equations: EliminationEquations,
        precision: DVector<f64>,
        errors: &DVector<f64>,
    ) -> Option<Self> {
        equations.information.add_diagonal(&precision);
        equations.gradient += precision.component_mul(errors);
        let factor = equations.information.factor()?;
        let covariance = factor.inverse();
        let step = -factor.solve(&equations.gradient);
        if !step.iter().all(|x| x.is_finite()) {
            return None;
        }
        Some(Self {
            minimum: errors + &step,
            step,
            variances: covariance.diagonal(),
            equations,
            precision,
            factor,
            covariance,
        })
    }

    pub(super) fn evidence<'a>(&'a self, layout: &'a ParameterLayout) -> Evidence<'a> {
        let information = &self.equations.information;
        Evidence::new(
            layout,
            &self.minimum,
            information,
            &self.factor,
            &self.precision,
        )
    }
}

/// By how much less errors that are correlated do to the poses of keyframes than independent ones with the same
/// variances: the trackers take them as independent. A mean of the ratios of position and attitude.
pub(super) fn independence(
    layout: &ParameterLayout,
    covariance: &Arrow,
    keyframes: &[Eliminated],
) -> f64 {
    let mut sums = [[0.0; 2]; 2];
    for Eliminated {
        inverse,
        columns,
        coupling,
        ..
    } in keyframes
    {
        let n = columns.len();
        let of_errors = |i: usize, j: usize| covariance.get(columns[i], columns[j]);
        let of_errors = DMatrix::from_fn(n, n, of_errors);
        let by_errors = inverse * coupling;
        let caused = (&by_errors * &of_errors).component_mul(&by_errors);
        for axis in 0..6 {
            sums[axis / 3][0] += caused.row(axis).sum();
            // What a body's tags share is no error of a tag.
            let taken = (0..n).filter(|at| layout.classes[columns[*at]] != Class::Scale);
            let own = taken.map(|at| by_errors[(axis, at)].powi(2) * of_errors[(at, at)]);
            sums[axis / 3][1] += own.sum::<f64>();
        }
    }
    let ratio = |[whole, own]: [f64; 2]| if own > 0.0 { whole / own } else { 1.0 };
    (0.5 * (ratio(sums[0]) + ratio(sums[1]))).clamp(LEAST_INDEPENDENCE, 1.0)
}

impl Eliminated {
    /// Variance of an unknown of the keyframe, conditional on the site's errors.
    pub(super) fn variance(&self, at: usize) -> f64 {
        self.inverse[(at, at)]
    }

    /// What the pose explains of the squares of the views.
    pub(super) fn explained(&self) -> f64 {
        self.gradient.dot(&(&self.inverse * &self.gradient))
    }

    /// The step of the keyframe's unknowns that goes with one of the errors.
    pub(super) fn step(&self, errors: &DVector<f64>) -> DVector<f64> {
        let own = DVector::from_iterator(
            self.columns.len(),
            self.columns.iter().map(|at| errors[*at]),
        );
        -&self.inverse * (&self.gradient + &self.coupling * own)
    }
}
