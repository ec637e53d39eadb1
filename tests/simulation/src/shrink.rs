//! Finds out what of a plan a broken promise does not need.

use crate::plan::Plan;
use crate::world::run;

/// Numbers of the faults and requests without which a plan breaks the same promise, for [`Plan::without`].
#[must_use]
pub fn superfluous(plan: &Plan, promise: &str) -> Vec<usize> {
    let breaks = |numbers: &[usize]| {
        let broken = run(&plan.without(numbers), false).broken;
        broken.is_some_and(|broken| broken.promise == promise)
    };
    let mut numbers = Vec::new();
    for number in 0..plan.faults.len() + plan.requests.len() {
        numbers.push(number);
        if !breaks(&numbers) {
            numbers.pop();
        }
    }
    numbers
}
