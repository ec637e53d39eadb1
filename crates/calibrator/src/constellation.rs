//! A first guess of where tags sit on an object, from images that show several of them.
//!
//! Two tags of one image propose up to four relative poses (two branches each); the right one recurs in every image while the
//! mirrored ones turn with the view. So each pair votes over its images, the strongest pairs make a spanning tree, and the
//! tree places every tag relative to its root.

use crate::graph::PoseGraph;
use crate::intake::{TagView, Wanted};
use crate::resection::{edge_px, tag_error_px};
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
/// A pair's guess may be off by this part of the tag's size in the image, and by pixels.
const BOUND: (f64, f64) = (0.5, 4.0);
/// Less agreement than this (in groups) joins nothing.
const LEAST_STRENGTH: f64 = 0.5;

/// Tags joined by every pair's consensus; strength is the number of agreeing groups.
pub(crate) fn joined_tags(groups: &[Group<'_>], wanted: &[Wanted]) -> PoseGraph {
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
fn thinned<T: Copy>(views: Vec<T>) -> Vec<T> {
    let n = views.len();
    if n <= MOST_GROUPS {
        return views;
    }
    (0..MOST_GROUPS)
        .map(|at| views[at * n / MOST_GROUPS])
        .collect()
}

/// The relative pose that most groups agree with, and how many do.
fn consensus(views: &[[GroupedView<'_>; 2]], sizes: [f64; 2]) -> Option<(f64, Pose)> {
    let mut best: Option<(f64, Pose)> = None;
    for [a, b] in views {
        for of_a in &a.view.branches {
            for of_b in &b.view.branches {
                let group_from_a = a.group_from_camera * of_a;
                let candidate = group_from_a.inverse() * (b.group_from_camera * of_b);
                let votes = views.iter().map(|pair| vote(pair, &candidate, sizes));
                let votes = votes.sum::<f64>();
                if best.as_ref().is_none_or(|(most, _)| votes > *most) {
                    best = Some((votes, candidate));
                }
            }
        }
    }
    best.filter(|(votes, _)| *votes >= LEAST_STRENGTH)
}

/// From 0 to 1: how well each tag of the pair predicts the other's corners, by its better branch.
fn vote([a, b]: &[GroupedView<'_>; 2], a_from_b: &Pose, [size_a, size_b]: [f64; 2]) -> f64 {
    let forth = predicted(a, b, a_from_b, size_b);
    let back = predicted(b, a, &a_from_b.inverse(), size_a);
    0.5 * (forth + back)
}

fn predicted(
    known: &GroupedView<'_>,
    other: &GroupedView<'_>,
    known_from_other: &Pose,
    size_m: f64,
) -> f64 {
    let camera_from_known = other.group_from_camera.inverse() * known.group_from_camera;
    let corners = &other.view.corners.corners;
    let bound = BOUND.0 * edge_px(corners) + BOUND.1;
    let votes = known.view.branches.iter().filter_map(|branch| {
        let pose = camera_from_known * branch * known_from_other;
        let error = tag_error_px(other.lens, &pose, size_m, corners)?;
        Some((1.0 - error / bound).max(0.0))
    });
    votes.fold(0.0, f64::max)
}
