//! The network of a site: processes hang on routers, links keep the order of messages, and what is wrong follows from
//! the plan.
//!
//! A link through which nothing passes holds messages back for a while, as the buffers of a connection do; after
//! [`LEASE_NS`] it is closed, what it held is lost, and it is opened again some time after the cause is gone.

use crate::plan::{Fault, FaultKind, MS, Place, Plan};
use sextant_simulator::Random;
use std::collections::BTreeMap;
use std::ops::Range;

/// Silence after which a link counts as dead: the nodes' default.
pub const LEASE_NS: u64 = 2_000 * MS;
/// A message that may be dropped waits so long in the buffers of a connection.
const PATIENCE_NS: u64 = 1_000 * MS;

/// Which way along a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Way {
    Up,
    Down,
    /// Between routers, from this one.
    Across(usize),
}

/// When nothing passes because of a fault.
struct Gap {
    stops: Range<u64>,
    /// When the link is closed because of it, if it is.
    closed: Option<Range<u64>>,
}

/// Where messages pass when.
#[derive(Debug)]
pub struct Network {
    faults: Vec<Fault>,
    /// Time from the end of a cause until a closed link is open again, by fault.
    reopening_ns: Vec<u64>,
    routers: usize,
    random: Random,
    /// The last arrival of each process at each other one.
    last_ns: BTreeMap<(Place, Place), u64>,
}

/// A way to or from a process, or between routers.
#[derive(Clone, Copy)]
struct Hop {
    /// `None` between routers.
    place: Option<Place>,
    way: Way,
}

impl Hop {
    fn new(place: Option<Place>, way: Way) -> Self {
        Self { place, way }
    }
}

impl Network {
    /// Of a plan.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        let mut random = Random::from_keys(&[plan.seed, 0x6e65_7477]);
        let reopening = plan.faults.iter();
        Self {
            reopening_ns: reopening
                .map(|_| 50 * MS + random.below(1000) as u64 * MS)
                .collect(),
            faults: plan.faults.clone(),
            routers: plan.routers,
            random,
            last_ns: BTreeMap::new(),
        }
    }

    fn router(&self, place: Place) -> usize {
        let index = match place {
            Place::Fusion(index) | Place::Camera(index) => index,
            Place::Client => 0,
        };
        index % self.routers
    }

    fn gap(&self, index: usize, hop: Hop) -> Option<Gap> {
        let fault = &self.faults[index];
        let Hop { place, way } = hop;
        let is_of_place = place.is_some() && fault.kind.place() == place;
        let router = place.map(|place| self.router(place));
        let reopened_ns = fault.until_ns + self.reopening_ns[index];
        let at_once = fault.from_ns..reopened_ns;
        let outlasts = fault.until_ns - fault.from_ns > LEASE_NS;
        let after_lease = outlasts.then_some(fault.from_ns + LEASE_NS..reopened_ns);
        let (stops, closed) = match fault.kind {
            FaultKind::Cut(_) | FaultKind::Paused(_) if is_of_place => (true, after_lease),
            FaultKind::Deaf(_) if is_of_place => (way == Way::Down, after_lease),
            FaultKind::Mute(_) if is_of_place => (way == Way::Up, after_lease),
            FaultKind::Killed(_) | FaultKind::PowerOff(_) if is_of_place => (true, Some(at_once)),
            FaultKind::Parted if place.is_none() => (true, after_lease),
            FaultKind::RouterDown(down) if router.is_none_or(|router| router == down) => {
                (true, Some(at_once))
            }
            _ => return None,
        };
        let until_ns = if stops { fault.until_ns } else { fault.from_ns };
        let stops = fault.from_ns..until_ns;
        Some(Gap { stops, closed })
    }

    fn gaps(&self, hop: Hop) -> impl Iterator<Item = Gap> {
        (0..self.faults.len()).filter_map(move |index| self.gap(index, hop))
    }

    /// Whether the link of a process to its router is open.
    #[must_use]
    pub fn is_linked(&self, place: Place, at_ns: u64) -> bool {
        self.is_open(Hop::new(Some(place), Way::Up), at_ns)
    }

    fn is_open(&self, hop: Hop, at_ns: u64) -> bool {
        let mut closed = self.gaps(hop).filter_map(|gap| gap.closed);
        !closed.any(|closed| closed.contains(&at_ns))
    }

    /// Whether the routers have each other and those of two processes, so that tokens of one are seen by the other.
    #[must_use]
    pub fn sees(&self, one: Place, other: Place, at_ns: u64) -> bool {
        let between = self.router(one) == self.router(other)
            || self.is_open(Hop::new(None, Way::Across(0)), at_ns);
        between && self.is_linked(one, at_ns) && self.is_linked(other, at_ns)
    }

    /// Whether messages have passed in both directions between two processes for so long, without delay.
    #[must_use]
    pub fn is_sound(&self, one: Place, other: Place, for_ns: u64, at_ns: u64) -> bool {
        let mut hops = vec![Some(one), Some(other)];
        if self.router(one) != self.router(other) {
            hops.push(None);
        }
        let since_ns = at_ns.saturating_sub(for_ns);
        self.faults.iter().enumerate().all(|(index, fault)| {
            let touches = hops.iter().any(|place| match fault.kind {
                FaultKind::Parted => place.is_none(),
                FaultKind::RouterDown(down) => place.is_none_or(|place| self.router(place) == down),
                _ => place.is_some() && fault.kind.place() == *place,
            });
            let ends_ns = match fault.kind {
                FaultKind::SlowDisk(..) | FaultKind::FullDisk(_) => 0,
                FaultKind::Overloaded(..) | FaultKind::Slow(..) => fault.until_ns + 1000 * MS,
                FaultKind::Killed(_) | FaultKind::PowerOff(_) => {
                    fault.until_ns + LEASE_NS + 1000 * MS
                }
                _ => fault.until_ns + self.reopening_ns[index],
            };
            !touches || fault.from_ns > at_ns || ends_ns < since_ns
        })
    }

    /// The times at which links open and close, and processes come and go.
    #[must_use]
    pub fn turning_points(&self) -> Vec<u64> {
        let mut points: Vec<u64> = (self.faults.iter().zip(&self.reopening_ns))
            .flat_map(|(fault, reopening_ns)| {
                let reopened_ns = fault.until_ns + reopening_ns;
                [
                    fault.from_ns,
                    fault.from_ns + LEASE_NS,
                    fault.until_ns,
                    reopened_ns,
                ]
            })
            .collect();
        points.sort_unstable();
        points.dedup();
        points
    }

    /// When a message of one process reaches another; never, where it is lost. `may_drop` of those that a congested
    /// network drops.
    pub fn arrival_ns(
        &mut self,
        from: Place,
        to: Place,
        at_ns: u64,
        may_drop: bool,
    ) -> Option<u64> {
        let (first, last) = (self.router(from), self.router(to));
        let at_ns = self.pass(Hop::new(Some(from), Way::Up), at_ns, may_drop)?;
        let at_ns = match first == last {
            true => at_ns,
            false => self.pass(Hop::new(None, Way::Across(first)), at_ns, may_drop)?,
        };
        let arrival_ns = self.pass(Hop::new(Some(to), Way::Down), at_ns, may_drop)?;
        let last_ns = self.last_ns.entry((from, to)).or_default();
        *last_ns = (*last_ns).max(arrival_ns);
        Some(*last_ns)
    }

    fn pass(&mut self, hop: Hop, at_ns: u64, may_drop: bool) -> Option<u64> {
        let mut leaves_ns = at_ns;
        // A gap may follow upon another.
        for _ in 0..self.faults.len() {
            let holds = |gap: &Gap| {
                let closed = gap.closed.as_ref();
                gap.stops.contains(&leaves_ns)
                    || closed.is_some_and(|closed| closed.contains(&leaves_ns))
            };
            let Some(Gap { stops, closed }) = self.gaps(hop).find(holds) else {
                break;
            };
            let until_ns = stops.end;
            if closed.is_some() || may_drop && until_ns - at_ns > PATIENCE_NS {
                return None;
            }
            leaves_ns = until_ns;
        }
        let mut delay_ns = 100_000 + self.random.below(200_000) as u64;
        for fault in &self.faults {
            let is_of_hop = hop.place.is_some() && fault.kind.place() == hop.place;
            match fault.kind {
                FaultKind::Slow(_, by_ns) if is_of_hop && fault.lasts(leaves_ns) => {
                    delay_ns += self.random.below(by_ns as usize) as u64;
                }
                FaultKind::Lossy(_, share)
                    if is_of_hop
                        && may_drop
                        && fault.lasts(leaves_ns)
                        && self.random.chance(share) =>
                {
                    return None;
                }
                _ => {}
            }
        }
        Some(leaves_ns + delay_ns)
    }
}
