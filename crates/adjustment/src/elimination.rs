//! Elimination of the instants: what is known of an instant is carried to the next one, and in the end to the kept
//! parameters.
//!
//! Of an instant, with everything before it eliminated, are known the information `A`, the gradient `g` and the
//! coupling `c` to the kept parameters. Where a tie leads to the next instant ([`Tie`]), the **noise** `w` between the
//! two is eliminated, not their difference:
//!
//! ```text
//! M = F^-T A F^-1,   h = F^-T g + M e,   k = F^-T c
//! B = 1 + C' M C = L L',   W = L^-1 C' M,   y = L^-1 C' h,   u = L^-1 C' k
//! A- = M - W' W,   g- = h - W' y,   c- = k - W' u
//! kept parameters:   information -= u' u,   gradient += k' e - u' y
//! ```
//!
//! The eigenvalues of `B` are at least one, so that it has a factor for vague and for sharp knowledge alike and for
//! every distance in time. The last instant of a body, and each one without ties, is eliminated by its Schur complement
//! (B. Triggs et al., Bundle adjustment: a modern synthesis, 2000, section 6). Back substitution is `w = B^-1 C' (M
//! dx(k+1) + h + k ds)` and `dx(k) = F^-1 (dx(k+1) + e - C w)`.

use crate::equations::NormalEquations;
use crate::node::{Coupling, Node};
use crate::stamps::StampRow;
use crate::tie::Tie;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Added to every diagonal element, so that a parameter without information keeps its value.
const FLOOR: f64 = 1e-9;

/// A step of all parameters.
pub(crate) struct Step<const D: usize> {
    pub kept: DVector<f64>,
    pub instants: Vec<SVector<f64, D>>,
    /// Of the error of each image's stamp; zero where it has none.
    pub stamps: Vec<f64>,
}

/// What an elimination leaves for back substitution: of an instant, or of the noise between it and the next one.
struct Row<const D: usize> {
    /// Cholesky factor of what is eliminated.
    lower: SMatrix<f64, D, D>,
    gradient: SVector<f64, D>,
    columns: Vec<usize>,
    coupling: Coupling<D>,
    next: Option<Next<D>>,
}

/// The next instant of a row.
struct Next<const D: usize> {
    tie: Tie,
    /// Coupling of the noise to it: W.
    coupling: SMatrix<f64, D, D>,
}

/// What is known of an instant, with everything before it eliminated.
struct Marginal<const D: usize> {
    information: SMatrix<f64, D, D>,
    gradient: SVector<f64, D>,
    coupling: Coupling<D>,
}

/// The reduced system over the kept parameters, and the factor for back substitution.
pub(crate) struct ReducedSystem<const D: usize> {
    /// Symmetric, both triangles.
    pub information: DMatrix<f64>,
    pub(crate) gradient: DVector<f64>,
    rows: Vec<Row<D>>,
}

impl<const D: usize> Marginal<D> {
    /// An instant by its own observations, with Marquardt damping, a fraction of the diagonal.
    fn new(node: &Node<D>, damping: f64) -> Self {
        let mut information = node.own;
        for at in 0..D {
            information[(at, at)] += (information[(at, at)] + node.tied[at]) * damping + FLOOR;
        }
        Self {
            information,
            gradient: node.gradient,
            coupling: node.coupling.clone(),
        }
    }

    /// Adds what is carried from the instant before.
    fn add(&mut self, carried: &Self) {
        self.information += carried.information;
        self.gradient += carried.gradient;
        self.coupling += &carried.coupling;
    }

    /// Eliminates the instant; `None` where it remains undetermined.
    fn eliminated(self, columns: &[usize]) -> Option<Row<D>> {
        let lower = self.information.cholesky()?.l();
        Some(Row {
            gradient: lower.solve_lower_triangular(&self.gradient)?,
            coupling: lower.solve_lower_triangular(&self.coupling)?,
            columns: columns.to_vec(),
            lower,
            next: None,
        })
    }

    /// Eliminates the noise up to the next instant: its row, what is known of the next instant, and the gradient of the
    /// kept parameters that the error of the tie brings about.
    fn carried(mut self, tie: &Tie, columns: &[usize]) -> Option<(Row<D>, Self, DVector<f64>)> {
        let error = tie.error_of::<D>();
        tie.pull_back(&mut self.information);
        let mut information = self.information.transpose();
        tie.pull_back(&mut information);
        tie.pull_back(&mut self.gradient);
        tie.pull_back(&mut self.coupling);
        let gradient = self.gradient + information * error;
        let coupling = self.coupling;
        let by_error = coupling.tr_mul(&error);

        let mut with_noise = information;
        tie.by_noise(&mut with_noise);
        let mut noise = with_noise.transpose();
        tie.by_noise(&mut noise);
        noise += SMatrix::identity();
        let lower = noise.cholesky()?.l();
        let whitened = |mut x: Coupling<D>| {
            tie.by_noise(&mut x);
            lower.solve_lower_triangular_mut(&mut x).then_some(x)
        };
        let to_next = lower.solve_lower_triangular(&with_noise)?;
        let mut pull = gradient;
        tie.by_noise(&mut pull);
        let pull = lower.solve_lower_triangular(&pull)?;
        let to_kept = whitened(coupling.clone())?;
        let next = Self {
            information: information - to_next.tr_mul(&to_next),
            gradient: gradient - to_next.tr_mul(&pull),
            coupling: coupling - to_next.tr_mul(&to_kept),
        };
        let row = Row {
            lower,
            gradient: pull,
            columns: columns.to_vec(),
            coupling: to_kept,
            next: Some(Next {
                tie: tie.clone(),
                coupling: to_next,
            }),
        };
        Some((row, next, by_error))
    }
}

impl<const D: usize> ReducedSystem<D> {
    /// Eliminates the instants with Marquardt damping, a fraction of the diagonal; `None` if an instant remains
    /// undetermined.
    pub(crate) fn new(equations: &NormalEquations<D>, damping: f64) -> Option<Self> {
        let mut reduced = Self {
            information: equations.kept.clone(),
            gradient: equations.gradient.clone(),
            rows: Vec::with_capacity(equations.nodes.len()),
        };
        for at in 0..equations.kept.nrows() {
            let diagonal = &mut reduced.information[(at, at)];
            *diagonal += *diagonal * damping + FLOOR;
        }
        let mut stack = Stack::new(equations.kept.nrows());
        let mut carried: Option<Marginal<D>> = None;
        for node in &equations.nodes {
            let mut marginal = Marginal::new(node, damping);
            if let Some(carried) = carried.take() {
                marginal.add(&carried);
            }
            let row = match &node.next {
                None => marginal.eliminated(&node.columns)?,
                Some(tie) => {
                    let (row, next, by_error) = marginal.carried(tie, &node.columns)?;
                    for (&column, pull) in node.columns.iter().zip(by_error.iter()) {
                        reduced.gradient[column] += pull;
                    }
                    carried = Some(next);
                    row
                }
            };
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
    pub(crate) fn step(&self, equations: &NormalEquations<D>) -> Option<Step<D>> {
        let kept = if self.gradient.is_empty() {
            DVector::zeros(0)
        } else {
            -self.information.clone().cholesky()?.solve(&self.gradient)
        };
        let mut instants = vec![SVector::zeros(); self.rows.len()];
        for at in (0..self.rows.len()).rev() {
            let later = instants.get(at + 1).copied();
            instants[at] = self.rows[at].back(&kept, later.as_ref())?;
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

    /// Logarithm of the determinant of the information of everything that is sought: kept parameters, instants as their
    /// noise, stamps; `None` where that is not definite.
    pub(crate) fn log_information(&self, equations: &NormalEquations<D>) -> Option<f64> {
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
    fn new(n: usize) -> Self {
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
    /// Step of the instant, given those of the kept parameters and of the later instant.
    fn back(
        &self,
        kept: &DVector<f64>,
        later: Option<&SVector<f64, D>>,
    ) -> Option<SVector<f64, D>> {
        let mut right = self.gradient;
        for (at, &column) in self.columns.iter().enumerate() {
            right += self.coupling.column(at) * kept[column];
        }
        let (Some(next), Some(later)) = (&self.next, later) else {
            return self.lower.tr_solve_lower_triangular(&-right);
        };
        let noise = self
            .lower
            .tr_solve_lower_triangular(&(right + next.coupling * later))?;
        let tie = &next.tie;
        let moved = later + tie.error_of::<D>() - tie.noisy(&noise);
        Some(tie.earlier(&moved))
    }
}
