//! Poses as lines of text: JSON, CSV, and TUM's `timestamp tx ty tz qx qy qz qw`, which `evo` reads.

use nalgebra::Matrix6;
use serde::Serialize;
use sextant_geometry::{Pose, PoseParts};
use sextant_site_model::{JointId, LinkId, ObjectId};
use sextant_site_report::{JointEstimate, LinkEstimate, ObjectEstimate, State};

#[derive(Serialize)]
struct PoseLine<'a> {
    t_ns: u64,
    object: &'a ObjectId,
    position: [f64; 3],
    orientation: [f64; 4],
    covariance: Vec<f64>,
    twist: [f64; 6],
    state: State,
    cameras: u32,
    tags: u32,
    rms_px: f64,
    /// Only where the object has links.
    #[serde(skip_serializing_if = "Option::is_none")]
    links: Option<Vec<LinkLine<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    joints: Option<Vec<JointLine<'a>>>,
}

#[derive(Serialize)]
struct LinkLine<'a> {
    link: &'a LinkId,
    position: [f64; 3],
    orientation: [f64; 4],
    covariance: Vec<f64>,
}

#[derive(Serialize)]
struct JointLine<'a> {
    joint: &'a JointId,
    value: f64,
    sigma: f64,
    velocity: f64,
}

/// `{"t_ns","object","position","orientation","covariance","twist","state","cameras","tags","rms_px"}`: metres, x y z
/// w, 6x6 row-major over (x, y, z, rx, ry, rz) in world axes, m/s and rad/s; for an object that has links also
/// `"links":[{"link","position","orientation","covariance"}]` and `"joints":[{"joint","value","sigma","velocity"}]`.
/// Numbers have as many digits as bring them back.
pub fn pose_json(estimate: &ObjectEstimate) -> String {
    let parts = PoseParts::from(&estimate.world_from_object);
    let articulated = estimate.articulated.as_deref();
    let line = PoseLine {
        t_ns: estimate.capture_ns,
        object: &estimate.object,
        position: parts.position,
        orientation: parts.orientation,
        covariance: row_major(&estimate.covariance),
        twist: estimate.twist.into(),
        state: estimate.state,
        cameras: estimate.cameras,
        tags: estimate.tags,
        rms_px: estimate.rms_px,
        links: articulated.map(|one| one.links.iter().map(link_line).collect()),
        joints: articulated.map(|one| one.joints.iter().map(joint_line).collect()),
    };
    // Numbers, names and an enum: there is nothing that JSON could refuse.
    serde_json::to_string(&line).unwrap_or_default()
}

fn link_line(estimate: &LinkEstimate) -> LinkLine<'_> {
    let parts = PoseParts::from(&estimate.world_from_link);
    LinkLine {
        link: &estimate.link,
        position: parts.position,
        orientation: parts.orientation,
        covariance: row_major(&estimate.covariance),
    }
}

fn joint_line(estimate: &JointEstimate) -> JointLine<'_> {
    JointLine {
        joint: &estimate.joint,
        value: estimate.value,
        sigma: estimate.variance.sqrt(),
        velocity: estimate.velocity,
    }
}

fn row_major(covariance: &Matrix6<f64>) -> Vec<f64> {
    covariance.transpose().iter().copied().collect()
}

/// Seconds, metres, x y z w; nanoseconds and nanometres are kept.
pub fn pose_tum(estimate: &ObjectEstimate) -> String {
    tum_line(estimate.capture_ns, &estimate.world_from_object)
}

/// The same of any pose at a time in ns.
pub fn tum_line(t_ns: u64, world_from_object: &Pose) -> String {
    let parts = PoseParts::from(world_from_object);
    let (seconds, nanos) = (t_ns / 1_000_000_000, t_ns % 1_000_000_000);
    let mut line = format!("{seconds}.{nanos:09}");
    for number in parts.position.iter().chain(&parts.orientation) {
        line.push_str(&format!(" {number:.9}"));
    }
    line
}

/// The axes of a covariance, in the names of the columns of [`pose_csv`].
const AXES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// The header of [`pose_csv`]'s lines:
/// `t_ns,object,state,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,cameras,tags,rms_px,cov_x_x,cov_x_y,...`, the upper triangle
/// of the covariance row by row.
pub fn csv_header() -> String {
    let mut header =
        "t_ns,object,state,x,y,z,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,cameras,tags,rms_px".to_owned();
    for (row, column) in upper_triangle() {
        header.push_str(&format!(",cov_{}_{}", AXES[row], AXES[column]));
    }
    header
}

/// Columns as in [`csv_header`], units as in [`pose_json`]. Ids and states need no quotes.
pub fn pose_csv(estimate: &ObjectEstimate) -> String {
    let parts = PoseParts::from(&estimate.world_from_object);
    let state = match estimate.state {
        State::Initialising => "initialising",
        State::Tracking => "tracking",
        State::Coasting => "coasting",
        State::Lost => "lost",
    };
    let mut line = format!("{},{},{state}", estimate.capture_ns, estimate.object);
    let pose = parts.position.iter().chain(&parts.orientation);
    for number in pose.chain(estimate.twist.iter()) {
        line.push_str(&format!(",{number}"));
    }
    line.push_str(&format!(
        ",{},{},{}",
        estimate.cameras, estimate.tags, estimate.rms_px
    ));
    for place in upper_triangle() {
        line.push_str(&format!(",{}", estimate.covariance[place]));
    }
    line
}

fn upper_triangle() -> impl Iterator<Item = (usize, usize)> {
    (0..6).flat_map(|row| (row..6).map(move |column| (row, column)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector6;

    fn estimate() -> ObjectEstimate {
        ObjectEstimate {
            object: ObjectId::new("cube").unwrap(),
            capture_ns: 1_800_000_000_000_000_005,
            world_from_object: Pose::translation(1.0, -2.5, 0.1),
            covariance: Matrix6::from_fn(|row, column| (row * 6 + column) as f64),
            twist: Vector6::new(0.0, 1.0, 2.0, 3.0, 4.0, 5.0),
            state: State::Tracking,
            cameras: 2,
            tags: 3,
            rms_px: 0.125,
            articulated: None,
        }
    }

    #[test]
    fn json_has_the_documented_keys_in_order() {
        let line = pose_json(&estimate());
        assert!(line.starts_with(
            r#"{"t_ns":1800000000000000005,"object":"cube","position":[1.0,-2.5,0.1],"orientation":[0.0,0.0,0.0,1.0],"covariance":[0.0,1.0,2.0,3.0,4.0,5.0,6.0,"#
        ));
        assert!(line.ends_with(
            r#","twist":[0.0,1.0,2.0,3.0,4.0,5.0],"state":"tracking","cameras":2,"tags":3,"rms_px":0.125}"#
        ));
    }

    #[test]
    fn tum_keeps_every_nanosecond() {
        assert_eq!(
            pose_tum(&estimate()),
            "1800000000.000000005 1.000000000 -2.500000000 0.100000000 0.000000000 0.000000000 0.000000000 1.000000000"
        );
    }

    #[test]
    fn csv_has_a_value_for_each_name() {
        let (header, line) = (csv_header(), pose_csv(&estimate()));
        let columns: Vec<(&str, &str)> = header.split(',').zip(line.split(',')).collect();
        assert_eq!(header.split(',').count(), line.split(',').count());
        for wanted in [
            ("t_ns", "1800000000000000005"),
            ("state", "tracking"),
            ("y", "-2.5"),
            ("qw", "1"),
            ("wz", "5"),
            ("rms_px", "0.125"),
            ("cov_x_x", "0"),
            ("cov_y_rz", "11"),
            ("cov_rz_rz", "35"),
        ] {
            assert!(columns.contains(&wanted), "{wanted:?} of {columns:?}");
        }
    }
}
