//! `sextant detect`: tags in pictures.

mod dataset;
pub mod explain;
mod print;
mod sight;

use crate::ordered::in_order;
use crate::output::{Format, print_line};
use anyhow::{Context, bail};
use clap::{ArgGroup, Args};
use sextant_apriltag::{Detector, Options, Tracker};
use sextant_estimator::{Camera, CameraId};
use sextant_process::{Exit, Failure, WithExit};
use sextant_site_files::read_rig;
use sextant_tag_families::Family;
use sight::{Sight, follow, look};
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

pub use sight::{detected_tags, image_of};

/// What a person may choose of `detect`.
#[derive(Args, Debug)]
#[command(group = ArgGroup::new("written").args(["dataset", "explain"]))]
#[command(after_help = "With --json, a line an image:
  {\"file\",\"ms\",\"detections\":[{\"family\",\"id\",\"hamming\",\"margin\",\"corners\":[[x,y]x4],\"corner_covariance\":[[xx,xy,yy]x4],\"corner_cross_covariance\":[[xx,xy,yx,yy]x6]}]}
Corners run from the top left clockwise, pixels, (0, 0) at the centre of the top-left one, covariances in square pixels. `ms` is the time of the detection
alone, without reading the file: of one run, or with --reps N the median of N runs after one that does not count.
With --tracking a line also has \"tracking\":{\"areas\",\"share\",\"followed\",\"discovered\",\"awaited\"}: the parts of the picture
that were searched, the share of its pixels in them, the tags decoded about where they were expected and elsewhere, and those not
decoded but in one of the three pictures before, which are not among the detections.

A picture that cannot be read is complained about on standard error; the others are still done, then the exit code is 3.

--explain IMAGE --out DIR makes DIR and in it, numbered by stage and with a legend each: which pixels have the border's colour,
for each pass over the image (1-threshold-PASS.png); their components (2-components-PASS.png); the quads around them
(3-quads.png); those that were no tag, in a colour a reason (4-rejected.png); each tag's corners before and after the fit, close
up (5-corners.png); the tags (6-tags.png); and report.json with counts and times of the stages.")]
pub struct DetectArguments {
    /// Pictures (PNG of 8 bits, grey or colour); `-` takes paths from standard input, one a line.
    #[arg(value_name = "IMAGE", required_unless_present = "written")]
    images: Vec<PathBuf>,
    /// Threads that work on different pictures at the same time.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
    /// Repetitions of the detection, for timing.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    reps: u32,
    /// Tag family to look for; may be repeated.
    #[arg(long = "family", value_name = "FAMILY", default_value = "tag36h11")]
    families: Vec<Family>,
    /// The pictures are one camera's, one after the other: each is searched where tags were, and elsewhere in turn, so that
    /// a new tag is found within ten pictures.
    #[arg(long, conflicts_with_all = ["threads", "reps", "written"])]
    tracking: bool,
    /// Cameras' lenses: tags are fitted through that of --camera, so that it does not bend their edges. Corners stay pixels
    /// of the picture.
    #[arg(
        long,
        value_name = "FILE",
        requires = "camera",
        conflicts_with = "written"
    )]
    rig: Option<PathBuf>,
    /// The camera of the rig that took the pictures.
    #[arg(long, value_name = "ID", requires = "rig")]
    camera: Option<CameraId>,
    /// Instead of pictures, a recording (DIR/CAMERA/data.csv): writes OUT/CAMERA/detections.jsonl, which `replay` takes.
    #[arg(
        long,
        value_name = "DIR",
        conflicts_with = "images",
        requires = "out",
        conflicts_with = "reps"
    )]
    dataset: Option<PathBuf>,
    /// Instead of pictures, one picture whose detection is to be drawn stage by stage into the folder OUT.
    #[arg(
        long,
        value_name = "IMAGE",
        conflicts_with = "images",
        requires = "out"
    )]
    explain: Option<PathBuf>,
    /// Where --dataset and --explain write to; for --dataset it may be DIR itself.
    #[arg(long, value_name = "OUT", requires = "written")]
    out: Option<PathBuf>,
}

/// Runs `sextant detect`.
///
/// # Errors
/// [`Exit::Usage`] for options that contradict each other, [`Exit::Input`] when a picture could not be used.
pub fn run(arguments: &DetectArguments, format: Format) -> anyhow::Result<()> {
    let options = Options {
        families: arguments.families.clone(),
        ..Options::default()
    };
    // Made once here, so that making it for each thread cannot fail any more.
    Detector::new(options.clone()).exit_with(Exit::Usage)?;
    let threads = usize::from(arguments.threads);
    match (&arguments.dataset, &arguments.explain, &arguments.out) {
        (Some(dataset), _, Some(out)) => dataset::write_detections(dataset, out, threads, &options),
        (_, Some(picture), Some(out)) => {
            let sight = explain::explain(picture, out, &options, arguments.reps)?;
            Ok(print_line(&print::of(&sight, format))?)
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
    let take = |sight: anyhow::Result<Sight>| {
        total += 1;
        match sight {
            Ok(sight) => print_line(&print::of(&sight, format))?,
            Err(error) => {
                failed += 1;
                eprintln!("error: {error:#}");
            }
        }
        Ok(())
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
            look(detector, &path?, arguments.reps, camera.as_ref())
        };
        in_order(threads, paths, || detector(options), work, take)?;
    }
    if failed > 0 {
        let cause = anyhow::anyhow!("{failed} of {total} pictures could not be used");
        bail!(Failure::new(Exit::Input, cause));
    }
    Ok(())
}

/// The camera whose lens is asked for.
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
