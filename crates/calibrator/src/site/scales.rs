//! Whether the given sizes of two bodies contradict each other: cameras are as far apart by one body as by the other.

use super::constellations::{Constellations, sightings};
use super::members::{BodyViews, Members};
use crate::rig::pairs::joined_cameras;
use crate::rig::trajectory::{Moments, Trajectory, is_synchronised};
use nalgebra::Point3;
use sextant_geometry::Pose;
use sextant_site_model::Rig;

/// A body whose tags are not as large as given, or all others are not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ScaleContradiction {
    pub body: usize,
    /// The body by whose sizes all lengths are.
    pub trusted: usize,
    /// Its lengths by those that follow from the given sizes.
    pub ratio: f64,
}

/// Logarithm of a ratio that is no error of approximate poses.
const CLEAR: f64 = 0.03;

/// Bodies whose sizes contradict those of the trusted one: the one with which most others agree and, of equals, that
/// with most images.
pub(super) fn contradictions(
    rig: &Rig,
    members: &Members,
    seen: &BodyViews,
    known: &Constellations,
) -> Vec<ScaleContradiction> {
    let sightings = sightings(rig, members, seen, known);
    let n = rig.cameras().len();
    let trajectory = |body: usize, camera: usize| {
        let views = seen
            .of_body(Some(body))
            .filter(|&at| seen.views[at].camera == camera);
        let sighting = |at: usize| {
            let poses = sightings.object[at].iter().map(|o| o.camera_from_object);
            (seen.views[at].capture_ns, poses.collect())
        };
        Trajectory::from_sightings(views.map(sighting).collect())
    };
    let centres = |body: usize| {
        let own: Vec<Trajectory> = (0..n).map(|camera| trajectory(body, camera)).collect();
        let moments = match is_synchronised(&own) {
            true => Moments::Exact,
            false => Moments::Interpolated,
        };
        let joined = joined_cameras(&[own], moments);
        (0..n).map(|root| joined.placed(root)).collect::<Vec<_>>()
    };
    let bodies: Vec<Vec<Vec<Option<Pose>>>> = (0..members.n_bodies).map(centres).collect();
    let log_ratio = |a: usize, b: usize| log_ratio(&bodies[a], &bodies[b]);
    let agreeing = |body: &usize| {
        let others = (0..members.n_bodies).filter_map(|other| log_ratio(*body, other));
        others.filter(|ratio| ratio.abs() < CLEAR).count()
    };
    let trusted = (0..members.n_bodies).max_by_key(|body| {
        let n_images = seen.of_body(Some(*body)).count();
        (agreeing(body), n_images, std::cmp::Reverse(*body))
    });
    let Some(trusted) = trusted else {
        return Vec::new();
    };
    let found = (0..members.n_bodies).filter_map(|body| {
        let ratio = log_ratio(body, trusted)?;
        (ratio.abs() > CLEAR).then_some(ScaleContradiction {
            body,
            trusted,
            ratio: ratio.exp(),
        })
    });
    found.collect()
}

/// Logarithm of the median ratio of the cameras' distances by one body over those by another.
fn log_ratio(one: &[Vec<Option<Pose>>], other: &[Vec<Option<Pose>>]) -> Option<f64> {
    let distance = |of: &[Vec<Option<Pose>>], a: usize, b: usize| {
        let place = |pose: Pose| Point3::from(pose.translation.vector);
        Some((place(of[a][b]?) - place(of[a][a]?)).norm()).filter(|m| *m > 0.0)
    };
    let pairs = (0..one.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let ratios =
        pairs.filter_map(|(a, b)| Some((distance(other, a, b)? / distance(one, a, b)?).ln()));
    let mut ratios: Vec<f64> = ratios.collect();
    ratios.sort_by(f64::total_cmp);
    ratios.get(ratios.len() / 2).copied()
}
