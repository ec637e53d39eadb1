//! `sextant calibrate robot`: where a robot's base is and what its hand carries, from its poses and images.

use crate::model_files::{read_object, read_rig};
use crate::output::{Format, print_line};
use crate::procedure::{ImageSelection, each_image, wrong};
use crate::recorded::{Preferred, Recorded};
use crate::words;
use anyhow::{anyhow, bail};
use clap::Args;
use sextant_adjustment::Mount;
use sextant_calibrator::{CalibratedRobot, RobotPlan, RobotPoses, RobotReport, RobotSession};
use sextant_evaluation::reference::{KeyedPoses, read_poses};
use sextant_process::{Exit, Failure, WithExit};
use sextant_replay::{ChessboardSearch, PartialViews};
use sextant_site_files::{Carried, RobotModel, UncertainPose, write_robot};
use sextant_site_model::{CameraId, ObjectId, PoseSigma, Rig};
use std::path::PathBuf;

/// Arguments of `sextant calibrate robot`.
#[derive(Args, Debug)]
#[command(
    after_help = "The hand carries a tagged object before cameras that stand still, or, with --on-hand CAMERA, a camera
before an object that lies still. Record images while the robot goes to 15 poses or more (or moves slowly): the object
near and all over the image, the hand turned by 30 degrees or more about at least two axes. Turns about one axis alone
leave a shift along it open; the report names it.

Robot poses are a CSV table with a header, such as t [ns],x,y,z,qx,qy,qz,qw (seconds, milliseconds and millimetres are
known, too), or TUM text: the hand in the robot's base. With times, an image counts between two poses that are at most
0.2 s apart, or at exactly the time of one; where the hand moves, the offset of the robot's clock is estimated. Where it
stands still for each image, write a column `image` with the number of the image in its camera, from 0 in the order of
capture, in place of the time; images of several cameras with one number show one pose.

Lenses, tags and the poses of all cameras but the first are adjusted by their sigmas or defaults, save those with a
sigma of zero. The first camera holds the world: covariances are relative to it. The noise of the robot's poses is
estimated from what robot and images disagree by. Held-out errors are those of a tenth of the poses at a time, predicted
from the others.

With --out, a file is written that `sextant replay --frame` and `sextant echo --frame` use to give poses in the robot's
base. Its world is that of the rig; with --on-hand it is the frame of the object. Where the motions leave something
open, the file is written and the exit code is 4; with --strict nothing is written and the exit code is 3.

With --json, the result is one line on standard output: {\"images\",\"poses\",\"outliers\",
\"base_from_world\":{\"position\",\"orientation\"},\"hand_from_carried\":{...},\"base_sigma_mm\",\"base_sigma_deg\",
\"hand_sigma_mm\",\"hand_sigma_deg\",\"robot_sigma_mm\",\"robot_sigma_deg\",\"held_out\":{\"poses\",\"rms_mm\",
\"rms_deg\",\"rms_px\",\"median_mm\",\"median_deg\"},\"clock_offset_ms\",\"clock_sigma_ms\",\"rms_px\",
\"undetermined\",\"verdict\":{\"grade\",\"because\"}}. Covariances are in the file."
)]
pub struct RobotArguments {
    /// The recording: DIR/CAMERA/data.csv with the pictures in DIR/CAMERA/data, or DIR/CAMERA/detections.jsonl, or an
    /// MCAP file.
    #[arg(value_name = "DIR|FILE.mcap")]
    recording: PathBuf,
    /// Poses of the hand in the robot's base: CSV with a header, or TUM text.
    #[arg(long, value_name = "FILE")]
    poses: PathBuf,
    /// Rig file with the lenses and poses of the cameras. A single camera may be without a pose: it is the world then.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// Object file of the tags on the hand or, with --on-hand, of those that lie still.
    #[arg(long, value_name = "FILE")]
    object: PathBuf,
    /// The camera that the hand carries.
    #[arg(long, value_name = "CAMERA")]
    on_hand: Option<CameraId>,
    /// File for the result.
    #[arg(long, value_name = "FILE", default_value = "robot.toml")]
    out: PathBuf,
    /// Number of detection threads; the result does not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
    /// Refuse a result that the motions leave open in part.
    #[arg(long)]
    strict: bool,
}

/// Runs `sextant calibrate robot`.
///
/// # Errors
/// [`Exit::Input`] for files that cannot be used and images that give no result; then nothing is written.
/// [`Exit::Unavailable`] after a result of which the motions leave a part open.
pub fn run(arguments: &RobotArguments, format: Format) -> anyhow::Result<()> {
    let rig = read_rig(&arguments.rig).exit_with(Exit::Input)?;
    let object = read_object(&arguments.object).exit_with(Exit::Input)?;
    let poses = match read_poses(&arguments.poses).exit_with(Exit::Input)? {
        KeyedPoses::ByTime(poses) => RobotPoses::ByTime(poses),
        KeyedPoses::ByImage(poses) => RobotPoses::ByImage(poses),
    };
    let chessboard = ChessboardSearch::among([&object], PartialViews::LeftOut);
    let preferred = match chessboard {
        Some(_) => Preferred::Pictures,
        None => Preferred::Detections,
    };
    let recorded = Recorded::open(&arguments.recording, preferred, arguments.on_hand.as_ref())?;
    let (rig, mount) = match &arguments.on_hand {
        Some(camera) => (with_one_camera(&rig, camera, arguments)?, Mount::Camera),
        None => (rig, Mount::Object),
    };
    let looking = ImageSelection {
        cameras: arguments.on_hand.iter().cloned().collect(),
        families: object.tags().iter().map(|tag| tag.tag.family).collect(),
        chessboard,
        rig,
    };
    let carried = object.id().clone();
    let plan = RobotPlan { object, mount };
    let mut session = RobotSession::new(&looking.rig, plan).exit_with(Exit::Input)?;
    let (folder, dataset) = (arguments.recording.as_path(), &recorded.dataset);
    each_image(folder, dataset, &looking, arguments.threads, |image| {
        session.handle(image);
    })?;
    let found = session.solve(&poses).exit_with(Exit::Input)?;
    let open = found.report.undetermined.join("; ");
    if arguments.strict && !open.is_empty() {
        bail!(Failure::new(Exit::Input, anyhow!("{open}")));
    }
    write_robot(&arguments.out, &robot_model(&found, arguments, carried))?;
    match format {
        Format::Json => print_line(&serde_json::to_string(&found.report)?)?,
        Format::Text => print_line(&text(&found.report, arguments))?,
    }
    if open.is_empty() {
        return Ok(());
    }
    bail!(Failure::new(Exit::Unavailable, anyhow!("partial: {open}")))
}

fn with_one_camera(rig: &Rig, id: &CameraId, arguments: &RobotArguments) -> anyhow::Result<Rig> {
    match rig.camera(id) {
        Some(camera) => Rig::new(vec![camera.clone()]).exit_with(Exit::Input),
        None => {
            let file = arguments.rig.display();
            wrong(format!("--on-hand {id}: {file} has no camera of that name"))?;
            Ok(rig.clone())
        }
    }
}

fn robot_model(
    found: &CalibratedRobot,
    arguments: &RobotArguments,
    object: ObjectId,
) -> RobotModel {
    let report = &found.report;
    let pose = UncertainPose {
        pose: found.hand_from_carried,
        covariance: found.hand_covariance,
    };
    RobotModel {
        base_from_world: UncertainPose {
            pose: found.base_from_world,
            covariance: found.base_covariance,
        },
        carried: Some(match &arguments.on_hand {
            Some(camera) => Carried::Camera(camera.clone(), pose),
            None => Carried::Object(object, pose),
        }),
        pose_sigma: Some(PoseSigma {
            position_m: 1e-3 * report.robot_sigma_mm,
            orientation_rad: report.robot_sigma_deg.to_radians(),
        }),
        clock_offset_s: report.clock_offset_ms.map(|ms| 1e-3 * ms),
    }
}

fn text(report: &RobotReport, arguments: &RobotArguments) -> String {
    let carried = match arguments.on_hand {
        Some(_) => "camera on the hand",
        None => "object on the hand",
    };
    let row = |name: &str, parts: &sextant_geometry::PoseParts, mm: f64, deg: f64| {
        let [x, y, z] = parts.position.map(|m| 1e3 * m);
        format!("{name:<20} {x:>9.2} {y:>9.2} {z:>9.2} {mm:>9.2} {deg:>7.3}")
    };
    let mut lines = vec![
        "                          x mm      y mm      z mm  sigma mm     deg".to_owned(),
        row(
            "world in the base",
            &report.base_from_world,
            report.base_sigma_mm,
            report.base_sigma_deg,
        ),
        row(
            carried,
            &report.hand_from_carried,
            report.hand_sigma_mm,
            report.hand_sigma_deg,
        ),
        format!(
            "Robot and images disagree by {:.2} mm and {:.3} degrees an axis, at a pose.",
            report.robot_sigma_mm, report.robot_sigma_deg
        ),
    ];
    if let Some(held_out) = &report.held_out {
        lines.push(format!(
            "{} of {} poses, each held out, are predicted to {:.2} mm, {:.3} degrees and {:.2} \
             px (rms; median {:.2} mm, {:.3} degrees).",
            held_out.poses,
            report.poses,
            held_out.rms_mm,
            held_out.rms_deg,
            held_out.rms_px,
            held_out.median_mm,
            held_out.median_deg
        ));
    }
    lines.push(format!(
        "{}: {} poses of {} images, {:.3} px rms; {}",
        arguments.out.display(),
        report.poses,
        report.images,
        report.rms_px,
        report.verdict.grade
    ));
    lines.extend(words::reasons(&report.verdict));
    lines.join("\n")
}
