//! `sextant calibrate rig`: where every camera is, from an object carried through what they see.

use super::rolling_shutter;
use crate::model_files::{read_object, read_rig};
use crate::output::{Format, print_line};
use crate::procedure::{ImageArguments, ImageSelection, wrong};
use crate::words;
use anyhow::bail;
use clap::Args;
use sextant_calibrator::procedure::{Plan, Procedure, ProcedureOutcome, Product, Report};
use sextant_calibrator::{Origin, RigPlan, RigReport, Up};
use sextant_process::{Exit, WithExit};
use sextant_replay::{ChessboardSearch, PartialViews};
use sextant_site_files::{Chessboard, write_rig};
use sextant_site_model::{CameraId, ObjectModel, TagId};
use std::path::PathBuf;

/// Arguments of `sextant calibrate rig`.
#[derive(Args, Debug)]
#[command(
    after_help = "Carry the object slowly through the views of the cameras, closer and farther, tilted back and forth,
and for a while where two cameras see it simultaneously; cameras that never do are connected through others. Tags of the
object without object_from_tag are placed as well. Cameras need not be synchronised: the motion of the object is
modelled, and clock offsets are estimated, as are the line delays of rolling shutters that the rig file does not have.
No number in the files counts as exact: lenses, tag poses and tag sizes are adjusted along with the camera poses, each
with its sigma or a default as a prior. Cameras that cannot be placed keep their entries and are named; the exit code is
then 4, and with --strict nothing is written. The previous rig file is kept. Sigmas relative to the reference camera are
written as world_from_camera_sigma, those of lenses as lens_sigma.

With --live the images come from the running site: follow the instructions until there are enough images, or press
Ctrl-C; then it is solved. With --json, progress is one line per second at most: {\"kind\",\"images\",\"fraction\",
\"is_enough\",\"hint\",\"details\":{\"cameras\":[{\"camera\",\"images\",\"seeing\",\"fields\":[12],\"distances\",
\"group\"}],\"together\":[[\"a\",\"b\",images]]}}.

The column \"ahead ms\", clock_offset_ms in JSON, is the clock of a camera minus that of the reference, as fusion and
replay report it.

With --json, the result is one line on standard output: {\"reference\",\"images\",\"images_used\",\"instants\",
\"synchronised\",\"rms_px\",\"noise_ratio\",\"held_out\":{\"images\",\"rms_px\",
\"used_rms_px\"},\"cameras\":[{\"camera\",\"images\",\"tags\",\"left_out\",\"sigma_mm\",
\"sigma_deg\",\"sigma_axes_mm\":[3],\"sigma_axes_deg\":[3],\"rms_px\",\"clock_offset_ms\",\"clock_sigma_ms\",
\"line_delay_us\",\"line_delay_sigma_us\"}],\"tags_left_out\",\"weak\",\"unsolved\",\"scale\",\"verdict\":{\"grade\",
\"because\"}}"
)]
pub struct RigArguments {
    #[command(flatten)]
    images: ImageArguments,
    /// Rig file with the lenses of the cameras; their poses are written into it.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// Object file of the carried object.
    #[arg(long, value_name = "FILE")]
    object: PathBuf,
    /// World frame: `camera:ID`, `tag:NUMBER` for a tag that lies still, or `tags:A,B,C` (origin, on +x, towards +y).
    /// By default the first camera keeps its pose, or is the world frame.
    #[arg(long, value_name = "FRAME", value_parser = frame)]
    origin: Option<Frame>,
    /// Vertical, along which z of the world points: `flat:NUMBER` for a tag on something level, `upright:NUMBER` for
    /// one that hangs plumb with its upper edge up, or `plumb:LOW,HIGH` for two tags on a plumb line.
    #[arg(long, value_name = "TAGS", value_parser = up)]
    up: Option<Vertical>,
    /// Edge of the black squares of the tags of --origin and --up, metres; by default that of the object's tags.
    #[arg(long, value_name = "METRES")]
    origin_size: Option<f64>,
}

#[derive(Clone, Debug)]
enum Frame {
    Camera(CameraId),
    Tags(Vec<u32>),
}

fn frame(text: &str) -> Result<Frame, String> {
    let usage = || "write `camera:ID`, `tag:NUMBER` or `tags:A,B,C`".to_owned();
    let (kind, names) = text.split_once(':').ok_or_else(usage)?;
    let tags = || -> Result<Vec<u32>, String> {
        names
            .split(',')
            .map(|n| n.trim().parse::<u32>().map_err(|_| usage()))
            .collect()
    };
    match kind {
        "camera" => names
            .parse()
            .map(Frame::Camera)
            .map_err(|error: sextant_site_model::IdError| error.to_string()),
        "tag" | "tags" => {
            let tags = tags()?;
            let right = tags.len() == if kind == "tag" { 1 } else { 3 };
            right.then_some(Frame::Tags(tags)).ok_or_else(usage)
        }
        _ => Err(usage()),
    }
}

#[derive(Clone, Copy, Debug)]
enum Vertical {
    Flat(u32),
    Upright(u32),
    Plumb([u32; 2]),
}

fn up(text: &str) -> Result<Vertical, String> {
    let usage = || "write `flat:NUMBER`, `upright:NUMBER` or `plumb:LOW,HIGH`".to_owned();
    let (kind, tags) = text.split_once(':').ok_or_else(usage)?;
    let tags: Result<Vec<u32>, _> = tags.split(',').map(|tag| tag.trim().parse()).collect();
    match (kind, tags.map_err(|_| usage())?.as_slice()) {
        ("flat", [tag]) => Ok(Vertical::Flat(*tag)),
        ("upright", [tag]) => Ok(Vertical::Upright(*tag)),
        ("plumb", [low, high]) => Ok(Vertical::Plumb([*low, *high])),
        _ => Err(usage()),
    }
}

/// Runs `sextant calibrate rig`.
///
/// # Errors
/// [`Exit::Input`] for files that cannot be used and images that place no cameras; then nothing is written.
/// [`Exit::Unavailable`] after a partial result.
pub fn run(arguments: &RigArguments, format: Format) -> anyhow::Result<()> {
    let rig = read_rig(&arguments.rig).exit_with(Exit::Input)?;
    let object = read_object(&arguments.object).exit_with(Exit::Input)?;
    if object.articulation().is_some() {
        wrong(format!(
            "{}: object {} has links; calibrate with one that is rigid",
            arguments.object.display(),
            object.id()
        ))?;
    }
    let chessboard = ChessboardSearch::among([&object], PartialViews::LeftOut);
    if let Some(board) = Chessboard::from_object(&object).filter(Chessboard::is_symmetric) {
        eprintln!("warning: {}", symmetric(&board));
    }
    let plan = Plan::Rig(RigPlan {
        origin: origin(arguments, &object)?,
        object,
    });
    let looking = ImageSelection {
        rig: rig.clone(),
        cameras: Vec::new(),
        families: plan.families(),
        chessboard,
    };
    let procedure = Procedure::start(rig, plan).exit_with(Exit::Input)?;
    let images = arguments
        .images
        .open(format, looking.chessboard.as_ref(), None)?;
    finish(&images.outcome(procedure, &looking)?, arguments, format)
}

/// A remark on a board that images show either way up.
fn symmetric(board: &Chessboard) -> String {
    format!(
        "a chessboard of {} x {} squares looks the same upside down: hold it so that its columns \
         run to the right in the images of all cameras, \
        or use one with an even number of squares in one direction and an odd one in the other \
        (`sextant print chessboard`)",
        board.columns + 1,
        board.rows + 1
    )
}

/// Writes the rig and prints the report.
fn finish(
    outcome: &ProcedureOutcome,
    arguments: &RigArguments,
    format: Format,
) -> anyhow::Result<()> {
    let (Product::Rig(rig), Report::Rig(report)) = (&outcome.product, &outcome.report) else {
        bail!("the calibration of a rig gave no rig");
    };
    arguments.images.keep(outcome, || {
        write_rig(&arguments.rig, rig)?;
        match format {
            Format::Json => print_line(&serde_json::to_string(report)?)?,
            Format::Text => print_line(&text(report, arguments))?,
        }
        Ok(())
    })
}

fn origin(arguments: &RigArguments, object: &ObjectModel) -> anyhow::Result<Origin> {
    let first = &object.tags()[0];
    let family = first.tag.family;
    let tag = |id: u32| TagId { family, id };
    let size_m = arguments.origin_size.unwrap_or(first.size_m);
    let frame = match &arguments.origin {
        None => Origin::FirstCamera,
        Some(Frame::Camera(id)) => Origin::Camera(id.clone()),
        Some(Frame::Tags(tags)) => match *tags.as_slice() {
            [a, b, c] => Origin::ThreeTags([a, b, c].map(tag), size_m),
            _ => Origin::Tag(tag(tags[0]), size_m),
        },
    };
    let up = arguments.up.map(|up| match up {
        Vertical::Flat(id) => Up::Flat(tag(id), size_m),
        Vertical::Upright(id) => Up::Upright(tag(id), size_m),
        Vertical::Plumb(ids) => Up::Plumb(ids.map(tag), size_m),
    });
    let origin = match up {
        Some(up) => Origin::Levelled(Box::new(frame), up),
        None => frame,
    };
    let still = origin.tags();
    let own = object.tags().iter().map(|own| own.tag);
    for own in own.filter(|own| still.iter().any(|(tag, _)| tag == own)) {
        wrong(format!(
            "tag {own} is on the object that is carried; the world's frame needs a tag that lies still"
        ))?;
    }
    Ok(origin)
}

fn text(report: &RigReport, arguments: &RigArguments) -> String {
    let mut lines = vec![
        "camera            images   tags  left out  sigma mm    deg    rms px  ahead ms".to_owned(),
    ];
    lines.extend(report.cameras.iter().map(|camera| {
        let clock = camera.clock_offset_ms;
        let clock = clock.map_or("-".to_owned(), |ms| format!("{ms:+.2}"));
        format!(
            "{:<16} {:>7} {:>6} {:>9} {:>9.2} {:>6.3} {:>9.3} {:>9}",
            camera.camera,
            camera.images,
            camera.tags,
            camera.left_out,
            camera.sigma_mm,
            camera.sigma_deg,
            camera.rms_px,
            clock
        )
    }));
    lines.extend(report.cameras.iter().filter_map(|camera| {
        let sigma_us = camera.line_delay_sigma_us;
        rolling_shutter(&camera.camera, camera.line_delay_us, sigma_us)
    }));
    lines.push(format!(
        "Deviations are relative to camera {}; ahead ms: by how much a clock is ahead of it, as \
         fusion and replay have it; {}.",
        report.reference, report.scale
    ));
    lines.extend(report.held_out.as_ref().map(words::held_out));
    lines.push(format!(
        "{}: {} of {} images at {} instants, {:.3} px rms; {}",
        arguments.rig.display(),
        report.images_used,
        report.images,
        report.instants,
        report.rms_px,
        report.verdict.grade
    ));
    lines.extend(words::reasons(&report.verdict));
    lines.extend(arguments.images.handing_over("rig", &arguments.rig));
    lines.join("\n")
}
