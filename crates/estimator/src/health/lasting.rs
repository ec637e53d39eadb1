//! What is stated to be wrong for good, as far as the views have shown it: errors of cameras' poses and of tags' places.
//!
//! Such an error is a constant that many views share, so that a view is held against what the others have taught of it, not against
//! all that is possible: with H what the errors e of all sources do to a view, its innovation is g - H e, and e and its covariance
//! follow by Kalman's filter from the prior that is stated. What a view shows that can't be by them, as one of a camera that was
//! bumped, teaches nothing of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Cholesky, Const, Dyn, Matrix6, OMatrix, U6, Vector6};

use super::guess::USUAL;
use super::testimony::Account;
use crate::filter::consider::{Displacing, Source};
use crate::filter::learned::Learned;

/// Most sources that are learned about: all their errors hang together, and further ones stay as they are stated.
const MOST_SOURCES: usize = 12;
/// Squared sigmas of an innovation's six numbers beyond which it is by no stated error: one view in 10⁵ by chance.
const GATE: f64 = 33.0;
/// Views as which one counts: what is unknown of a pose, and how corners err, hangs together from image to image.
const ALIKE: f64 = 10.0;
/// Share of what errors do that is not as the track's sensitivities have it: these are linear, and weights go with residuals.
const BENT: f64 = 0.25;
/// Seconds in which what was learned fades to what is stated: what holds a camera gives way.
const FADES_S: f64 = 60.0;
/// Seconds between two such steps.
const STEP_S: f64 = 0.1;
/// Of the trace of a covariance: added to it, so that it has an inverse.
const FLOOR: f64 = 1e-9;
/// Views over which a camera's noise is averaged, by which factor one can exceed it, and the least of it: to the track stated errors
/// are noise, of which it allows for so much.
const RECENT: f64 = 30.0;
const MORE: f64 = 4.0;
const LEAST: f64 = 0.04;

type Columns = OMatrix<f64, Dyn, U6>;

/// What is known of the errors.
#[derive(Debug, Clone, Default)]
pub(super) struct Lasting {
    learned: Arc<Learned>,
    at_ns: u64,
    /// By camera, the variance of its noise against what the track takes it for.
    noise: BTreeMap<usize, f64>,
}

/// What the errors do to a link's pose as a view shows it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Expected {
    pub displacement: Vector6<f64>,
    pub covariance: Matrix6<f64>,
    /// Covariance of the errors with it.
    with: Columns,
}

/// What a view, or several, show beyond what was expected.
struct Innovation {
    gradient: Vector6<f64>,
    noise: Matrix6<f64>,
    /// What is unknown of it by the errors, and how it goes with them.
    by_errors: Matrix6<f64>,
    with: Columns,
}

impl Expected {
    /// It may be displaced by so much more, either way.
    pub fn allow_for(&mut self, displaced: &Vector6<f64>) {
        self.covariance += displaced * displaced.transpose();
    }
}

impl Lasting {
    /// What is expected of a view that errors displace so.
    pub fn expected(&mut self, displacing: &[Displacing]) -> Expected {
        let known: Vec<_> = displacing.iter().map(|one| self.place(one)).collect();
        let learned = &*self.learned;
        let of_known = || displacing.iter().zip(&known);
        let mut with = Columns::zeros(learned.mean.len());
        let mut displacement = Vector6::zeros();
        for (one, first) in of_known() {
            let Some(first) = *first else { continue };
            displacement += one.by * learned.mean.fixed_rows::<6>(first);
            with += learned.covariance.fixed_columns::<6>(first) * one.by.transpose();
        }
        let mut covariance = Matrix6::zeros();
        for (one, first) in of_known() {
            let stated = one.covariance();
            covariance += match *first {
                Some(first) => one.by * with.fixed_rows::<6>(first) + stated * BENT.powi(2),
                None => stated,
            };
        }
        Expected {
            displacement,
            covariance: 0.5 * (covariance + covariance.transpose()),
            with,
        }
    }

    /// Where the errors of a source stand; `None` where they are not learned about.
    fn place(&mut self, of: &Displacing) -> Option<usize> {
        // A lens displaces corners, not only what is seen as a whole.
        if matches!(of.source, Source::Lens(_)) {
            return None;
        }
        self.learned.place(of.source).or_else(|| self.add(of))
    }

    fn add(&mut self, of: &Displacing) -> Option<usize> {
        let index = self.learned.sources.len();
        if index >= MOST_SOURCES {
            return None;
        }
        let (from, to) = (6 * index, 6 * index + 6);
        let learned = Arc::make_mut(&mut self.learned);
        learned.sources.push((of.source, of.variance));
        learned.mean.resize_vertically_mut(to, 0.0);
        learned.covariance.resize_mut(to, to, 0.0);
        let mut own = learned.covariance.fixed_view_mut::<6, 6>(from, from);
        own.copy_from(&Matrix6::from_diagonal(&of.variance));
        Some(from)
    }

    /// Learns from a view of which that was expected.
    pub fn learn(&mut self, time_ns: u64, account: &Account, expected: &Expected) {
        self.fade(time_ns);
        let Some(known) = account.conditional(expected) else {
            return;
        };
        let slope = known.slope.transpose();
        self.absorb(&Innovation {
            gradient: known.gradient,
            noise: known.noise,
            by_errors: known.slope * expected.covariance * slope,
            with: &expected.with * slope,
        });
    }

    /// Learns from views taken together: their gradient apart from what was expected of it, and the covariance of its noise.
    pub fn learn_together(
        &mut self,
        time_ns: u64,
        (gradient, noise): (Vector6<f64>, Matrix6<f64>),
        expected: Expected,
    ) {
        self.fade(time_ns);
        self.absorb(&Innovation {
            gradient,
            noise,
            by_errors: expected.covariance,
            with: expected.with,
        });
    }

    fn absorb(&mut self, of: &Innovation) {
        let gradient = of.gradient;
        let innovation = |share: f64| {
            let covariance = of.noise * share + of.by_errors * share.powi(2);
            let floor = Matrix6::identity() * (covariance.trace() * FLOOR);
            Cholesky::<f64, Const<6>>::new(covariance + floor)
        };
        let Some((single, alike)) = innovation(1.0).zip(innovation(ALIKE.recip())) else {
            return;
        };
        // Not below: NaN teaches nothing either.
        if gradient.dot(&single.solve(&gradient)) < GATE {
            let with = &of.with / ALIKE;
            let gain = &with * alike.inverse();
            let learned = Arc::make_mut(&mut self.learned);
            learned.mean += &gain * (gradient / ALIKE);
            learned.covariance -= &gain * with.transpose();
        }
    }

    fn fade(&mut self, time_ns: u64) {
        let gone_s = time_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        if gone_s < STEP_S {
            return;
        }
        self.at_ns = time_ns;
        let keep = (-gone_s / FADES_S).exp();
        let learned = Arc::make_mut(&mut self.learned);
        learned.mean *= keep;
        let covariance = &mut learned.covariance;
        *covariance = (&*covariance + covariance.transpose()) * (0.5 * keep.powi(2));
        let stated = learned.sources.iter().flat_map(|(_, variance)| variance);
        for (place, variance) in stated.enumerate() {
            covariance[(place, place)] += variance * (1.0 - keep.powi(2));
        }
    }

    /// What is known now.
    pub fn learned(&self) -> Arc<Learned> {
        Arc::clone(&self.learned)
    }

    /// Variance of a camera's noise against what the track takes it for.
    pub fn noise(&self, camera: usize) -> f64 {
        self.noise.get(&camera).copied().unwrap_or(1.0)
    }

    /// Learns of it from what a view leaves.
    pub fn learn_noise(&mut self, camera: usize, square: f64) {
        let own = self.noise.entry(camera).or_insert(1.0);
        *own += *own * ((square / USUAL).min(MORE) - 1.0) / RECENT;
        *own = own.clamp(LEAST, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::health::testimony::Testimony;

    const SIGMA: f64 = 0.001;

    /// A view by the first camera among two whose errors go through the track half and half.
    fn account(errors: [Vector6<f64>; 2]) -> Account {
        let acting = [-0.5, 0.5].map(|share| Matrix6::identity() * share);
        let information = Matrix6::identity() * 1e8;
        let displaced: Vector6<f64> = acting.iter().zip(&errors).map(|(by, e)| by * e).sum();
        let displacing = acting.iter().enumerate().map(|(camera, by)| Displacing {
            source: Source::Camera(camera),
            variance: Vector6::repeat(SIGMA.powi(2)),
            by: *by,
        });
        Account {
            testimony: Testimony::of_displaced(information, &displaced),
            covariance: Matrix6::zeros(),
            took_part: false,
            displacing: displacing.collect(),
        }
    }

    fn taught(lasting: &mut Lasting, account: &Account, views: u64) -> Vector6<f64> {
        for view in 0..views {
            let expected = lasting.expected(&account.displacing);
            lasting.learn(1_000_000_000 + view * 33_000_000, account, &expected);
        }
        lasting.expected(&account.displacing).displacement
    }

    #[test]
    fn errors_as_stated_are_expected_once_they_have_been_seen() {
        let (mut lasting, off) = (Lasting::default(), Vector6::repeat(SIGMA));
        let account = account([off, -off]);
        let before = lasting.expected(&account.displacing);
        assert_eq!(before.displacement, Vector6::zeros());
        assert!((before.covariance[(0, 0)] / SIGMA.powi(2) - 0.53).abs() < 0.01);
        let after = taught(&mut lasting, &account, 300);
        assert!((after + off).amax() < 0.1 * SIGMA, "{after}");
        let left = account.apart_from(&lasting.expected(&account.displacing));
        assert!(left.is_some_and(|left| left.square < 8.0));
    }

    #[test]
    fn a_bump_is_none_of_them() {
        let mut lasting = Lasting::default();
        let bumped = account([Vector6::repeat(20.0 * SIGMA), Vector6::zeros()]);
        assert_eq!(taught(&mut lasting, &bumped, 300), Vector6::zeros());
    }
}
