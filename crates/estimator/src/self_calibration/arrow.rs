//! Block-arrow matrices, the form of the normal equations: a keyframe shows one body, so that tags of different bodies
//! are coupled through cameras only. Bodies are eliminated one by one (Schur complement), which makes all operations
//! linear in their number.

use std::ops::Range;
use std::rc::Rc;

use nalgebra::{Cholesky, DMatrix, DMatrixView, DVector, DVectorView, Dyn};

use crate::self_calibration::parameters::ParameterLayout;

/// A symmetric matrix over the places of a [`ParameterLayout`]: cameras first, then body by body.
#[derive(Debug, Clone)]
pub(crate) struct Arrow {
    pub cameras: DMatrix<f64>,
    pub bodies: Vec<BodyBlocks>,
}

/// The rows of one body.
#[derive(Debug, Clone)]
pub(crate) struct BodyBlocks {
    pub places: Range<usize>,
    pub own: DMatrix<f64>,
    /// With the cameras.
    pub coupling: DMatrix<f64>,
}

impl Arrow {
    pub fn zeros(layout: &ParameterLayout) -> Self {
        let n_cameras = layout.n_of_cameras();
        let body = |places: &Range<usize>| BodyBlocks {
            places: places.clone(),
            own: DMatrix::zeros(places.len(), places.len()),
            coupling: DMatrix::zeros(places.len(), n_cameras),
        };
        Self {
            cameras: DMatrix::zeros(n_cameras, n_cameras),
            bodies: layout.bodies.iter().map(|(_, one)| body(one)).collect(),
        }
    }

    /// Adds a block to the cameras, to one body, or to a body (rows) with the cameras (columns); without effect for the
    /// transpose of the latter.
    pub fn add(
        &mut self,
        rows: &Range<usize>,
        columns: &Range<usize>,
        added: &DMatrixView<'_, f64>,
    ) {
        let n_cameras = self.cameras.nrows();
        let (row, column) = (rows.start, columns.start);
        let mut block = if row < n_cameras && column < n_cameras {
            self.cameras.view_mut((row, column), added.shape())
        } else if row < n_cameras {
            return;
        } else {
            let body = body_of(&self.bodies, row);
            let body = &mut self.bodies[body];
            let first = body.places.start;
            if column < n_cameras {
                body.coupling.view_mut((row - first, column), added.shape())
            } else {
                body.own
                    .view_mut((row - first, column - first), added.shape())
            }
        };
        block += added;
    }

    /// An element within such a block, or within the transpose of one.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let (row, column) = (row.max(column), row.min(column));
        let n_cameras = self.cameras.nrows();
        if row < n_cameras {
            return self.cameras[(row, column)];
        }
        let body = &self.bodies[body_of(&self.bodies, row)];
        let row = row - body.places.start;
        if column < n_cameras {
            body.coupling[(row, column)]
        } else {
            body.own[(row, column - body.places.start)]
        }
    }

    pub fn add_diagonal(&mut self, added: &DVector<f64>) {
        let n_cameras = self.cameras.nrows();
        add_diagonal(&mut self.cameras, &added.rows(0, n_cameras));
        for body in &mut self.bodies {
            add_diagonal(&mut body.own, &rows(added, &body.places));
        }
    }

    pub fn times(&self, vector: &DVector<f64>) -> DVector<f64> {
        let of_cameras = vector.rows(0, self.cameras.nrows());
        let mut product = DVector::zeros(vector.len());
        let mut on_cameras = &self.cameras * of_cameras;
        for body in &self.bodies {
            let own = rows(vector, &body.places);
            on_cameras += body.coupling.tr_mul(&own);
            let on_body = &body.own * own + &body.coupling * of_cameras;
            copy_rows(&mut product, &body.places, &on_body);
        }
        copy_rows(&mut product, &(0..on_cameras.len()), &on_cameras);
        product
    }

    /// `None` where it is not positive definite.
    pub fn factor(&self) -> Option<ArrowFactor> {
        let bodies = self.bodies.iter().map(|body| body.eliminated());
        ArrowFactor::new(self.cameras.clone(), bodies.collect::<Option<_>>()?)
    }

    /// Factor of this matrix with a change of its diagonal, by the factor without: bodies that do not change are not
    /// eliminated again.
    pub fn factor_changed(&self, former: &ArrowFactor, by: &DVector<f64>) -> Option<ArrowFactor> {
        let bodies = self.bodies.iter().zip(&former.bodies);
        let bodies = bodies.map(|(body, eliminated)| {
            let by = rows(by, &body.places);
            if by.iter().all(|change| *change == 0.0) {
                return Some(Rc::clone(eliminated));
            }
            let mut changed = body.clone();
            add_diagonal(&mut changed.own, &by);
            changed.eliminated()
        });
        let bodies = bodies.collect::<Option<_>>()?;
        let mut cameras = self.cameras.clone();
        let n_cameras = cameras.nrows();
        add_diagonal(&mut cameras, &by.rows(0, n_cameras));
        ArrowFactor::new(cameras, bodies)
    }
}

impl BodyBlocks {
    fn eliminated(&self) -> Option<Rc<EliminatedBody>> {
        let factor = self.own.clone().cholesky()?;
        let mut whitened = self.coupling.clone();
        factor.l_dirty().solve_lower_triangular_mut(&mut whitened);
        Some(Rc::new(EliminatedBody {
            places: self.places.clone(),
            taken: whitened.tr_mul(&whitened),
            factor,
            whitened,
        }))
    }
}

/// Cholesky factor of an [`Arrow`]: with D = L L' of a body's own block and B its coupling, W = L^-1 B and S = A - sum
/// W' W.
pub(crate) struct ArrowFactor {
    bodies: Vec<Rc<EliminatedBody>>,
    /// Of S.
    cameras: Cholesky<f64, Dyn>,
}

struct EliminatedBody {
    places: Range<usize>,
    factor: Cholesky<f64, Dyn>,
    whitened: DMatrix<f64>,
    /// W' W.
    taken: DMatrix<f64>,
}

impl ArrowFactor {
    fn new(mut cameras: DMatrix<f64>, bodies: Vec<Rc<EliminatedBody>>) -> Option<Self> {
        for body in &bodies {
            cameras -= &body.taken;
        }
        Some(Self {
            bodies,
            cameras: cameras.cholesky()?,
        })
    }

    pub fn ln_determinant(&self) -> f64 {
        let of = |factor: &Cholesky<f64, Dyn>| -> f64 {
            2.0 * factor.l_dirty().diagonal().map(f64::ln).sum()
        };
        let bodies = self.bodies.iter().map(|body| of(&body.factor));
        of(&self.cameras) + bodies.sum::<f64>()
    }

    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut solution = right.clone();
        let n_cameras = self.cameras.l_dirty().nrows();
        for body in &self.bodies {
            let mut own = rows(&solution, &body.places).into_owned();
            body.factor.l_dirty().solve_lower_triangular_mut(&mut own);
            let mut of_cameras = solution.rows_mut(0, n_cameras);
            of_cameras -= body.whitened.tr_mul(&own);
            copy_rows(&mut solution, &body.places, &own);
        }
        let of_cameras = self.cameras.solve(&solution.rows(0, n_cameras));
        for body in &self.bodies {
            let mut own = rows(&solution, &body.places) - &body.whitened * &of_cameras;
            body.factor
                .l_dirty()
                .tr_solve_lower_triangular_mut(&mut own);
            copy_rows(&mut solution, &body.places, &own);
        }
        copy_rows(&mut solution, &(0..n_cameras), &of_cameras);
        solution
    }

    pub fn inverse(&self) -> ArrowInverse {
        let body = |body: &Rc<EliminatedBody>| {
            let mut gain = body.whitened.clone();
            body.factor
                .l_dirty()
                .tr_solve_lower_triangular_mut(&mut gain);
            InverseBlocks {
                places: body.places.clone(),
                own: body.factor.inverse(),
                gain,
            }
        };
        ArrowInverse {
            cameras: self.cameras.inverse(),
            bodies: self.bodies.iter().map(body).collect(),
        }
    }
}

/// Inverse of an [`Arrow`], which is none: with K the bodies' gains, it is the block diagonal of their own parts plus U
/// S^-1 U', U = (I, -K).
pub(crate) struct ArrowInverse {
    /// S^-1: the block of the cameras.
    pub cameras: DMatrix<f64>,
    pub bodies: Vec<InverseBlocks>,
}

/// One body's part.
pub(crate) struct InverseBlocks {
    pub places: Range<usize>,
    /// D^-1.
    pub own: DMatrix<f64>,
    /// D^-1 B.
    pub gain: DMatrix<f64>,
}

impl ArrowInverse {
    pub fn diagonal(&self) -> DVector<f64> {
        let n_cameras = self.cameras.nrows();
        let n = self.bodies.last().map_or(n_cameras, |one| one.places.end);
        let mut diagonal = DVector::zeros(n);
        copy_rows(&mut diagonal, &(0..n_cameras), &self.cameras.diagonal());
        for body in &self.bodies {
            let by_cameras = (&body.gain * &self.cameras).component_mul(&body.gain);
            let own = body.own.diagonal() + by_cameras.column_sum();
            copy_rows(&mut diagonal, &body.places, &own);
        }
        diagonal
    }
}

fn body_of(bodies: &[BodyBlocks], place: usize) -> usize {
    bodies.partition_point(|body| body.places.end <= place)
}

fn rows<'a>(vector: &'a DVector<f64>, places: &Range<usize>) -> DVectorView<'a, f64> {
    vector.rows(places.start, places.len())
}

fn copy_rows(vector: &mut DVector<f64>, places: &Range<usize>, from: &DVector<f64>) {
    vector.rows_mut(places.start, places.len()).copy_from(from);
}

fn add_diagonal(matrix: &mut DMatrix<f64>, added: &DVectorView<'_, f64>) {
    for (at, one) in added.iter().enumerate() {
        matrix[(at, at)] += one;
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    use sextant_tag_families::Family;

    use sextant_site_model::TagId;

    /// Two cameras and three bodies of two tags, whose tags are not in the order of their bodies.
    pub fn layout() -> ParameterLayout {
        let tag = |id| TagId {
            family: Family::Tag36h11,
            id,
        };
        let tags = (0..6).map(|id| (tag(id), (id as usize % 3, 0)));
        ParameterLayout::new(
            &BTreeSet::from([0, 1]),
            &tags.collect::<BTreeMap<_, _>>(),
            &BTreeSet::new(),
        )
    }

    /// Positive definite and different in every element, also as a dense matrix.
    pub fn arrow() -> (Arrow, DMatrix<f64>) {
        let layout = layout();
        let mut arrow = Arrow::zeros(&layout);
        let n = layout.len();
        let n_cameras = layout.n_of_cameras();
        let bodies = layout.bodies.iter().map(|(_, places)| places.clone());
        let ranges: Vec<_> = std::iter::once(0..n_cameras).chain(bodies).collect();
        let mut dense = DMatrix::zeros(n, n);
        for (k, rows) in ranges.iter().enumerate() {
            for columns in [&ranges[0], rows].into_iter().skip(usize::from(k == 0)) {
                for row in rows.clone() {
                    for column in columns.clone() {
                        let (low, high) = (row.min(column), row.max(column));
                        let value = ((low * 31 + high * 17 + k) as f64).sin();
                        let value = value + if row == column { 60.0 } else { 0.0 };
                        let value = DMatrix::from_element(1, 1, value);
                        arrow.add(&(row..row + 1), &(column..column + 1), &value.as_view());
                        let value = value[(0, 0)];
                        dense[(row, column)] = value;
                        dense[(column, row)] = value;
                    }
                }
            }
        }
        (arrow, dense)
    }

    fn assert_near(a: &DMatrix<f64>, b: &DMatrix<f64>) {
        assert!((a - b).amax() < 1e-10, "{:e}", (a - b).amax());
    }

    #[test]
    fn an_arrow_computes_what_the_dense_matrix_does() {
        let (arrow, dense) = arrow();
        let n = dense.nrows();
        let vector = DVector::from_fn(n, |at, _| (at as f64).cos());
        let factor = arrow.factor().unwrap();
        let of_dense = dense.clone().cholesky().unwrap();
        let column = |vector: DVector<f64>| DMatrix::from_column_slice(n, 1, vector.as_slice());
        assert_near(&column(arrow.times(&vector)), &column(&dense * &vector));
        assert_near(
            &column(factor.solve(&vector)),
            &column(of_dense.solve(&vector)),
        );
        assert_near(
            &column(factor.inverse().diagonal()),
            &column(of_dense.inverse().diagonal()),
        );
        let determinant = of_dense.determinant().ln();
        assert!((factor.ln_determinant() - determinant).abs() < 1e-9);
    }

    #[test]
    fn a_changed_factor_is_that_of_the_changed_matrix() {
        let (mut arrow, _) = arrow();
        let factor = arrow.factor().unwrap();
        let n = layout().len();
        let of_one_body = DVector::from_fn(n, |at, _| if at > n - 9 { 5.0 } else { 0.0 });
        for change in [of_one_body, DVector::from_element(n, 3.0)] {
            let changed = arrow.factor_changed(&factor, &change).unwrap();
            let mut whole = arrow.clone();
            whole.add_diagonal(&change);
            let fresh = whole.factor().unwrap();
            assert!((changed.ln_determinant() - fresh.ln_determinant()).abs() < 1e-9);
        }
        arrow.cameras.fill_diagonal(-1.0);
        assert!(arrow.factor().is_none());
    }
}
