//! What is summed over groups of neighbouring pixels, and how the normal equations are put together from that.
//!
//! A pixel's derivatives are a few basic ones, times 1, u or v for most parameters. Within a group u and v are taken to be
//! those of its middle: so products of basic derivatives are summed over its pixels, and only these sums are multiplied with
//! u and v. What this leaves out makes the estimate no less right (sums of residuals times anything but themselves are zero
//! on average where the model holds) and hardly less sharp.

use super::lanes::{LANES, Lanes, VECTOR, add_products};
use super::normal_equations::{PARAMETERS, Vector};
use super::pixels::GROUP;

/// Basic derivatives: along x, along y, towards the origin, black, white, blur 3, gain.
pub(super) const BASICS: usize = 9;

/// Those from here on, as the residual, are multiplied with nothing.
const FIRST_PLAIN: usize = 5;

/// These and the residual.
pub(super) const COLUMNS: usize = BASICS + 1;

/// The basic derivative behind each parameter, and whether it is multiplied with 1, u or v.
#[rustfmt::skip]
pub(super) const MADE_OF: [(usize, Factors); PARAMETERS] = [
    (0, Factors::U), (0, Factors::V), (0, Factors::One),
    (1, Factors::U), (1, Factors::V), (1, Factors::One),
    (2, Factors::U), (2, Factors::V),
    (3, Factors::One), (3, Factors::U), (3, Factors::V),
    (4, Factors::One), (4, Factors::U), (4, Factors::V),
    (5, Factors::One), (6, Factors::One), (7, Factors::One), (8, Factors::One),
];

/// What basic derivatives, and products of two, are multiplied with.
#[derive(Clone, Copy)]
pub(super) enum Factors {
    One,
    U,
    V,
    Uu,
    Uv,
    Vv,
}

impl Factors {
    pub(super) const ALL: usize = 6;

    pub(super) const fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::One, other) => other,
            (this, Self::One) => this,
            (Self::U, Self::U) => Self::Uu,
            (Self::V, Self::V) => Self::Vv,
            _ => Self::Uv,
        }
    }
}

/// Basic derivatives and residual of a pixel of each group, times the roots of their weights.
pub(super) type Row = [Lanes; COLUMNS];

/// What is summed over each group of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    /// Products of each column with itself and those before it.
    pub(super) products: [[Lanes; COLUMNS]; COLUMNS],
    /// 1, u and v at the groups' middles, and products of these.
    factors: [Lanes; Factors::ALL],
    pub(super) weights: Lanes,
    pub(super) roots: Lanes,
}

impl Sums {
    pub(super) const NOTHING: Self = Self {
        products: [[[0.0; LANES]; COLUMNS]; COLUMNS],
        factors: [[0.0; LANES]; Factors::ALL],
        weights: [0.0; LANES],
        roots: [0.0; LANES],
    };
}

/// Room for a block's rows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows {
    pub(super) columns: [Row; GROUP],
    /// Weights, and these times u and v, for the groups' middles.
    pub(super) weights: Lanes,
    pub(super) places: [Lanes; 2],
    /// Sums of the weights' roots.
    pub(super) roots: Lanes,
}

impl Rows {
    pub(super) const NONE: Self = Self {
        columns: [[[0.0; LANES]; COLUMNS]; GROUP],
        weights: [0.0; LANES],
        places: [[0.0; LANES]; 2],
        roots: [0.0; LANES],
    };
}

impl Sums {
    #[inline(always)]
    pub(super) fn gather(&mut self, rows: &Rows, n_rows: usize) {
        let rows_of_vectors = &rows.columns[..n_rows];
        for vector in 0..LANES / VECTOR {
            for i in 0..COLUMNS {
                for first in (0..=i).step_by(TOGETHER) {
                    let products = products(rows_of_vectors, vector, i, first);
                    for (j, product) in (first..).zip(products) {
                        self.products[i][j].as_chunks_mut::<VECTOR>().0[vector] = product;
                    }
                }
            }
        }
        self.weights = rows.weights;
        self.roots = rows.roots;
        for i in 0..LANES {
            let per_weight = 1.0 / rows.weights[i].max(f32::MIN_POSITIVE);
            let (u, v) = (
                rows.places[0][i] * per_weight,
                rows.places[1][i] * per_weight,
            );
            for (factor, value) in self
                .factors
                .iter_mut()
                .zip([1.0, u, v, u * u, u * v, v * v])
            {
                factor[i] = value;
            }
        }
    }

    /// J^T W (r - J step) of each group.
    #[inline(always)]
    pub(super) fn pulls(&self, step: &Vector) -> [Lanes; PARAMETERS] {
        let mut changes = [[0.0; LANES]; BASICS];
        for ((basic, factor), change) in MADE_OF.into_iter().zip(step) {
            let factor = &self.factors[factor as usize];
            for i in 0..LANES {
                changes[basic][i] -= change * factor[i];
            }
        }
        let mut basic_pulls = [[0.0; LANES]; BASICS];
        for (a, pull) in basic_pulls.iter_mut().enumerate() {
            *pull = self.products[BASICS][a];
            for (b, change) in changes.iter().enumerate() {
                add_products(pull, &self.products[a.max(b)][a.min(b)], change);
            }
        }
        let mut pulls = [[0.0; LANES]; PARAMETERS];
        for (pull, (basic, factor)) in pulls.iter_mut().zip(MADE_OF) {
            add_products(pull, &basic_pulls[basic], &self.factors[factor as usize]);
        }
        pulls
    }
}

/// Columns that are multiplied with another at a time, so that the sums stay in registers.
const TOGETHER: usize = COLUMNS / 2;

/// Over some rows, for one vector of lanes: the sums of products of column `i` with the columns from `first` on.
#[inline(always)]
fn products(rows: &[Row], vector: usize, i: usize, first: usize) -> [[f32; VECTOR]; TOGETHER] {
    let mut sums = [[0.0; VECTOR]; TOGETHER];
    for row in rows {
        let a = &row[i].as_chunks::<VECTOR>().0[vector];
        for (sum, column) in sums.iter_mut().zip(&row[first..first + TOGETHER]) {
            let b = &column.as_chunks::<VECTOR>().0[vector];
            for lane in 0..VECTOR {
                sum[lane] += a[lane] * b[lane];
            }
        }
    }
    sums
}

/// Sums over all groups of products of two columns, the later one first, times each of the factors that are asked for.
#[inline(always)]
pub(super) fn moments(blocks: &[Sums]) -> [[[f32; Factors::ALL]; COLUMNS]; COLUMNS] {
    let mut moments = [[[0.0; Factors::ALL]; COLUMNS]; COLUMNS];
    for a in 0..COLUMNS {
        for b in 0..=a {
            let moments = &mut moments[a][b];
            match (a < FIRST_PLAIN, b < FIRST_PLAIN) {
                (true, true) => add_moments::<6>(blocks, [a, b], moments),
                (false, false) => add_moments::<1>(blocks, [a, b], moments),
                _ => add_moments::<3>(blocks, [a, b], moments),
            }
        }
    }
    moments
}

/// Sums over all groups of a product times the first `N` factors.
#[inline(always)]
fn add_moments<const N: usize>(
    blocks: &[Sums],
    [a, b]: [usize; 2],
    moments: &mut [f32; Factors::ALL],
) {
    let halves: [[[f32; VECTOR]; N]; LANES / VECTOR] =
        std::array::from_fn(|vector| moments_of(blocks, vector, [a, b]));
    for (k, moment) in moments.iter_mut().take(N).enumerate() {
        *moment = halves.iter().flat_map(|sums| &sums[k]).sum();
    }
}

/// The same for one vector of lanes.
#[inline(always)]
fn moments_of<const N: usize>(
    blocks: &[Sums],
    vector: usize,
    [a, b]: [usize; 2],
) -> [[f32; VECTOR]; N] {
    let mut sums = [[0.0; VECTOR]; N];
    for block in blocks {
        let product = &block.products[a][b].as_chunks::<VECTOR>().0[vector];
        for (sum, factor) in sums.iter_mut().zip(&block.factors[..N]) {
            let factor = &factor.as_chunks::<VECTOR>().0[vector];
            for lane in 0..VECTOR {
                sum[lane] += product[lane] * factor[lane];
            }
        }
    }
    sums
}
