//! Whether every camera stayed where it was, and whether each is the one its name says.

use super::clocks::Clocked;
use super::solving::{Sightings, options};
use super::{RigError, RigSession};
use crate::adjustment::{Adjusted, Adjustment};
use crate::bundle::{BundleCamera, Freedom, solve};
use crate::intake::ImageView;
use nalgebra::Matrix6;
use sextant_estimator::Rig;
use sextant_geometry::{Pose, se3};

/// A camera whose images fit in one half of the time and not in the other has moved far.
const FITS: f64 = 0.7;
const FAILS: f64 = 0.3;
/// Images that a half needs to say anything.
const ENOUGH: usize = 6;
/// A move smaller than this does no harm: metres, radians. Further, it must exceed its deviation by so many.
const HARMLESS: (f64, f64) = (0.003, 0.004);
const SIGNIFICANT: f64 = 6.0;
/// Lenses are swapped if that divides the variance of the errors by so much.
const SWAPPED: f64 = 4.0;
/// Below this ratio of errors to stated noise nothing is wrong with the names.
const SUSPICIOUS: f64 = 2.0;

/// Finds a camera that was moved so far that its later images fit nowhere.
pub(super) fn check_at_start(
    rig: &Rig,
    sightings: &Sightings,
    first: &Adjustment,
) -> Result<(), RigError> {
    for (at, camera) in rig.cameras().iter().enumerate() {
        let own: Vec<usize> = (0..first.images.len())
            .filter(|&i| first.images[i].camera == at && !is_floor(sightings, first, i))
            .collect();
        let fits: Vec<bool> = own
            .iter()
            .map(|&i| !first.images[i].tags.is_empty())
            .collect();
        let Some(split) = best_split(&fits) else {
            continue;
        };
        let lost = own[..split]
            .iter()
            .chain(&own[split..])
            .filter(|&&i| first.images[i].tags.is_empty());
        let moves = lost.filter_map(|&i| {
            let image = &first.images[i];
            let object = sightings.object[image.view].first()?;
            let instant = &first.instants[image.instant].world_from_object;
            let there = instant * object.camera_from_object.inverse();
            Some(move_between(&first.cameras[at].world_from_camera, &there))
        });
        let (mm, deg) = median(moves.collect());
        return Err(RigError::Moved {
            camera: camera.id.clone(),
            mm,
            deg,
        });
    }
    Ok(())
}

fn is_floor(sightings: &Sightings, first: &Adjustment, image: usize) -> bool {
    let image = &first.images[image];
    let tags = image
        .tags
        .iter()
        .map(|&t| sightings.views[image.view].tags[t].tag);
    tags.clone().count() > 0 && tags.clone().all(|tag| tag >= sightings.n_carried)
}

/// Where images begin to fit or cease to; `None` if they do neither.
fn best_split(fits: &[bool]) -> Option<usize> {
    let n = fits.len();
    let part = |of: &[bool]| of.iter().filter(|f| **f).count() as f64 / of.len() as f64;
    let changes = |split: &usize| {
        let (before, after) = (part(&fits[..*split]), part(&fits[*split..]));
        before.max(after) >= FITS && before.min(after) <= FAILS
    };
    let contrast = |split: &usize| (part(&fits[..*split]) - part(&fits[*split..])).abs();
    (ENOUGH..n.saturating_sub(ENOUGH - 1))
        .filter(changes)
        .max_by(|a, b| contrast(a).total_cmp(&contrast(b)))
}

fn move_between(a: &Pose, b: &Pose) -> (f64, f64) {
    let apart = se3::difference(b, a);
    let (mm, rad) = (
        apart.fixed_rows::<3>(0).norm() * 1e3,
        apart.fixed_rows::<3>(3).norm(),
    );
    (mm, rad.to_degrees())
}

fn median(moves: Vec<(f64, f64)>) -> (f64, f64) {
    let middle = |mut of: Vec<f64>| {
        of.sort_by(f64::total_cmp);
        of.get(of.len() / 2).copied().unwrap_or(0.0)
    };
    let (mm, deg) = moves.into_iter().unzip();
    (middle(mm), middle(deg))
}

/// Finds a camera that moved a little: each is given a pose for either half of its images, and the two are compared.
pub(super) fn check(rig: &Rig, found: &Clocked, views: &[ImageView]) -> Result<(), RigError> {
    let n = rig.cameras().len();
    let halves = in_halves(&found.whole, &found.adjusted);
    let split: Vec<bool> = (0..n)
        .map(|at| {
            let count = |camera: usize| {
                halves
                    .images
                    .iter()
                    .filter(|i| i.camera == camera && !i.tags.is_empty())
                    .count()
            };
            count(at) >= ENOUGH && count(at + n) >= ENOUGH
        })
        .collect();
    let solution = solve(halves.bundle(views), &options())?;
    let mut worst: Option<(f64, RigError)> = None;
    for (at, camera) in rig
        .cameras()
        .iter()
        .enumerate()
        .filter(|(at, _)| split[*at])
    {
        let poses = [at, at + n].map(|c| solution.bundle.cameras[c].world_from_camera);
        let of = |c: usize| solution.covariance.camera(c).unwrap_or_else(Matrix6::zeros);
        let apart = se3::difference(&poses[1], &poses[0]);
        let Some(information) = (of(at) + of(at + n)).try_inverse() else {
            continue;
        };
        let sigmas = (apart.dot(&(information * apart)) / 6.0).max(0.0).sqrt();
        let (mm, deg) = move_between(&poses[0], &poses[1]);
        let harm = (mm * 1e-3 / HARMLESS.0).max(deg.to_radians() / HARMLESS.1);
        if sigmas > SIGNIFICANT && harm > 1.0 && worst.as_ref().is_none_or(|(w, _)| harm > *w) {
            let moved = RigError::Moved {
                camera: camera.id.clone(),
                mm,
                deg,
            };
            worst = Some((harm, moved));
        }
    }
    worst.map_or(Ok(()), |(_, moved)| Err(moved))
}

/// Every camera twice: as it is for the first half of its images, and again behind the last camera for the second.
fn in_halves(whole: &Adjustment, adjusted: &Adjusted) -> Adjustment {
    let n = whole.cameras.len();
    let mut halves = whole.clone();
    halves.cameras = adjusted.solution.bundle.cameras.clone();
    for camera in &mut halves.cameras {
        camera.clock = Freedom::Fixed;
    }
    let again = halves.cameras.iter().map(|camera| BundleCamera {
        pose: Freedom::Free,
        ..camera.clone()
    });
    let again: Vec<BundleCamera> = again.collect();
    halves.cameras.extend(again);
    for camera in 0..n {
        let own = || whole.images.iter().filter(|i| i.camera == camera);
        let middle = own()
            .nth(own().count() / 2)
            .map_or(0, |image| image.instant);
        for image in halves.images.iter_mut().filter(|i| i.camera == camera) {
            if image.instant >= middle {
                image.camera += n;
            }
        }
    }
    halves
}

impl RigSession {
    /// Finds two cameras whose images fit each other's lens far better than their own.
    pub(super) fn check_names(&self, adjusted: &Adjusted) -> Result<(), RigError> {
        let solution = &adjusted.solution;
        if solution.variance_factor < SUSPICIOUS * SUSPICIOUS {
            return Ok(());
        }
        let cameras = self.rig.cameras();
        for a in 0..cameras.len() {
            for b in a + 1..cameras.len() {
                if cameras[a].lens == cameras[b].lens
                    || cameras[a].resolution != cameras[b].resolution
                {
                    continue;
                }
                let mut bundle = solution.bundle.clone();
                (bundle.cameras[a].lens, bundle.cameras[b].lens) =
                    (cameras[b].lens, cameras[a].lens);
                let swapped = solve(bundle, &options())?;
                if swapped.variance_factor * SWAPPED < solution.variance_factor {
                    return Err(RigError::Swapped {
                        first: cameras[a].id.clone(),
                        second: cameras[b].id.clone(),
                    });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_fit_is_found_and_its_absence_too() {
        let change: Vec<bool> = (0..40).map(|at| at < 17).collect();
        assert_eq!(best_split(&change), Some(17));
        assert_eq!(best_split(&[true; 40]), None);
        let mixed: Vec<bool> = (0..40).map(|at| at % 3 > 0).collect();
        assert_eq!(best_split(&mixed), None);
        assert_eq!(best_split(&[]), None);
    }
}
