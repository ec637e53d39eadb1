//! A first guess of where tags sit on an object, from images that show several of them.
//!
//! Two tags of one image propose up to four relative poses (two branches each); the right one recurs in every image
//! while the mirrored ones turn with the view. So each pair votes over its images, the strongest pairs make a spanning
//! tree, and the tree places every tag relative to its root.

use crate::graph::PoseGraph;
use crate::image_store::{TagSpec, TagView};
use crate::resection::{edge_px, tag_error_px};
use sextant_adjustment::{
    BodyId, Bundle, BundleCamera, BundleImage, BundleOptions, BundleTag, Freedom, Instant,
    TagObservation, solve,
};
use sextant_geometry::{Lens, Pose};
use std::collections::BTreeMap;

/// A tag in a group of images taken at one instant.
#[derive(Clone, Copy)]
pub(crate) struct GroupedView<'a> {
    pub lens: &'a Lens,
    /// Of the camera in the group's frame; the identity where the group is one image.
    pub group_from_camera: Pose,
    pub view: &'a TagView,
}

/// Tags seen at one instant.
pub(crate) type Group<'a> = Vec<GroupedView<'a>>;

/// Groups looked at of one pair: more add little.
const MOST_GROUPS: usize = 40;
/// Bound of the error of a pair's guess; and once it was adjusted to all groups.
const LOOSE: ErrorBound = ErrorBound {
    of_edge: 0.5,
    px: 4.0,
};
const TIGHT: ErrorBound = ErrorBound {
    of_edge: 0.15,
    px: 2.0,
};
/// Guesses that are adjusted, and by how much they differ at least, radians.
const MOST_CANDIDATES: usize = 4;
const APART_RAD: f64 = 0.15;
/// A rival that explains the groups worse by this sum of squares, in pixels, halves the strength.
const CLEAR: f64 = 20.0;
/// Noise that a guess is adjusted with, pixels.
const ROUGH_PX: f64 = 1.0;
/// Less agreement than this (in groups) joins nothing.
const LEAST_STRENGTH: f64 = 0.5;

/// Largest error of predicted corners, the sum of both parts.
#[derive(Clone, Copy)]
struct ErrorBound {
    /// Share of the tag's edge in the image.
    of_edge: f64,
    /// Pixels.
    px: f64,
}

impl ErrorBound {
    fn px(self, corners: &[nalgebra::Point2<f64>; 4]) -> f64 {
        self.of_edge * edge_px(corners) + self.px
    }
}

/// Tags joined by every pair's consensus; strength is the number of agreeing groups, less where a rival agrees with
/// them too.
pub(crate) fn joined_tags(groups: &[Group<'_>], wanted: &[TagSpec]) -> PoseGraph {
    let mut pairs: BTreeMap<[usize; 2], Vec<[GroupedView<'_>; 2]>> = BTreeMap::new();
    for group in groups {
        for (at, a) in group.iter().enumerate() {
            for b in &group[at + 1..] {
                match a.view.tag.cmp(&b.view.tag) {
                    std::cmp::Ordering::Less => {
                        pairs
                            .entry([a.view.tag, b.view.tag])
                            .or_default()
                            .push([*a, *b]);
                    }
                    std::cmp::Ordering::Greater => {
                        pairs
                            .entry([b.view.tag, a.view.tag])
                            .or_default()
                            .push([*b, *a]);
                    }
                    std::cmp::Ordering::Equal => {}
                }
            }
        }
    }
    let mut joined = PoseGraph::new(wanted.len());
    for (nodes, views) in pairs {
        let sizes = nodes.map(|tag| wanted[tag].size_m);
        if let Some((strength, pose)) = consensus(&thinned(views), sizes) {
            joined.join(nodes, strength, pose);
        }
    }
    joined
}

/// At most [`MOST_GROUPS`], evenly from all.
pub(crate) fn thinned<T: Copy>(views: Vec<T>) -> Vec<T> {
    let n = views.len();
    if n <= MOST_GROUPS {
        return views;
    }
    (0..MOST_GROUPS)
        .map(|at| views[at * n / MOST_GROUPS])
        .collect()
}

/// The relative pose that explains the groups best, and how many it explains. Candidates are refined on all groups
/// before they are compared: a mirrored one explains single images nearly as well as the right one where perspective is
/// weak.
fn consensus(views: &[[GroupedView<'_>; 2]], sizes: [f64; 2]) -> Option<(f64, Pose)> {
    let mut candidates: Vec<(f64, Pose)> = Vec::new();
    for [a, b] in views {
        for of_a in &a.view.branches {
            for of_b in &b.view.branches {
                let group_from_a = a.group_from_camera * of_a;
                let candidate = group_from_a.inverse() * (b.group_from_camera * of_b);
                let votes = views
                    .iter()
                    .map(|pair| vote(pair, &candidate, sizes, LOOSE));
                candidates.push((votes.sum(), candidate));
            }
        }
    }
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut apart: Vec<Pose> = Vec::new();
    for (votes, pose) in candidates {
        let is_new = |other: &Pose| other.rotation.angle_to(&pose.rotation) > APART_RAD;
        if votes >= LEAST_STRENGTH && apart.len() < MOST_CANDIDATES && apart.iter().all(is_new) {
            apart.push(pose);
        }
    }
    let judged = apart.iter().filter_map(|pose| refined(views, pose, sizes));
    let mut judged: Vec<(f64, Pose)> = judged.collect();
    judged.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (cost, best) = *judged.first()?;
    let votes = views.iter().map(|pair| vote(pair, &best, sizes, TIGHT));
    let votes = votes.sum::<f64>();
    // Where another candidate explains the groups as well, the best of them may be the wrong one.
    let is_other = |pose: &Pose| pose.rotation.angle_to(&best.rotation) > APART_RAD;
    let rival = judged.iter().find(|(_, pose)| is_other(pose));
    let clear = rival.map_or(1.0, |(other, _)| (other - cost) / (other - cost + CLEAR));
    (votes >= LEAST_STRENGTH).then_some((votes * clear, best))
}

/// The relative pose adjusted to all groups, with the first tag as the object's frame, and the sum of the robust
/// squares.
fn refined(views: &[[GroupedView<'_>; 2]], pose: &Pose, sizes: [f64; 2]) -> Option<(f64, Pose)> {
    let tag = |at: usize, object_from_tag: Pose| BundleTag {
        object_from_tag,
        size_m: sizes[at],
        pose: if at == 0 {
            Freedom::Fixed
        } else {
            Freedom::Free
        },
        size: Freedom::Fixed,
        scale: None,
    };
    let mut bundle = Bundle {
        tags: vec![tag(0, Pose::identity()), tag(1, *pose)],
        ..Bundle::default()
    };
    for (instant, pair) in views.iter().enumerate() {
        let nearest = nearest_object(pair, pose, sizes)?;
        for (tag, seen) in pair.iter().enumerate() {
            bundle.cameras.push(BundleCamera {
                pose: Freedom::Fixed,
                ..BundleCamera::with_known_lens(*seen.lens, seen.group_from_camera)
            });
            bundle.images.push(BundleImage {
                camera: bundle.cameras.len() - 1,
                instant,
                seconds_after_instant: 0.0,
                stamp_error_s: 0.0,
                tags: vec![TagObservation::with_sigma(
                    tag,
                    seen.view.corners.corners,
                    ROUGH_PX,
                )],
            });
        }
        bundle
            .instants
            .push(Instant::at_rest(BodyId::Moving(0), 0.0, nearest));
    }
    let options = BundleOptions {
        max_iterations: 15,
        ..BundleOptions::default()
    };
    let solution = solve(bundle, &options).ok()?;
    Some((solution.cost, solution.bundle.tags[1].object_from_tag))
}

/// `group_from_object` by the branch of either tag of a pair that explains the corners of both best; the object's frame
/// is the first tag, and `pose` that of the second one in it.
fn nearest_object(pair: &[GroupedView<'_>; 2], pose: &Pose, sizes: [f64; 2]) -> Option<Pose> {
    let [a, b] = pair;
    let of_a = a
        .view
        .branches
        .iter()
        .map(|a_pose| a.group_from_camera * a_pose);
    let of_b = b.view.branches.iter();
    let of_b = of_b.map(|b_pose| b.group_from_camera * b_pose * pose.inverse());
    let error = |group_from_object: &Pose| -> f64 {
        let places = [Pose::identity(), *pose].into_iter().zip(sizes);
        let errors = pair.iter().zip(places).map(|(seen, (place, size_m))| {
            let at = seen.group_from_camera.inverse() * group_from_object * place;
            tag_error_px(seen.lens, &at, size_m, &seen.view.corners.corners).unwrap_or(1e3)
        });
        errors.sum()
    };
    of_a.chain(of_b)
        .min_by(|x, y| error(x).total_cmp(&error(y)))
}

/// From 0 to 1: how well each tag of the pair predicts the other's corners, by its better branch.
fn vote(
    [a, b]: &[GroupedView<'_>; 2],
    a_from_b: &Pose,
    [size_a, size_b]: [f64; 2],
    bound: ErrorBound,
) -> f64 {
    let forth = predicted(a, b, a_from_b, size_b, bound);
    let back = predicted(b, a, &a_from_b.inverse(), size_a, bound);
    0.5 * (forth + back)
}

fn predicted(
    known: &GroupedView<'_>,
    other: &GroupedView<'_>,
    known_from_other: &Pose,
    size_m: f64,
    bound: ErrorBound,
) -> f64 {
    let camera_from_known = other.group_from_camera.inverse() * known.group_from_camera;
    let corners = &other.view.corners.corners;
    let bound_px = bound.px(corners);
    let votes = known.view.branches.iter().filter_map(|branch| {
        let pose = camera_from_known * branch * known_from_other;
        let error = tag_error_px(other.lens, &pose, size_m, corners)?;
        Some((1.0 - error / bound_px).max(0.0))
    });
    votes.fold(0.0, f64::max)
}
