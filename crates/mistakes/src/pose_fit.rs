//! The pose that explains some views best, with a cost that is bounded for each view.
//!
//! A view whose corners are off by a squared Mahalanobis distance d² costs d²/2 · C / (C + d²/2) (S. Geman, D. McClure,
//! 1987): a wrong view costs at most [`MOST_COST`], however far it is off.

use nalgebra::{Matrix6, Point2, Point3, SMatrix, SVector, Vector2, Vector6};
use sextant_geometry::{Lens, Pose, se3, so3};

/// Most that a view costs.
pub(crate) const MOST_COST: f64 = 25.0;
/// Gauss-Newton steps.
const STEPS: usize = 8;
/// A step shorter than this, m and rad, ends the search.
const LAST_STEP: f64 = 1e-6;
/// Information that keeps the equations definite.
const LEAST_INFORMATION: f64 = 1e-6;
/// Starts that are refined.
const PROMISING: usize = 3;

/// x and y of the four corners in turn.
type Corners = SVector<f64, 8>;

/// Variances of the corners of a view: of each coordinate by itself, and of what moves them together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spread {
    /// Of a coordinate, px².
    pub own: f64,
    /// Of the shift of all corners along either axis, px².
    pub shift: f64,
    /// Of the angle by which they turn about their middle, rad².
    pub turn: f64,
    /// Of the logarithm of their distances from it.
    pub scale: f64,
}

/// Four corners of a tag seen by a camera: the unknown pose maps `points`, and `outer` its result into the camera.
#[derive(Debug, Clone)]
pub(crate) struct Term<'a> {
    pub lens: &'a Lens,
    pub outer: Pose,
    pub points: [Point3<f64>; 4],
    pub corners: [Point2<f64>; 4],
    /// Brings errors of the corners into units of their standard deviations.
    pub whitening: Whitening,
}

/// As [`Term::whitening`].
pub(crate) type Whitening = SMatrix<f64, 8, 8>;

impl Spread {
    /// The inverse of a square root of the covariance, from the directions in which corners move together.
    pub fn whitening(&self, corners: &[Point2<f64>; 4]) -> Whitening {
        let mut whitening = Whitening::identity();
        for (mode, variance) in self.modes(corners) {
            let factor = (self.own / (self.own + variance)).sqrt() - 1.0;
            whitening += mode * mode.transpose() * factor;
        }
        whitening / self.own.sqrt()
    }

    /// The directions, of unit length and at right angles to one another, with the variances along them.
    fn modes(&self, corners: &[Point2<f64>; 4]) -> [(Corners, f64); 4] {
        let sum = corners.iter().map(|corner| corner.coords);
        let middle = sum.sum::<Vector2<f64>>() / 4.0;
        let arms = corners.map(|corner| corner.coords - middle);
        let square: f64 = arms.iter().map(Vector2::norm_squared).sum();
        let length = square.sqrt().max(f64::MIN_POSITIVE);
        let mode = |at: fn(&Vector2<f64>) -> Vector2<f64>| {
            Corners::from_fn(|row, _| at(&arms[row / 2])[row % 2] / length)
        };
        let shift = |axis: usize| Corners::from_fn(|row, _| f64::from(row % 2 == axis) * 0.5);
        [
            (shift(0), 4.0 * self.shift),
            (shift(1), 4.0 * self.shift),
            (mode(|arm| Vector2::new(-arm.y, arm.x)), square * self.turn),
            (mode(|arm| *arm), square * self.scale),
        ]
    }
}

impl Term<'_> {
    /// What it costs at a pose, at most [`MOST_COST`].
    pub fn cost(&self, pose: &Pose) -> f64 {
        let error = self.error(pose);
        error.map_or(MOST_COST, |error| {
            bounded(0.5 * (self.whitening * error).norm_squared())
        })
    }

    /// Square of the distances of expected and seen corners, px²; `None` where they can't be seen.
    pub fn square_px(&self, pose: &Pose) -> Option<f64> {
        self.error(pose).map(|error| error.norm_squared())
    }

    /// Expected less seen corners, px; `None` where they can't be seen.
    fn error(&self, pose: &Pose) -> Option<Corners> {
        let mut error = Corners::zeros();
        for (at, (point, corner)) in self.points.iter().zip(&self.corners).enumerate() {
            let seen = self.lens.project(&(self.outer * (pose * point)))?;
            error
                .fixed_rows_mut::<2>(2 * at)
                .copy_from(&(seen - corner));
        }
        Some(error)
    }

    fn add(&self, pose: &Pose, information: &mut Matrix6<f64>, gradient: &mut Vector6<f64>) {
        let outer = self.outer.rotation.to_rotation_matrix();
        let (mut error, mut by_step) = (Corners::zeros(), SMatrix::<f64, 8, 6>::zeros());
        for (at, (point, corner)) in self.points.iter().zip(&self.corners).enumerate() {
            let turned = pose.rotation * point.coords;
            let in_camera = self.outer * (pose * point);
            let Some((seen, by_point)) = self.lens.project_with_jacobian(&in_camera) else {
                return;
            };
            let by_point = by_point * outer.matrix();
            error
                .fixed_rows_mut::<2>(2 * at)
                .copy_from(&(seen - corner));
            by_step
                .fixed_view_mut::<2, 3>(2 * at, 0)
                .copy_from(&by_point);
            by_step
                .fixed_view_mut::<2, 3>(2 * at, 3)
                .copy_from(&(-by_point * so3::hat(&turned)));
        }
        let error = self.whitening * error;
        let by_step = self.whitening * by_step;
        let weight = (MOST_COST / (MOST_COST + 0.5 * error.norm_squared())).powi(2);
        *information += by_step.transpose() * by_step * weight;
        *gradient += by_step.transpose() * error * weight;
    }
}

fn bounded(half_square: f64) -> f64 {
    half_square * MOST_COST / (MOST_COST + half_square)
}

/// The sum of what all terms cost at a pose.
pub(crate) fn cost(terms: &[Term<'_>], pose: &Pose) -> f64 {
    terms.iter().map(|term| term.cost(pose)).sum()
}

/// The best pose next to a start, with its cost; the start where nothing better is found.
fn refined(terms: &[Term<'_>], start: Pose) -> (Pose, f64) {
    let (mut best, mut least) = (start, cost(terms, &start));
    for _ in 0..STEPS {
        let mut information = Matrix6::identity() * LEAST_INFORMATION;
        let mut gradient = Vector6::zeros();
        for term in terms {
            term.add(&best, &mut information, &mut gradient);
        }
        let Some(factor) = information.cholesky() else {
            break;
        };
        let step = -factor.solve(&gradient);
        let moved = se3::perturb(&best, &step);
        let there = cost(terms, &moved);
        if there.is_nan() || there >= least {
            break;
        }
        (best, least) = (moved, there);
        if step.amax() < LAST_STEP {
            break;
        }
    }
    (best, least)
}

/// Covariance of the pose that explains some terms, (dt, dr), m² and rad²; `None` where they do not determine it.
pub(crate) fn covariance(terms: &[Term<'_>], pose: &Pose) -> Option<Matrix6<f64>> {
    let (mut information, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
    for term in terms {
        term.add(pose, &mut information, &mut gradient);
    }
    Some(information.cholesky()?.inverse())
}

/// The best of several starts, the most promising ones refined; `None` without a start.
pub(crate) fn best_of(
    terms: &[Term<'_>],
    starts: impl Iterator<Item = Pose>,
) -> Option<(Pose, f64)> {
    let mut scored: Vec<(f64, Pose)> = starts.map(|start| (cost(terms, &start), start)).collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    let promising = scored.into_iter().take(PROMISING);
    let refined = promising.map(|(_, start)| refined(terms, start));
    refined.min_by(|a, b| a.1.total_cmp(&b.1))
}
