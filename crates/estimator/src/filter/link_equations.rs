//! Normal equations of the links that are seen, summed by link before the chain rule is applied once.

use nalgebra::{Matrix6, SMatrix, SVector, Vector6};

use crate::kinematics::configuration::{Configuration, rates_at};
use crate::measurement::corners::WeightedView;
use crate::measurement::rolling_shutter::{LinkMotion, TwistEquations};
use crate::measurement::view_equations::ViewEquations;

/// A link, or the object where it is rigid.
pub(crate) struct ObservedLink<const D: usize> {
    /// `None` for a rigid object.
    link: Option<usize>,
    pub moving: LinkMotion,
    /// Derivative of its pose by the configuration; `None` where they are the same.
    by_configuration: Option<SMatrix<f64, 6, D>>,
}

/// The links that are seen, each once.
pub(crate) struct ObservedLinks<const D: usize>(Vec<ObservedLink<D>>);

/// Normal equations of a configuration.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ConfigurationEquations<const D: usize> {
    pub information: SMatrix<f64, D, D>,
    pub gradient: SVector<f64, D>,
}

fn link_of(weighted: &WeightedView<'_>) -> Option<usize> {
    weighted
        .view
        .chain_link
        .as_ref()
        .map(|chain_link| chain_link.link)
}

impl<const D: usize> ObservedLinks<D> {
    pub fn new(weighted_views: &[WeightedView<'_>], at: &Configuration) -> Self {
        let mut links: Vec<ObservedLink<D>> = Vec::with_capacity(1);
        for weighted in weighted_views {
            let link = link_of(weighted);
            if links.iter().all(|observed| observed.link != link) {
                let chain_link = weighted.view.chain_link.as_ref();
                let twist = || chain_link.map_or(at.rates.twist, |chain_link| chain_link.twist(at));
                links.push(ObservedLink {
                    link,
                    moving: LinkMotion {
                        pose: weighted.view.world_from_link(at),
                        twist: rates_at(D).map(|_| twist()),
                    },
                    by_configuration: chain_link.map(|chain_link| chain_link.jacobian::<D>(at)),
                });
            }
        }
        Self(links)
    }

    /// The link that a view shows.
    pub fn of_view(&self, weighted: &WeightedView<'_>) -> Option<&ObservedLink<D>> {
        let link = link_of(weighted);
        self.0.iter().find(|observed| observed.link == link)
    }

    /// Normal equations of the configuration by all views, each with a factor on its weight.
    pub fn equations(
        &self,
        weighted_views: &[WeightedView<'_>],
        views: &[Option<ViewEquations>],
        factor: impl Fn(&ObservedLink<D>, &WeightedView<'_>, &ViewEquations) -> f64,
    ) -> ConfigurationEquations<D> {
        let mut all = ConfigurationEquations {
            information: SMatrix::zeros(),
            gradient: SVector::zeros(),
        };
        for observed in &self.0 {
            let mut sum = Sum::default();
            for (weighted, view) in weighted_views.iter().zip(views) {
                let Some(view) = view.as_ref().filter(|_| link_of(weighted) == observed.link)
                else {
                    continue;
                };
                sum.add(view, factor(observed, weighted, view));
            }
            observed.add(&sum, &mut all);
        }
        all
    }
}

/// Sums over the views of a link: about its pose and, where the shutter rolls, its twist.
#[derive(Default)]
struct Sum {
    information: Matrix6<f64>,
    gradient: Vector6<f64>,
    rolling: Option<TwistEquations>,
}

impl Sum {
    #[inline(always)]
    fn add(&mut self, view: &ViewEquations, factor: f64) {
        let sums = self.information.as_mut_slice().iter_mut();
        sums.zip(view.information.as_slice())
            .for_each(|(sum, one)| *sum += one * factor);
        self.gradient += view.gradient * factor;
        if let Some(rolling) = view.rolling.as_deref() {
            let weighed = rolling.weighed(factor, 1.0);
            self.rolling = Some(match self.rolling.take() {
                Some(sum) => sum.sum(&weighed),
                None => weighed,
            });
        }
    }
}

impl<const D: usize> ObservedLink<D> {
    /// By the chain rule.
    fn add(&self, sum: &Sum, all: &mut ConfigurationEquations<D>) {
        match &self.by_configuration {
            None => {
                let mut of_pose = all.information.fixed_view_mut::<6, 6>(0, 0);
                of_pose += sum.information;
                let mut of_pose = all.gradient.fixed_rows_mut::<6>(0);
                of_pose += sum.gradient;
            }
            Some(jacobian) => {
                all.information += jacobian.tr_mul(&(sum.information * jacobian));
                all.gradient += jacobian.tr_mul(&sum.gradient);
            }
        }
        if let Some((rolling, first)) = sum.rolling.as_ref().zip(rates_at(D)) {
            self.add_rolling(rolling, first, all);
        }
    }

    /// Adds the part of a rolling shutter about the rates, whose places begin at `first`.
    fn add_rolling(
        &self,
        rolling: &TwistEquations,
        first: usize,
        all: &mut ConfigurationEquations<D>,
    ) {
        let by_configuration = self
            .by_configuration
            .unwrap_or_else(SMatrix::<f64, 6, D>::identity);
        let mut by_rates = SMatrix::<f64, 6, D>::zeros();
        by_rates
            .columns_mut(first, first)
            .copy_from(&by_configuration.columns(0, first));
        let mixed = by_configuration.tr_mul(&(rolling.with_pose * by_rates));
        all.information +=
            mixed + mixed.transpose() + by_rates.tr_mul(&(rolling.information * by_rates));
        all.gradient += by_rates.tr_mul(&rolling.gradient);
    }

    /// Step of the pose of the link by a step of the configuration, and of its twist where rates have places.
    pub fn moved(&self, step: &SVector<f64, D>) -> (Vector6<f64>, Option<Vector6<f64>>) {
        let by = |step: &SVector<f64, D>| match &self.by_configuration {
            None => step.fixed_rows::<6>(0).into_owned(),
            Some(jacobian) => jacobian * step,
        };
        let of_twist = rates_at(D).map(|first| {
            let mut rates = SVector::<f64, D>::zeros();
            rates.rows_mut(0, first).copy_from(&step.rows(first, first));
            by(&rates)
        });
        (by(step), of_twist)
    }
}
