//! An arm to try articulated objects on: a base that drifts about, an upper arm that turns on it, a forearm that nods.
//!
//! Each link is an object of the scenario; its path has the joints from the base to it. Three tags a link: on top and
//! on either side.

use super::{Scenario, SceneObject, SceneTag, Solid};
use crate::path::{Path, PathJoint, PathJointKind, Wave, about};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_tag_families::Family;
use std::f64::consts::FRAC_PI_2;

/// Thickness of the links, m.
const THICK: f64 = 0.056;
/// Edge of the tags, m; a print is a quarter larger.
const TAG: f64 = 0.04;
/// The links' ids.
const LINKS: [&str; 3] = ["arm-base", "arm-upper", "arm-fore"];

/// How an arm is built and moves.
struct Build {
    /// Length of the links, and where the middle of each lies on its x axis, m.
    links: [[f64; 2]; 3],
    /// Where the elbow sits on the upper arm's x axis, m, its limits and its value.
    elbow: (f64, [f64; 2], Wave),
    /// Mean place of the base, and how far it swings along x and y, m.
    place: [f64; 3],
    swing: f64,
    /// Number of its first tag.
    first_tag: usize,
}

impl Scenario {
    /// The demonstration's room and cameras (1 to 16) with an arm of two joints: objects `arm-base`, `arm-upper`,
    /// `arm-fore`, joints `shoulder` and `elbow`. The elbow swings from one of its limits to the other.
    pub fn arm(n_cameras: usize, seed: u64) -> Self {
        // The arm needs the room of four objects.
        let mut scenario = Self::demo(n_cameras, 4, seed);
        let build = Build {
            links: [[0.16, 0.0], [0.16, 0.07], [0.16, 0.12]],
            elbow: (0.19, [-1.0, 1.0], Wave::still(0.0).and(3, 1.0, 1.1)),
            place: [-0.06, 0.0, 0.12],
            swing: 0.05,
            first_tag: 0,
        };
        scenario.objects = build.objects();
        scenario
    }
}

/// How far from the middle of the table the arm of a demonstration reaches, m.
pub(super) const DEMO_REACH_M: f64 = 0.3;

/// An arm that keeps to the middle of the table, its forearm upright; its tags are numbered from `first_tag`.
pub(super) fn demo_arm(first_tag: usize) -> Vec<SceneObject> {
    let build = Build {
        links: [[0.16, 0.0], [0.13, 0.035], [0.12, 0.09]],
        elbow: (0.14, [-2.0, -1.0], Wave::still(-1.5).and(3, 0.5, 1.1)),
        place: [-0.05, 0.0, 0.08],
        swing: 0.02,
        first_tag,
    };
    build.objects()
}

impl Build {
    fn objects(&self) -> Vec<SceneObject> {
        (0..LINKS.len()).map(|index| link(self, index)).collect()
    }
}

fn link(build: &Build, index: usize) -> SceneObject {
    let [length, middle] = build.links[index];
    let solid = Solid::Box {
        size: [length, THICK, THICK],
        object_from_box: Pose::translation(middle, 0.0, 0.0),
        albedo: 0.3 + 0.1 * index as f64,
    };
    // What hangs on the base must not hide its tags.
    let tags_at = if index == 0 { -0.045 } else { middle };
    SceneObject {
        id: LINKS[index].into(),
        solids: vec![solid],
        tags: (0..3)
            .map(|side| tag(build.first_tag + 3 * index + side, side, tags_at))
            .collect(),
        path: Path {
            joints: joints(build).into_iter().take(index).collect(),
            ..path_of_base(build)
        },
    }
}

/// On top (side 0), and on the sides towards y and away from it.
fn tag(id: usize, side: usize, x: f64) -> SceneTag {
    let turn = match side {
        0 => UnitQuaternion::identity(),
        1 => about(0, -FRAC_PI_2),
        _ => about(0, FRAC_PI_2),
    };
    let place = turn * Vector3::new(0.0, 0.0, THICK / 2.0) + Vector3::new(x, 0.0, 0.0);
    let object_from_tag = Pose::from_parts(Translation3::from(place), turn);
    SceneTag::new(Family::Tag36h11, id as u32, TAG, object_from_tag)
}

fn path_of_base(build: &Build) -> Path {
    let [x, y, z] = build.place;
    let swing = |mean: f64, amplitude: f64, phase: f64| Wave::still(mean).and(1, amplitude, phase);
    Path {
        period_s: 7.5,
        turns: 0,
        position: [
            swing(x, build.swing, 0.3),
            swing(y, build.swing, 1.9),
            swing(z, 0.02, 0.0),
        ],
        yaw: swing(0.2, 0.4, 0.7),
        pitch: swing(0.0, 0.05, 2.0),
        roll: swing(0.0, 0.05, 1.0),
        joints: Vec::new(),
        events: Vec::new(),
    }
}

/// From the base outwards.
fn joints(build: &Build) -> [PathJoint; 2] {
    let gap = 0.012;
    let (elbow_at, elbow_limits, elbow_value) = build.elbow.clone();
    let joint = |id: &str, axis, place: [f64; 3], limits, value| PathJoint {
        id: id.into(),
        kind: PathJointKind::Revolute,
        axis,
        parent_from_joint: Pose::translation(place[0], place[1], place[2]),
        limits,
        value,
    };
    [
        joint(
            "shoulder",
            [0.0, 0.0, 1.0],
            [0.05, 0.0, THICK + gap],
            [-1.6, 2.0],
            Wave::still(0.2).and(2, 1.2, 0.4),
        ),
        joint(
            "elbow",
            [0.0, 1.0, 0.0],
            [elbow_at, 0.0, 0.0],
            elbow_limits,
            elbow_value,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Observer, Random, Visibility};

    #[test]
    fn the_arm_is_a_valid_scenario_and_survives_its_file() {
        let scenario = Scenario::arm(4, 1);
        assert_eq!(scenario.validate(), Ok(()));
        let text = toml::to_string(&scenario).unwrap();
        assert_eq!(toml::from_str::<Scenario>(&text).unwrap(), scenario);
    }

    #[test]
    fn links_hang_together_at_the_joints() {
        let scenario = Scenario::arm(1, 1);
        let [base, upper, fore] = &scenario.objects[..] else {
            panic!("three links")
        };
        for time_ns in (0..40).map(|n| n * 190_000_000) {
            for (parent, child) in [(base, upper), (upper, fore)] {
                let joint = child.path.joints.last().unwrap();
                let of_parent = parent.world_from_object(time_ns) * joint.parent_from_joint;
                let gap = of_parent.translation.vector
                    - child.world_from_object(time_ns).translation.vector;
                assert!(gap.norm() < 1e-12);
                let value = *child.path.joint_values(time_ns).last().unwrap();
                assert!((joint.limits[0]..=joint.limits[1]).contains(&value));
            }
        }
    }

    #[test]
    fn every_link_is_seen_by_some_camera_most_of_the_time() {
        let scenario = Scenario::arm(4, 3);
        let mut seen = [0; 3];
        for camera in 0..4 {
            let mut observer = Observer::new(&scenario, Visibility::default()).unwrap();
            for n in 0..50 {
                for tag in
                    observer.observe(camera, n * 150_000_000, 0.0, &mut Random::from_keys(&[7]))
                {
                    seen[tag.object] += 1;
                }
            }
        }
        assert!(seen.iter().all(|seen| *seen > 100), "{seen:?}");
    }
}
