//! `rig.toml`: the cameras of a site.

use crate::atomic::write_keeping_former;
use crate::document::Document;
use crate::error::{Complaint, FileError};
use crate::foreign::{is_foreign, read_foreign};
use crate::object::pose_of;
use crate::read::read_text;
use serde::Deserialize;
use sextant_estimator::{Camera, CameraId, PoseSigma, Rig, RigError};
use sextant_geometry::{Lens, PoseParts};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RigFile {
    #[serde(default)]
    camera: Vec<CameraTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    id: CameraId,
    /// Width, height, pixels.
    resolution: [u32; 2],
    lens: Lens,
    /// Omitted until calibrated.
    world_from_camera: Option<PoseParts>,
    /// How well that is known; omitted where nobody says.
    world_from_camera_sigma: Option<SigmaTable>,
}

/// One sigma an axis.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SigmaTable {
    /// m.
    position: f64,
    /// rad.
    orientation: f64,
}

/// The rig of a file: `rig.toml`, or a YAML file of ROS, Kalibr or OpenCV.
///
/// # Errors
/// A file that is missing, malformed, or describes no rig; with line, column, key and remedy.
pub fn read_rig(path: &Path) -> Result<Rig, FileError> {
    if is_foreign(path) {
        return Ok(read_foreign(path)?.1);
    }
    parse_rig(path, &read_text(path)?)
}

/// The rig of a text; `path` is for the messages.
///
/// # Errors
/// As [`read_rig`].
pub fn parse_rig(path: &Path, text: &str) -> Result<Rig, FileError> {
    let document = Document::parse(path, text)?;
    let file: RigFile = document.read()?;
    let rig = rig_of(&file, &document).map_err(|complaint| document.complaint(complaint))?;
    Ok(rig)
}

fn rig_of(file: &RigFile, document: &Document<'_>) -> Result<Rig, Complaint> {
    if file.camera.is_empty() {
        let remedy = "add a [[camera]] table with id, resolution and lens";
        return Err(Complaint::new("", "the rig has no camera", remedy));
    }
    unique(file, document)?;
    let cameras: Result<Vec<Camera>, Complaint> =
        file.camera.iter().enumerate().map(camera_of).collect();
    let rig = Rig::new(cameras?).map_err(|error| complaint("camera", &error))?;
    with_sigmas(rig, file)
}

fn with_sigmas(mut rig: Rig, file: &RigFile) -> Result<Rig, Complaint> {
    for (index, table) in file.camera.iter().enumerate() {
        let Some(sigma) = &table.world_from_camera_sigma else {
            continue;
        };
        let sigma = PoseSigma {
            position_m: sigma.position,
            orientation_rad: sigma.orientation,
        };
        let stated = rig.with_pose_sigmas([(table.id.clone(), sigma)]);
        rig = stated.map_err(|error| complaint(&format!("camera[{index}]"), &error))?;
    }
    Ok(rig)
}

fn unique(file: &RigFile, document: &Document<'_>) -> Result<(), Complaint> {
    let mut first = BTreeMap::new();
    for (index, camera) in file.camera.iter().enumerate() {
        let key = format!("camera[{index}].id");
        if let Some(earlier) = first.insert(&camera.id, key.clone()) {
            let line = document.line_of(&earlier).unwrap_or(0);
            let cause = format!("camera \"{}\" is there already, on line {line}", camera.id);
            return Err(Complaint::new(
                key,
                cause,
                "give each camera its own id or remove one",
            ));
        }
    }
    Ok(())
}

fn camera_of((index, table): (usize, &CameraTable)) -> Result<Camera, Complaint> {
    let key = format!("camera[{index}]");
    let pose_key = format!("{key}.world_from_camera");
    let camera = Camera {
        id: table.id.clone(),
        resolution: table.resolution,
        lens: table.lens,
        world_from_camera: pose_of(table.world_from_camera.as_ref(), &pose_key)?,
    };
    // A rig of this camera alone: the rules are the estimator's, the place is known here.
    Rig::new(vec![camera.clone()]).map_err(|error| complaint(&key, &error))?;
    Ok(camera)
}

fn complaint(key: &str, error: &RigError) -> Complaint {
    let (part, remedy) = match error {
        RigError::Resolution { .. } => (
            ".resolution",
            "write width and height of the camera's images in pixels",
        ),
        RigError::Pose(_) => (".world_from_camera", "write finite numbers"),
        RigError::PoseSigma(_) => (
            ".world_from_camera_sigma",
            "write metres and radians, one sigma an axis, or leave it out",
        ),
        _ => ("", ""),
    };
    Complaint::new(format!("{key}{part}"), error.to_string(), remedy)
}

/// The text of a rig's file. Numbers are written with as many digits as bring them back exactly.
pub fn rig_toml(rig: &Rig) -> String {
    let mut text = String::new();
    for camera in rig.cameras() {
        let [width, height] = camera.resolution;
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "[[camera]]\nid = \"{}\"\nresolution = [{width}, {height}]\nlens = {}\n",
            camera.id,
            lens_toml(&camera.lens)
        );
        if let Some(pose) = &camera.world_from_camera {
            let _ = writeln!(text, "world_from_camera = {}", pose_toml(&pose.into()));
        }
        if let Some(sigma) = rig.pose_sigma(&camera.id) {
            let _ = writeln!(
                text,
                "world_from_camera_sigma = {{ position = {:?}, orientation = {:?} }}",
                sigma.position_m, sigma.orientation_rad
            );
        }
        text.push('\n');
    }
    text
}

/// Writes a rig's file, whole or not at all; the former one is kept as [`crate::former_of`] says.
///
/// # Errors
/// What the system refuses; the old file is then untouched.
pub fn write_rig(path: &Path, rig: &Rig) -> Result<(), FileError> {
    write_keeping_former(path, rig_toml(rig).as_bytes())
}

fn lens_toml(lens: &Lens) -> String {
    let numbers = lens.intrinsics();
    let mut text = format!(
        "{{ model = \"{}\", fx = {:?}, fy = {:?}, cx = {:?}, cy = {:?}",
        lens.model(),
        numbers.fx,
        numbers.fy,
        numbers.cx,
        numbers.cy
    );
    if !lens.distortion().is_empty() {
        let _ = write!(text, ", distortion = {:?}", lens.distortion());
    }
    text + " }"
}

pub(crate) fn pose_toml(pose: &PoseParts) -> String {
    let PoseParts {
        position,
        orientation,
    } = pose;
    format!("{{ position = {position:?}, orientation = {orientation:?} }}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
[[camera]]
id = "north"
resolution = [640, 480]
lens = { model = "brown-conrady", fx = 600.0, fy = 600, cx = 319.5, cy = 239.5, distortion = [0, 0, 0, 0, 0] }
world_from_camera = { position = [1.0, 0.0, 1.2], orientation = [0, 0, 0, 1] }

[[camera]]
id = "south"
resolution = [1280, 800]
lens = { model = "kannala-brandt", fx = 123.4567890123, fy = 600.0, cx = 639.5, cy = 399.5, distortion = [0.01, 0, 1e-7, 0] }
"#;

    fn parsed(text: &str) -> Result<Rig, String> {
        parse_rig(Path::new("rig.toml"), text).map_err(|error| error.to_string())
    }

    fn with(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from));
        parsed(&GOOD.replacen(from, to, 1)).unwrap_err()
    }

    #[test]
    fn the_designs_file_is_read() {
        let rig = parsed(GOOD).unwrap();
        let [north, south] = rig.cameras() else {
            panic!("two cameras")
        };
        assert_eq!(north.resolution, [640, 480]);
        let at = PoseParts::from(&north.world_from_camera.unwrap());
        assert_eq!(at.position, [1.0, 0.0, 1.2]);
        assert_eq!(south.lens.distortion(), [0.01, 0.0, 1e-7, 0.0]);
        assert_eq!(south.world_from_camera, None);
    }

    const WITH_SIGMA: &str =
        "[0, 0, 0, 1] }\nworld_from_camera_sigma = { position = 0.0004, orientation = 0.0002 }";

    #[test]
    fn how_well_a_pose_is_known_may_be_stated() {
        let rig = parsed(&GOOD.replacen("[0, 0, 0, 1] }", WITH_SIGMA, 1)).unwrap();
        let sigma = |index: usize| rig.pose_sigma(&rig.cameras()[index].id);
        assert_eq!(sigma(0).map(|sigma| sigma.position_m), Some(0.0004));
        assert_eq!(sigma(1), None);
        assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
        let negative = WITH_SIGMA.replace("0.0002", "-0.0002");
        let message = with("[0, 0, 0, 1] }", &negative);
        assert!(
            message.contains("camera[0].world_from_camera_sigma: "),
            "{message}"
        );
    }

    #[test]
    fn what_is_written_is_read_back_exactly() {
        let rig = parsed(GOOD).unwrap();
        assert_eq!(parsed(&rig_toml(&rig)).unwrap(), rig);
    }

    #[test]
    fn wrong_cameras_are_refused_with_line_key_and_remedy() {
        for (from, to, expected) in [
            (
                "\"south\"",
                "\"north\"",
                "rig.toml:9:6: camera[1].id: camera \"north\" is there already, on line 3; give each camera",
            ),
            ("\"north\"", "\"North\"", "rig.toml:3:6: camera[0].id: "),
            (
                "[640, 480]",
                "[640, 0]",
                "rig.toml:4:14: camera[0].resolution: ",
            ),
            (
                "[640, 480]",
                "[640]",
                "rig.toml:4:14: camera[0].resolution: invalid length 1",
            ),
            (
                "[640, 480]",
                "[640, 480, 3]",
                "rig.toml:4:14: camera[0].resolution: 3 elements are too many; remove",
            ),
            (
                "[1.0, 0.0, 1.2]",
                "[1.0, 0.0, 1.2, 1.0]",
                "rig.toml:6:34: camera[0].world_from_camera.position: 4 elements are too many",
            ),
            (
                "[1280, 800]",
                "[1280, 800, 3]",
                "rig.toml:10:14: camera[1].resolution: 3 elements are too many",
            ),
            (
                "[640, 480]",
                "[-640, 480]",
                "rig.toml:4:15: camera[0].resolution[0]: invalid value: integer `-640`",
            ),
            (
                "resolution = [640, 480]\n",
                "",
                "camera[0]: missing field `resolution`; add `resolution = ...`",
            ),
            (
                "resolution",
                "resolutoin",
                "rig.toml:4:1: camera[0].resolutoin: unknown field `resolutoin`",
            ),
            (
                "fx = 600.0",
                "fx = -600.0",
                "rig.toml:5:8: camera[0].lens: focal length fx = -600 must be",
            ),
            (
                "fx = 600.0",
                "fx = nan",
                "rig.toml:5:8: camera[0].lens: focal length fx = NaN must be",
            ),
            (
                "cx = 319.5",
                "cx = inf",
                "rig.toml:5:8: camera[0].lens: cx = inf must be finite",
            ),
            (
                "cx = 319.5",
                "cx = 319.5, cz = 1",
                "camera[0].lens: unknown field `cz`, expected one of",
            ),
            (
                "brown-conrady",
                "brown-conradi",
                "did you mean `brown-conrady`?",
            ),
            (
                "distortion = [0, 0, 0, 0, 0]",
                "distortion = [0, 0]",
                "rig.toml:5:8: camera[0].lens: invalid length 2",
            ),
            (
                "[1.0, 0.0, 1.2]",
                "[nan, 0.0, 1.2]",
                "rig.toml:6:34: camera[0].world_from_camera.position: ",
            ),
            (
                "orientation = [0, 0, 0, 1]",
                "orientation = [0, 0, 0, 2]",
                "rig.toml:6:65: camera[0].world_from_camera.orientation: ",
            ),
            (
                "orientation = [0, 0, 0, 1]",
                "orientation = [0, 0, 0, 1.002]",
                "its length is 1.002",
            ),
            ("orientation", "orientatoin", "did you mean `orientation`?"),
            (
                "[[camera]]\nid = \"south\"",
                "[[camra]]\nid = \"south\"",
                "rig.toml:8:3: camra: unknown field `camra`, expected `camera`; did you mean `camera`?",
            ),
            ("[[camera]]", "[[camera]", "rig.toml:2:"),
        ] {
            let message = with(from, to);
            assert!(message.contains(expected), "{from} -> {to}: {message}");
        }
    }

    #[test]
    fn a_rounded_quaternion_is_normalised() {
        let text = GOOD.replace(
            "orientation = [0, 0, 0, 1]",
            "orientation = [0, 0, 0.7071, 0.7071]",
        );
        let rig = parsed(&text).unwrap();
        let rotation = rig.cameras()[0].world_from_camera.unwrap().rotation;
        assert!((rotation.quaternion().norm() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn an_empty_rig_is_refused() {
        assert!(parsed("").unwrap_err().contains("the rig has no camera"));
    }
}
