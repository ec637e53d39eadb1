//! `sextant replay`: a recording through the very estimator that runs live.

mod ledger;
mod models;
mod poses_file;
pub mod sight;
mod summary;

use crate::ordered::in_order;
use crate::output::{Format, print_line};
use crate::progress;
use anyhow::{Context, bail};
use clap::Args;
use ledger::Ledger;
use models::Models;
use poses_file::PosesFile;
use sextant_estimator::{Fusion, FusionOptions, ImageObservation, Input, ObjectEstimate, Output};
use sextant_process::{Exit, Failure, Shutdown, WithExit};
use sextant_recordings::{Dataset, Row, pose_json};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use summary::Summary;

/// Arguments of `sextant replay`.
#[derive(Args, Debug)]
#[command(
    after_help = "Images are processed in order of arrival (third column of data.csv, `arrival_ns` of detections.jsonl; otherwise the
capture time), then of capture time, then of camera. There is one pose per object and capture time: the estimate after the last
image of exactly that capture time, which later arrivals do not change. Poses are sorted by time, then object; the same
recording gives the same bytes.

JSON lines: {\"t_ns\",\"object\",\"position\":[3],\"orientation\":[x,y,z,w],\"covariance\":[36],\"twist\":[6],\"state\",\"cameras\",\"tags\",\"rms_px\"}
For an articulated object, whose pose is that of its base, also \"links\":[{\"link\",\"position\",\"orientation\",\"covariance\"}] and
\"joints\":[{\"joint\",\"value\",\"sigma\",\"velocity\"}], in radians or metres.
With --json and --out, one line on standard output: {\"images\",\"cameras\":[{\"id\",\"images\",\"late\",\"ahead\",\"unknown_tags\"}],\"objects\":[{\"id\",\"poses\"}]}
TUM: timestamp tx ty tz qx qy qz qw, as `evo` reads it; one object only."
)]
pub struct ReplayArguments {
    /// The recording: DIR/CAMERA/data.csv with DIR/CAMERA/data/*.png (8-bit grey), or DIR/CAMERA/detections.jsonl.
    #[arg(value_name = "DIR")]
    recording: PathBuf,
    /// Rig file.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// An object file; may be repeated.
    #[arg(long = "object", value_name = "FILE", required = true)]
    objects: Vec<PathBuf>,
    /// File for the poses, FILE.jsonl or FILE.tum, written atomically. By default JSON lines go to standard output.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replay at the recorded speed; poses go to standard output as they become final.
    #[arg(long)]
    realtime: bool,
    /// Number of detection threads; the poses do not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
}

/// Runs `sextant replay`.
///
/// # Errors
/// [`Exit::Input`] for a recording, rig or object that cannot be used; then nothing is written.
pub fn run(arguments: &ReplayArguments, format: Format) -> anyhow::Result<()> {
    let file = PosesFile::named(arguments.out.as_deref(), arguments.objects.len())?;
    if arguments.recording.extension().is_some_and(|e| e == "mcap") {
        let cause = anyhow::anyhow!(
            "{}: recordings in MCAP cannot be replayed yet; give a folder",
            arguments.recording.display()
        );
        bail!(Failure::new(Exit::Input, cause));
    }
    let models = Models::read(&arguments.rig, &arguments.objects)?;
    let dataset = Dataset::open(&arguments.recording).exit_with(Exit::Input)?;
    models.check_cameras(&dataset, &arguments.recording)?;
    let (poses, fusion) = replay(arguments, &models, &dataset, file.is_none())?;
    if let Some(file) = &file {
        file.write(&poses)?;
    }
    let summary = Summary::of(&dataset, &models.objects, &poses, &fusion);
    match format {
        Format::Text => eprintln!("{}", summary.text()),
        Format::Json if file.is_some() => print_line(&serde_json::to_string(&summary)?)?,
        Format::Json => {}
    }
    Ok(())
}

/// The final poses, sorted. In real time with nowhere else to go they are printed as they become final.
fn replay(
    arguments: &ReplayArguments,
    models: &Models,
    dataset: &Dataset,
    to_stdout: bool,
) -> anyhow::Result<(Vec<ObjectEstimate>, Fusion)> {
    let rows = dataset.rows_by_arrival();
    let options = models.detector_options();
    let fusion = Fusion::new(
        models.rig.clone(),
        models.objects.clone(),
        FusionOptions::default(),
    );
    let mut fusion = fusion.exit_with(Exit::Input)?;
    let mut ledger = Ledger::of(rows.iter().map(|row| models.capture_ns(row)));
    let mut pace = arguments.realtime.then(Pace::start).transpose()?;
    let mut poses = Vec::new();
    in_order(
        usize::from(arguments.threads),
        progress::over(rows.iter().copied(), "images"),
        || crate::detect::detector(&options),
        |detector, row| (row, sight::observation(detector, row, &models.rig)),
        |(row, seen): (&Row, anyhow::Result<ImageObservation>)| {
            let image = models.rig.timed(seen.exit_with(Exit::Input)?);
            let capture_ns = image.capture_ns;
            if let Some(pace) = &mut pace {
                pace.wait_for(row.arrival_ns)?;
            }
            fusion.handle(row.arrival_ns, Input::Image(image));
            let said = std::iter::from_fn(|| fusion.poll_output());
            let finals = ledger.took(capture_ns, said.filter_map(pose_of));
            if pace.is_some() && to_stdout {
                finals
                    .iter()
                    .try_for_each(|pose| print_line(&pose_json(pose)))?;
            }
            poses.extend(finals);
            Ok(())
        },
    )?;
    poses.sort_by(|a, b| (a.capture_ns, &a.object).cmp(&(b.capture_ns, &b.object)));
    if pace.is_none() && to_stdout {
        poses
            .iter()
            .try_for_each(|pose| print_line(&pose_json(pose)))?;
    }
    Ok((poses, fusion))
}

fn pose_of(output: Output) -> Option<ObjectEstimate> {
    match output {
        Output::Pose(estimate) => Some(estimate),
        Output::Refused(_) | Output::ClockStep { .. } => None,
    }
}

/// Replay at the recorded speed.
struct Pace {
    shutdown: Shutdown,
    start: Option<(Instant, u64)>,
}

impl Pace {
    fn start() -> anyhow::Result<Self> {
        let shutdown = Shutdown::install().context("signals cannot be caught")?;
        Ok(Self {
            shutdown,
            start: None,
        })
    }

    fn wait_for(&mut self, arrival_ns: u64) -> anyhow::Result<()> {
        let (start, first_ns) = *self.start.get_or_insert((Instant::now(), arrival_ns));
        let due = start + Duration::from_nanos(arrival_ns.saturating_sub(first_ns));
        if self
            .shutdown
            .wait(due.saturating_duration_since(Instant::now()))
        {
            let cause = anyhow::anyhow!("interrupted");
            bail!(Failure::new(Exit::Interrupted, cause));
        }
        Ok(())
    }
}
