//! Initial instants of the adjustment: poses of the object over time, and the tags on the floor.

use super::sightings::Sightings;
use super::trajectory::{SAME_TIME_NS, twist};
use crate::adjustment::UsedImage;
use crate::resection::agreeing_loosely;
use sextant_adjustment::{BodyId, BundleCamera, Instant};
use sextant_geometry::Pose;

/// An instant for every tag on the floor, seen by all images that show it.
pub(crate) fn floor(
    sightings: &Sightings,
    cameras: &[BundleCamera],
) -> (Vec<Instant>, Vec<UsedImage>) {
    let views: Vec<usize> = (0..sightings.views.len()).collect();
    floor_in(&views, sightings, cameras)
}

/// As [`floor`], of some of the views, by index.
pub(crate) fn floor_in(
    of: &[usize],
    sightings: &Sightings,
    cameras: &[BundleCamera],
) -> (Vec<Instant>, Vec<UsedImage>) {
    let (mut instants, mut images) = (Vec::new(), Vec::new());
    for tag in sightings.n_carried..sightings.placed.len() {
        let own = of.iter().filter_map(|&at| {
            let tags = &sightings.views[at].tags;
            let seen = tags.iter().position(|t| t.tag == tag)?;
            Some((at, seen))
        });
        let own: Vec<(usize, usize)> = own.collect();
        let proposals = own.iter().flat_map(|&(at, seen)| {
            let view = &sightings.views[at];
            let camera = &cameras[view.camera].world_from_camera;
            view.tags[seen]
                .branches
                .iter()
                .map(move |branch| camera * branch)
        });
        let proposals: Vec<Pose> = proposals.collect();
        let Some(pose) = nearest_to_all(&proposals) else {
            continue;
        };
        images.extend(own.iter().map(|&(view, seen)| UsedImage {
            view,
            camera: sightings.views[view].camera,
            instant: instants.len(),
            seconds_after_instant: 0.0,
            stamp_error_s: 0.0,
            tags: vec![seen],
        }));
        instants.push(Instant::at_rest(BodyId::Still(tag), 0.0, pose));
    }
    (instants, images)
}

/// The pose with the most close neighbours.
fn nearest_to_all(poses: &[Pose]) -> Option<Pose> {
    let near = |a: &Pose, b: &Pose| {
        let apart = a.inverse() * b;
        (1.0 - apart.rotation.angle() / 0.2).max(0.0)
            * (1.0 - apart.translation.vector.norm() / 0.2).max(0.0)
    };
    let stride = poses.len().div_ceil(60).max(1);
    let votes = poses
        .iter()
        .step_by(stride)
        .map(|a| (poses.iter().map(|b| near(a, b)).sum::<f64>(), a));
    votes
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, pose)| *pose)
}

/// An instant for every time at which images show the object.
pub(crate) fn carried(
    sightings: &Sightings,
    cameras: &[BundleCamera],
    instants: &mut Vec<Instant>,
    images: &mut Vec<UsedImage>,
) {
    let views: Vec<usize> = (0..sightings.views.len()).collect();
    carried_in(
        &views,
        BodyId::Moving(0),
        sightings,
        cameras,
        instants,
        images,
    );
    give_twists(instants);
}

/// As [`carried`], of some of the views (by index), and without initial twists.
pub(crate) fn carried_in(
    of: &[usize],
    body: BodyId,
    sightings: &Sightings,
    cameras: &[BundleCamera],
    instants: &mut Vec<Instant>,
    images: &mut Vec<UsedImage>,
) {
    let views = &sightings.views;
    let seeing = of.iter().copied();
    let mut order: Vec<usize> = seeing
        .filter(|&at| !sightings.object[at].is_empty())
        .collect();
    order.sort_by_key(|&at| (views[at].capture_ns, views[at].camera));
    let Some(start_ns) = order.first().map(|&at| views[at].capture_ns) else {
        return;
    };
    let seconds = |at: usize| (views[at].capture_ns - start_ns) as f64 * 1e-9;
    let same = |a: &usize, b: &usize| views[*b].capture_ns - views[*a].capture_ns <= SAME_TIME_NS;
    let mut before: Option<Pose> = None;
    for group in order.chunk_by(same) {
        let Some(pose) = best_pose(sightings, cameras, group, before.as_ref()) else {
            continue;
        };
        before = Some(pose);
        let fitting = |at: usize| {
            let camera = &cameras[views[at].camera];
            let camera_from_object = camera.world_from_camera.inverse() * pose;
            agreeing_loosely(
                &camera.lens,
                &views[at],
                &sightings.placed,
                &camera_from_object,
            )
        };
        images.extend(group.iter().map(|&at| UsedImage {
            view: at,
            camera: views[at].camera,
            instant: instants.len(),
            seconds_after_instant: seconds(at) - seconds(group[0]),
            stamp_error_s: 0.0,
            tags: fitting(at),
        }));
        instants.push(Instant::at_rest(body, seconds(group[0]), pose));
    }
}

/// The pose with which most tags of all images agree; among equals the one nearest to the previous instant.
fn best_pose(
    sightings: &Sightings,
    cameras: &[BundleCamera],
    group: &[usize],
    before: Option<&Pose>,
) -> Option<Pose> {
    let proposals = group.iter().flat_map(|&at| {
        let camera = &cameras[sightings.views[at].camera];
        let object = sightings.object[at].iter();
        object.map(move |o| camera.world_from_camera * o.camera_from_object)
    });
    let scored = proposals.map(|pose| {
        let fits = group.iter().map(|&at| {
            let view = &sightings.views[at];
            let camera = &cameras[view.camera];
            let camera_from_object = camera.world_from_camera.inverse() * pose;
            agreeing_loosely(&camera.lens, view, &sightings.placed, &camera_from_object).len()
        });
        let turned = before.map_or(0.0, |b| b.rotation.angle_to(&pose.rotation));
        (fits.sum::<usize>(), turned, pose)
    });
    let best = scored.max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    best.map(|(_, _, pose)| pose)
}

/// Initial twists, from the neighbours of each instant.
pub(crate) fn give_twists(instants: &mut [Instant]) {
    let twists: Vec<_> = (0..instants.len())
        .map(|at| {
            let (from, to) = (at.saturating_sub(1), (at + 1).min(instants.len() - 1));
            let (from, to) = (&instants[from], &instants[to]);
            let dt = to.seconds - from.seconds;
            (from.body == to.body && 0.0 < dt && dt < 1.0)
                .then(|| twist(&from.world_from_object, &to.world_from_object, dt))
        })
        .collect();
    for (instant, twist) in instants.iter_mut().zip(twists) {
        instant.twist = twist.unwrap_or_default();
    }
}
