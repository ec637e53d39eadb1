//! The normal equations of an adjustment: what the views of keyframes say of the site's errors, the pose of each
//! keyframe eliminated (Schur complement), and their solution with priors.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix6, SMatrix};

use crate::measurement::whitening::Rows;
use crate::self_calibration::arrow::{Arrow, ArrowFactor, ArrowInverse};
use crate::self_calibration::evidence::Evidence;
use crate::self_calibration::keyframes::{Keyframe, KeyframeView};
use crate::self_calibration::parameters::{Class, OF_CAMERA, OF_SCALE, OF_TAG, ParameterLayout};
use crate::self_calibration::view_rows::{ALL, BY_CAMERA, BY_SCALE, BY_TAG, OF_POSE};

/// Least factor that [`independence`] gives.
const LEAST_INDEPENDENCE: f64 = 0.01;
/// Products of the weighted rows of a view: by the pose first, the residual last.
pub(super) type Products<const N: usize> = SMatrix<f64, N, N>;

/// What the views of all keyframes say.
pub(super) struct EliminationEquations {
    pub(super) information: Arrow,
    pub(super) gradient: DVector<f64>,
    pub(super) eliminated: Vec<Eliminated>,
    /// What the views leave: the sum of their squares.
    pub(super) left: f64,
}

/// What the views of one keyframe say of the errors of its cameras and tags, its own unknowns eliminated.
pub(super) struct KeyframeEquations {
    pub(super) information: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    pub(super) eliminated: Eliminated,
    /// As [`EliminationEquations::left`].
    pub(super) left: f64,
    blocks: Vec<Block>,
}

/// Errors of one camera, one tag or one scale.
struct Block {
    /// Places in the layout.
    places: Range<usize>,
    /// First place among those of the keyframe.
    local: usize,
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

/// The products of a view's rows with its weight; a step of the object that is not known exactly is marginalised first,
/// so that the gradient is that of [`cost`].
pub(super) fn normal<const N: usize>(
    rows: &Rows<N>,
    one: &KeyframeView,
    weighting: Weighting,
) -> Products<N> {
    let products = marginalised(rows, one);
    let square = products[(N - 1, N - 1)];
    let weight = one.view.noise_source.weight(square / weighting.excess) / weighting.design_effect;
    products * weight
}

/// Twice the robust cost of a view, weighted as by [`normal`].
pub(super) fn cost<const N: usize>(
    rows: &Rows<N>,
    one: &KeyframeView,
    weighting: Weighting,
) -> f64 {
    let square = marginalised(rows, one)[(N - 1, N - 1)];
    let chi2 = one.view.noise_source.chi2(square / weighting.excess);
    chi2 * weighting.excess / weighting.design_effect
}

/// N - N (N + Q^-1)^-1 N = N (I + Q N)^-1, for the displacement and what goes with it, Q the covariance of the step of
/// the object.
fn marginalised<const N: usize>(rows: &Rows<N>, one: &KeyframeView) -> Products<N> {
    let rows = SMatrix::<f64, 8, N>::from_fn(|row, column| rows[row][column]);
    let products = rows.tr_mul(&rows);
    let Some(motion) = &one.motion else {
        return products;
    };
    let with_pose = products.fixed_rows::<OF_POSE>(0).into_owned();
    let of_pose = with_pose.fixed_columns::<OF_POSE>(0);
    match (Matrix6::identity() + motion.covariance * of_pose).try_inverse() {
        Some(inverse) => {
            let taken = inverse * motion.covariance;
            products - with_pose.tr_mul(&(taken * with_pose))
        }
        None => Products::zeros(),
    }
}

impl KeyframeEquations {
    /// From the information and the gradient of the keyframe's own unknowns before any view, and the views with their
    /// products.
    pub(super) fn new<'a>(
        keyframe: &Keyframe,
        layout: &ParameterLayout,
        mut own: DMatrix<f64>,
        mut own_gradient: DVector<f64>,
        views: impl Iterator<Item = (&'a KeyframeView, Products<ALL>)>,
    ) -> Self {
        let blocks = blocks(keyframe, layout);
        let columns: Vec<usize> = blocks
            .iter()
            .flat_map(|block| block.places.clone())
            .collect();
        let local: BTreeMap<usize, usize> = blocks
            .iter()
            .map(|block| (block.places.start, block.local))
            .collect();
        let mut coupling = DMatrix::zeros(own.nrows(), columns.len());
        let mut information = DMatrix::zeros(columns.len(), columns.len());
        let (mut gradient, mut left) = (DVector::zeros(columns.len()), 0.0);
        for (one, products) in views {
            let lever = one.lever(keyframe);
            let by_own = lever.tr_mul(&products.fixed_rows::<OF_POSE>(0));
            own += by_own.columns(0, OF_POSE) * &lever;
            own_gradient += by_own.column(ALL - 1);
            left += products[(ALL - 1, ALL - 1)];
            let places = firsts(keyframe, one, layout).map(|(first, by)| (local[&first], by));
            let places: Vec<(usize, Range<usize>)> = places.collect();
            for (row, by_row) in &places {
                let mut with_own = coupling.columns_mut(*row, by_row.len());
                with_own += by_own.columns_range(by_row.clone());
                let mut pull = gradient.rows_mut(*row, by_row.len());
                pull += products.column(ALL - 1).rows_range(by_row.clone());
                for (column, by_column) in &places {
                    let size = (by_row.len(), by_column.len());
                    let mut block = information.view_mut((*row, *column), size);
                    block += products.view((by_row.start, by_column.start), size);
                }
            }
        }
        // The Schur complement of the keyframe's own unknowns.
        let n_own = own.nrows();
        let inverse = own
            .try_inverse()
            .unwrap_or_else(|| DMatrix::zeros(n_own, n_own));
        let weighted = &inverse * &coupling;
        Self {
            information: information - coupling.tr_mul(&weighted),
            gradient: gradient - weighted.tr_mul(&own_gradient),
            left,
            blocks,
            eliminated: Eliminated {
                inverse,
                gradient: own_gradient,
                columns,
                coupling,
            },
        }
    }
}

/// First places of the errors that a view depends on, with their columns in its rows.
fn firsts(
    keyframe: &Keyframe,
    one: &KeyframeView,
    layout: &ParameterLayout,
) -> impl Iterator<Item = (usize, Range<usize>)> {
    let scale = layout.scales.get(&keyframe.body()).copied();
    let camera = (
        layout.cameras[&one.camera_index],
        BY_CAMERA..BY_CAMERA + OF_CAMERA,
    );
    let tag = (layout.tags[&one.view.tag].1, BY_TAG..BY_TAG + OF_TAG);
    let scale = scale.map(|first| (first, BY_SCALE..BY_SCALE + OF_SCALE));
    [camera, tag].into_iter().chain(scale)
}

/// The errors that the views of a keyframe depend on, ascending.
fn blocks(keyframe: &Keyframe, layout: &ParameterLayout) -> Vec<Block> {
    let views = keyframe.views.iter();
    let all: BTreeSet<(usize, usize)> = views
        .flat_map(|one| firsts(keyframe, one, layout))
        .map(|(first, by)| (first, by.len()))
        .collect();
    let mut local = 0;
    let block = all.into_iter().map(|(first, width)| {
        local += width;
        Block {
            places: first..first + width,
            local: local - width,
        }
    });
    block.collect()
}

impl EliminationEquations {
    /// Without any keyframe.
    pub(super) fn new(layout: &ParameterLayout) -> Self {
        Self {
            information: Arrow::zeros(layout),
            gradient: DVector::zeros(layout.len()),
            eliminated: Vec::new(),
            left: 0.0,
        }
    }

    /// Adds what a keyframe says.
    pub(super) fn add(&mut self, keyframe: KeyframeEquations) {
        self.left += keyframe.left;
        for Block { places, local } in &keyframe.blocks {
            let mut gradient = self.gradient.rows_range_mut(places.clone());
            gradient += keyframe.gradient.rows(*local, places.len());
            for other in &keyframe.blocks {
                let size = (places.len(), other.places.len());
                let block = keyframe.information.view((*local, other.local), size);
                self.information.add(places, &other.places, &block);
            }
        }
        self.eliminated.push(keyframe.eliminated);
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
