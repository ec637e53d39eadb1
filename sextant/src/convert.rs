//! `sextant convert`: lenses and poses to and from ROS, Kalibr and OpenCV, their calibration boards, and recordings, also to bags of ROS 2.

mod recording;
mod ros2;

use crate::model_files::{read_rig, say_assumptions};
use crate::output::{Format, print_line};
use crate::words;
use anyhow::{Context, bail, ensure};
use clap::{Args, ValueEnum};
pub use recording::{Counts, RecordingConversion};
use recording::{is_recording, refuse_without_target};
use serde_json::json;
use sextant_geometry::Lens;
use sextant_process::{Exit, Failure, WithExit};
use sextant_site_files::{
    ForeignFormat, assumptions, foreign_text, has_foreign_name, is_foreign, object_toml,
    read_board, read_text, rig_toml, write_keeping_former,
};
use sextant_site_model::{Camera, CameraId, ObjectModel, Rig};
use std::path::{Path, PathBuf};

/// Arguments of `sextant convert`.
#[derive(Args, Debug)]
#[command(
    after_help = "FROM is a rig.toml, or a calibration of ROS (camera_info), Kalibr (camchain), OpenCV (YAML, JSON, XML), PhotonVision, WPILib, anipose,
caliscope, MATLAB (JSON), nerfstudio, EuRoC, ORB-SLAM, stella_vslam, Basalt, RealSense, ZED or Metashape; the format is recognised by its contents. Or it
describes a board: a Kalibr target.yaml, a ChArUco board with squaresX, squaresY, squareLength, markerLength and dictionary, or a grid of
markers with markersX, markersY, markerLength, markerSeparation and dictionary; then the object file of the board is written. Such a file is also accepted wherever an object file is expected.
Cameras are merged into an existing rig.toml: one with the same id gets the new lens and keeps its pose if FROM has none.
The previous file is kept as rig.toml.former.

All these formats have pixel (0, 0) at the centre of the top left pixel, as Sextant has. Calibrations from corners with (0, 0) at its
edge (AprilTag's C library) are larger by half a pixel: use --pixel-origin edge.

A recording is converted from a folder in EuRoC's layout to an MCAP file, or back; images and detections come back byte for byte. From a folder,
--rig and --object put the models into the file, so that it can be replayed; detections need the rig. To a folder, rig.toml, OBJECT.toml,
CAMERA/data.csv with CAMERA/data/*.png, and CAMERA/detections.jsonl are written; replay takes the detections where there are both.

With --ros2, a recording in an MCAP file becomes a bag of ROS 2, a new folder for `ros2 bag`, PlotJuggler and Rerun: the topics of `sextant ros2`
and, where images were recorded, /sextant/camera/ID/image/compressed with .../camera_info at their times. See docs/ros2.md.

With --json and a recording: {\"to\",\"images\",\"detections\"}; with --ros2: {\"to\",\"messages\",\"topics\":{NAME:messages},
\"left_out\":{CAUSE:messages}}.
With --json and --out: {\"file\",\"cameras\",\"assumed\"} or {\"file\",\"object\",\"tags\",\"assumed\"}; assumed: what FROM leaves open, such as a unit.

For example: sextant convert ost.yaml --camera north --out rig.toml
             sextant convert camchain.yaml --out rig.toml
             sextant convert target.yaml --out board.toml
             sextant convert rig.toml --to kalibr --out camchain.yaml
             sextant convert rig.toml --to ros --camera north --out north.yaml
             sextant convert DIR site.mcap --rig rig.toml --object cube.toml
             sextant convert site.mcap DIR
             sextant convert site.mcap BAG --ros2"
)]
pub struct ConvertArguments {
    /// File to read, or a recording: a folder or an MCAP file.
    from: PathBuf,
    /// Recording to write: an MCAP file or a new folder; with --ros2 a bag, a new folder.
    #[arg(value_name = "RECORDING", conflicts_with = "out")]
    recording: Option<PathBuf>,
    /// Rig to put into an MCAP file.
    #[arg(long, value_name = "FILE", requires = "recording")]
    rig: Option<PathBuf>,
    /// Object to put into an MCAP file; may be repeated.
    #[arg(long = "object", value_name = "FILE", requires = "recording")]
    objects: Vec<PathBuf>,
    /// Write a bag of ROS 2.
    #[arg(long, requires = "recording", conflicts_with_all = ["rig", "objects", "to", "camera", "pixel_origin"])]
    ros2: bool,
    /// Format to write.
    #[arg(long, value_enum, default_value = "toml")]
    to: Target,
    /// Camera to convert, of several; or the id for the single camera of another format.
    #[arg(long, value_name = "ID")]
    camera: Option<CameraId>,
    /// Location of pixel (0, 0) in the other format.
    #[arg(long, value_enum, default_value = "centre")]
    pixel_origin: PixelOrigin,
    /// File to write; by default standard output.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A format to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Target {
    /// Sextant's rig.toml.
    Toml,
    /// ROS camera_info.
    Ros,
    /// A Kalibr camchain.
    Kalibr,
    /// OpenCV's YAML.
    Opencv,
}

/// Where pixel (0, 0) lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PixelOrigin {
    /// The centre of the top left pixel.
    Centre,
    /// Its upper left corner.
    Edge,
}

/// Runs `sextant convert`.
///
/// # Errors
/// [`Exit::Input`] for a file that cannot be used or says what the other format cannot.
pub fn run(arguments: &ConvertArguments, format: Format) -> anyhow::Result<()> {
    if let Some(to) = &arguments.recording {
        if arguments.ros2 {
            return ros2::run(&arguments.from, to, format);
        }
        let conversion = RecordingConversion {
            from: &arguments.from,
            to,
            rig: arguments.rig.as_deref(),
            objects: &arguments.objects,
        };
        return conversion.run(format);
    }
    if is_recording(&arguments.from) {
        return refuse_without_target(&arguments.from);
    }
    if let Some(board) = board(arguments)? {
        return write_board(arguments, &board, format);
    }
    let rig = read_rig(&arguments.from).exit_with(Exit::Input)?;
    let mut cameras = chosen(arguments, &rig).exit_with(Exit::Input)?;
    let shift = match (arguments.pixel_origin, is_foreign_file(&arguments.from)?) {
        (PixelOrigin::Centre, _) => 0.0,
        (PixelOrigin::Edge, true) => -0.5,
        (PixelOrigin::Edge, false) => 0.5,
    };
    for camera in &mut cameras {
        camera.lens = shifted(&camera.lens, shift).exit_with(Exit::Input)?;
    }
    let text = match foreign(arguments.to) {
        Some(target) => foreign_text(target, &cameras)
            .map_err(|c| anyhow::anyhow!("{}: {}; {}", arguments.from.display(), c.cause, c.remedy))
            .exit_with(Exit::Input)?,
        None => merged(arguments.out.as_deref(), &cameras).exit_with(Exit::Input)?,
    };
    let Some(out) = &arguments.out else {
        return Ok(print_line(text.trim_end())?);
    };
    write_keeping_former(out, text.as_bytes())?;
    say(arguments, out, &cameras, format)
}

/// The board that FROM describes, named after the file to write, if it describes one.
fn board(arguments: &ConvertArguments) -> anyhow::Result<Option<ObjectModel>> {
    if !is_foreign_file(&arguments.from)? {
        return Ok(None);
    }
    let named = arguments.out.as_ref().and_then(|out| out.file_stem());
    let named = named.and_then(|stem| stem.to_str()?.parse().ok());
    let id = match named {
        Some(id) => id,
        None => "board".parse()?,
    };
    let board = read_board(&arguments.from, &id).exit_with(Exit::Input)?;
    if board.is_some() {
        say_assumptions(&arguments.from).exit_with(Exit::Input)?;
    }
    Ok(board)
}

fn is_foreign_file(path: &Path) -> anyhow::Result<bool> {
    let text = read_text(path).exit_with(Exit::Input)?;
    Ok(is_foreign(path, &text))
}

/// What is assumed where the file leaves something open, for the line of JSON.
fn assumed(arguments: &ConvertArguments) -> anyhow::Result<Vec<String>> {
    assumptions(&arguments.from).exit_with(Exit::Input)
}

fn write_board(
    arguments: &ConvertArguments,
    board: &ObjectModel,
    format: Format,
) -> anyhow::Result<()> {
    if arguments.to != Target::Toml {
        let from = arguments.from.display();
        let error = anyhow::anyhow!("{from} describes a board; only --to toml takes that");
        return Err(error).exit_with(Exit::Usage);
    }
    let text = object_toml(board);
    let Some(out) = &arguments.out else {
        return Ok(print_line(text.trim_end())?);
    };
    write_keeping_former(out, text.as_bytes())?;
    let tags = board.tags().len();
    let line = match format {
        Format::Json => {
            let (object, assumed) = (board.id().as_str(), assumed(arguments)?);
            json!({"file": out, "object": object, "tags": tags, "assumed": assumed}).to_string()
        }
        Format::Text => format!("{}: {}", out.display(), words::count(tags, "tag")),
    };
    Ok(print_line(&line)?)
}

fn say(
    arguments: &ConvertArguments,
    out: &Path,
    cameras: &[Camera],
    format: Format,
) -> anyhow::Result<()> {
    let names: Vec<&str> = cameras.iter().map(|camera| camera.id.as_str()).collect();
    let line = match format {
        Format::Json => {
            let assumed = assumed(arguments)?;
            json!({"file": out, "cameras": names, "assumed": assumed}).to_string()
        }
        Format::Text => format!("{}: {}", out.display(), names.join(", ")),
    };
    Ok(print_line(&line)?)
}

fn foreign(target: Target) -> Option<ForeignFormat> {
    match target {
        Target::Toml => None,
        Target::Ros => Some(ForeignFormat::Ros),
        Target::Kalibr => Some(ForeignFormat::Kalibr),
        Target::Opencv => Some(ForeignFormat::OpenCv),
    }
}

fn chosen(arguments: &ConvertArguments, rig: &Rig) -> anyhow::Result<Vec<Camera>> {
    let cameras = rig.cameras();
    let Some(id) = &arguments.camera else {
        return Ok(cameras.to_vec());
    };
    match (rig.camera(id), cameras) {
        (Some(camera), _) => Ok(vec![camera.clone()]),
        (None, [camera]) if is_foreign_file(&arguments.from)? => Ok(vec![Camera {
            id: id.clone(),
            ..camera.clone()
        }]),
        _ => {
            let names: Vec<&str> = cameras.iter().map(|camera| camera.id.as_str()).collect();
            bail!(
                "{}: there is no camera \"{id}\"; there are {}",
                arguments.from.display(),
                names.join(", ")
            )
        }
    }
}

fn shifted(lens: &Lens, shift: f64) -> anyhow::Result<Lens> {
    let mut parameters = lens.parameters();
    parameters[2] += shift;
    parameters[3] += shift;
    lens.with_parameters(&parameters)
        .context("the shifted lens is none")
}

/// The text of a rig file with these cameras in the place of those that it has.
fn merged(out: Option<&Path>, cameras: &[Camera]) -> anyhow::Result<String> {
    let existing = out.filter(|out| out.exists());
    if let Some(out) = out {
        ensure!(
            !has_foreign_name(out),
            "{}: the ending is that of another format but --to says toml; state --to ros, kalibr or opencv",
            out.display()
        );
    }
    let former = match existing {
        Some(out) => read_rig(out)?,
        None => Rig::default(),
    };
    let mut all = former.cameras().to_vec();
    for camera in cameras {
        let known = former.camera(&camera.id);
        let pose = camera.world_from_camera;
        let pose = pose.or(known.and_then(|known| known.world_from_camera));
        let taken = Camera::new(camera.id.clone(), camera.resolution, camera.lens, pose);
        match all.iter_mut().find(|known| known.id == camera.id) {
            Some(known) => *known = taken,
            None => all.push(taken),
        }
    }
    let rig = Rig::new(all).map_err(|error| Failure::new(Exit::Input, error))?;
    Ok(rig_toml(&rig.holding_on_to(&former)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::Pose;
    use sextant_site_files::read_object;

    const CAMERA_INFO: &str = "image_width: 640\nimage_height: 480\ncamera_name: left\ncamera_matrix: {rows: 3, cols: 3, \
        data: [600.0, 0.0, 320.0, 0.0, 601.0, 240.0, 0.0, 0.0, 1.0]}\ndistortion_model: plumb_bob\n\
        distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0.0, 0.0, 0.0, 0.0]}\n";

    fn arguments(from: &Path, out: &Path) -> ConvertArguments {
        ConvertArguments {
            from: from.to_owned(),
            recording: None,
            rig: None,
            objects: Vec::new(),
            ros2: false,
            to: Target::Toml,
            camera: None,
            pixel_origin: PixelOrigin::Centre,
            out: Some(out.to_owned()),
        }
    }

    #[test]
    fn an_imported_lens_leaves_the_cameras_pose_and_the_former_file_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (info, rig) = (
            folder.path().join("ost.yaml"),
            folder.path().join("rig.toml"),
        );
        std::fs::write(&info, CAMERA_INFO).unwrap();
        let mut convert = arguments(&info, &rig);
        convert.camera = Some("north".parse().unwrap());
        run(&convert, Format::Text).unwrap();
        let mut camera = read_rig(&rig).unwrap().cameras()[0].clone();
        assert_eq!(camera.id.as_str(), "north");
        let pose = Pose::translation(1.0, 2.0, 3.0);
        camera.world_from_camera = Some(pose);
        std::fs::write(&rig, rig_toml(&Rig::new(vec![camera]).unwrap())).unwrap();

        convert.pixel_origin = PixelOrigin::Edge;
        run(&convert, Format::Text).unwrap();
        let read = read_rig(&rig).unwrap();
        let [camera] = read.cameras() else {
            panic!("one camera")
        };
        assert_eq!(camera.world_from_camera, Some(pose));
        assert_eq!(camera.lens.intrinsics().cx, 319.5);
        let former = std::fs::read_to_string(sextant_site_files::former_of(&rig)).unwrap();
        assert!(former.contains("cx = 320.0"));
    }

    #[test]
    fn a_board_becomes_an_object_file() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("target.yaml");
        let kalibrs =
            "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.088\ntagSpacing: 0.3\n";
        std::fs::write(&target, kalibrs).unwrap();
        let out = folder.path().join("grid.toml");
        run(&arguments(&target, &out), Format::Text).unwrap();
        let board = read_object(&out).unwrap();
        assert_eq!((board.id().as_str(), board.tags().len()), ("grid", 30));
        let there = ConvertArguments {
            to: Target::Kalibr,
            ..arguments(&target, &out)
        };
        let error = run(&there, Format::Text).unwrap_err();
        assert!(error.to_string().contains("only --to toml"), "{error}");
    }

    #[test]
    fn a_rig_comes_back_from_every_format() {
        let folder = tempfile::tempdir().unwrap();
        let (info, rig) = (
            folder.path().join("left.yaml"),
            folder.path().join("rig.toml"),
        );
        std::fs::write(&info, CAMERA_INFO).unwrap();
        run(&arguments(&info, &rig), Format::Text).unwrap();
        for to in [Target::Ros, Target::Kalibr, Target::Opencv] {
            let out = folder.path().join("out.yaml");
            let there = ConvertArguments {
                to,
                ..arguments(&rig, &out)
            };
            run(&there, Format::Json).unwrap();
            assert_eq!(read_rig(&out).unwrap(), read_rig(&rig).unwrap(), "{to:?}");
        }
        let absent = ConvertArguments {
            camera: Some("north".parse().unwrap()),
            ..arguments(&rig, &folder.path().join("other.toml"))
        };
        let error = run(&absent, Format::Text).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("there is no camera \"north\"; there are left")
        );
    }
}
