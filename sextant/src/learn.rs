//! `sextant learn`: where each tag of an object sits, from images of the object being turned.

use crate::calibrate::recording::{each_image, wrong};
use crate::output::{Format, print_line};
use clap::Args;
use sextant_calibrator::{Gauge, LearnPlan, LearnReport, LearnSession};
use sextant_estimator::{CameraId, ObjectId, ObjectModel, TagId};
use sextant_process::{Exit, WithExit};
use sextant_site_files::{read_object, read_rig, write_object};
use sextant_tag_families::Family;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// What a person may choose of `learn`.
#[derive(Args, Debug)]
#[command(
    after_help = "Turn the object slowly before a camera, so that every tag is seen and neighbouring tags are seen together. Tags that no
image joins are named, with the turn that would join them; then nothing is written. The former file is kept as FILE.former.

With --json, a line on standard output: {\"object\",\"images\",\"images_used\",\"rms_px\",\"noise_ratio\",\"tags\":[{\"tag\",\"images\",\"left_out\",
\"elsewhere\",\"sigma_mm\",\"sigma_deg\",\"sigma_axes_mm\":[3],\"sigma_axes_deg\":[3],\"rms_px\",\"size_ratio\",\"size_ratio_sigma\"}],\"kept\",\"weak\",\"verdict\":{\"grade\",\"because\"}}"
)]
pub struct LearnArguments {
    /// The recording: DIR/CAMERA/data.csv with DIR/CAMERA/data/*.png (8-bit grey), or DIR/CAMERA/detections.jsonl.
    #[arg(value_name = "DIR")]
    recording: PathBuf,
    /// The cameras: a rig file. Their lenses must be known; their poses only if tags are to be joined across cameras.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// A camera whose images count; may be repeated. Without it all count.
    #[arg(long = "camera", value_name = "ID")]
    cameras: Vec<CameraId>,
    /// The tags to be placed: numbers, or NUMBER:SIZE for a size of its own, separated by commas. Without it the tags of --from.
    #[arg(long, value_name = "IDS", value_delimiter = ',', value_parser = tag_and_size)]
    tags: Vec<(u32, Option<f64>)>,
    /// Edge of the tags' black squares, metres.
    #[arg(long, value_name = "METRES", value_parser = size)]
    size: Option<f64>,
    /// The family of the tags.
    #[arg(long, default_value = "tag36h11")]
    family: Family,
    /// The object's name.
    #[arg(long, value_name = "ID")]
    id: ObjectId,
    /// Where the object goes: an object file, written whole or not at all.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The object's frame: `centroid` of the tags, or `tag:NUMBER`, that tag's own.
    #[arg(long, value_name = "FRAME", default_value = "centroid", value_parser = frame)]
    origin: Frame,
    /// An object that is known already: its tags stay, those of --tags are added or learned anew.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Threads that look for tags in pictures; the result does not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
}

#[derive(Clone, Copy, Debug)]
enum Frame {
    Centroid,
    Tag(u32),
}

fn frame(text: &str) -> Result<Frame, String> {
    let tag = text.strip_prefix("tag:").and_then(|n| n.parse().ok());
    match (text, tag) {
        ("centroid", _) => Ok(Frame::Centroid),
        (_, Some(tag)) => Ok(Frame::Tag(tag)),
        _ => Err("write `centroid` or `tag:NUMBER`".to_owned()),
    }
}

fn size(text: &str) -> Result<f64, String> {
    let size: f64 = text.parse().map_err(|_| "write metres".to_owned())?;
    (0.001..=100.0)
        .contains(&size)
        .then_some(size)
        .ok_or_else(|| "a tag's size lies between 0.001 and 100 metres".to_owned())
}

fn tag_and_size(text: &str) -> Result<(u32, Option<f64>), String> {
    let (id, own) = match text.split_once(':') {
        Some((id, own)) => (id, Some(size(own)?)),
        None => (text, None),
    };
    let id = id.trim().parse();
    id.map(|id| (id, own))
        .map_err(|_| "write tag numbers, such as 3,4,5 or 3:0.05".to_owned())
}

/// Runs `sextant learn`.
///
/// # Errors
/// [`Exit::Input`] for files that cannot be used and images that do not place every tag; then nothing is written.
pub fn run(arguments: &LearnArguments, format: Format) -> anyhow::Result<()> {
    let rig = read_rig(&arguments.rig).exit_with(Exit::Input)?;
    let plan = plan(arguments)?;
    let families: BTreeSet<Family> = families(&plan);
    let mut session = LearnSession::new(rig.clone(), plan).exit_with(Exit::Input)?;
    each_image(
        &arguments.recording,
        &rig,
        &arguments.cameras,
        families.into_iter().collect(),
        arguments.threads,
        |image| session.handle(image),
    )?;
    let learned = session.solve().exit_with(Exit::Input)?;
    write_object(&arguments.out, &learned.object)?;
    match format {
        Format::Json => print_line(&serde_json::to_string(&learned.report)?)?,
        Format::Text => print_line(&text(&learned.report, arguments))?,
    }
    Ok(())
}

fn plan(arguments: &LearnArguments) -> anyhow::Result<LearnPlan> {
    let from = match &arguments.from {
        Some(file) => Some(read_object(file).exit_with(Exit::Input)?),
        None => None,
    };
    if from
        .as_ref()
        .is_some_and(|object| object.articulation().is_some())
    {
        wrong(format!(
            "--from: object {} has links; learn each link as an object, and write the joints by hand",
            arguments.id
        ))?;
    }
    let mut tags = Vec::new();
    for &(id, own) in &arguments.tags {
        let tag = TagId {
            family: arguments.family,
            id,
        };
        let known = from
            .iter()
            .flat_map(ObjectModel::tags)
            .find(|t| t.tag == tag);
        let Some(size) = own.or(arguments.size).or(known.map(|t| t.size_m)) else {
            wrong(format!(
                "the size of tag {id} is not stated; give --size, or write {id}:METRES"
            ))?;
            continue;
        };
        tags.push((tag, size));
    }
    if tags.is_empty() {
        let all = from.iter().flat_map(ObjectModel::tags);
        tags = all
            .map(|t| (t.tag, arguments.size.unwrap_or(t.size_m)))
            .collect();
    }
    Ok(LearnPlan {
        object: arguments.id.clone(),
        tags,
        cameras: arguments.cameras.clone(),
        gauge: match arguments.origin {
            Frame::Centroid => Gauge::Centroid,
            Frame::Tag(id) => Gauge::Tag(TagId {
                family: arguments.family,
                id,
            }),
        },
        from,
    })
}

fn families(plan: &LearnPlan) -> BTreeSet<Family> {
    let known = plan
        .from
        .iter()
        .flat_map(ObjectModel::tags)
        .map(|t| t.tag.family);
    plan.tags
        .iter()
        .map(|(tag, _)| tag.family)
        .chain(known)
        .collect()
}

fn text(report: &LearnReport, arguments: &LearnArguments) -> String {
    let mut lines = vec![format!(
        "{:<16} images  left out  sigma mm   deg     rms px",
        "tag"
    )];
    lines.extend(report.tags.iter().map(|tag| {
        format!(
            "{:<16} {:>6}  {:>8}  {:>8.3}  {:>5.3}  {:>7.3}",
            tag.tag, tag.images, tag.left_out, tag.sigma_mm, tag.sigma_deg, tag.rms_px
        )
    }));
    lines.push(format!(
        "{}: {} of {} images, {:.3} px rms; {}",
        arguments.out.display(),
        report.images_used,
        report.images,
        report.rms_px,
        report.verdict
    ));
    lines.join("\n")
}
