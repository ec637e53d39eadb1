//! `sextant detect`: tags in pictures.

mod dataset;
mod families;
mod otherwise;
mod print;
mod sight;

use crate::model_files::read_rig;
use crate::output::{Format, print_line};
use anyhow::{Context, bail};
use clap::{ArgGroup, Args};
use families::{Sought, families};
pub(crate) use otherwise::NothingFound;
use sextant_apriltag::{Detector, Options, Tracker};
use sextant_explain::Explanation;
use sextant_process::{Exit, Failure, WithExit};
use sextant_replay::in_order;
use sextant_site_model::{Camera, CameraId};
use sight::{DetectedImage, detect, follow};
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Arguments of `sextant detect`.
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("written").args(["dataset", "explain"]))]
#[command(after_help = "With --json, one line per image:
  {\"file\",\"ms\",\"detections\":[{\"family\",\"id\",\"hamming\",\"margin\",\"corners\":[[x,\
  y]x4],\"corner_covariance\":[[xx,xy,yy]x4],\"corner_cross_covariance\":[[xx,xy,yx,yy]x6]}]}
Corners are clockwise from the top left, in pixels with (0, 0) at the centre of the top left pixel; covariances are in
square pixels. `ms` is the duration of the detection without reading the file: of one run or, with --reps N, the median
of N runs after a warm-up. With --tracking a line also has \"tracking\":{\"areas\",\"share\",\"followed\",
\"discovered\",\"awaited\"}: the number of areas searched, their share of the pixels, the tags decoded near their
prediction and elsewhere, and those not decoded but present in one of the three images before, which are not among the
detections.

An image that cannot be read is reported on standard error; the other images are processed, and the exit code is 3.

--explain IMAGE --out DIR draws each stage of the detection, with a legend: the pixels of the border colour in each pass
(1-threshold-PASS.png), their components (2-components-PASS.png), the quads (3-quads.png), the rejected candidates by
reason (4-rejected.png), the corners before and after refinement, enlarged (5-corners.png), the tags (6-tags.png); and
writes report.json with the counts and durations of the stages.")]
pub struct DetectArguments {
    /// Images (JPEG, PNG, PNM, WebP, TIFF or BMP, grey or colour); `-` reads paths from standard input, one per line.
    #[arg(value_name = "IMAGE", required_unless_present = "written")]
    images: Vec<PathBuf>,
    /// Number of threads, each with its own image.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
    /// Repetitions of the detection, for timing.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    reps: u32,
    /// Tag family to detect; may be repeated. `all` is for tags of an unknown family: it takes more time, and leaves
    /// out families of 16 bits (tag16h5, aruco4x4) and ChArUco boards, whose markers are found as ArUco tags.
    #[arg(long = "family", value_name = "FAMILY", default_value = "tag36h11")]
    families: Vec<Sought>,
    /// Detect tags that are printed inverted, white for black.
    #[arg(long)]
    inverted: bool,
    /// Track tags through the images of one camera: each image is searched near earlier tags and, in turn, elsewhere,
    /// so that a new tag is found within ten images.
    #[arg(long, conflicts_with_all = ["threads", "reps", "written"])]
    tracking: bool,
    /// Rig file with the lens of --camera, which is used to fit tags with distorted edges. Corners remain pixels of the
    /// image.
    #[arg(
        long,
        value_name = "FILE",
        requires = "camera",
        conflicts_with = "written"
    )]
    rig: Option<PathBuf>,
    /// Camera of the rig that took the images.
    #[arg(long, value_name = "ID", requires = "rig")]
    camera: Option<CameraId>,
    /// Process a recording (DIR/CAMERA/data.csv, or an MCAP file with images) and write OUT/CAMERA/detections.jsonl for
    /// `replay`.
    #[arg(
        long,
        value_name = "DIR|FILE.mcap",
        conflicts_with = "images",
        requires = "out",
        conflicts_with = "reps"
    )]
    dataset: Option<PathBuf>,
    /// Draw the stages of the detection in one image into the folder OUT.
    #[arg(
        long,
        value_name = "IMAGE",
        conflicts_with = "images",
        requires = "out"
    )]
    explain: Option<PathBuf>,
    /// Output folder of --dataset and --explain; for --dataset it may be DIR itself.
    #[arg(long, value_name = "OUT", requires = "written")]
    out: Option<PathBuf>,
}

/// Runs `sextant detect`.
///
/// # Errors
/// [`Exit::Usage`] for options that contradict each other, [`Exit::Input`] when a picture could not be used.
pub fn run(arguments: &DetectArguments, format: Format) -> anyhow::Result<()> {
    let options = Options {
        families: families(&arguments.families),
        inverted: arguments.inverted,
        ..Options::default()
    };
    // Made once here, so that making it for each thread cannot fail any more.
    Detector::new(options.clone()).exit_with(Exit::Usage)?;
    let threads = usize::from(arguments.threads);
    match (&arguments.dataset, &arguments.explain, &arguments.out) {
        (Some(dataset), _, Some(out)) => dataset::write_detections(dataset, out, threads, &options),
        (_, Some(picture), Some(out)) => {
            let explanation = Explanation::explain(picture, &options, arguments.reps);
            let explanation = explanation.exit_with(Exit::Input)?;
            explanation.write(out).exit_with(Exit::Input)?;
            let sight = DetectedImage {
                path: picture.clone(),
                ms: explanation.total_ms(),
                detections: explanation.detections().to_vec(),
                tracking: None,
            };
            Ok(print_line(&print::line(&sight, format))?)
        }
        _ => detect_each(arguments, threads, &options, format),
    }
}

fn detect_each(
    arguments: &DetectArguments,
    threads: usize,
    options: &Options,
    format: Format,
) -> anyhow::Result<()> {
    let (mut total, mut failed) = (0_usize, 0_usize);
    let mut nothing = NothingFound::default();
    let take = |sight: anyhow::Result<DetectedImage>| {
        total += 1;
        match sight {
            Ok(sight) => {
                nothing.add(&sight.path, sight.detections.len());
                print_line(&print::line(&sight, format))?;
            }
            Err(error) => {
                failed += 1;
                eprintln!("error: {error:#}");
            }
        }
        anyhow::Ok(())
    };
    let paths = paths(&arguments.images);
    let camera = camera(arguments)?;
    if arguments.tracking {
        let tracker = || Tracker::new(options.clone()).ok();
        let work = |tracker: &mut Option<Tracker>, path: io::Result<PathBuf>| {
            follow(tracker, &path?, camera.as_ref())
        };
        in_order(1, paths, tracker, work, take)?;
    } else {
        let work = |detector: &mut Option<Detector>, path: io::Result<PathBuf>| {
            detect(detector, &path?, arguments.reps, camera.as_ref())
        };
        in_order(threads, paths, || detector(options), work, take)?;
    }
    if let Some(hint) = nothing.hint(options) {
        eprintln!("hint: {hint}");
    }
    if failed > 0 {
        let cause = anyhow::anyhow!("{failed} of {total} pictures could not be used");
        bail!(Failure::new(Exit::Input, cause));
    }
    Ok(())
}

/// The camera whose lens is used.
fn camera(arguments: &DetectArguments) -> anyhow::Result<Option<Camera>> {
    let (Some(file), Some(id)) = (&arguments.rig, &arguments.camera) else {
        return Ok(None);
    };
    let rig = read_rig(file).exit_with(Exit::Input)?;
    let camera = rig
        .camera(id)
        .with_context(|| format!("{}: there is no camera \"{id}\"", file.display()))
        .exit_with(Exit::Input)?;
    Ok(Some(camera.clone()))
}

/// None where the options are refused, which [`run`] has seen already.
pub fn detector(options: &Options) -> Option<Detector> {
    Detector::new(options.clone()).ok()
}

/// The paths of the command line, with those of standard input in the place of `-`.
fn paths(arguments: &[PathBuf]) -> impl Iterator<Item = io::Result<PathBuf>> + Send {
    arguments.iter().flat_map(|argument| {
        let from_stdin = argument == Path::new("-");
        let given = (!from_stdin).then(|| Ok(argument.clone()));
        let read = from_stdin.then(|| BufReader::new(io::stdin()).lines());
        let read = read
            .into_iter()
            .flatten()
            .filter(|line| line.as_ref().map_or(true, |line| !line.is_empty()))
            .map(|line| line.map(PathBuf::from));
        given.into_iter().chain(read)
    })
}
