//! Clock offsets of the cameras: always estimated for free-running shutters, and for synchronised ones only if the
//! images show them.

use super::RigError;
use super::comparison::{BETTER, MOST_INSTANTS, left_by, options};
use super::instants::give_twists;
use crate::adjustment::{Adjustment, AdjustmentResult};
use crate::image_store::ImageView;
use sextant_adjustment::{
    Bundle, BundleCamera, BundleOptions, BundleSolution, FreeLens, Freedom, KeptParameter, Motion,
    solve,
};
use sextant_geometry::least_squares::Kernel;
use sextant_site_model::{CLOCK_SIGMA_S, Camera, READOUT_SIGMA_S};
use std::collections::BTreeSet;

/// Motion of a hand-held object, which gains or loses half a metre per second in a third of a second.
const CARRIED: Motion = Motion {
    acceleration: 2.5,
    angular_acceleration: 8.0,
    longest_gap_s: 0.6,
};
/// A synchronised camera's clock is off if its offset exceeds this many of its deviations, and this many seconds.
const SIGNIFICANT: f64 = 6.0;
const HARMFUL_S: f64 = 0.002;
/// A camera's clock: by how many seconds it is ahead, one standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clock {
    pub offset_s: f64,
    pub sigma_s: f64,
}

/// Clock of each camera; `None` if it was not estimated.
pub(crate) type Clocks = Vec<Option<Clock>>;

/// Seconds from a row to the next and their standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineDelay {
    pub line_delay_s: f64,
    pub sigma_s: f64,
}

/// Shortest readout that matters, seconds.
const LEAST_READOUT_S: f64 = 1e-3;

/// The row whose time is the capture time.
pub(crate) fn middle_row(camera: &Camera) -> f64 {
    (f64::from(camera.resolution[1]) - 1.0) / 2.0
}

/// Estimated line delay of a camera; `None` if it was known or no motion was modelled.
pub(crate) fn line_delay(solution: &BundleSolution, camera: usize) -> Option<LineDelay> {
    let parameter = KeptParameter::LineDelay { camera };
    Some(LineDelay {
        line_delay_s: solution.bundle.cameras[camera].line_delay_s,
        sigma_s: solution.covariance.sigma(parameter)?,
    })
}

impl LineDelay {
    /// Whether a shutter rolls; the line delay of a global one is zero within its deviation.
    pub(crate) fn is_rolling(&self, camera: &Camera) -> bool {
        let readout_s = self.line_delay_s.abs() * f64::from(camera.resolution[1]);
        readout_s > LEAST_READOUT_S && self.line_delay_s.abs() > SIGNIFICANT * self.sigma_s
    }
}

/// What the images of synchronised shutters show of time.
struct Timing {
    /// Clocks that are clearly off; `None` for others.
    clocks: Clocks,
    /// Line delays of shutters that clearly roll.
    line_delays: Vec<Option<f64>>,
}

/// Clocks that are clearly off and shutters that clearly roll; `None` if there are none.
fn timing(adjusted: &Adjustment, views: &[ImageView]) -> Result<Option<Timing>, RigError> {
    let mut part = adjusted.excerpt(MOST_INSTANTS);
    free_clocks(&mut part);
    free_line_delays(&mut part);
    give_twists(&mut part.instants);
    let solution = solve(part.bundle(views), &options())?;
    let is_off =
        |c: &Clock| c.offset_s.abs() > HARMFUL_S && c.offset_s.abs() > SIGNIFICANT * c.sigma_s;
    let clocks = clocks(&solution).into_iter().map(|c| c.filter(is_off));
    let rolling = |at: usize| {
        let n_rows = 2.0 * part.cameras[at].middle_row + 1.0;
        let found = line_delay(&solution, at)?;
        let readout_s = found.line_delay_s.abs() * n_rows;
        let clear = found.line_delay_s.abs() > SIGNIFICANT * found.sigma_s;
        (clear && readout_s > HARMFUL_S).then_some(found.line_delay_s)
    };
    let timing = Timing {
        clocks: clocks.collect(),
        line_delays: (0..part.cameras.len()).map(rolling).collect(),
    };
    let is_any = timing.clocks.iter().any(Option::is_some)
        || timing.line_delays.iter().any(Option::is_some)
        || adjusted.cameras.iter().any(is_known_to_roll);
    Ok(is_any.then_some(timing))
}

/// Most steps of a factor of two by which a density of acceleration is changed.
const MOST_STEPS: usize = 5;

/// The model with the densities of acceleration for which its images have most evidence. Too large ones attribute the
/// errors of a line delay to the speed of the object, as in a regression with errors in both variables.
fn likeliest_motion(model: Adjustment, views: &[ImageView]) -> Result<Adjustment, RigError> {
    let mut best = weighed(model, views)?;
    for scale in [scaled_acceleration, scaled_angular_acceleration] {
        for factor in [0.5, 2.0] {
            let before = best.0;
            for _ in 0..MOST_STEPS {
                let mut other = best.1.clone();
                other.motion = other.motion.map(|motion| scale(motion, factor));
                let other = weighed(other, views)?;
                if other.0 <= best.0 {
                    break;
                }
                best = other;
            }
            if best.0 > before {
                break;
            }
        }
    }
    Ok(best.1)
}

fn scaled_acceleration(motion: Motion, factor: f64) -> Motion {
    Motion {
        acceleration: motion.acceleration * factor,
        ..motion
    }
}

fn scaled_angular_acceleration(motion: Motion, factor: f64) -> Motion {
    Motion {
        angular_acceleration: motion.angular_acceleration * factor,
        ..motion
    }
}

fn is_known_to_roll(camera: &BundleCamera) -> bool {
    camera.line_delay == Freedom::Fixed && camera.line_delay_s != 0.0
}

/// Clock offsets and rolling shutters of synchronised cameras, if they explain the images clearly better than clocks
/// that agree and global shutters, or are known; with the first solution as the start of an adjustment.
pub(crate) fn of_synchronised(
    still: &AdjustmentResult,
    views: &[ImageView],
) -> Result<Option<(Adjustment, Bundle)>, RigError> {
    let Some(timing) = timing(&still.adjustment, views)? else {
        return Ok(None);
    };
    let mut moving = still.with_misfits();
    let agreeing = moving.bundle(views);
    moving.motion = Some(CARRIED);
    give_twists(&mut moving.instants);
    let is_known = moving.cameras.iter().any(is_known_to_roll);
    for at in 0..moving.cameras.len() {
        if let Some(clock) = timing.clocks[at] {
            moving.cameras[at].clock = Freedom::Free;
            moving.cameras[at].clock_offset_s = clock.offset_s;
        }
        if let Some(line_delay_s) = timing.line_delays[at] {
            free_line_delay(&mut moving, at);
            moving.cameras[at].line_delay_s = line_delay_s;
        }
    }
    let part = held(moving.excerpt(MOST_INSTANTS));
    moving.motion = likeliest_motion(part, views)?.motion;
    let explained = solve(moving.bundle(views), &options())?.bundle;
    let left = left_by(&agreeing, &explained, moving.cameras.len());
    let [agreeing, left] = left.map(|cameras| cameras.iter().sum::<f64>());
    let is_clearer = is_known || left * BETTER < agreeing;
    Ok(is_clearer.then_some((moving, explained)))
}

/// Standard deviations of the errors of single stamps that are tried: of arrival over a radio, in a program, in a
/// driver, of a trigger.
const STAMP_SIGMAS_S: [f64; 5] = [0.03, 0.01, 0.003, 0.001, 0.0];
/// Largest number of cameras for which the jitter is chosen camera by camera.
const MOST_DISTINGUISHED: usize = 12;
/// Difference of logarithms of evidence that speaks very strongly for a model (R. Kass and A. Raftery, Bayes factors,
/// 1995).
const VERY_STRONG: f64 = 5.0;
/// Motion and errors of stamps in the first solution, whose cameras may be off.
const LOOSELY: Motion = Motion {
    acceleration: 8.0,
    angular_acceleration: 24.0,
    ..CARRIED
};
const FIRST_STAMP_SIGMA_S: f64 = 0.01;

/// Free-running shutters: the object moves between images. How the clocks behave is what the images have most evidence
/// for: clocks that agree or, where that explains them far better, have constant offsets; stamps of each camera that
/// are exact or jitter.
pub(crate) fn of_free_running(
    mut whole: Adjustment,
    views: &[ImageView],
) -> Result<(AdjustmentResult, Clocks), RigError> {
    whole.noise = noise_of_single_images(&whole, views)?;
    let mut held = held(whole.clone());
    free_clocks(&mut held);
    free_line_delays(&mut held);
    let mut strictly = held.clone();
    strictly.take(&solve(strictly.bundle(views), &options())?.bundle);
    held.motion = Some(LOOSELY);
    for camera in &mut held.cameras {
        camera.stamp_sigma_s = FIRST_STAMP_SIGMA_S;
    }
    let mut loosely = weighed(held, views)?.1;
    loosely.motion = Some(CARRIED);
    let (strictly, loosely) = (weighed(strictly, views)?, weighed(loosely, views)?);
    // Either alone ends in a local minimum now and then.
    let (_, held) = if strictly.0 > loosely.0 {
        strictly
    } else {
        loosely
    };
    let found = likeliest_clocks(&held.excerpt(MOST_INSTANTS), views)?;
    let found = likeliest_motion(found, views)?;
    (whole.motion, whole.instants, whole.images) = (found.motion, held.instants, held.images);
    if has_offsets(&found) {
        free_clocks(&mut whole);
    }
    free_line_delays(&mut whole);
    for (camera, found) in whole.cameras.iter_mut().zip(&found.cameras) {
        camera.line_delay_s = found.line_delay_s;
        camera.world_from_camera = found.world_from_camera;
        camera.clock_offset_s = found.clock_offset_s;
        camera.stamp_sigma_s = found.stamp_sigma_s;
    }
    whole.anchor_anew();
    solved(whole, views)
}

fn has_offsets(model: &Adjustment) -> bool {
    let mut cameras = model.cameras.iter();
    cameras.any(|camera| camera.clock == Freedom::Free)
}

/// Solves a model and returns the logarithm of its evidence with it. The kernel is wide, because an outlier no longer
/// constrains its instant, which the evidence would reward. Instants are moved to the capture times of their images by
/// the estimated clocks, because the motion between an instant and its image is assumed to be uniform.
fn weighed(mut model: Adjustment, views: &[ImageView]) -> Result<(f64, Adjustment), RigError> {
    let widely = BundleOptions {
        kernel: Kernel::CauchyTails { width: 50.0 },
        ..options()
    };
    let mut evidence = f64::NEG_INFINITY;
    for _ in 0..if has_offsets(&model) { 2 } else { 1 } {
        let solution = solve(model.bundle(views), &widely)?;
        model.take(&solution.bundle);
        model.anchor_anew();
        evidence = solution.log_evidence.unwrap_or(evidence);
    }
    Ok((evidence, model))
}

/// The clock model with the most evidence, starting from a solution with free offsets.
fn likeliest_clocks(start: &Adjustment, views: &[ImageView]) -> Result<Adjustment, RigError> {
    let mut agreeing = start.clone();
    for camera in &mut agreeing.cameras {
        (camera.clock, camera.clock_offset_s) = (Freedom::Fixed, 0.0);
    }
    agreeing.anchor_anew();
    let mut best: Option<(f64, Adjustment)> = None;
    for start in [agreeing, start.clone()] {
        let margin = if has_offsets(&start) {
            VERY_STRONG
        } else {
            0.0
        };
        let mut last = start;
        for sigma_s in STAMP_SIGMAS_S {
            for camera in &mut last.cameras {
                camera.stamp_sigma_s = sigma_s;
            }
            let (evidence, found) = weighed(last, views)?;
            last = found;
            let evidence = evidence - margin;
            if best.as_ref().is_none_or(|(most, _)| evidence > *most) {
                best = Some((evidence, last.clone()));
            }
        }
    }
    let Some((mut evidence, mut model)) = best else {
        return Ok(start.clone());
    };
    let n = model.cameras.len();
    for at in (0..n).filter(|_| n <= MOST_DISTINGUISHED) {
        let own_s = model.cameras[at].stamp_sigma_s;
        let own = STAMP_SIGMAS_S.iter().position(|sigma_s| *sigma_s == own_s);
        let own = own.unwrap_or(0);
        for next in [own.checked_sub(1), Some(own + 1)] {
            let Some(sigma_s) = next.and_then(|next| STAMP_SIGMAS_S.get(next)) else {
                continue;
            };
            let mut other = model.clone();
            other.cameras[at].stamp_sigma_s = *sigma_s;
            let other = weighed(other, views)?;
            if other.0 > evidence {
                (evidence, model) = other;
            }
        }
    }
    Ok(model)
}

/// The adjustment with lenses and tags fixed.
fn held(mut whole: Adjustment) -> Adjustment {
    for camera in &mut whole.cameras {
        camera.free_lens = FreeLens::FIXED;
    }
    for tag in &mut whole.tags {
        (tag.pose, tag.size) = (Freedom::Fixed, Freedom::Fixed);
    }
    whole
}

/// Corner noise of each camera where every image has its own pose of the object, so that no model of time is in it.
fn noise_of_single_images(whole: &Adjustment, views: &[ImageView]) -> Result<Vec<f64>, RigError> {
    let mut alone = held(whole.clone());
    for camera in &mut alone.cameras {
        camera.pose = Freedom::Fixed;
    }
    let solution = solve(alone.bundle(views), &options())?;
    alone.measure_noise(&solution.bundle, 6.0 * alone.instants.len() as f64);
    Ok(alone.noise)
}

/// Solves with free clocks.
pub(crate) fn solved(
    whole: Adjustment,
    views: &[ImageView],
) -> Result<(AdjustmentResult, Clocks), RigError> {
    let adjusted = whole.solve(views, &options())?;
    let clocks = clocks(&adjusted.solution);
    Ok((adjusted, clocks))
}

/// The clock of the reference is that of the world.
fn free_clocks(whole: &mut Adjustment) {
    whole.motion.get_or_insert(CARRIED);
    for at in 0..whole.cameras.len() {
        if whole.cameras[at].pose == Freedom::Free {
            whole
                .priors
                .free_clock(&mut whole.cameras, at, CLOCK_SIGMA_S);
        }
    }
}

/// Frees the line delays of cameras with images, unless they are known.
fn free_line_delays(whole: &mut Adjustment) {
    let used: BTreeSet<usize> = whole.images.iter().map(|image| image.camera).collect();
    for at in used {
        if !is_known_to_roll(&whole.cameras[at]) {
            free_line_delay(whole, at);
        }
    }
}

fn free_line_delay(whole: &mut Adjustment, camera: usize) {
    let n_rows = 2.0 * whole.cameras[camera].middle_row + 1.0;
    let sigma_s = READOUT_SIGMA_S / n_rows;
    whole
        .priors
        .free_line_delay(&mut whole.cameras, camera, sigma_s);
}

fn clocks(solution: &BundleSolution) -> Clocks {
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
