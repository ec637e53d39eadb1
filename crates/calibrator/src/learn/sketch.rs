//! A preview of the growing constellation: approximate poses of the connected tags from a few images, fast enough for
//! display.

use super::LearnSession;
use super::places::Groups;
use crate::constellation::joined_tags;
use crate::graph::PoseGraph;
use serde::Serialize;

/// Approximate pose of a tag in the frame of the sketch's first tag, within millimetres and degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SketchedTag {
    /// Family and number, as text.
    pub tag: String,
    /// Edge of its black square, metres.
    pub size_m: f64,
    /// Position, metres.
    pub position: [f64; 3],
    /// Quaternion x, y, z, w.
    pub orientation: [f64; 4],
}

impl LearnSession {
    /// The largest group of connected tags, in the frame of its first tag; empty before two are connected.
    pub fn sketch(&self) -> Vec<SketchedTag> {
        let views = self.coverage.sample();
        let groups = Groups::from_views(&self.images.rig, views);
        let joints = joined_tags(&groups.seen(&self.images.rig, views), &self.images.wanted);
        let Some(root) = first_of_largest(&joints) else {
            return Vec::new();
        };
        let placed = joints.placed(root).into_iter().zip(&self.images.wanted);
        let sketched = placed.filter_map(|(pose, wanted)| {
            let pose = pose?;
            Some(SketchedTag {
                tag: wanted.tag.to_string(),
                size_m: wanted.size_m,
                position: pose.translation.vector.into(),
                orientation: pose.rotation.coords.into(),
            })
        });
        sketched.collect()
    }
}

/// The first node of the largest island of two nodes or more.
fn first_of_largest(joints: &PoseGraph) -> Option<usize> {
    let islands = joints.islands();
    let size = |island: &usize| islands.iter().filter(|of| *of == island).count();
    let largest = (0..islands.len()).max_by_key(|node| (size(node), std::cmp::Reverse(*node)));
    largest.filter(|node| size(node) > 1)
}
