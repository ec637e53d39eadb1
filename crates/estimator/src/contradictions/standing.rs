//! Which cameras contradict the others.

use std::collections::BTreeMap;

use crate::fading_counter::FadingCounter;

/// Instants, fading, from which on their share means something.
const FEWEST: f64 = 2.5;
/// Share of its instants from which on a camera contradicts, and up to which it agrees.
const CONTRADICTS: f64 = 0.6;
const AGREES: f64 = 0.3;
/// Instants in which it agreed with another after which a camera has been right once.
const CONFIRMED: usize = 5;

/// How a camera's views have compared with those of others.
#[derive(Debug, Clone, Copy, Default)]
struct Standing {
    /// Instants with other cameras, and those in which it contradicted.
    instants: FadingCounter,
    n_agreed: usize,
    is_suspended: bool,
}

/// The standings of all cameras, by index.
#[derive(Debug, Default)]
pub(crate) struct Standings(BTreeMap<usize, Standing>);

impl Standings {
    /// Notes the cameras that saw a body at one instant, each with whether it contradicts.
    pub fn record(&mut self, time_ns: u64, cameras: &[(usize, bool)]) {
        if cameras.len() < 2 {
            return;
        }
        let n_agreeing = cameras.iter().filter(|(_, is_wrong)| !is_wrong).count();
        for (camera, is_wrong) in cameras {
            let standing = self.0.entry(*camera).or_default();
            standing.instants.add(time_ns, *is_wrong);
            if !is_wrong && n_agreeing > 1 {
                standing.n_agreed = standing.n_agreed.saturating_add(1);
            }
        }
        self.decide(time_ns);
    }

    /// Suspends the cameras that contradict others that are right: two of those, or one if this camera has been right
    /// before. One that agrees again is back.
    fn decide(&mut self, time_ns: u64) {
        let faded = |standing: &Standing| standing.instants.faded(time_ns);
        let is_sound = |standing: &Standing| {
            let instants = faded(standing);
            !standing.is_suspended && instants.total >= FEWEST && instants.share() <= AGREES
        };
        let n_sound = self.0.values().filter(|one| is_sound(one)).count();
        for standing in self.0.values_mut() {
            let instants = faded(standing);
            if instants.total < FEWEST {
                continue;
            }
            let least = if standing.n_agreed >= CONFIRMED { 1 } else { 2 };
            let is_wrong = instants.share() >= CONTRADICTS && n_sound >= least;
            let is_right = instants.share() <= AGREES;
            standing.is_suspended = is_wrong || (standing.is_suspended && !is_right);
        }
    }

    /// Whether a camera contradicts others that are right.
    pub fn is_suspended(&self, camera: usize) -> bool {
        self.0.get(&camera).is_some_and(|one| one.is_suspended)
    }

    /// Whether a camera has agreed with others before.
    pub fn is_confirmed(&self, camera: usize) -> bool {
        let standing = self.0.get(&camera);
        standing.is_some_and(|standing| standing.n_agreed >= CONFIRMED)
    }

    /// The cameras that contradict others that are right.
    pub fn suspended(&self) -> impl Iterator<Item = usize> {
        let suspended = self.0.iter().filter(|(_, one)| one.is_suspended);
        suspended.map(|(camera, _)| *camera)
    }
}
