//! Removes from a plan what a broken promise does not need.

use crate::plan::Plan;
use crate::world::run;

/// The plan with as few faults and requests as break the same promise.
#[must_use]
pub fn shrunk(plan: &Plan, promise: &str) -> Plan {
    let breaks = |plan: &Plan| {
        let broken = run(plan, false).broken;
        broken.is_some_and(|broken| broken.promise == promise)
    };
    let mut plan = plan.clone();
    let mut at = 0;
    while at < plan.faults.len() + plan.requests.len() {
        let mut less = plan.clone();
        match at < plan.faults.len() {
            true => drop(less.faults.remove(at)),
            false => drop(less.requests.remove(at - plan.faults.len())),
        }
        match breaks(&less) {
            true => plan = less,
            false => at += 1,
        }
    }
    plan
}
