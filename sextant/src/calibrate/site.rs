//! `sextant calibrate site`: lenses, camera poses, objects and clocks from one recording, from nothing but sizes.

use super::rolling_shutter;
use crate::output::{Format, print_line};
use crate::procedure::{ImageSelection, each_image, wrong};
use crate::recorded::{Preferred, Recorded};
use crate::words;
use anyhow::{Context, anyhow, bail};
use clap::Args;
use sextant_calibrator::{CalibratedSite, MeasuredDistance, SitePlan, SiteReport, SiteSession};
use sextant_geometry::{Intrinsics, Lens};
use sextant_process::{Exit, Failure, WithExit};
use sextant_recordings::{CameraRecording, Frame, read_picture};
use sextant_site_files::{write_object, write_rig};
use sextant_site_model::{Camera, CameraId, Rig, TagId};
use sextant_tag_families::Family;
use std::fs;
use std::path::{Path, PathBuf};

/// Standard deviation of a measured distance that states none, metres: a tape.
const TAPE_M: f64 = 0.001;

/// Arguments of `sextant calibrate site`.
#[derive(Args, Debug)]
#[command(
    after_help = "Record for a minute while you carry tagged objects about before the cameras: tilted back and forth,
near and far, through the whole image of each camera up to its corners, and for a good part of the time where the views
of cameras overlap. Show neighbouring tags of an object together. Nothing else needs to be known: tags that move
together become an object, single images give a first lens and the places of its tags, common views chain the cameras,
and one adjustment estimates lenses, camera poses, tag poses, ratios of sizes and, for cameras that are not triggered
together, clocks. Rolling shutters are found, too.

Tags that never move are the room. The one that most cameras see is the world frame, or that of --world; without any it
is the first camera. All lengths follow from the sizes of the black squares; a measured distance between two tags of one
object, or of the room, corrects them.

Written to --out: rig.toml with lens_sigma and world_from_camera_sigma of each camera, object-N.toml for each object, N
being its lowest tag, and room.toml with the static tags. Former files are kept as FILE.former. Cameras that share no
view with the others are written without a pose and named, those that see no tag are left out; the exit code is then 4,
and with --strict nothing is written. Lenses are brown-conrady; calibrate fisheye lenses with a board (`sextant
calibrate lens`).

With --json, the result is one line on standard output: {\"world\",\"reference\",\"images\",\"synchronised\",\"rms_px\",
\"noise_ratio\",\"held_out\":{\"images\",\"rms_px\",
\"used_rms_px\"},\"cameras\":[{\"camera\",\"placed\",\"images\",\"sigma_mm\",\"sigma_deg\",\"focal_px\",
\"focal_sigma_px\",\"distortion_sigma_px\",\"corners_covered\",\"rms_px\",\"clock_offset_ms\",\"clock_sigma_ms\",
\"line_delay_us\",\"line_delay_sigma_us\"}],\"objects\":[{\"object\",\"tags\",\"sigma_mm\",\"sigma_deg\",\"images\",
\"shared\"}],\"still\",\"unassigned\",\"scale_factor\",\"scale_sigma\",\"unsolved\",\"verdict\":{\"grade\",
\"because\"}}. clock_offset_ms is the clock of a camera minus that of the reference."
)]
pub struct SiteArguments {
    /// The recording: DIR/CAMERA/data.csv with the pictures in DIR/CAMERA/data, or DIR/CAMERA/detections.jsonl, or an
    /// MCAP file.
    #[arg(value_name = "DIR|FILE.mcap")]
    recording: PathBuf,
    /// Edge of the black squares of the tags, metres; NUMBER:METRES for a tag of another size. May be repeated.
    #[arg(long = "size", value_name = "METRES", required = true, value_parser = size)]
    sizes: Vec<(Option<u32>, f64)>,
    /// The family of the tags.
    #[arg(long, default_value = "tag36h11")]
    family: Family,
    /// Width and height of the images, such as 640x480, or CAMERA=640x480; needed for a folder that has detections and
    /// no pictures.
    #[arg(long = "resolution", value_name = "[CAMERA=]WxH", value_parser = resolution)]
    resolutions: Vec<(Option<CameraId>, [u32; 2])>,
    /// World frame: a tag that does not move.
    #[arg(long, value_name = "tag:NUMBER", value_parser = tag_number)]
    world: Option<u32>,
    /// Measured distance between the centres of two tags that do not move relative to each other, metres, with its
    /// standard deviation; by default 1 mm. May be repeated.
    #[arg(long = "distance", num_args = 3, value_names = ["tag:NUMBER", "tag:NUMBER", "METRES[+-SIGMA]"])]
    distances: Vec<String>,
    /// Folder for the files of the site; made where it does not exist.
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Number of detection threads; the result does not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
    /// Refuse a partial result. Without it, what can be solved is written, the rest is named, and the exit code is 4.
    #[arg(long)]
    strict: bool,
}

fn size(text: &str) -> Result<(Option<u32>, f64), String> {
    let usage = || "write METRES, or NUMBER:METRES such as 3:0.05".to_owned();
    let (tag, size) = match text.split_once(':') {
        Some((tag, size)) => (Some(tag.trim().parse().map_err(|_| usage())?), size),
        None => (None, text),
    };
    let size_m: f64 = size.trim().parse().map_err(|_| usage())?;
    if (0.001..=100.0).contains(&size_m) {
        Ok((tag, size_m))
    } else {
        Err("a tag's size lies between 0.001 and 100 metres".to_owned())
    }
}

fn resolution(text: &str) -> Result<(Option<CameraId>, [u32; 2]), String> {
    let (camera, size) = match text.split_once('=') {
        Some((camera, size)) => {
            let camera = camera.parse();
            let camera = camera.map_err(|e: sextant_site_model::IdError| e.to_string())?;
            (Some(camera), size)
        }
        None => (None, text),
    };
    let sizes = size.split_once('x');
    let sizes = sizes.and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sizes.map(|sizes| (camera, sizes)).ok_or_else(|| {
        "write width and height in pixels, such as 640x480 or north=640x480".to_owned()
    })
}

fn tag_number(text: &str) -> Result<u32, String> {
    let number = text.strip_prefix("tag:").and_then(|n| n.parse().ok());
    number.ok_or_else(|| "write `tag:NUMBER`".to_owned())
}

/// Metres and their standard deviation.
fn length(text: &str) -> Result<[f64; 2], String> {
    let (length, sigma) = text.split_once("+-").unwrap_or((text, ""));
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let sigma_m = if sigma.is_empty() {
        Some(TAPE_M)
    } else {
        number(sigma)
    };
    let both = number(length).zip(sigma_m);
    let positive = both.filter(|(length, sigma)| *length > 0.0 && *sigma > 0.0);
    let usage = || "write METRES or METRES+-SIGMA, such as 0.412+-0.001".to_owned();
    positive.map(|(a, b)| [a, b]).ok_or_else(usage)
}

/// Runs `sextant calibrate site`.
///
/// # Errors
/// [`Exit::Input`] for a recording that cannot be used or does not determine the site; then nothing is written.
/// [`Exit::Unavailable`] after a partial result.
pub fn run(arguments: &SiteArguments, format: Format) -> anyhow::Result<()> {
    let recorded = Recorded::open(&arguments.recording, Preferred::Detections, None)?;
    let cameras = recorded.dataset.cameras().iter();
    let cameras = cameras.map(|camera| {
        let resolution = resolution_of(camera, &recorded, arguments)?;
        anyhow::Ok((camera.camera.clone(), resolution))
    });
    let cameras: Vec<(CameraId, [u32; 2])> = cameras.collect::<Result<_, _>>()?;
    let looking = ImageSelection {
        rig: placeholders(&cameras)?,
        cameras: Vec::new(),
        families: [arguments.family].into(),
        chessboard: None,
    };
    let mut session = SiteSession::new(plan(arguments, cameras)?).exit_with(Exit::Input)?;
    let (folder, dataset) = (arguments.recording.as_path(), &recorded.dataset);
    each_image(folder, dataset, &looking, arguments.threads, |image| {
        session.handle(image);
    })?;
    let found = session.solve().exit_with(Exit::Input)?;
    let unsolved = found.report.unsolved.join("; ");
    if arguments.strict && !unsolved.is_empty() {
        bail!(Failure::new(Exit::Input, anyhow!("{unsolved}")));
    }
    write(&arguments.out, &found)?;
    match format {
        Format::Json => print_line(&serde_json::to_string(&found.report)?)?,
        Format::Text => print_line(&text(&found, &arguments.out))?,
    }
    if unsolved.is_empty() {
        return Ok(());
    }
    bail!(Failure::new(
        Exit::Unavailable,
        anyhow!("partial: {unsolved}")
    ))
}

fn plan(arguments: &SiteArguments, cameras: Vec<(CameraId, [u32; 2])>) -> anyhow::Result<SitePlan> {
    let tag = |id: u32| TagId {
        family: arguments.family,
        id,
    };
    let own = arguments.sizes.iter();
    let own = own.filter_map(|(id, size_m)| id.map(|id| (tag(id), *size_m)));
    let mut of_all = arguments.sizes.iter().filter(|(id, _)| id.is_none());
    let Some((_, size_m)) = of_all.next_back() else {
        bail!(Failure::new(
            Exit::Input,
            anyhow!(
                "--size: state the size that most tags have, METRES, beside those of single tags"
            )
        ));
    };
    let distances = arguments.distances.chunks(3).map(|words| {
        let [a, b, apart] = words else {
            bail!("a distance is of two tags");
        };
        let number = |text: &str| tag_number(text).map_err(|usage| anyhow!("{usage}"));
        let [distance_m, sigma_m] = length(apart).map_err(|usage| anyhow!("{usage}"))?;
        Ok(MeasuredDistance {
            tags: [tag(number(a)?), tag(number(b)?)],
            distance_m,
            sigma_m,
        })
    });
    let distances: anyhow::Result<Vec<MeasuredDistance>> = distances.collect();
    Ok(SitePlan {
        cameras,
        families: vec![arguments.family],
        size_m: *size_m,
        sizes: own.collect(),
        world: arguments.world.map(tag),
        distances: distances.context("--distance").exit_with(Exit::Input)?,
    })
}

/// Resolution: from the arguments, else as recorded with detections, else of the first picture.
fn resolution_of(
    camera: &CameraRecording,
    recorded: &Recorded,
    arguments: &SiteArguments,
) -> anyhow::Result<[u32; 2]> {
    let given = arguments.resolutions.iter();
    let own = given
        .clone()
        .find(|(id, _)| id.as_ref() == Some(&camera.camera));
    let given = own.or_else(|| given.clone().find(|(id, _)| id.is_none()));
    let given = given.map(|(_, resolution)| resolution);
    let known = given.or_else(|| recorded.resolutions.get(&camera.camera));
    Ok(match (known, camera.rows.first().map(|row| &row.frame)) {
        (Some(resolution), _) => *resolution,
        (None, Some(Frame::Picture(path))) => {
            let picture = read_picture(path).exit_with(Exit::Input)?;
            [picture.width, picture.height].map(|pixels| pixels as u32)
        }
        (None, _) => {
            wrong(format!(
                "the size of the images of camera \"{0}\" is not known: state it with \
                 --resolution WxH or --resolution {0}=WxH",
                camera.camera
            ))?;
            [0, 0]
        }
    })
}

/// The cameras while images are read; their lenses are not used.
fn placeholders(cameras: &[(CameraId, [u32; 2])]) -> anyhow::Result<Rig> {
    let cameras = cameras.iter().map(|(id, resolution)| {
        let [width, height] = resolution.map(f64::from);
        let lens = Lens::pinhole(Intrinsics {
            fx: width,
            fy: width,
            cx: width / 2.0,
            cy: height / 2.0,
        });
        let lens = lens.exit_with(Exit::Input)?;
        anyhow::Ok(Camera::new(id.clone(), *resolution, lens, None))
    });
    Rig::new(cameras.collect::<Result<_, _>>()?).exit_with(Exit::Input)
}

fn write(folder: &Path, found: &CalibratedSite) -> anyhow::Result<()> {
    fs::create_dir_all(folder)
        .with_context(|| format!("making the folder {}", folder.display()))
        .exit_with(Exit::Input)?;
    write_rig(&folder.join("rig.toml"), &found.rig)?;
    for object in &found.objects {
        write_object(&folder.join(format!("{}.toml", object.id())), object)?;
    }
    Ok(())
}

fn text(found: &CalibratedSite, folder: &Path) -> String {
    let report = &found.report;
    let mut lines = vec![
        "camera            images  sigma mm    deg   focal px  sigma px    rms px  ahead ms"
            .to_owned(),
    ];
    lines.extend(report.cameras.iter().map(|camera| {
        let clock = camera.clock_offset_ms;
        let clock = clock.map_or("-".to_owned(), |ms| format!("{ms:+.2}"));
        format!(
            "{:<16} {:>7} {:>9.2} {:>6.3} {:>10.2} {:>9.2} {:>9.3} {:>9}",
            camera.camera,
            camera.images,
            camera.sigma_mm,
            camera.sigma_deg,
            camera.focal_px,
            camera.focal_sigma_px,
            camera.rms_px,
            clock
        )
    }));
    lines.extend(report.cameras.iter().filter_map(|camera| {
        let sigma_us = camera.line_delay_sigma_us;
        rolling_shutter(&camera.camera, camera.line_delay_us, sigma_us)
    }));
    lines.extend(report.objects.iter().map(|object| {
        format!(
            "{}: {}; tags to {:.2} mm and {:.3} degrees",
            object.object,
            object.tags.join(", "),
            object.sigma_mm,
            object.sigma_deg
        )
    }));
    if !report.still.is_empty() {
        lines.push(format!("stood still: {}", report.still.join(", ")));
    }
    lines.push(frame_and_scale(report));
    lines.extend(report.held_out.as_ref().map(words::held_out));
    lines.push(format!(
        "{}: {} images, {:.3} px rms; {}",
        folder.join("rig.toml").display(),
        report.images,
        report.rms_px,
        report.verdict.grade
    ));
    lines.extend(words::reasons(&report.verdict));
    lines.join("\n")
}

fn frame_and_scale(report: &SiteReport) -> String {
    let source = if report.scale_factor == 1.0 {
        "follow from the given sizes".to_owned()
    } else {
        format!(
            "are {:+.2} % those of the given sizes, by the measured distances",
            100.0 * (report.scale_factor - 1.0)
        )
    };
    format!(
        "The world is the frame of {}; deviations are relative to camera {}. All lengths \
         {source}, and share a deviation of {:.2} %.",
        report.world,
        report.reference,
        100.0 * report.scale_sigma
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_a_deviation() {
        assert_eq!(length("0.412+-0.002"), Ok([0.412, 0.002]));
        assert_eq!(length("0.412"), Ok([0.412, TAPE_M]));
        assert!(length("0.4+-").is_ok());
        assert!(length("0.4+-0").is_err() && length("-1").is_err() && length("x").is_err());
    }

    #[test]
    fn sizes_and_resolutions_are_of_all_or_of_one() {
        assert_eq!(size("0.04"), Ok((None, 0.04)));
        assert_eq!(size("7:0.08"), Ok((Some(7), 0.08)));
        assert!(size("7:8 mm").is_err());
        assert_eq!(resolution("640x480"), Ok((None, [640, 480])));
        let north = CameraId::new("north").ok();
        assert_eq!(resolution("north=800x600"), Ok((north, [800, 600])));
        assert!(resolution("640").is_err());
    }
}
