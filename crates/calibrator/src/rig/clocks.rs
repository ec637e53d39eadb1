//! Clock offsets of the cameras: always estimated for free-running shutters, and for synchronised ones only if the images show them.

use super::RigError;
use super::comparison::{BETTER, MOST_INSTANTS, left_by, options};
use super::instants::give_twists;
use crate::adjustment::{Adjustment, AdjustmentResult};
use crate::bundle::{Bundle, Freedom, KeptParameter, Motion, solve};
use crate::image_store::ImageView;

/// Motion of a hand-held object, which gains or loses half a metre per second in a third of a second.
const CARRIED: Motion = Motion {
    acceleration: 2.5,
    angular_acceleration: 8.0,
    longest_gap_s: 0.6,
};
/// A synchronised camera's clock is off if its offset exceeds this many of its deviations, and this many seconds.
const SIGNIFICANT: f64 = 6.0;
const HARMFUL_S: f64 = 0.002;
/// A camera's clock: seconds to be added to its time, one standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clock {
    pub offset_s: f64,
    pub sigma_s: f64,
}

/// Clock of each camera; `None` if it was not estimated.
pub(super) type Clocks = Vec<Option<Clock>>;

/// Clocks that are clearly off although shutters are synchronised; `None` if none is.
fn off(adjusted: &Adjustment, views: &[ImageView]) -> Result<Option<Clocks>, RigError> {
    let mut asked = asked_clocks(adjusted, views)?;
    for clock in &mut asked {
        *clock = clock
            .filter(|c| c.offset_s.abs() > HARMFUL_S && c.offset_s.abs() > SIGNIFICANT * c.sigma_s);
    }
    Ok(asked.iter().any(Option::is_some).then_some(asked))
}

/// Clock offsets of synchronised shutters, if they explain the images clearly better than clocks that agree; with the first solution
/// as the start of an adjustment.
pub(super) fn of_synchronised(
    still: &AdjustmentResult,
    views: &[ImageView],
) -> Result<Option<(Adjustment, Bundle)>, RigError> {
    let Some(off) = off(&still.adjustment, views)? else {
        return Ok(None);
    };
    let mut moving = still.with_misfits();
    let agreeing = moving.bundle(views);
    moving.motion = Some(CARRIED);
    give_twists(&mut moving.instants);
    for (camera, clock) in moving.cameras.iter_mut().zip(off) {
        if let Some(clock) = clock {
            camera.clock = Freedom::Free;
            camera.clock_offset_s = clock.offset_s;
        }
    }
    let explained = solve(moving.bundle(views), &options())?.bundle;
    let left = left_by(&agreeing, &explained, moving.cameras.len());
    let [agreeing, left] = left.map(|cameras| cameras.iter().sum::<f64>());
    Ok((left * BETTER < agreeing).then_some((moving, explained)))
}

/// Free-running shutters: the object moves between images, and every clock but the reference's is free.
pub(super) fn of_free_running(
    mut whole: Adjustment,
    views: &[ImageView],
) -> Result<(AdjustmentResult, Clocks), RigError> {
    free_clocks(&mut whole);
    solved(whole, views)
}

/// Solves with free clocks.
pub(super) fn solved(
    whole: Adjustment,
    views: &[ImageView],
) -> Result<(AdjustmentResult, Clocks), RigError> {
    let adjusted = whole.solve(views, &options())?;
    let clocks = clocks(&adjusted.solution);
    Ok((adjusted, clocks))
}

fn free_clocks(whole: &mut Adjustment) {
    whole.motion = Some(CARRIED);
    for camera in &mut whole.cameras {
        camera.clock = camera.pose; // the reference clock is that of the world
    }
}

/// Clocks estimated from a part of the images.
fn asked_clocks(whole: &Adjustment, views: &[ImageView]) -> Result<Clocks, RigError> {
    let mut part = whole.clone();
    free_clocks(&mut part);
    let most = part.instants.len().min(MOST_INSTANTS);
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
