//! The cameras' clocks: sought always where shutters run free, and where they are synchronised only if the images say so.

use super::instants::give_twists;
use super::solving::{Sightings, options};
use super::{RigError, stillness};
use crate::adjustment::{Adjusted, Adjustment};
use crate::bundle::{Freedom, KeptParameter, Motion, solve};
use crate::intake::ImageView;
use sextant_estimator::Rig;

/// A person's hand: half a metre per second is reached or lost in a third of a second.
const CARRIED: Motion = Motion {
    acceleration: 2.5,
    angular_acceleration: 8.0,
    longest_gap_s: 0.6,
};
/// A synchronised camera's clock is off if its offset exceeds this many of its deviations, and this many seconds.
const SIGNIFICANT: f64 = 6.0;
const HARMFUL_S: f64 = 0.002;
/// Instants that are asked about the clocks.
pub(super) const ASKED: usize = 300;
/// One explanation is nearly as good as another if it leaves less than so many times its error, clearly better beyond.
pub(super) const BETTER: f64 = 1.5;

/// A camera's clock: seconds to be added to its time, one standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clock {
    pub offset_s: f64,
    pub sigma_s: f64,
}

/// The adjustment with its clocks, and what it was made of.
pub(super) struct Clocked {
    pub adjusted: Adjusted,
    /// As it was before tags were left out, at the estimates found.
    pub whole: Adjustment,
}

/// By camera; `None` where the clock was taken as it is.
pub(super) type Clocks = Vec<Option<Clock>>;

/// Clocks that are clearly off although shutters are synchronised; `None` if none is.
pub(super) fn off(whole: &Adjustment, views: &[ImageView]) -> Result<Option<Clocks>, RigError> {
    let mut asked = asked_clocks(whole, views)?;
    for clock in &mut asked {
        *clock = clock
            .filter(|c| c.offset_s.abs() > HARMFUL_S && c.offset_s.abs() > SIGNIFICANT * c.sigma_s);
    }
    Ok(asked.iter().any(Option::is_some).then_some(asked))
}

/// Synchronised shutters: clocks are taken as they are but for those that are off.
///
/// A camera that moved looks like a wrong clock, and with few images a second the object's modelled motion bends to fit
/// anything: a move that explains the images nearly as well is believed first.
pub(super) fn of_synchronised(
    rig: &Rig,
    whole: Adjustment,
    sightings: &Sightings,
    off: Option<Clocks>,
) -> Result<(Clocked, Clocks), RigError> {
    let views = &sightings.views;
    let adjusted = whole.clone().solve(views, &options())?;
    let Some(off) = off else {
        let clocks = vec![None; whole.cameras.len()];
        return Ok((Clocked { adjusted, whole }, clocks));
    };
    let still = Clocked { adjusted, whole };
    let halves = stillness::halves(rig, &still, sightings)?;
    let mut moving = still.whole;
    moving.motion = Some(CARRIED);
    for (camera, clock) in moving.cameras.iter_mut().zip(off) {
        if let Some(clock) = clock {
            camera.clock = Freedom::Free;
            camera.clock_offset_s = clock.offset_s;
        }
    }
    let start = moving.bundle(views);
    let explained = solve(start, &options())?.cost;
    match halves.moved {
        Some(moved) if halves.cost < BETTER * explained => Err(moved),
        _ => solved(moving, views),
    }
}

/// Free-running shutters: the object moves between images, and every clock but the reference's is sought.
pub(super) fn of_free_running(
    mut whole: Adjustment,
    views: &[ImageView],
) -> Result<(Clocked, Clocks), RigError> {
    free_clocks(&mut whole);
    solved(whole, views)
}

fn solved(whole: Adjustment, views: &[ImageView]) -> Result<(Clocked, Clocks), RigError> {
    let adjusted = whole.clone().solve(views, &options())?;
    let clocks = clocks(&adjusted.solution);
    Ok((Clocked { adjusted, whole }, clocks))
}

fn free_clocks(whole: &mut Adjustment) {
    whole.motion = Some(CARRIED);
    for camera in &mut whole.cameras {
        camera.clock = camera.pose; // the reference's is the world's
    }
}

/// What a part of the images says of every clock.
fn asked_clocks(whole: &Adjustment, views: &[ImageView]) -> Result<Clocks, RigError> {
    let mut part = whole.clone();
    free_clocks(&mut part);
    let most = part.instants.len().min(ASKED);
    part.images.retain(|image| image.instant < most);
    part.instants.truncate(most);
    give_twists(&mut part.instants);
    Ok(clocks(&solve(part.bundle(views), &options())?))
}

fn clocks(solution: &crate::bundle::BundleSolution) -> Clocks {
    let cameras = solution.bundle.cameras.iter().enumerate();
    let clock = cameras.map(|(at, camera)| {
        let sigma_s = solution
            .covariance
            .sigma(KeptParameter::Clock { camera: at })?;
        Some(Clock {
            offset_s: camera.clock_offset_s,
            sigma_s,
        })
    });
    clock.collect()
}
