//! Initial instants of the adjustment: poses of the object over time, and the tags on the floor.

use super::sightings::Sightings;
use super::trajectory::{SAME_TIME_NS, twist};
use crate::adjustment::UsedImage;
use crate::resection::agreeing_loosely;
use nalgebra::Vector6;
use sextant_adjustment::{BodyId, BundleCamera, Instant};
use sextant_geometry::Pose;
use sextant_geometry::least_squares::Kernel;

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
    let groups: Vec<&[usize]> = order.chunk_by(same).collect();
    let candidates = groups
        .iter()
        .map(|group| (seconds(group[0]), candidates(sightings, cameras, group)));
    for (group, pose) in groups
        .iter()
        .zip(smoothest(&candidates.collect::<Vec<_>>()))
    {
        let Some(pose) = pose else {
            continue;
        };
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

/// A pose that the images of one time allow.
#[derive(Clone, Copy)]
struct Candidate {
    world_from_object: Pose,
    /// Tags of all images that agree with it.
    n_agreeing: usize,
}

/// The poses that the images of one time allow.
fn candidates(sightings: &Sightings, cameras: &[BundleCamera], group: &[usize]) -> Vec<Candidate> {
    let proposals = group.iter().flat_map(|&at| {
        let camera = &cameras[sightings.views[at].camera];
        let object = sightings.object[at].iter();
        object.map(move |o| camera.world_from_camera * o.camera_from_object)
    });
    let scored = proposals.map(|world_from_object| {
        let fits = group.iter().map(|&at| {
            let view = &sightings.views[at];
            let camera = &cameras[view.camera];
            let camera_from_object = camera.world_from_camera.inverse() * world_from_object;
            agreeing_loosely(&camera.lens, view, &sightings.placed, &camera_from_object).len()
        });
        Candidate {
            world_from_object,
            n_agreeing: fits.sum(),
        }
    });
    scored.collect()
}

/// Cost of each tag that does not agree with a pose, in squared standard deviations.
const DISAGREEING: f64 = 16.0;
/// Standard deviations of the change of a pose from one time to a later one, m and rad: of both poses, and a second of
/// a hand's motion.
const CHANGE: [(f64, f64); 2] = [(0.02, 0.5), (0.1, 3.0)];

/// For each time the pose of the most plausible sequence (dynamic programming; A. Viterbi, 1967): the mirrored pose of
/// a single tag fits its image, but not the times before and after. `None` where there is no candidate.
fn smoothest(times: &[(f64, Vec<Candidate>)]) -> Vec<Option<Pose>> {
    let mut costs: Vec<f64> = Vec::new();
    let mut last: Option<&(f64, Vec<Candidate>)> = None;
    // Of each candidate the one before it in the best sequence.
    let mut before: Vec<Vec<usize>> = Vec::with_capacity(times.len());
    for time in times
        .iter()
        .filter(|(_, candidates)| !candidates.is_empty())
    {
        let best = time.1.iter().map(|candidate| {
            let earlier = last.iter().flat_map(|(seconds, earlier)| {
                let dt = time.0 - seconds;
                earlier
                    .iter()
                    .zip(&costs)
                    .map(move |(from, cost)| cost + change(from, candidate, dt))
            });
            let best = earlier.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            best.unwrap_or((0, 0.0))
        });
        let best: Vec<(usize, f64)> = best.collect();
        let most = time.1.iter().map(|candidate| candidate.n_agreeing).max();
        let disagreeing = time.1.iter().map(|c| most.unwrap_or(0) - c.n_agreeing);
        costs = best
            .iter()
            .zip(disagreeing)
            .map(|((_, cost), n)| cost + DISAGREEING * n as f64)
            .collect();
        before.push(best.into_iter().map(|(from, _)| from).collect());
        last = Some(time);
    }
    let mut at = (0..costs.len())
        .min_by(|a, b| costs[*a].total_cmp(&costs[*b]))
        .unwrap_or(0);
    let mut poses: Vec<Option<Pose>> = Vec::with_capacity(times.len());
    for (_, candidates) in times.iter().rev() {
        poses.push(
            candidates
                .get(at)
                .map(|candidate| candidate.world_from_object),
        );
        if !candidates.is_empty() {
            at = before.pop().map_or(0, |from| from[at]);
        }
    }
    poses.reverse();
    poses
}

/// How implausible a change of pose is, in squared standard deviations, bounded by a kernel: an object may be taken
/// away and come back.
fn change(from: &Candidate, to: &Candidate, dt: f64) -> f64 {
    let [from, to] = [from, to].map(|candidate| &candidate.world_from_object);
    let moved = (to.translation.vector - from.translation.vector).norm();
    let turned = from.rotation.angle_to(&to.rotation);
    let squares = [moved, turned].into_iter().zip(CHANGE);
    let squares =
        squares.map(|(change, (of_poses, a_second))| (change / (of_poses + a_second * dt)).powi(2));
    Kernel::CauchyTails { width: 3.0 }.rho(squares.sum())
}

/// Least time before and after an instant over which its initial twist is the mean: over less, the errors of two
/// poses would be a twist of any size.
const TWIST_OVER_S: f64 = 0.02;
/// Longest such time; farther poses say nothing of the twist.
const TWIST_WITHIN_S: f64 = 0.5;

/// Initial twists, from instants before and after each.
pub(crate) fn give_twists(instants: &mut [Instant]) {
    let twists: Vec<_> = (0..instants.len())
        .map(|at| initial_twist(instants, at).unwrap_or_default())
        .collect();
    for (instant, twist) in instants.iter_mut().zip(twists) {
        instant.twist = twist;
    }
}

/// Mean twist about an instant; `None` where no other is near.
fn initial_twist(instants: &[Instant], at: usize) -> Option<Vector6<f64>> {
    let here = &instants[at];
    let of_body = |other: &&Instant| {
        let apart_s = (other.seconds - here.seconds).abs();
        other.body == here.body && apart_s < TWIST_WITHIN_S
    };
    let is_apart = |other: &&Instant| (other.seconds - here.seconds).abs() >= TWIST_OVER_S;
    let before = instants[..at].iter().rev().take_while(of_body);
    let after = instants[at + 1..].iter().take_while(of_body);
    let from = before
        .clone()
        .find(is_apart)
        .or(before.last())
        .unwrap_or(here);
    let to = after
        .clone()
        .find(is_apart)
        .or(after.last())
        .unwrap_or(here);
    let dt = to.seconds - from.seconds;
    (dt > 0.5 * TWIST_OVER_S).then(|| twist(&from.world_from_object, &to.world_from_object, dt))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Vector3};

    fn turned(angle: f64) -> Candidate {
        Candidate {
            world_from_object: Isometry3::new(Vector3::z(), Vector3::x() * angle),
            n_agreeing: 1,
        }
    }

    #[test]
    fn mirrored_poses_do_not_enter_the_start_even_where_they_join_the_right_ones() {
        // From the frontal pose on both branches are continuous; only the last image tells which is right.
        let angles = (0..10).map(|k| 0.1 * f64::from(k));
        let mut times: Vec<(f64, Vec<Candidate>)> = angles
            .enumerate()
            .map(|(k, angle)| (0.03 * k as f64, vec![turned(-angle), turned(angle)]))
            .collect();
        times.insert(4, (0.1, Vec::new()));
        times.push((0.3, vec![turned(1.0)]));
        let found = smoothest(&times);
        assert!(found[4].is_none());
        for (pose, (_, candidates)) in found.iter().zip(&times) {
            let Some(right) = candidates.last() else {
                continue;
            };
            assert_eq!(*pose, Some(right.world_from_object));
        }
    }

    #[test]
    fn instants_that_are_almost_one_have_no_absurd_twist() {
        let at = |seconds: f64, x: f64| {
            Instant::at_rest(BodyId::Moving(0), seconds, Pose::translation(x, 0.0, 1.0))
        };
        // 1 m/s, and an error of 5 mm a tenth of a millisecond later.
        let mut instants: Vec<Instant> = (0..20)
            .flat_map(|k| [0.0, 1e-4].map(|after| 0.033 * f64::from(k) + after))
            .enumerate()
            .map(|(k, seconds)| at(seconds, seconds + if k % 2 == 0 { 0.0 } else { 5e-3 }))
            .collect();
        give_twists(&mut instants);
        for instant in &instants {
            assert!((instant.twist.x - 1.0).abs() < 0.2, "{}", instant.twist.x);
        }
        let mut alone = vec![at(0.0, 0.0)];
        give_twists(&mut alone);
        assert_eq!(alone[0].twist, Vector6::zeros());
    }
}
