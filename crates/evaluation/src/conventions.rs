//! Conventions of a reference that differ from those here, by its poses: unit of length, order of quaternions,
//! direction of the poses.
//!
//! Compared is the motion of the body from one pose to the next half a trajectory on, whose angle and form depend on no
//! world frame.

use crate::reference::{References, Trajectory};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::ObjectId;
use sextant_site_report::ObjectEstimate;
use std::collections::BTreeMap;

/// Error of turns from which a reference is in doubt, rad, and the share of it that another convention must leave.
const WRONG_RAD: f64 = 0.3;
const LEFT: f64 = 0.2;
/// Fewest poses that decide.
const FEWEST: usize = 10;
/// Relative deviation of a ratio of lengths from that of two units.
const UNIT_TOLERANCE: f64 = 0.2;
/// Ratios of lengths to metres, and the units.
const UNITS: [(f64, &str); 2] = [(1000.0, "millimetres"), (100.0, "centimetres")];

/// What references seem to have otherwise, a sentence each with what to do.
pub fn other_conventions(poses: &[ObjectEstimate], references: &References) -> Vec<String> {
    let mut by_object: BTreeMap<&ObjectId, Vec<(Pose, Pose)>> = BTreeMap::new();
    for pose in poses {
        let reference = references.get(&pose.object);
        if let Some(truth) = reference.and_then(|reference| reference.at(pose.capture_ns)) {
            let pairs = by_object.entry(&pose.object).or_default();
            pairs.push((pose.world_from_object, truth));
        }
    }
    let objects = by_object.into_iter();
    let objects = objects.filter(|(_, pairs)| pairs.len() >= FEWEST);
    let sentences = objects.flat_map(|(object, pairs)| {
        let both = [other_turns(&pairs).map(str::to_owned), other_unit(&pairs)];
        both.into_iter()
            .flatten()
            .map(move |words| format!("the reference of {object} {words}"))
    });
    sentences.collect()
}

fn other_turns(pairs: &[(Pose, Pose)]) -> Option<&'static str> {
    let as_read = |truth: &Pose| truth.rotation;
    let wrong = turn_error(pairs, as_read);
    if wrong < WRONG_RAD {
        return None;
    }
    let w_first = |truth: &Pose| {
        let q = truth.rotation.quaternion();
        UnitQuaternion::new_normalize(Quaternion::new(q.i, q.j, q.k, q.w))
    };
    let w_last = |truth: &Pose| {
        let q = truth.rotation.quaternion();
        UnitQuaternion::new_normalize(Quaternion::new(q.k, q.w, q.i, q.j))
    };
    let inverse = |truth: &Pose| truth.rotation.inverse();
    if turn_error(pairs, w_first) < LEFT * wrong {
        Some(
            "seems to have its quaternions as w, x, y, z: name the columns in a header, such as t,x,y,z,qw,qx,qy,qz",
        )
    } else if turn_error(pairs, w_last) < LEFT * wrong {
        Some(
            "seems to have its quaternions as x, y, z, w: name the columns in a header, such as t,x,y,z,qx,qy,qz,qw",
        )
    } else if turn_error(pairs, inverse) < LEFT * wrong {
        Some("seems to have the inverse of each pose: give the pose of the object in the world")
    } else {
        None
    }
}

/// Root mean square difference of the body's turns, rad.
fn turn_error(pairs: &[(Pose, Pose)], rotation: impl Fn(&Pose) -> UnitQuaternion<f64>) -> f64 {
    let half = pairs.len() / 2;
    let later = pairs.iter().skip(half);
    let squares = pairs.iter().zip(later).map(|(before, after)| {
        let estimated = before.0.rotation.inverse() * after.0.rotation;
        let given = rotation(&before.1).inverse() * rotation(&after.1);
        estimated.angle_to(&given).powi(2)
    });
    let n = pairs.len() - half;
    (squares.sum::<f64>() / n as f64).sqrt()
}

fn other_unit(pairs: &[(Pose, Pose)]) -> Option<String> {
    let spread = |place: fn(&(Pose, Pose)) -> Vector3<f64>| {
        let mean = pairs.iter().map(place).sum::<Vector3<f64>>() / pairs.len() as f64;
        let squares = pairs.iter().map(|pair| (place(pair) - mean).norm_squared());
        squares.sum::<f64>().sqrt()
    };
    let ratio = spread(|pair| pair.1.translation.vector) / spread(|pair| pair.0.translation.vector);
    let mut units = UNITS.iter();
    let (_, unit) = units.find(|(times, _)| (ratio / times - 1.0).abs() < UNIT_TOLERANCE)?;
    Some(format!(
        "moves {ratio:.0} times as far: are these {unit}? name the unit in a header, such as x [mm]"
    ))
}

/// Why no pose has a reference: the times of both, from their first to their last, s.
pub fn no_common_time(poses: &[ObjectEstimate], references: &References) -> String {
    let times = poses.iter().map(|pose| pose.capture_ns);
    let replayed = times.clone().min().zip(times.max());
    let spans = references.values().filter_map(Trajectory::span_ns);
    let given = spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let words = |span: Option<(u64, u64)>| match span {
        Some((first, last)) => {
            let seconds = |ns: u64| format!("{}.{:03}", ns / 1_000_000_000, ns / 1_000_000 % 1000);
            format!("{} to {} s", seconds(first), seconds(last))
        }
        None => "none".to_owned(),
    };
    format!(
        "no pose of the reference is of the time of a replayed pose of the same object: it has \
         {}, the poses have {}; both count from 1970, in the unit of the header",
        words(given),
        words(replayed)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;
    use nalgebra::Matrix6;
    use sextant_site_report::State;

    fn truth(t_ns: u64) -> Pose {
        let s = t_ns as f64 * 1e-9;
        Pose::new(
            Vector3::new(s, s * s, 0.3),
            Vector3::new(0.1 + s, 2.0 * s, -0.2),
        )
    }

    /// The conventions that are suspected of a reference with rows made by `row`, against poses in another world.
    fn suspected(row: impl Fn(&Pose) -> [f64; 7]) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cube.tum");
        let times = || (0..20).map(|k| k * 50_000_000);
        let line = |t_ns: u64| {
            let numbers = row(&truth(t_ns)).map(|number| number.to_string());
            format!("{:.3} {}\n", t_ns as f64 * 1e-9, numbers.join(" "))
        };
        std::fs::write(&file, times().map(line).collect::<String>()).unwrap();
        let id = ObjectId::new("cube").unwrap();
        let references = reference::read(&[file], &[id.clone()].into()).unwrap();
        let world = Pose::new(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.2, -0.4));
        let poses = times().map(|t_ns| ObjectEstimate {
            object: id.clone(),
            capture_ns: t_ns,
            world_from_object: world * truth(t_ns),
            covariance: Matrix6::identity(),
            twist: Default::default(),
            state: State::Tracking,
            cameras: 1,
            tags: 1,
            rms_px: 0.0,
            articulated: None,
        });
        other_conventions(&poses.collect::<Vec<_>>(), &references)
    }

    fn row(pose: &Pose, scale: f64) -> [f64; 7] {
        let (p, q) = (pose.translation.vector * scale, pose.rotation.coords);
        [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
    }

    #[test]
    fn other_conventions_are_named_and_the_usual_ones_are_not() {
        assert_eq!(suspected(|pose| row(pose, 1.0)), Vec::<String>::new());
        let w_first = suspected(|pose| {
            let [x, y, z, qx, qy, qz, qw] = row(pose, 1.0);
            [x, y, z, qw, qx, qy, qz]
        });
        assert!(
            w_first.len() == 1 && w_first[0].contains("as w, x, y, z"),
            "{w_first:?}"
        );
        let millimetres = suspected(|pose| row(pose, 1000.0));
        assert!(
            millimetres.len() == 1 && millimetres[0].contains("are these millimetres?"),
            "{millimetres:?}"
        );
        let inverse = suspected(|pose| row(&pose.inverse(), 1.0));
        assert!(
            inverse
                .iter()
                .any(|words| words.contains("inverse of each pose")),
            "{inverse:?}"
        );
    }
}
