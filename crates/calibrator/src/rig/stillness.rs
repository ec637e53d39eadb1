//! Tests whether a camera moved during the recording, and whether camera names are swapped.

use super::comparison::{BETTER, MOST_INSTANTS, left_by, options};
use super::sightings::Sightings;
use super::{RigError, RigSession};
use crate::adjustment::{Adjustment, AdjustmentResult};
use nalgebra::{Matrix6, Vector6};
use sextant_adjustment::{Bundle, BundleCamera, FreeLens, Freedom, solve};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{Camera, Rig};

/// Shares of fitting images before and after a large move of a camera.
const FITS: f64 = 0.7;
const FAILS: f64 = 0.3;
/// Least number of images in each half.
const ENOUGH: usize = 6;
/// Largest harmless move: metres, radians. A larger one must also exceed its standard deviation by this factor.
const HARMLESS: (f64, f64) = (0.003, 0.004);
const SIGNIFICANT: f64 = 6.0;
/// Least relative difference of focal lengths by which swapped lenses can be distinguished from inaccurate ones.
const LENSES_DIFFER: f64 = 0.03;
/// Most pairs of cameras that are tested.
const MOST_SWAPS: usize = 30;

/// Finds a camera that moved so far that its later images do not fit.
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

/// Index at which images start or stop to fit; `None` if there is none.
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

/// Finds a camera that moved a little: separate poses for the two halves of its images explain them clearly better, and
/// the two differ significantly. The reference is assumed not to move. Returns the adjustment with the move.
pub(super) fn moved(
    rig: &Rig,
    found: &AdjustmentResult,
    sightings: &Sightings,
) -> Result<Option<(RigError, Bundle)>, RigError> {
    let n = rig.cameras().len();
    let whole = &found.with_misfits();
    let halves = in_halves(whole, sightings);
    let count = |camera: usize| halves.images.iter().filter(|i| i.camera == camera).count();
    let solution = solve(halves.bundle(&sightings.views), &options())?;
    let [before, after] = left_by(&whole.bundle(&sightings.views), &solution.bundle, n);
    let mut moves: Vec<(usize, f64, f64)> = Vec::new();
    for at in 0..n {
        let poses = [at, at + n].map(|c| solution.bundle.cameras[c].world_from_camera);
        let of = |c: usize| solution.covariance.camera(c).unwrap_or_else(Matrix6::zeros);
        let apart = se3::difference(&poses[1], &poses[0]);
        let Some(information) = (of(at) + of(at + n)).try_inverse() else {
            continue; // the reference
        };
        let sigmas = (apart.dot(&(information * apart)) / 6.0).max(0.0).sqrt();
        let (mm, deg) = move_between(&poses[0], &poses[1]);
        let enough = count(at) >= ENOUGH && count(at + n) >= ENOUGH;
        let explains = before[at] > BETTER * after[at];
        if enough && explains && sigmas > SIGNIFICANT && harm(mm, deg) > 1.0 {
            moves.push((at, mm, deg));
        }
    }
    let named = who_moved(rig, whole, moves);
    Ok(named.map(|moved| (moved, solution.bundle)))
}

/// The instant at which a camera moved, if it did: where the mean of the poses from its single images changes
/// most. The pose of the object in each image is that given by the other cameras.
fn likeliest_move(whole: &Adjustment, sightings: &Sightings, camera: usize) -> usize {
    let pose = &whole.cameras[camera].world_from_camera;
    let own = whole.images.iter().filter(|image| image.camera == camera);
    let off: Vec<(usize, Vector6<f64>)> = own
        .filter_map(|image| {
            let object = sightings.object[image.view].first()?;
            let instant = &whole.instants[image.instant].world_from_object;
            let there = instant * object.camera_from_object.inverse();
            let off = se3::difference(&there, pose) / MOVE_UNIT;
            Some((image.instant, off.map(|x| x.clamp(-MOVE_CLIP, MOVE_CLIP))))
        })
        .collect();
    let whole_sum: Vector6<f64> = off.iter().map(|(_, x)| x).sum();
    let (mut best, mut sum) = ((0.0, off.len() / 2), Vector6::zeros());
    for (at, (_, x)) in off.iter().enumerate() {
        let (before, after) = (at as f64, (off.len() - at) as f64);
        if at >= ENOUGH && off.len() - at >= ENOUGH {
            let change = sum / before - (whole_sum - sum) / after;
            let contrast = change.norm_squared() * before * after;
            if contrast > best.0 {
                best = (contrast, at);
            }
        }
        sum += x;
    }
    off.get(best.1).map_or(0, |(instant, _)| *instant)
}

/// Unit of moves, metres and radians, and the largest move of an image in that unit.
const MOVE_UNIT: f64 = 0.01;
const MOVE_CLIP: f64 = 5.0;

fn harm(mm: f64, deg: f64) -> f64 {
    (mm * 1e-3 / HARMLESS.0).max(deg.to_radians() / HARMLESS.1)
}

/// The camera that moved most; the reference where most others seem to have moved, since it was assumed not to.
fn who_moved(rig: &Rig, whole: &Adjustment, moves: Vec<(usize, f64, f64)>) -> Option<RigError> {
    let n = rig.cameras().len();
    let most =
        |a: &&(usize, f64, f64), b: &&(usize, f64, f64)| harm(a.1, a.2).total_cmp(&harm(b.1, b.2));
    let &(camera, mm, deg) = moves.iter().max_by(most)?;
    let reference = whole.cameras.iter().position(|c| c.pose == Freedom::Fixed);
    let all_others = n > 2 && 2 * moves.len() > n;
    let (camera, (mm, deg)) = match reference.filter(|_| all_others) {
        Some(reference) => {
            let seen = moves.iter().map(|m| (m.1, m.2));
            (reference, median(seen.collect()))
        }
        None => (camera, (mm, deg)),
    };
    Some(RigError::Moved {
        camera: rig.cameras()[camera].id.clone(),
        mm,
        deg,
    })
}

/// Every camera twice: for the first half of its images, and again after the last camera for the second.
fn in_halves(whole: &Adjustment, sightings: &Sightings) -> Adjustment {
    let n = whole.cameras.len();
    let mut halves = whole.clone();
    for camera in &mut halves.cameras {
        camera.clock = Freedom::Fixed;
        camera.free_lens = FreeLens::FIXED;
    }
    // The reference stays fixed: moves are relative to it.
    let again: Vec<BundleCamera> = halves.cameras.clone();
    halves.cameras.extend(again);
    for camera in 0..n {
        let middle = likeliest_move(whole, sightings, camera);
        for image in halves.images.iter_mut().filter(|i| i.camera == camera) {
            if image.instant >= middle {
                image.camera += n;
            }
        }
    }
    halves
}

impl RigSession {
    /// Two cameras whose lenses explain the images far better when swapped.
    pub(super) fn swapped_names(
        &self,
        sightings: &Sightings,
        first: &Adjustment,
    ) -> Option<RigError> {
        let error = |first: &Adjustment, sightings: &Sightings| {
            let mut part = first.clone();
            for camera in &mut part.cameras {
                camera.free_lens = FreeLens::FIXED;
            }
            part.images.retain(|image| image.instant < MOST_INSTANTS);
            part.instants.truncate(MOST_INSTANTS);
            solve(part.bundle(&sightings.views), &options())
                .ok()
                .map(|s| s.cost)
        };
        let as_named = error(first, sightings)?;
        let n = self.images.rig.cameras().len();
        let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
        for (a, b) in pairs
            .filter(|&(a, b)| self.swappable(a, b))
            .take(MOST_SWAPS)
        {
            let mut cameras = self.images.rig.cameras().to_vec();
            (cameras[a].lens, cameras[b].lens) = (cameras[b].lens, cameras[a].lens);
            let mut swapped = self.clone();
            swapped.images.rig = Rig::new(cameras).ok()?;
            let Ok((sightings, first, _)) = swapped.first() else {
                continue;
            };
            if error(&first, &sightings).is_some_and(|cost| cost * BETTER < as_named) {
                return Some(self.swapped(a, b));
            }
        }
        None
    }

    fn swappable(&self, a: usize, b: usize) -> bool {
        let (a, b) = (&self.images.rig.cameras()[a], &self.images.rig.cameras()[b]);
        let focal = |camera: &Camera| camera.lens.intrinsics().fx;
        let apart = (focal(a) / focal(b)).ln().abs();
        a.resolution == b.resolution && (apart > LENSES_DIFFER || a.lens.model() != b.lens.model())
    }

    fn swapped(&self, a: usize, b: usize) -> RigError {
        RigError::Swapped {
            first: self.images.rig.cameras()[a].id.clone(),
            second: self.images.rig.cameras()[b].id.clone(),
        }
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
