//! The pose that agrees best with a prior and the corners of simultaneous images.
//!
//! Minimises |difference(pose, prior)|²_P + sum over corners of rho(r) by Gauss-Newton with Levenberg-Marquardt damping;
//! at the minimum the normal matrix is the inverse covariance (Bell, Cathey 1993, The iterated Kalman filter update as a
//! Gauss-Newton method; information form).

use nalgebra::{Cholesky, Const, Matrix6, Vector6};
use sextant_geometry::{Pose, se3, so3};

use super::corners::{Normal, Sight};

/// Most steps of one solve; a tracked object needs two or three.
const MOST_STEPS: usize = 20;
/// A step below this many sigmas is not worth taking.
const SMALL_STEP: f64 = 0.01;
/// Damping at which the search is given up: steps are far below a sigma by then.
const MOST_DAMPING: f64 = 1e6;
/// Twice the cost of a view that can't be seen from the pose: as bad as a view can be.
pub(crate) const UNSEEN: f64 = 1e3;

/// What is known about the pose before.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Prior {
    pub pose: Pose,
    /// Inverse covariance over (dt, dr).
    pub information: Matrix6<f64>,
}

/// A minimum.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fit {
    pub pose: Pose,
    /// What the corners say about the pose: the sum over all views, and each view's part.
    pub corners: Normal,
    pub views: Vec<Option<Normal>>,
    /// Squared Mahalanobis distance from the prior.
    pub surprise: f64,
    /// Twice the cost: surprise and chi-square of all corners.
    pub cost: f64,
}

struct Point {
    pose: Pose,
    corners: Normal,
    views: Vec<Option<Normal>>,
    surprise: f64,
    cost: f64,
    /// Of prior and corners together.
    information: Matrix6<f64>,
    gradient: Vector6<f64>,
}

/// The minimum reached from `start`; `None` where the sights can't see their tags even there.
pub(crate) fn solve(prior: &Prior, sights: &[Sight<'_>], start: &Pose) -> Option<Fit> {
    let mut best = evaluate(prior, sights, start)?;
    let mut damping = 0.0;
    for _ in 0..MOST_STEPS {
        let Some(step) = damped_step(&best, damping) else {
            break;
        };
        let length = step.dot(&(best.information * step)).sqrt();
        if (damping == 0.0 && length < SMALL_STEP) || damping > MOST_DAMPING {
            break;
        }
        let next = evaluate(prior, sights, &se3::perturb(&best.pose, &step));
        match next.filter(|next| next.cost <= best.cost) {
            Some(next) => {
                best = next;
                damping = if damping < 1e-4 { 0.0 } else { damping * 0.1 };
            }
            None => damping = (damping * 10.0).max(1e-3),
        }
    }
    Some(Fit {
        pose: best.pose,
        corners: best.corners,
        views: best.views,
        surprise: best.surprise,
        cost: best.cost,
    })
}

fn damped_step(at: &Point, damping: f64) -> Option<Vector6<f64>> {
    let mut matrix = at.information;
    for axis in 0..6 {
        matrix[(axis, axis)] *= 1.0 + damping;
    }
    let step = -Cholesky::<f64, Const<6>>::new(matrix)?.solve(&at.gradient);
    step.iter().all(|x| x.is_finite()).then_some(step)
}

fn evaluate(prior: &Prior, sights: &[Sight<'_>], pose: &Pose) -> Option<Point> {
    let views: Vec<_> = sights.iter().map(|sight| sight.normal(pose)).collect();
    let mut corners = Normal::zero();
    views.iter().flatten().for_each(|view| corners.add(view));
    let unseen = views.iter().filter(|view| view.is_none()).count();
    if unseen == sights.len() && unseen > 0 {
        return None;
    }
    corners.chi2 += UNSEEN * unseen as f64;
    let off = se3::difference(pose, &prior.pose);
    let (information, gradient) = prior_normal(prior, &off);
    let surprise = off.dot(&(prior.information * off));
    let cost = surprise + corners.chi2;
    let (information, gradient) = (
        information + corners.information,
        gradient + corners.gradient,
    );
    cost.is_finite().then_some(Point {
        pose: *pose,
        corners,
        views,
        surprise,
        cost,
        information,
        gradient,
    })
}

/// The prior's part of the normal equations at the distance `off` from it: d log(exp(e) exp(off)) / de = J_l⁻¹(off).
fn prior_normal(prior: &Prior, off: &Vector6<f64>) -> (Matrix6<f64>, Vector6<f64>) {
    let mut jacobian = Matrix6::identity();
    let turn = off.fixed_rows::<3>(3).into_owned();
    jacobian
        .fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&so3::left_jacobian_inverse(&turn));
    let weighted = jacobian.transpose() * prior.information;
    (weighted * jacobian, weighted * off)
}
