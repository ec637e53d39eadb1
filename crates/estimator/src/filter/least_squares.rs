//! The configuration that agrees best with a prior and the corners of simultaneous images.
//!
//! Minimises |difference(configuration, prior)|²_P + sum over corners of rho(r) by Gauss-Newton with
//! Levenberg-Marquardt damping; at the minimum the normal matrix is the inverse covariance (Bell, Cathey 1993, The
//! iterated Kalman filter update as a Gauss-Newton method; information form).

use nalgebra::{Cholesky, Const, SMatrix, SVector};
use sextant_geometry::so3;

use crate::filter::link_equations::{ConfigurationEquations, ObservedLinks};
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::{WeightedView, unseen_cost};
use crate::measurement::view_equations::ViewEquations;

/// Most steps of one solve; a tracked object needs two or three.
const MOST_STEPS: usize = 20;
/// Step, in standard deviations, below which the search ends.
const SMALL_STEP: f64 = 0.01;
/// Most reweightings of one step.
const MOST_REWEIGHINGS: usize = 5;
/// Damping at which the search is given up: steps are far below a sigma by then.
const MOST_DAMPING: f64 = 1e6;
/// What is known about the configuration before.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Prior<const D: usize> {
    pub configuration: Configuration,
    /// Inverse covariance over (dt, dr, dq).
    pub information: SMatrix<f64, D, D>,
}

impl<const D: usize> Prior<D> {
    /// Squared Mahalanobis distance of a configuration.
    pub fn nis(&self, at: &Configuration) -> f64 {
        let off = at.difference::<D>(&self.configuration);
        off.dot(&(self.information * off))
    }
}

/// A minimum.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fit<const D: usize> {
    pub configuration: Configuration,
    /// Information of the corners of all views.
    pub information: SMatrix<f64, D, D>,
    /// Each view's part, about the pose of its link.
    pub views: Vec<Option<ViewEquations>>,
    /// Squared Mahalanobis distance from the prior.
    pub nis: f64,
    /// Twice the cost: `nis` and chi-square of all corners.
    pub cost: f64,
}

struct Point<const D: usize> {
    configuration: Configuration,
    links: ObservedLinks<D>,
    views: Vec<Option<ViewEquations>>,
    /// Of the corners, of the prior, and of both.
    corners: ConfigurationEquations<D>,
    prior: ConfigurationEquations<D>,
    all: ConfigurationEquations<D>,
    nis: f64,
    cost: f64,
}

/// The minimum reached from `start`; `None` where no view can see its tag even there.
pub(crate) fn solve<const D: usize>(
    prior: &Prior<D>,
    weighted_views: &[WeightedView<'_>],
    start: &Configuration,
) -> Option<Fit<D>> {
    let mut best = evaluate(prior, weighted_views, start)?;
    let mut damping = 0.0;
    for _ in 0..MOST_STEPS {
        let Some(mut step) = best.all.step(damping) else {
            break;
        };
        let length = best.length(&step);
        if damping > MOST_DAMPING {
            break;
        }
        if damping == 0.0 && length < SMALL_STEP {
            best.configuration = best.configuration.perturbed(&step);
            break;
        }
        if damping == 0.0 {
            step = best.reweighed(step, weighted_views);
        }
        let next = evaluate(prior, weighted_views, &best.configuration.perturbed(&step));
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
        information: best.corners.information,
        views: best.views,
        nis: best.nis,
        cost: best.cost,
    })
}

impl<const D: usize> ConfigurationEquations<D> {
    /// To the minimum of the parabola, or less far with damping.
    fn step(&self, damping: f64) -> Option<SVector<f64, D>> {
        let mut matrix = self.information;
        for axis in 0..D {
            matrix[(axis, axis)] *= 1.0 + damping;
        }
        let step = -Cholesky::<f64, Const<D>>::new(matrix)?.solve(&self.gradient);
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            information: self.information + other.information,
            gradient: self.gradient + other.gradient,
        }
    }
}

impl<const D: usize> Point<D> {
    /// In sigmas.
    fn length(&self, step: &SVector<f64, D>) -> f64 {
        step.dot(&(self.all.information * step)).sqrt()
    }

    /// The step with the weights that the views will have after it. Where the prediction was off by more than the
    /// corners' noise their weights rise by the way, and would only be known by looking at all corners again.
    fn reweighed(
        &self,
        first: SVector<f64, D>,
        weighted_views: &[WeightedView<'_>],
    ) -> SVector<f64, D> {
        let mut step = first;
        for _ in 0..MOST_REWEIGHINGS {
            let corners =
                self.links
                    .equations(weighted_views, &self.views, |observed, weighted, view| {
                        let (moved, turned) = observed.moved(&step);
                        view.weight_after(&moved, turned, weighted.view.noise_source)
                    });
            let Some(next) = self.prior.and(&corners).step(0.0) else {
                break;
            };
            let change = self.length(&(next - step));
            step = next;
            if change < 0.1 * SMALL_STEP {
                break;
            }
        }
        step
    }
}

fn evaluate<const D: usize>(
    prior: &Prior<D>,
    weighted_views: &[WeightedView<'_>],
    at: &Configuration,
) -> Option<Point<D>> {
    let links = ObservedLinks::new(weighted_views, at);
    let normal = |weighted: &WeightedView<'_>| weighted.normal(&links.of_view(weighted)?.moving);
    let views: Vec<_> = weighted_views.iter().map(normal).collect();
    let unseen = views.iter().filter(|view| view.is_none()).count();
    if unseen == weighted_views.len() && unseen > 0 {
        return None;
    }
    let seen = views.iter().flatten().map(|view| view.chi2);
    let chi2 = unseen_cost() * unseen as f64 + seen.sum::<f64>();
    let corners = links.equations(weighted_views, &views, |_, _, _| 1.0);
    let off = at.difference::<D>(&prior.configuration);
    let of_prior = prior.equations(&off);
    let nis = off.dot(&(prior.information * off));
    let cost = nis + chi2;
    cost.is_finite().then(|| Point {
        configuration: *at,
        links,
        views,
        all: corners.and(&of_prior),
        corners,
        prior: of_prior,
        nis,
        cost,
    })
}

impl<const D: usize> Prior<D> {
    /// Its part of the normal equations at the distance `off` from it: d log(exp(e) exp(off)) / de = J_l⁻¹(off).
    fn equations(&self, off: &SVector<f64, D>) -> ConfigurationEquations<D> {
        let turn = off.fixed_rows::<3>(3).into_owned();
        let jacobian = so3::left_jacobian_inverse(&turn);
        let mut information = self.information;
        let mut gradient = self.information * off;
        let rows = jacobian.tr_mul(&information.fixed_rows::<3>(3));
        information.fixed_rows_mut::<3>(3).copy_from(&rows);
        let columns = information.fixed_columns::<3>(3) * jacobian;
        information.fixed_columns_mut::<3>(3).copy_from(&columns);
        let turned = jacobian.tr_mul(&gradient.fixed_rows::<3>(3));
        gradient.fixed_rows_mut::<3>(3).copy_from(&turned);
        ConfigurationEquations {
            information,
            gradient,
        }
    }
}
