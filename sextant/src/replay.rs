//! `sextant replay`: a recording through the very estimator that runs live.

mod delivery;
mod poses_file;
mod summary;
mod table;

use crate::model_files::{read_rig, say_assumptions};
use crate::output::{Format, print_line};
use crate::robot_frame::OutputFrame;
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use delivery::Delivery;
use poses_file::{PosesFile, Scene};
use sextant_evaluation::reference::{self, ReferenceError};
use sextant_evaluation::{
    Alignment, compare as compared, no_common_time, other_conventions, plots,
};
use sextant_process::{Exit, Failure, WithExit};
use sextant_proto::NodeId;
use sextant_recordings::Dataset;
use sextant_recordings::mcap::reader::Ending;
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_replay::{
    Order, Plan, Replacement, ReplayModels, read_objects, replay_folder, replay_plan,
};
use sextant_site_report::ObjectEstimate;
use std::collections::BTreeSet;
use std::path::PathBuf;
use summary::Summary;

/// Arguments of `sextant replay`.
#[derive(Args, Debug)]
#[command(
    after_help = "Images of a folder are processed in order of arrival (third column of data.csv, `arrival_ns` of
detections.jsonl; otherwise the capture time), then of capture time, then of camera; those of an MCAP file as the
recorded fusion node processed them, with the rig and the objects that it had. There is one pose per object and capture
time: the estimate after the last image of exactly that capture time, which later arrivals do not change. Poses are
sorted by time, then object; the same recording gives the same bytes. Of an MCAP file, the poses that were published
live are compared bit for bit: they are identical where the recording began before the node's first image.

JSON lines: {\"t_ns\",\"object\",\"position\":[3],\"orientation\":[x,y,z,w],\"covariance\":[36],\"twist\":[6],\"state\",
\"cameras\",\"tags\",\"rms_px\"} For an articulated object, whose pose is that of its base, also \"links\":[{\"link\",
\"position\",\"orientation\",\"covariance\"}] and \"joints\":[{\"joint\",\"value\",\"sigma\",\"velocity\"}], in radians
or metres. With --json and --out, one line on standard output: {\"images\",\"cameras\":[{\"id\",\"images\",\"late\",
\"ahead\",\"unknown_tags\"}],\"objects\":[{\"id\",\"poses\"}],\"notices\"}, of an MCAP file
\"live\":{\"identical\",\"different\",\"without_inputs\"}, with --against \"against\":[\"none\"|\"rigid\",[{\"object\",
\"compared\",\"without_reference\",\"position_mm\":{\"rms\",\"median\",\"p95\",\"max\"},\"attitude_deg\":{...},
\"nees\",\"within_95\"}]] TUM: timestamp tx ty tz qx qy qz qw, as `evo` reads it; one object only. C3D: a point (its
origin, mm) and a rotation of each object, at a constant rate; docs/formats.md has more. USD (.usda) and glTF (.glb):
objects and cameras as an animation; docs/outputs.md has more."
)]
pub struct ReplayArguments {
    /// The recording: an MCAP file of `sextant record`, or DIR/CAMERA/data.csv with the pictures in DIR/CAMERA/data, or
    /// DIR/CAMERA/detections.jsonl.
    #[arg(value_name = "DIR|FILE.mcap")]
    recording: PathBuf,
    /// Rig file; of an MCAP file in place of the recorded rig.
    #[arg(long, value_name = "FILE")]
    rig: Option<PathBuf>,
    /// An object file; may be repeated; of an MCAP file in place of all recorded objects.
    #[arg(long = "object", value_name = "FILE")]
    objects: Vec<PathBuf>,
    /// Fusion node whose inputs are replayed; by default the one with the most in the file.
    #[arg(long, value_name = "ID")]
    node: Option<NodeId>,
    /// File for the poses, FILE.jsonl, FILE.tum, FILE.c3d, FILE.usda or FILE.glb, written atomically. By default JSON
    /// lines go to standard output.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Give poses in the base of this robot, a file of `sextant calibrate robot`, instead of the world; those of
    /// --against are then in the base, too.
    #[arg(long, value_name = "FILE")]
    frame: Option<PathBuf>,
    /// Compare with the poses of this file: another recording (its truth where it is simulated, else its poses), JSON
    /// lines of poses, TUM text, or EuRoC's ground truth CSV; may be repeated. A file of one trajectory is of the
    /// object after which it is named, or of the only one.
    #[arg(long, value_name = "FILE")]
    against: Vec<PathBuf>,
    /// Motion allowed between the world of the poses and that of --against.
    #[arg(long, value_enum, default_value = "none", requires = "against")]
    align: AlignmentName,
    /// Folder for plots of the errors over time, OBJECT.png: position, attitude, NEES.
    #[arg(long, value_name = "DIR", requires = "against")]
    plots: Option<PathBuf>,
    /// Replay at the recorded speed; poses go to standard output as they become final.
    #[arg(long)]
    realtime: bool,
    /// Number of detection threads; the poses do not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
}

/// Value of `--align`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AlignmentName {
    /// None: both have the same world frame.
    None,
    /// The rigid motion of the whole world that fits the poses of all objects best.
    Rigid,
}

impl From<AlignmentName> for Alignment {
    fn from(name: AlignmentName) -> Self {
        match name {
            AlignmentName::None => Self::None,
            AlignmentName::Rigid => Self::Rigid,
        }
    }
}

/// Runs `sextant replay`.
///
/// # Errors
/// [`Exit::Input`] for a recording, rig or object that cannot be used; then nothing is written.
pub fn run(arguments: &ReplayArguments, format: Format) -> anyhow::Result<()> {
    let file = arguments.out.as_deref().map(PosesFile::named).transpose()?;
    if file.as_ref().is_some_and(PosesFile::is_animation) && arguments.frame.is_some() {
        let cause = anyhow::anyhow!(
            "an animation has cameras, which stand in the world; leave out --frame"
        );
        bail!(Failure::new(Exit::Usage, cause));
    }
    let delivery = Delivery {
        frame: OutputFrame::read(arguments.frame.as_deref())?,
        is_realtime: arguments.realtime,
        prints: file.is_none(),
    };
    let (poses, mut summary, scene) = if arguments.recording.is_file() {
        file_replayed(arguments, delivery)?
    } else {
        folder_replayed(arguments, delivery)?
    };
    if let Some(file) = &file {
        file.write(&poses, scene)?;
    }
    compare(arguments, &poses, &mut summary)?;
    match format {
        Format::Text => eprintln!("{}", summary.text()),
        Format::Json if file.is_some() => {
            print_line(&serde_json::to_string(&summary)?)?;
        }
        Format::Json => {}
    }
    Ok(())
}

/// Compares with the references, if any are named.
fn compare(
    arguments: &ReplayArguments,
    poses: &[ObjectEstimate],
    summary: &mut Summary,
) -> anyhow::Result<()> {
    if arguments.against.is_empty() {
        return Ok(());
    }
    if poses.is_empty() {
        let words = summary.text();
        let cause = anyhow::anyhow!("--against: the replay gives no pose to compare: {words}");
        bail!(Failure::new(Exit::Input, cause));
    }
    let objects: BTreeSet<_> = poses.iter().map(|p| p.object.clone()).collect();
    let references = reference::read(&arguments.against, &objects)
        .map_err(|error| match error {
            ReferenceError::UnknownFormat(_) | ReferenceError::UnknownObject { .. } => {
                anyhow::anyhow!("--against {error}")
            }
            error => error.into(),
        })
        .exit_with(Exit::Input)?;
    let alignment = arguments.align.into();
    let comparisons = compared(poses, &references, alignment);
    if comparisons.is_empty() {
        let cause = anyhow::anyhow!("--against: {}", no_common_time(poses, &references));
        bail!(Failure::new(Exit::Input, cause));
    }
    if let Some(folder) = &arguments.plots {
        plots::write(folder, &comparisons)?;
    }
    summary
        .notices
        .extend(other_conventions(poses, &references));
    summary.against = Some((alignment, comparisons));
    Ok(())
}

fn folder_replayed(
    arguments: &ReplayArguments,
    delivery: Delivery,
) -> anyhow::Result<(Vec<ObjectEstimate>, Summary, Scene)> {
    let (Some(rig), false) = (&arguments.rig, arguments.objects.is_empty()) else {
        let cause = anyhow::anyhow!(
            "a folder has no rig and no objects: name their files with --rig and --object"
        );
        bail!(Failure::new(Exit::Usage, cause));
    };
    let models = ReplayModels::read(rig, &arguments.objects).exit_with(Exit::Input)?;
    for file in arguments.objects.iter().chain([rig]) {
        say_assumptions(file).exit_with(Exit::Input)?;
    }
    let dataset = Dataset::open(&arguments.recording).exit_with(Exit::Input)?;
    dataset.check_times().exit_with(Exit::Input)?;
    models
        .check_cameras(&dataset, &arguments.recording)
        .exit_with(Exit::Input)?;
    let threads = usize::from(arguments.threads);
    let images = dataset.rows_by_arrival().len() as u64;
    let replayed = delivery.deliver(Some(images), |observer| {
        replay_folder(&dataset, &models, threads, observer)
    })?;
    let summary = Summary::new(&replayed);
    let scene = Scene {
        rig: models.rig,
        objects: models.objects,
    };
    Ok((replayed.poses, summary, scene))
}

fn file_replayed(
    arguments: &ReplayArguments,
    delivery: Delivery,
) -> anyhow::Result<(Vec<ObjectEstimate>, Summary, Scene)> {
    let rig = arguments.rig.as_deref().map(read_rig).transpose();
    let objects = match &arguments.objects[..] {
        [] => Ok(None),
        files => read_objects(files).map(Some),
    };
    for file in &arguments.objects {
        say_assumptions(file).exit_with(Exit::Input)?;
    }
    let replacement = Replacement {
        rig: rig.exit_with(Exit::Input)?,
        objects: objects.exit_with(Exit::Input)?,
    };
    let recording = SiteRecording::read(&arguments.recording).exit_with(Exit::Input)?;
    let path = arguments.recording.display();
    let place = match &recording.ending {
        Ending::Closed => path.to_string(),
        ending => format!("{path}: {ending}"),
    };
    let plan = Plan::new(&recording, arguments.node.as_ref(), &replacement)
        .context(place)
        .exit_with(Exit::Input)?;
    let mut notices = notices(&recording, &plan);
    let last = plan.runs.last();
    let scene = Scene {
        rig: last.map(|run| run.rig.clone()).unwrap_or_default(),
        objects: last.map_or(Vec::new(), |run| run.objects.clone()),
    };
    let mut replayed = delivery.deliver(None, |observer| {
        replay_plan(plan, &recording.poses, observer)
    })?;
    if replacement.rig.is_some() || replacement.objects.is_some() {
        replayed.live = None;
    }
    let mut summary = Summary::new(&replayed);
    notices.append(&mut summary.notices);
    summary.notices = notices;
    Ok((replayed.poses, summary, scene))
}

/// What a person should know about a recording.
fn notices(recording: &SiteRecording, plan: &Plan) -> Vec<String> {
    let mut notices = Vec::new();
    if recording.ending != Ending::Closed {
        notices.push(recording.ending.to_string());
    }
    if recording.rejected > 0 {
        notices.push(format!(
            "{} messages are damaged or of another version",
            recording.rejected
        ));
    }
    match &plan.order {
        Order::Inputs { first: 0, .. } => {}
        Order::Inputs { node, first } => notices.push(format!(
            "the recording begins after {first} inputs of the fusion node {node}: the first \
             poses differ from those published live"
        )),
        Order::Arrival { cause } => notices.push(format!(
            "images are replayed as they arrived at the recorder, since {cause}: poses may \
             differ from those published live"
        )),
    }
    if plan.missing > 0 {
        notices.push(format!(
            "{} images of the fusion node are not in the recording: poses after them differ from those published live",
            plan.missing
        ));
    }
    if recording.info.version != env!("CARGO_PKG_VERSION") {
        notices.push(format!(
            "recorded by version {}, replayed by {}: poses may differ from those published live",
            crate::words::plain(&recording.info.version),
            env!("CARGO_PKG_VERSION")
        ));
    }
    notices
}
