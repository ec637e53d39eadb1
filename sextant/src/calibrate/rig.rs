//! `sextant calibrate rig`: where every camera is, from an object carried through what they see.

use super::recording::{each_image, wrong};
use crate::output::{Format, print_line};
use clap::Args;
use sextant_calibrator::{Origin, RigPlan, RigReport, RigSession};
use sextant_estimator::{CameraId, ObjectModel, TagId};
use sextant_process::{Exit, WithExit};
use sextant_site_files::{read_object, read_rig, write_rig};
use sextant_tag_families::Family;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// What a person may choose of `calibrate rig`.
#[derive(Args, Debug)]
#[command(
    after_help = "Carry the object slowly through what the cameras see, nearer and further, tilted to and fro, and for a while where two cameras
see it at once; cameras that never do are joined through others. Tags of the object without object_from_tag are placed on the
way. Cameras need not be synchronised: the object's motion is modelled, and clocks that are off are found. What the images
cannot determine is named, and then nothing is written. The former rig file is kept beside the new one. How well each pose is
known relative to the reference goes along as world_from_camera_sigma, which fusion counts in.

With --json, a line on standard output: {\"reference\",\"images\",\"images_used\",\"instants\",\"synchronised\",\"rms_px\",\"noise_ratio\",
\"cameras\":[{\"camera\",\"images\",\"tags\",\"left_out\",\"sigma_mm\",\"sigma_deg\",\"sigma_axes_mm\":[3],\"sigma_axes_deg\":[3],\"rms_px\",\"clock_offset_ms\",\"clock_sigma_ms\"}],
\"tags_left_out\",\"weak\",\"verdict\":{\"grade\",\"because\"}}"
)]
pub struct RigArguments {
    /// The recording: DIR/CAMERA/data.csv with DIR/CAMERA/data/*.png (8-bit grey), or DIR/CAMERA/detections.jsonl.
    #[arg(value_name = "DIR")]
    recording: PathBuf,
    /// The cameras: a rig file with their lenses, into which their poses are written.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// What was carried: an object file.
    #[arg(long, value_name = "FILE")]
    object: PathBuf,
    /// The world's frame: `camera:ID`, `tag:NUMBER` of a tag that lies still, or `tags:A,B,C` (origin, on +x, towards +y).
    /// Without it the first camera keeps its pose or is the world's frame.
    #[arg(long, value_name = "FRAME", value_parser = frame)]
    origin: Option<Frame>,
    /// Edge of the black squares of the origin's tags, metres; that of the object's tags when absent.
    #[arg(long, value_name = "METRES")]
    origin_size: Option<f64>,
    /// Threads that look for tags in pictures; the result does not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
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
            .map_err(|error: sextant_estimator::IdError| error.to_string()),
        "tag" | "tags" => {
            let tags = tags()?;
            let right = tags.len() == if kind == "tag" { 1 } else { 3 };
            right.then_some(Frame::Tags(tags)).ok_or_else(usage)
        }
        _ => Err(usage()),
    }
}

/// Runs `sextant calibrate rig`.
///
/// # Errors
/// [`Exit::Input`] for files that cannot be used and images that do not place every camera; then nothing is written.
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
    let families: BTreeSet<Family> = object.tags().iter().map(|tag| tag.tag.family).collect();
    let plan = RigPlan {
        origin: origin(arguments, &object)?,
        object,
    };
    let mut session = RigSession::new(rig.clone(), plan).exit_with(Exit::Input)?;
    each_image(
        &arguments.recording,
        &rig,
        &[],
        families.into_iter().collect(),
        arguments.threads,
        |image| session.handle(image),
    )?;
    let calibrated = session.solve().exit_with(Exit::Input)?;
    write_rig(&arguments.rig, &calibrated.rig)?;
    match format {
        Format::Json => print_line(&serde_json::to_string(&calibrated.report)?)?,
        Format::Text => print_line(&text(&calibrated.report, arguments))?,
    }
    Ok(())
}

fn origin(arguments: &RigArguments, object: &ObjectModel) -> anyhow::Result<Origin> {
    let tags = match &arguments.origin {
        None => return Ok(Origin::FirstCamera),
        Some(Frame::Camera(id)) => return Ok(Origin::Camera(id.clone())),
        Some(Frame::Tags(tags)) => tags,
    };
    let first = &object.tags()[0];
    let family = first.tag.family;
    let tag = |id: u32| TagId { family, id };
    if let Some(own) = object
        .tags()
        .iter()
        .find(|own| tags.iter().any(|&id| tag(id) == own.tag))
    {
        wrong(format!(
            "tag {} is on the object that is carried; the world's frame needs a tag that lies still",
            own.tag
        ))?;
    }
    let size_m = arguments.origin_size.unwrap_or(first.size_m);
    Ok(match *tags.as_slice() {
        [a, b, c] => Origin::ThreeTags([a, b, c].map(tag), size_m),
        _ => Origin::Tag(tag(tags[0]), size_m),
    })
}

fn text(report: &RigReport, arguments: &RigArguments) -> String {
    let mut lines = vec![
        "camera            images   tags  left out  sigma mm    deg    rms px  clock ms".to_owned(),
    ];
    lines.extend(report.cameras.iter().map(|camera| {
        let clock = camera
            .clock_offset_ms
            .map_or("-".to_owned(), |ms| format!("{ms:.2}"));
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
    lines.push(format!(
        "Deviations are relative to camera {}.",
        report.reference
    ));
    lines.push(format!(
        "{}: {} of {} images at {} instants, {:.3} px rms; {}",
        arguments.rig.display(),
        report.images_used,
        report.images,
        report.instants,
        report.rms_px,
        report.verdict
    ));
    lines.join("\n")
}
