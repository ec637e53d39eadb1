//! `sextant learn`: where each tag of an object sits, from images of the object being turned.

use crate::model_files::{read_object, read_rig};
use crate::output::{Format, print_line};
use crate::procedure::{ImageArguments, ImageSelection, wrong};
use crate::words;
use anyhow::bail;
use clap::Args;
use sextant_calibrator::procedure::{Plan, Procedure, ProcedureOutcome, Product, Report};
use sextant_calibrator::{DiscoveredTags, DiscoveryPlan, Gauge, LearnPlan, LearnReport};
use sextant_geometry::Pose;
use sextant_process::{Exit, WithExit};
use sextant_site_files::write_object;
use sextant_site_model::{CameraId, ObjectId, ObjectModel, TagId};
use sextant_tag_families::Family;
use std::path::PathBuf;

/// Arguments of `sextant learn`.
#[derive(Args, Debug)]
#[command(
    after_help = "Turn the object slowly in front of a camera, so that every tag is visible and neighbouring tags are
visible together. Without --tags, the tags that move as one body are those of the object; the camera must stand still,
since tags that stand still are left out. Tags that cannot be placed are left out and named, with the rotation that
would connect them; the exit code is then 4, and with --strict nothing is written. Tag sizes and the lens are adjusted
within their sigmas; the lens in the rig file stays as it is. The previous file is kept as FILE.former.

With --live the images come from the running site: turn the object as instructed until there are enough images, or press
Ctrl-C; then it is solved. With --json, progress is one line per second at most: {\"kind\",\"images\",\"fraction\",
\"is_enough\",\"hint\",\"details\":{\"joining\",\"tags\":[{\"tag\",\"images\",\"directions\",\"group\"}],
\"sketch\":[{\"tag\",\"size_m\",\"position\",\"orientation\"}]}}.

With --json, the result is one line on standard output: {\"object\",\"images\",\"images_used\",\"rms_px\",
\"noise_ratio\",\"held_out\":{\"images\",\"rms_px\",\"used_rms_px\"},
\"tags\":[{\"tag\",\"images\",\"left_out\",\"elsewhere\",\"sigma_mm\",\"sigma_deg\",
\"sigma_axes_mm\":[3],\"sigma_axes_deg\":[3],\"rms_px\",\"size_ratio\",\"size_ratio_sigma\"}],\"kept\",\"weak\",
\"unsolved\",\"solved_sizes\":[[\"tag\",metres]],\"found\":{\"object\",\"others\",\"loose\",\"still\"},
\"verdict\":{\"grade\",\"because\"}}"
)]
pub struct LearnArguments {
    #[command(flatten)]
    images: ImageArguments,
    /// Rig file. It must have the lenses; poses are needed only to connect tags across cameras.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// Camera to use; may be repeated. By default all.
    #[arg(long = "camera", value_name = "ID")]
    cameras: Vec<CameraId>,
    /// Tags to place: numbers, or NUMBER:SIZE for a different size, separated by commas. By default the tags of --from
    /// or, without it, the tags that move as one body.
    #[arg(long, value_name = "IDS", value_delimiter = ',', value_parser = tag_and_size)]
    tags: Vec<(u32, Option<f64>)>,
    /// Edge of the black squares of the tags, metres. Without --tags also NUMBER:METRES for one measured tag; the other
    /// sizes follow from it.
    #[arg(long, value_name = "METRES", value_parser = tag_or_all)]
    size: Option<SizeScope>,
    /// Number of a tag of the object, if several things move and --tags is not given.
    #[arg(long, value_name = "NUMBER", conflicts_with_all = ["tags", "from"])]
    around: Option<u32>,
    /// The family of the tags.
    #[arg(long, default_value = "tag36h11")]
    family: Family,
    /// The object's name.
    #[arg(long, value_name = "ID")]
    id: ObjectId,
    /// Object file to write, atomically.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Object frame: `centroid` of the tags, or `tag:NUMBER` for the frame of that tag.
    #[arg(long, value_name = "FRAME", default_value = "centroid", value_parser = frame)]
    origin: Frame,
    /// The tags stand still, and the object's frame is the world: carried cameras are localised by them.
    #[arg(long, requires = "tags")]
    world: bool,
    /// Object file to extend: its tags keep their poses, those of --tags are added or replaced.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
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

/// The tags that a size applies to.
#[derive(Clone, Copy, Debug)]
enum SizeScope {
    All(f64),
    One(u32, f64),
}

impl SizeScope {
    fn size_m(self, tag: u32) -> Option<f64> {
        match self {
            Self::All(size_m) => Some(size_m),
            Self::One(id, size_m) => (id == tag).then_some(size_m),
        }
    }
}

fn tag_or_all(text: &str) -> Result<SizeScope, String> {
    match text.split_once(':') {
        None => size(text).map(SizeScope::All),
        Some((id, own)) => {
            let id = id.trim().parse();
            let id = id.map_err(|_| "write METRES, or NUMBER:METRES such as 3:0.05".to_owned())?;
            Ok(SizeScope::One(id, size(own)?))
        }
    }
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
/// [`Exit::Input`] for files that cannot be used and images that place no tags; then nothing is written.
/// [`Exit::Unavailable`] after a partial result.
pub fn run(arguments: &LearnArguments, format: Format) -> anyhow::Result<()> {
    let rig = read_rig(&arguments.rig).exit_with(Exit::Input)?;
    let plan = if arguments.tags.is_empty() && arguments.from.is_none() {
        Plan::Discover(discovery(arguments))
    } else {
        Plan::Learn(plan(arguments)?)
    };
    let looking = ImageSelection {
        rig: rig.clone(),
        cameras: arguments.cameras.clone(),
        families: plan.families(),
        chessboard: None,
    };
    let procedure = Procedure::start(rig, plan).exit_with(Exit::Input)?;
    let images = arguments.images.open(format, None, None)?;
    finish(&images.outcome(procedure, &looking)?, arguments, format)
}

/// Writes the object and prints the report.
fn finish(
    outcome: &ProcedureOutcome,
    arguments: &LearnArguments,
    format: Format,
) -> anyhow::Result<()> {
    let (Product::Object(object), Report::Learn(report)) = (&outcome.product, &outcome.report)
    else {
        bail!("learning gave no object");
    };
    let place = arguments.world.then(Pose::identity);
    let place = place.or_else(|| object.world_from_object().copied());
    let object = object.clone().with_world_from_object(place)?;
    arguments.images.keep(outcome, || {
        write_object(&arguments.out, &object)?;
        match format {
            Format::Json => print_line(&serde_json::to_string(report)?)?,
            Format::Text => print_line(&text(report, arguments))?,
        }
        Ok(())
    })
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
        let stated = own.or(arguments.size.and_then(|size| size.size_m(id)));
        let Some(size) = stated.or(known.map(|t| t.size_m)) else {
            wrong(format!(
                "the size of tag {id} is unknown; give --size, or write {id}:METRES"
            ))?;
            continue;
        };
        tags.push((tag, size));
    }
    if tags.is_empty() {
        let all = from.iter().flat_map(ObjectModel::tags);
        tags = all
            .map(|t| {
                (
                    t.tag,
                    arguments
                        .size
                        .and_then(|size| size.size_m(t.tag.id))
                        .unwrap_or(t.size_m),
                )
            })
            .collect();
    }
    Ok(LearnPlan {
        object: arguments.id.clone(),
        tags,
        cameras: arguments.cameras.clone(),
        gauge: gauge(arguments),
        from,
    })
}

/// The search for the tags that move as one.
fn discovery(arguments: &LearnArguments) -> DiscoveryPlan {
    let tag = |id| TagId {
        family: arguments.family,
        id,
    };
    DiscoveryPlan {
        object: arguments.id.clone(),
        families: vec![arguments.family],
        size_m: match arguments.size {
            Some(SizeScope::All(size_m)) => Some(size_m),
            _ => None,
        },
        sizes: match arguments.size {
            Some(SizeScope::One(id, size_m)) => vec![(tag(id), size_m)],
            _ => Vec::new(),
        },
        around: arguments.around.map(tag),
        cameras: arguments.cameras.clone(),
        gauge: gauge(arguments),
    }
}

fn gauge(arguments: &LearnArguments) -> Gauge {
    match arguments.origin {
        Frame::Centroid => Gauge::Centroid,
        Frame::Tag(id) => Gauge::Tag(TagId {
            family: arguments.family,
            id,
        }),
    }
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
    lines.extend(report.found.iter().flat_map(found));
    let solved = report.solved_sizes.iter();
    lines.extend(solved.map(|(tag, size_m)| {
        format!(
            "{tag}: {:.2} mm, by comparison with the given size",
            size_m * 1e3
        )
    }));
    lines.extend(report.held_out.as_ref().map(words::held_out));
    lines.push(format!(
        "{}: {} of {} images, {:.3} px rms; {}",
        arguments.out.display(),
        report.images_used,
        report.images,
        report.rms_px,
        report.verdict.grade
    ));
    lines.extend(words::reasons(&report.verdict));
    lines.extend(arguments.images.handing_over("object", &arguments.out));
    lines.join("\n")
}

/// Discovered tags, if none were given.
fn found(found: &DiscoveredTags) -> Vec<String> {
    let mut lines = vec![format!("found to move as one: {}", found.object.join(", "))];
    let others = found.others.iter();
    lines.extend(others.map(|thing| format!("another thing: {}", thing.join(", "))));
    if !found.still.is_empty() {
        lines.push(format!("stood still: {}", found.still.join(", ")));
    }
    lines
}
