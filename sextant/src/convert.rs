//! `sextant convert`: lenses and poses to and from ROS, Kalibr and OpenCV, their calibration boards, and recordings,
//! also to bags of ROS 2 and to animations.

mod animation;
mod recording;
mod ros2;

use crate::animation_file::AnimationFormat;
use crate::model_files::{read_object, read_rig, say_assumptions};
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
    ForeignFormat, assumptions, field_layout, foreign_text, has_foreign_name, is_foreign,
    object_toml, read_board, read_text, rig_toml, write_keeping_former,
};
use sextant_site_model::{Camera, CameraId, ObjectModel, Rig};
use std::path::{Path, PathBuf};

/// Arguments of `sextant convert`.
#[derive(Args, Debug)]
#[command(
    after_help = "FROM is a rig.toml, or a calibration of ROS (camera_info), Kalibr (camchain), OpenCV (YAML, JSON,
XML), PhotonVision, WPILib, anipose, caliscope, MATLAB (JSON), nerfstudio, EuRoC, ORB-SLAM, stella_vslam, Basalt,
RealSense, ZED or Metashape; the format is recognised by its contents. Or it describes a board: a Kalibr target.yaml, a
ChArUco board with squaresX, squaresY, squareLength, markerLength and dictionary, or a grid of markers with markersX,
markersY, markerLength, markerSeparation and dictionary; then the object file of the board is written. Such a file is
also accepted wherever an object file is expected. With --to wpilib, an object whose frame is a field becomes a field
layout of WPILib, with the size of the field from --field. Cameras are merged into an existing rig.toml: one with the
same id gets the new lens and keeps its pose if FROM has none. The previous file is kept as rig.toml.former.

All these formats have pixel (0, 0) at the centre of the top left pixel, as Sextant has. Calibrations from corners with
(0, 0) at its edge (AprilTag's C library) are larger by half a pixel: use --pixel-origin edge.

A recording is converted from a folder in EuRoC's layout to an MCAP file, or back; images and detections come back byte
for byte. From a folder, --rig and --object put the models into the file, so that it can be replayed; detections need
the rig. To a folder, rig.toml, OBJECT.toml, CAMERA/data.csv with CAMERA/data/*.png, and CAMERA/detections.jsonl are
written; replay takes the detections where there are both.

With --ros2, a recording in an MCAP file becomes a bag of ROS 2, a new folder for `ros2 bag`, PlotJuggler and Rerun: the
topics of `sextant ros2` and, where images were recorded, /sextant/camera/ID/image/compressed with .../camera_info at
their times. See docs/ros2.md.

To a name that ends with .usda or .glb, the poses of a recording in an MCAP file are written as an animation in USD
(text) or binary glTF: objects with their tags, and cameras with lenses. Objects are invisible while they are lost; in
glTF they are scaled to zero. See docs/outputs.md.

With --json and a recording: {\"to\",\"images\",\"detections\"}; with --ros2: {\"to\",\"messages\",
\"topics\":{NAME:messages},\"left_out\":{CAUSE:messages}}; to .usda or .glb: {\"to\",\"cameras\",\"objects\",
\"seconds\",\"left_out\":{\"cameras\":[ID],\"objects\":[ID],\"tags\"}}. With --json and --out:
{\"file\",\"cameras\",\"assumed\"} or {\"file\",\"object\",\"tags\",\"assumed\"}; assumed: what FROM leaves open, such
as a unit.

For example: sextant convert ost.yaml --camera north --out rig.toml
             sextant convert camchain.yaml --out rig.toml
             sextant convert target.yaml --out board.toml
             sextant convert rig.toml --to kalibr --out camchain.yaml
             sextant convert rig.toml --to ros --camera north --out north.yaml
             sextant convert field.toml --to wpilib --field 16.541,8.069 --out field.json
             sextant convert DIR site.mcap --rig rig.toml --object cube.toml
             sextant convert site.mcap DIR
             sextant convert site.mcap BAG --ros2
             sextant convert site.mcap site.usda"
)]
pub struct ConvertArguments {
    /// File to read, or a recording: a folder or an MCAP file.
    from: PathBuf,
    /// Recording to write: an MCAP file or a new folder; with --ros2 a bag, a new folder. Or an animation: FILE.usda,
    /// FILE.glb.
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
    /// Length and width of the field of --to wpilib, m, such as 16.541,8.069.
    #[arg(long, value_name = "LENGTH,WIDTH", value_parser = field_size)]
    field: Option<[f64; 2]>,
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
    /// WPILib's field layout, from an object file; with --field.
    Wpilib,
}

/// Length and width of a field, m.
fn field_size(text: &str) -> Result<[f64; 2], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|m| m.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[length, width]) if length > 0.0 && width > 0.0 && (length + width).is_finite() => {
            Ok([length, width])
        }
        _ => Err("give length and width in metres, such as 16.541,8.069".to_owned()),
    }
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
        if let Some(animation_format) = AnimationFormat::named(to)? {
            refuse_with_animation(arguments).exit_with(Exit::Usage)?;
            return animation::run(&arguments.from, to, animation_format, format);
        }
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
    if arguments.to == Target::Wpilib {
        return write_field(arguments, format);
    }
    if arguments.field.is_some() {
        let error = anyhow::anyhow!("--field is the size of a field layout; give --to wpilib, too");
        return Err(error).exit_with(Exit::Usage);
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

/// Options that say nothing about an animation.
fn refuse_with_animation(arguments: &ConvertArguments) -> anyhow::Result<()> {
    if arguments.ros2 {
        bail!("a bag of ROS 2 is a folder; give a name without .usda or .glb, or leave out --ros2");
    }
    if arguments.rig.is_some() || !arguments.objects.is_empty() {
        bail!(
            "an animation has the rig and the objects of the recording; leave out --rig and --object"
        );
    }
    Ok(())
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

/// Writes an object whose frame is a field as a layout of WPILib.
fn write_field(arguments: &ConvertArguments, format: Format) -> anyhow::Result<()> {
    let from = arguments.from.display();
    let size = arguments.field.with_context(
        || "--to wpilib needs the length and width of the field in metres: --field 16.541,8.069",
    );
    let size = size.exit_with(Exit::Usage)?;
    let object = read_object(&arguments.from).exit_with(Exit::Input)?;
    let text = field_layout(&object, size)
        .map_err(|c| anyhow::anyhow!("{from}: {}; {}", c.cause, c.remedy))
        .exit_with(Exit::Input)?;
    let unplaced = object.tags().iter();
    let unplaced = unplaced.filter(|tag| tag.object_from_tag.is_none()).count();
    if unplaced > 0 {
        let unplaced = words::count(unplaced, "tag");
        eprintln!("{from}: {unplaced} without a place on the object left out");
    }
    let Some(out) = &arguments.out else {
        return Ok(print_line(text.trim_end())?);
    };
    write_keeping_former(out, text.as_bytes())?;
    say_object(arguments, out, &object, format)
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
        let error =
            anyhow::anyhow!("{from} describes a board; only --to toml and wpilib take that");
        return Err(error).exit_with(Exit::Usage);
    }
    let text = object_toml(board);
    let Some(out) = &arguments.out else {
        return Ok(print_line(text.trim_end())?);
    };
    write_keeping_former(out, text.as_bytes())?;
    say_object(arguments, out, board, format)
}

fn say_object(
    arguments: &ConvertArguments,
    out: &Path,
    object: &ObjectModel,
    format: Format,
) -> anyhow::Result<()> {
    let placed = object.tags().iter();
    let tags = placed.filter(|tag| tag.object_from_tag.is_some()).count();
    let line = match format {
        Format::Json => {
            let (object, assumed) = (object.id().as_str(), assumed(arguments)?);
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
        // An object, not cameras.
        Target::Toml | Target::Wpilib => None,
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
        let mount = known.and_then(|known| known.mount.clone());
        let taken = Camera {
            mount: mount.filter(|_| pose.is_none()),
            ..Camera::new(camera.id.clone(), camera.resolution, camera.lens, pose)
        };
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

    const CAMERA_INFO: &str = "image_width: 640\nimage_height: 480\ncamera_name: left\n\
        camera_matrix: {rows: 3, cols: 3, \
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
            field: None,
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
    fn a_field_layout_comes_back_and_wrong_options_say_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let [object, layout] = ["field.toml", "field.json"].map(|name| folder.path().join(name));
        let text = "id = \"field\"\n[[tag]]\nfamily = \"tag36h11\"\nid = 7\nsize = 0.1651\n\
            object_from_tag = { position = [15.0, 1.0, 1.5], orientation = [0.0, 0.0, 0.0, 1.0] }\n";
        std::fs::write(&object, text).unwrap();
        let there = |field| ConvertArguments {
            to: Target::Wpilib,
            field,
            ..arguments(&object, &layout)
        };
        let error = run(&there(None), Format::Text).unwrap_err();
        assert!(
            error.to_string().contains("--field 16.541,8.069"),
            "{error}"
        );
        run(&there(Some([16.541, 8.069])), Format::Text).unwrap();
        let back = arguments(&layout, &folder.path().join("field.toml"));
        run(&back, Format::Text).unwrap();
        assert_eq!(read_object(&back.out.unwrap()).unwrap().tags().len(), 1);
        let without = ConvertArguments {
            to: Target::Toml,
            ..there(Some([16.541, 8.069]))
        };
        let error = run(&without, Format::Text).unwrap_err();
        assert!(error.to_string().contains("give --to wpilib"), "{error}");
        for wrong in ["16", "16,", "0,8", "nan,8", "1,2,3"] {
            assert!(field_size(wrong).is_err(), "{wrong}");
        }
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
