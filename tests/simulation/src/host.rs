//! The clocks of a host, by true time.

use crate::plan::{Fault, FaultKind, Place, S};
use sextant_election::Moment;

/// Of the true time 0.
const BEGINNING_NS: u64 = 1_800_000_000 * S;

/// The wall clock at a true time, of a host whose clock was off by `off_ns` in the initial.
#[must_use]
pub fn wall_ns(faults: &[Fault], place: Place, off_ns: i64, at_ns: u64) -> u64 {
    let set_by = faults.iter().map(|fault| match fault.kind {
        FaultKind::ClockSet(of, by_ns) if of == place && at_ns >= fault.from_ns => by_ns,
        _ => 0,
    });
    (BEGINNING_NS + at_ns).saturating_add_signed(off_ns + set_by.sum::<i64>())
}

/// The true time of a wall clock that is right.
#[must_use]
pub fn true_ns(wall_ns: u64) -> u64 {
    wall_ns.saturating_sub(BEGINNING_NS)
}

/// The clock of a process: wire time follows the monotonic clock until a step is taken, as that of the nodes does.
#[derive(Debug)]
pub struct ProcessClock {
    offset_ns: i64,
}

impl ProcessClock {
    /// Read at a true time.
    #[must_use]
    pub fn new(wall_ns: u64, at_ns: u64) -> Self {
        Self {
            offset_ns: wall_ns.cast_signed() - at_ns.cast_signed(),
        }
    }

    /// The step of the wall clock since the last call, if there was one.
    pub fn take_step(&mut self, wall_ns: u64, at_ns: u64) -> Option<i64> {
        let offset_ns = wall_ns.cast_signed() - at_ns.cast_signed();
        let by_ns = offset_ns - std::mem::replace(&mut self.offset_ns, offset_ns);
        (by_ns.unsigned_abs() >= sextant_process::SteadyClock::LEAST_STEP_NS).then_some(by_ns)
    }

    /// Both clocks at a true time. The monotonic one counts from long before.
    #[must_use]
    pub fn moment(&self, at_ns: u64) -> Moment {
        Moment {
            monotonic_ns: at_ns + 1000 * S,
            wall_ns: at_ns.saturating_add_signed(self.offset_ns),
        }
    }
}
