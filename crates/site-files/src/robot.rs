//! `robot.toml`: where a robot's base is in the site, and what its hand carries.

use crate::atomic::write_keeping_former;
use crate::document::Document;
use crate::error::{Complaint, FileError};
use crate::pose::{SigmaTable, pose_of, pose_toml, sigma_toml};
use crate::read::read_text;
use nalgebra::Matrix6;
use serde::Deserialize;
use sextant_geometry::{Pose, PoseParts};
use sextant_site_model::{CameraId, ObjectId, PoseSigma};
use std::path::Path;

/// A robot of a site.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Maps points of the world into the robot's base.
    pub base_from_world: UncertainPose,
    /// What the hand carries, if that is known.
    pub carried: Option<Carried>,
    /// Standard deviation of the robot's poses, per axis.
    pub pose_sigma: Option<PoseSigma>,
    /// The robot's clock minus that of the images, s.
    pub clock_offset_s: Option<f64>,
}

/// What a hand carries, and where.
#[derive(Clone, Debug, PartialEq)]
pub enum Carried {
    /// Maps points of the object into the hand.
    Object(ObjectId, UncertainPose),
    /// Maps points of the camera into the hand.
    Camera(CameraId, UncertainPose),
}

/// A pose and its covariance: a step of FRAMES.md, m and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UncertainPose {
    /// `a_from_b`.
    pub pose: Pose,
    /// Over (x, y, z, rx, ry, rz), along the axes of a.
    pub covariance: Matrix6<f64>,
}

type Rows = [[f64; 6]; 6];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotFile {
    base_from_world: PoseParts,
    base_from_world_covariance: Option<Rows>,
    object: Option<ObjectId>,
    hand_from_object: Option<PoseParts>,
    hand_from_object_covariance: Option<Rows>,
    camera: Option<CameraId>,
    hand_from_camera: Option<PoseParts>,
    hand_from_camera_covariance: Option<Rows>,
    pose_sigma: Option<SigmaTable>,
    clock_offset: Option<f64>,
}

/// The robot of a file.
///
/// # Errors
/// A file that is missing, malformed, or invalid; with line, column, key and remedy.
pub fn read_robot(path: &Path) -> Result<RobotModel, FileError> {
    let text = read_text(path)?;
    let document = Document::parse(path, &text)?;
    let file: RobotFile = document.read()?;
    let robot = robot_of(&file).map_err(|complaint| document.complaint(complaint))?;
    Ok(robot)
}

/// Writes a robot file atomically and keeps the former one, as rigs and objects are written.
///
/// # Errors
/// As [`write_keeping_former`].
pub fn write_robot(path: &Path, robot: &RobotModel) -> Result<(), FileError> {
    write_keeping_former(path, robot_toml(robot).as_bytes())
}

fn robot_of(file: &RobotFile) -> Result<RobotModel, Complaint> {
    let object = uncertain(
        &file.hand_from_object,
        &file.hand_from_object_covariance,
        "hand_from_object",
    )?;
    let camera = uncertain(
        &file.hand_from_camera,
        &file.hand_from_camera_covariance,
        "hand_from_camera",
    )?;
    let carried = match ((&file.object, object), (&file.camera, camera)) {
        ((None, None), (None, None)) => None,
        ((Some(id), Some(pose)), (None, None)) => Some(Carried::Object(id.clone(), pose)),
        ((None, None), (Some(id), Some(pose))) => Some(Carried::Camera(id.clone(), pose)),
        _ => {
            return Err(Complaint::new(
                "",
                "the hand carries either an object or a camera",
                "write object and hand_from_object, or camera and hand_from_camera",
            ));
        }
    };
    let base = uncertain(
        &Some(file.base_from_world),
        &file.base_from_world_covariance,
        "base_from_world",
    )?;
    let clock_offset_s = file.clock_offset;
    if clock_offset_s.is_some_and(|offset_s| !offset_s.is_finite()) {
        let remedy = "write seconds, or leave it out";
        return Err(Complaint::new("clock_offset", "it is not finite", remedy));
    }
    Ok(RobotModel {
        base_from_world: base.unwrap_or(UncertainPose {
            pose: Pose::identity(),
            covariance: Matrix6::zeros(),
        }),
        carried,
        pose_sigma: file.pose_sigma.as_ref().map(PoseSigma::from),
        clock_offset_s,
    })
}

/// A pose with its covariance; that of a camera placed by hand where the file has none.
fn uncertain(
    parts: &Option<PoseParts>,
    rows: &Option<Rows>,
    key: &str,
) -> Result<Option<UncertainPose>, Complaint> {
    let Some(pose) = pose_of(parts.as_ref(), key)? else {
        return match rows {
            None => Ok(None),
            Some(_) => Err(Complaint::new(
                format!("{key}_covariance"),
                format!("there is no {key} that this is the covariance of"),
                format!("add {key}, or take this away"),
            )),
        };
    };
    let covariance = match rows {
        None => Matrix6::from_diagonal(&PoseSigma::OF_CAMERA.variance()),
        Some(rows) => Matrix6::from_fn(|row, column| rows[row][column]),
    };
    let is_symmetric = (covariance - covariance.transpose()).amax() <= 1e-9 * covariance.amax();
    let is_positive = covariance
        .symmetric_eigenvalues()
        .iter()
        .all(|value| *value >= -1e-9 * covariance.amax());
    if !(covariance.iter().all(|x| x.is_finite()) && is_symmetric && is_positive) {
        return Err(Complaint::new(
            format!("{key}_covariance"),
            "this is no covariance: it is not symmetric and positive",
            "write six rows over x, y, z, rx, ry, rz in m and rad, or leave it out",
        ));
    }
    Ok(Some(UncertainPose { pose, covariance }))
}

fn robot_toml(robot: &RobotModel) -> String {
    let mut text =
        "# A robot of the site. Covariances are over (x, y, z, rx, ry, rz), m and rad.\n"
            .to_owned();
    text += &uncertain_toml("base_from_world", &robot.base_from_world);
    match &robot.carried {
        None => {}
        Some(Carried::Object(id, pose)) => {
            text += &format!("object = \"{id}\"\n");
            text += &uncertain_toml("hand_from_object", pose);
        }
        Some(Carried::Camera(id, pose)) => {
            text += &format!("camera = \"{id}\"\n");
            text += &uncertain_toml("hand_from_camera", pose);
        }
    }
    if let Some(sigma) = &robot.pose_sigma {
        text += &format!("pose_sigma = {}\n", sigma_toml(sigma));
    }
    if let Some(offset_s) = robot.clock_offset_s {
        text += &format!("clock_offset = {offset_s:?}\n");
    }
    text
}

fn uncertain_toml(key: &str, UncertainPose { pose, covariance }: &UncertainPose) -> String {
    let rows = covariance.row_iter().map(|row| {
        let numbers: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        format!("    [{}],\n", numbers.join(", "))
    });
    let rows: String = rows.collect();
    let pose = pose_toml(&PoseParts::from(pose));
    format!("{key} = {pose}\n{key}_covariance = [\n{rows}]\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector3, Vector6};

    fn read(text: &str) -> Result<RobotModel, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.toml");
        std::fs::write(&path, text).unwrap();
        read_robot(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn a_written_robot_is_read_again() {
        let pose = |x| UncertainPose {
            pose: Pose::new(Vector3::new(x, 0.2, 0.3), Vector3::new(0.1, x, 0.0)),
            covariance: Matrix6::from_diagonal(&Vector6::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)) * 1e-7
                + Matrix6::repeat(1e-8),
        };
        let robot = RobotModel {
            base_from_world: pose(0.5),
            carried: Some(Carried::Camera(CameraId::new("hand").unwrap(), pose(-0.1))),
            pose_sigma: Some(PoseSigma::OF_TAG),
            clock_offset_s: Some(-0.0125),
        };
        assert_eq!(read(&robot_toml(&robot)), Ok(robot));
    }

    #[test]
    fn wrong_robots_are_refused_at_their_place() {
        const BASE: &str =
            "base_from_world = { position = [0, 0, 0], orientation = [0, 0, 0, 1] }\n";
        let refused = |text: &str, words: &[&str]| {
            let error = read(text).unwrap_err();
            words
                .iter()
                .for_each(|word| assert!(error.contains(word), "{error}"));
        };
        assert!(read(BASE).is_ok());
        refused("", &["base_from_world", "add `base_from_world"]);
        refused(&format!("{BASE}bases = 1\n"), &[":2:", "bases", "unknown"]);
        refused(
            &format!("{BASE}object = \"a\"\n"),
            &["either an object or a camera"],
        );
        refused(
            "base_from_world = { position = [0, 0, 0], orientation = [0, 0, 0, 2] }\n",
            &[":1:", "base_from_world.orientation", "unit quaternion"],
        );
        let rows = "[[0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, \
            0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]]";
        refused(
            &format!("{BASE}base_from_world_covariance = {rows}\n"),
            &[":2:", "base_from_world_covariance", "six rows"],
        );
        for key in ["hand_from_object", "hand_from_camera"] {
            refused(
                &format!("{BASE}{key}_covariance = {rows}\n"),
                &[":2:", &format!("{key}_covariance"), &format!("add {key}")],
            );
        }
    }
}
