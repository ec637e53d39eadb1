//! Elimination of the instants: the Schur complement over the kept parameters, and back substitution.
//!
//! Instants tied to the next one form a chain, which is eliminated from its earliest instant on (block Cholesky
//! factorisation of a block tridiagonal matrix); instants without ties are chains of one.

use super::equations::Equations;
use super::node::{Coupling, Node};
use super::stamps::StampRow;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Added to every diagonal element, so that a parameter without information keeps its value.
const FLOOR: f64 = 1e-9;

/// A step of all parameters.
pub(super) struct Step<const D: usize> {
    pub kept: DVector<f64>,
    pub instants: Vec<SVector<f64, D>>,
    /// Of the error of each image's stamp; zero where it has none.
    pub stamps: Vec<f64>,
}

/// The rows of the Cholesky factor of an instant.
struct Row<const D: usize> {
    lower: SMatrix<f64, D, D>,
    gradient: SVector<f64, D>,
    columns: Vec<usize>,
    coupling: Coupling<D>,
    next: Option<SMatrix<f64, D, D>>,
}

/// The reduced system over the kept parameters, and the factor for back substitution.
pub(super) struct ReducedSystem<const D: usize> {
    /// Symmetric, both triangles.
    pub information: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    rows: Vec<Row<D>>,
}

impl<const D: usize> ReducedSystem<D> {
    /// Eliminates the instants with Marquardt damping, a fraction of the diagonal; `None` if an instant remains
    /// undetermined.
    pub(super) fn of(equations: &Equations<D>, damping: f64) -> Option<Self> {
        let mut reduced = Self {
            information: equations.kept.clone(),
            gradient: equations.gradient.clone(),
            rows: Vec::with_capacity(equations.nodes.len()),
        };
        for at in 0..equations.kept.nrows() {
            let diagonal = &mut reduced.information[(at, at)];
            *diagonal += *diagonal * damping + FLOOR;
        }
        let mut stack = Stack::of(equations.kept.nrows());
        for node in &equations.nodes {
            let row = Row::of(node, reduced.rows.last(), damping)?;
            if row.columns.len() == stack.n {
                stack.push(&row, &mut reduced);
            } else {
                reduced.subtract(&row);
            }
            reduced.rows.push(row);
        }
        stack.flush(&mut reduced);
        reduced
            .information
            .fill_lower_triangle_with_upper_triangle();
        Some(reduced)
    }

    fn subtract(&mut self, row: &Row<D>) {
        let square = row.coupling.tr_mul(&row.coupling);
        let pull = row.coupling.tr_mul(&row.gradient);
        for (j, &column) in row.columns.iter().enumerate() {
            self.gradient[column] -= pull[j];
            for (i, &line) in row.columns[..=j].iter().enumerate() {
                self.information[(line, column)] -= square[(i, j)];
            }
        }
    }

    /// Solves the damped equations for the step; `None` if they are not positive definite.
    pub(super) fn step(&self, equations: &Equations<D>) -> Option<Step<D>> {
        let kept = if self.gradient.is_empty() {
            DVector::zeros(0)
        } else {
            -self.information.clone().cholesky()?.solve(&self.gradient)
        };
        let mut instants = vec![SVector::zeros(); self.rows.len()];
        for at in (0..self.rows.len()).rev() {
            let later = instants.get(at + 1).copied();
            instants[at] = self.rows[at].back(&kept, later)?;
        }
        let stamps = equations.stamps.iter().map(|stamp| {
            let stamp = stamp.as_ref();
            stamp.map_or(0.0, |stamp| stamp.step(&kept, &instants))
        });
        let stamps = stamps.collect();
        let finite = kept.iter().all(|x| x.is_finite());
        finite.then_some(Step {
            kept,
            instants,
            stamps,
        })
    }

    /// Logarithm of the determinant of the information of everything that is sought; `None` where that is not definite.
    pub(super) fn log_information(&self, equations: &Equations<D>) -> Option<f64> {
        let half = |lower: &mut dyn Iterator<Item = f64>| lower.map(f64::ln).sum::<f64>();
        let kept = self.information.clone().cholesky()?.unpack();
        let of_kept = half(&mut kept.diagonal().iter().copied());
        let of_instants: f64 = self
            .rows
            .iter()
            .map(|row| half(&mut row.lower.diagonal().iter().copied()))
            .sum();
        let stamps = equations.stamps.iter().flatten();
        let of_stamps: f64 = stamps.map(StampRow::log_information).sum();
        Some(2.0 * (of_kept + of_instants) + of_stamps)
    }
}

/// Rows over all kept columns that wait for their subtraction: one product of large matrices is many times as fast as
/// many small ones.
struct Stack<const D: usize> {
    couplings: DMatrix<f64>,
    /// Rows of `couplings` in use.
    used: usize,
    n: usize,
}

/// Instants whose rows are subtracted together.
const STACKED: usize = 32;

impl<const D: usize> Stack<D> {
    fn of(n: usize) -> Self {
        Self {
            couplings: DMatrix::zeros(STACKED * D, n),
            used: 0,
            n,
        }
    }

    fn push(&mut self, row: &Row<D>, reduced: &mut ReducedSystem<D>) {
        if self.used == self.couplings.nrows() {
            self.flush(reduced);
        }
        let mut place = self.couplings.rows_mut(self.used, D);
        place.copy_from(&row.coupling);
        self.used += D;
        reduced
            .gradient
            .gemv_tr(-1.0, &row.coupling, &row.gradient, 1.0);
    }

    fn flush(&mut self, reduced: &mut ReducedSystem<D>) {
        let rows = self.couplings.rows(0, self.used);
        reduced
            .information
            .gemm(-1.0, &rows.transpose(), &rows, 1.0);
        self.used = 0;
    }
}

impl<const D: usize> Row<D> {
    fn of(node: &Node<D>, earlier: Option<&Self>, damping: f64) -> Option<Self> {
        let mut own = node.own;
        for at in 0..D {
            own[(at, at)] += own[(at, at)] * damping + FLOOR;
        }
        let (mut gradient, mut coupling) = (node.gradient, node.coupling.clone());
        if let Some(earlier) = earlier
            && let Some(tie) = &earlier.next
        {
            let back = tie.transpose();
            own -= back * tie;
            gradient -= back * earlier.gradient;
            coupling -= back * &earlier.coupling;
        }
        let lower = own.cholesky()?.l();
        Some(Self {
            gradient: lower.solve_lower_triangular(&gradient)?,
            coupling: lower.solve_lower_triangular(&coupling)?,
            next: match &node.next {
                Some(next) => Some(lower.solve_lower_triangular(next)?),
                None => None,
            },
            columns: node.columns.clone(),
            lower,
        })
    }

    /// Step of the instant, given those of the kept parameters and of the later instant.
    fn back(&self, kept: &DVector<f64>, later: Option<SVector<f64, D>>) -> Option<SVector<f64, D>> {
        let mut right = self.gradient;
        for (at, &column) in self.columns.iter().enumerate() {
            right += self.coupling.column(at) * kept[column];
        }
        if let (Some(next), Some(later)) = (&self.next, later) {
            right += next * later;
        }
        self.lower.tr_solve_lower_triangular(&-right)
    }
}
