//! The configuration that agrees best with a prior and the corners of simultaneous images.
//!
//! Minimises |difference(configuration, prior)|²_P + sum over corners of rho(r) by Gauss-Newton with Levenberg-Marquardt damping;
//! at the minimum the normal matrix is the inverse covariance (Bell, Cathey 1993, The iterated Kalman filter update as a
//! Gauss-Newton method; information form).

use nalgebra::{Cholesky, Const, SMatrix, SVector};
use sextant_geometry::so3;

use super::configuration::{Configuration, rates_at};
use super::corners::Sight;
use super::normal::Normal;
use super::shutter::Rolling;

/// Most steps of one solve; a tracked object needs two or three.
const MOST_STEPS: usize = 20;
/// A step below this many sigmas is not worth taking.
const SMALL_STEP: f64 = 0.01;
/// Damping at which the search is given up: steps are far below a sigma by then.
const MOST_DAMPING: f64 = 1e6;
/// Twice the cost of a view that can't be seen from the pose: as bad as a view can be.
pub(crate) const UNSEEN: f64 = 1e3;

/// What is known about the configuration before.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Prior<const D: usize> {
    pub configuration: Configuration,
    /// Inverse covariance over (dt, dr, dq).
    pub information: SMatrix<f64, D, D>,
}

impl<const D: usize> Prior<D> {
    /// Squared Mahalanobis distance of a configuration.
    pub fn surprise(&self, at: &Configuration) -> f64 {
        let off = at.difference::<D>(&self.configuration);
        off.dot(&(self.information * off))
    }
}

/// A minimum.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fit<const D: usize> {
    pub configuration: Configuration,
    /// What the corners of all views say about it.
    pub information: SMatrix<f64, D, D>,
    /// Each view's part, about the pose of its link.
    pub views: Vec<Option<Normal>>,
    /// Squared Mahalanobis distance from the prior.
    pub surprise: f64,
    /// Twice the cost: surprise and chi-square of all corners.
    pub cost: f64,
}

impl Sight<'_> {
    /// Twice the robust cost of the view at a configuration.
    pub fn chi2(&self, at: &Configuration) -> f64 {
        let normal = self.normal(&self.view.moving(at));
        normal.map_or(UNSEEN, |normal| normal.chi2)
    }
}

struct Point<const D: usize> {
    configuration: Configuration,
    corners: SMatrix<f64, D, D>,
    views: Vec<Option<Normal>>,
    surprise: f64,
    cost: f64,
    /// Of prior and corners together.
    information: SMatrix<f64, D, D>,
    gradient: SVector<f64, D>,
}

/// The minimum reached from `start`; `None` where the sights can't see their tags even there.
pub(crate) fn solve<const D: usize>(
    prior: &Prior<D>,
    sights: &[Sight<'_>],
    start: &Configuration,
) -> Option<Fit<D>> {
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
        let next = evaluate(prior, sights, &best.configuration.perturbed(&step));
        match next.filter(|next| next.cost <= best.cost) {
            Some(next) => {
                best = next;
                damping = if damping < 1e-4 { 0.0 } else { damping * 0.1 };
            }
            None => damping = (damping * 10.0).max(1e-3),
        }
    }
    Some(Fit {
        configuration: best.configuration,
        information: best.corners,
        views: best.views,
        surprise: best.surprise,
        cost: best.cost,
    })
}

fn damped_step<const D: usize>(at: &Point<D>, damping: f64) -> Option<SVector<f64, D>> {
    let mut matrix = at.information;
    for axis in 0..D {
        matrix[(axis, axis)] *= 1.0 + damping;
    }
    let step = -Cholesky::<f64, Const<D>>::new(matrix)?.solve(&at.gradient);
    step.iter().all(|x| x.is_finite()).then_some(step)
}

fn evaluate<const D: usize>(
    prior: &Prior<D>,
    sights: &[Sight<'_>],
    at: &Configuration,
) -> Option<Point<D>> {
    let normal = |sight: &Sight<'_>| sight.normal(&sight.view.moving(at));
    let views: Vec<_> = sights.iter().map(normal).collect();
    let unseen = views.iter().filter(|view| view.is_none()).count();
    if unseen == sights.len() && unseen > 0 {
        return None;
    }
    let mut corners = SMatrix::<f64, D, D>::zeros();
    let mut slope = SVector::<f64, D>::zeros();
    let mut chi2 = UNSEEN * unseen as f64;
    for (sight, view) in sights.iter().zip(&views) {
        let Some(view) = view else { continue };
        chi2 += view.chi2;
        add(&mut corners, &mut slope, (sight, view), at);
    }
    let off = at.difference::<D>(&prior.configuration);
    let (information, gradient) = prior_normal(prior, &off);
    let surprise = off.dot(&(prior.information * off));
    let cost = surprise + chi2;
    cost.is_finite().then_some(Point {
        configuration: *at,
        corners,
        views,
        surprise,
        cost,
        information: information + corners,
        gradient: gradient + slope,
    })
}

/// A view's normal equations about the pose of its link, by the chain rule about the configuration.
fn add<const D: usize>(
    information: &mut SMatrix<f64, D, D>,
    gradient: &mut SVector<f64, D>,
    (sight, view): (&Sight<'_>, &Normal),
    at: &Configuration,
) {
    match &sight.view.limb {
        None => {
            let mut of_pose = information.fixed_view_mut::<6, 6>(0, 0);
            of_pose += view.information;
            let mut of_pose = gradient.fixed_rows_mut::<6>(0);
            of_pose += view.gradient;
        }
        Some(limb) => {
            let jacobian = limb.jacobian::<D>(at);
            *information += jacobian.transpose() * view.information * jacobian;
            *gradient += jacobian.transpose() * view.gradient;
        }
    }
    if let Some((rolling, first)) = view.rolling.as_deref().zip(rates_at(D)) {
        add_rolling(information, gradient, (sight, rolling), (at, first));
    }
}

/// The same for what a rolling shutter tells about the rates, whose places begin at `first`.
fn add_rolling<const D: usize>(
    information: &mut SMatrix<f64, D, D>,
    gradient: &mut SVector<f64, D>,
    (sight, rolling): (&Sight<'_>, &Rolling),
    (at, first): (&Configuration, usize),
) {
    let by_configuration = match &sight.view.limb {
        None => SMatrix::<f64, 6, D>::identity(),
        Some(limb) => limb.jacobian::<D>(at),
    };
    let mut by_rates = SMatrix::<f64, 6, D>::zeros();
    by_rates
        .columns_mut(first, first)
        .copy_from(&by_configuration.columns(0, first));
    let mixed = by_configuration.transpose() * rolling.with_pose * by_rates;
    *information +=
        mixed + mixed.transpose() + by_rates.transpose() * rolling.information * by_rates;
    *gradient += by_rates.transpose() * rolling.gradient;
}

/// The prior's part of the normal equations at the distance `off` from it: d log(exp(e) exp(off)) / de = J_l⁻¹(off).
fn prior_normal<const D: usize>(
    prior: &Prior<D>,
    off: &SVector<f64, D>,
) -> (SMatrix<f64, D, D>, SVector<f64, D>) {
    let mut jacobian = SMatrix::<f64, D, D>::identity();
    let turn = off.fixed_rows::<3>(3).into_owned();
    jacobian
        .fixed_view_mut::<3, 3>(3, 3)
        .copy_from(&so3::left_jacobian_inverse(&turn));
    let weighted = jacobian.transpose() * prior.information;
    (weighted * jacobian, weighted * off)
}
