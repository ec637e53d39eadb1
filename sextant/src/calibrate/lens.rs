//! `sextant calibrate lens`: a camera's lens, from images of a board of tags.

mod pictures;
mod report;

use super::live::LiveCamera;
use super::recording::{each_image, wrong};
use crate::output::{Format, print_line};
use crate::print::enlarged;
use crate::site::SiteArguments;
use anyhow::{Context, ensure};
use clap::Args;
use serde_json::json;
use sextant_calibrator::lens::{
    Hint, LensCalibration, LensOptions, LensProgress, LensSession, Selection, Taken,
};
use sextant_estimator::{Camera, CameraId, ObjectModel, Rig};
use sextant_geometry::{Intrinsics, Lens, LensModel};
use sextant_process::{Exit, WithExit};
use sextant_recordings::{Dataset, Frame, read_grey_png};
use sextant_site_files::{read_object, read_rig, write_rig};
use sextant_tag_families::Family;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// More images than this are a stream, of which those are kept that show the board otherwise than the ones before.
const MANY: usize = 60;

/// What a person may choose of `calibrate lens`.
#[derive(Args, Debug)]
#[command(
    after_help = "Print a board (`sextant print board`), glue it onto something flat, and take 30 images of it: everywhere in the picture, its
edges and corners above all, from near enough to fill a third of it, tilted by 30 degrees and more in every direction. Parts of
the board will do. Without --model the images choose: the simplest model that foretells best where corners lie in images that it
was not fitted to. What the images cannot determine is named, and then nothing is written. The camera keeps its pose in the rig
file, one that is not there yet is added; the former file is kept as FILE.former.

With --live the images are those of a camera of the running site: hold the board as the lines say until there is enough, or end
it with Ctrl-C; then the lens is solved. With --json these lines are {\"images\",\"views\",\"fraction\",\"hint\"}.

The scale of the board has no say in the lens: if the printer enlarged it as a whole, the lens is the same.

With --report: coverage.png, residuals.png and uncertainty.png over the picture, and lens.json.
With --json, a line on standard output: {\"camera\",\"resolution\",\"lens\",\"sigmas\",\"rms_px\",\"noise_px\",\"images\",\"views\",\"tags\",\"wrong_tags\",
\"suspicious\",\"models\":[{\"model\",\"held_out_rms_px\"}],\"coverage\",\"uncertainty_px\":{\"mean\",\"largest\"},
\"cells\":[[{\"corners\",\"mean_px\",\"rms_px\",\"sigma_px\"}]],\"verdict\":{\"grade\",\"because\"}}"
)]
pub struct LensArguments {
    /// The recording: DIR/CAMERA/data.csv with DIR/CAMERA/data/*.png (8-bit grey), or DIR/CAMERA/detections.jsonl.
    #[arg(value_name = "DIR", required_unless_present = "live")]
    recording: Option<PathBuf>,
    /// Take the images from the running site instead.
    #[arg(long, conflicts_with = "recording")]
    live: bool,
    #[command(flatten)]
    site: SiteArguments,
    /// The board: the object file that `sextant print board` wrote.
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    /// The camera.
    #[arg(long, value_name = "ID")]
    camera: CameraId,
    /// The rig file that the lens is written into; it is made if there is none.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// The lens model: pinhole, brown-conrady or kannala-brandt. Without it the images choose.
    #[arg(long)]
    model: Option<LensModel>,
    /// Edge of a black square of the board as measured, metres; without it the board file's word counts.
    #[arg(long, value_name = "METRES")]
    measured_size: Option<f64>,
    /// Width and height of the pictures, such as 640x480; needed for detections of a camera that the rig lacks.
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    resolution: Option<[u32; 2]>,
    /// A folder for pictures of coverage, residuals and uncertainty.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Threads that look for tags in pictures; the result does not depend on it.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
}

fn resolution(text: &str) -> Result<[u32; 2], String> {
    let sizes = text.split_once('x');
    let sizes = sizes.and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sizes.ok_or_else(|| "write width and height in pixels, such as 640x480".to_owned())
}

/// Runs `sextant calibrate lens`.
///
/// # Errors
/// [`Exit::Input`] for files that cannot be used and images that do not give a lens; then nothing is written.
pub fn run(arguments: &LensArguments, format: Format) -> anyhow::Result<()> {
    let board = board(arguments).exit_with(Exit::Input)?;
    let known = existing(&arguments.rig).exit_with(Exit::Input)?;
    let rig = known.cameras();
    let (session, resolution) = match &arguments.recording {
        Some(recording) => recorded(arguments, recording, &board, rig)?,
        None => live(arguments, &board, format)?,
    };
    let calibration = session.solve().exit_with(Exit::Input)?;
    let camera = camera(arguments, rig, resolution)?;
    write_rig(&arguments.rig, &with_lens(&known, camera, &calibration)?)?;
    let report = report::Report::of(&arguments.camera, &calibration);
    if let Some(folder) = &arguments.report {
        pictures::write(folder, &calibration.maps, &report)?;
    }
    match format {
        Format::Json => print_line(&serde_json::to_string(&report)?)?,
        Format::Text => print_line(&report.text(&arguments.rig))?,
    }
    Ok(())
}

/// The images of a recording.
fn recorded(
    arguments: &LensArguments,
    recording: &Path,
    board: &ObjectModel,
    rig: &[Camera],
) -> anyhow::Result<(LensSession, [u32; 2])> {
    let images = images(arguments, recording)?;
    let resolution = resolution_of(arguments, rig, &images)?;
    let camera = camera(arguments, rig, resolution)?;
    let options = LensOptions {
        resolution,
        model: arguments.model,
        selection: if images.len() > MANY {
            Selection::New
        } else {
            Selection::All
        },
    };
    let mut session = LensSession::new(board, options).exit_with(Exit::Input)?;
    let families: BTreeSet<Family> = board.tags().iter().map(|tag| tag.tag.family).collect();
    let mut taken = Ok(());
    each_image(
        recording,
        &Rig::new(vec![camera])?,
        std::slice::from_ref(&arguments.camera),
        families.into_iter().collect(),
        arguments.threads,
        |image| {
            if taken.is_ok() {
                taken = session.handle(image).map(|_| ());
            }
        },
    )?;
    taken.exit_with(Exit::Input)?;
    Ok((session, resolution))
}

/// The images of a running site, with words where to hold the board next.
fn live(
    arguments: &LensArguments,
    board: &ObjectModel,
    format: Format,
) -> anyhow::Result<(LensSession, [u32; 2])> {
    let site = arguments.site.open()?;
    let mut session: Option<(LensSession, [u32; 2])> = None;
    LiveCamera::of(&site, &arguments.camera)?.each(|image| {
        let (session, _) = match &mut session {
            Some(session) => session,
            None => {
                let options = LensOptions {
                    resolution: image.resolution,
                    model: arguments.model,
                    selection: Selection::New,
                };
                let first = LensSession::new(board, options).exit_with(Exit::Input)?;
                session.insert((first, image.resolution))
            }
        };
        if session.handle(&image.observation).exit_with(Exit::Input)? == Taken::Kept {
            say(&session.progress(), format)?;
        }
        Ok(match session.progress().hint {
            Hint::Enough => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        })
    })?;
    site.bus.close();
    session
        .with_context(|| {
            format!(
                "camera \"{}\" has sent nothing; `sextant list` says who is there",
                arguments.camera
            )
        })
        .exit_with(Exit::Unavailable)
}

fn say(progress: &LensProgress, format: Format) -> anyhow::Result<()> {
    let hint = progress.hint.to_string();
    let line = match format {
        Format::Json => json!({
            "images": progress.images, "views": progress.views, "fraction": progress.fraction, "hint": hint,
        })
        .to_string(),
        Format::Text => format!(
            "{:>3.0} %  {:>3} views  {hint}",
            100.0 * progress.fraction,
            progress.views
        ),
    };
    Ok(print_line(&line)?)
}

fn board(arguments: &LensArguments) -> anyhow::Result<ObjectModel> {
    let board = read_object(&arguments.board)?;
    let Some(measured) = arguments.measured_size else {
        return Ok(board);
    };
    let size = board.tags()[0].size_m;
    ensure!(
        board.tags().iter().all(|tag| tag.size_m == size),
        "{}: the tags have different sizes, so that --measured-size is not clear; correct the file",
        arguments.board.display()
    );
    enlarged(&board, measured / size)
}

/// The cameras of a rig file that may not be there yet.
fn existing(path: &Path) -> anyhow::Result<Rig> {
    if !path.exists() {
        return Ok(Rig::default());
    }
    Ok(read_rig(path)?)
}

/// What the recording has of the camera.
fn images(arguments: &LensArguments, recording: &Path) -> anyhow::Result<Vec<Frame>> {
    let dataset = Dataset::open(recording).exit_with(Exit::Input)?;
    let recorded = dataset
        .cameras()
        .iter()
        .find(|c| c.camera == arguments.camera);
    let Some(recorded) = recorded else {
        let names: Vec<&str> = dataset
            .cameras()
            .iter()
            .map(|c| c.camera.as_str())
            .collect();
        wrong(format!(
            "{}: there is no folder of camera \"{}\"; there are {}",
            recording.display(),
            arguments.camera,
            names.join(", ")
        ))?;
        return Ok(Vec::new());
    };
    Ok(recorded.rows.iter().map(|row| row.frame.clone()).collect())
}

/// The size of the pictures: as stated, as in the rig, or of the first picture.
fn resolution_of(
    arguments: &LensArguments,
    rig: &[Camera],
    images: &[Frame],
) -> anyhow::Result<[u32; 2]> {
    let known = rig.iter().find(|camera| camera.id == arguments.camera);
    Ok(match (arguments.resolution, known, images.first()) {
        (Some(stated), _, _) => stated,
        (None, Some(known), _) => known.resolution,
        (None, None, Some(Frame::Picture(path))) => {
            let picture = read_grey_png(path).exit_with(Exit::Input)?;
            [picture.width, picture.height].map(|pixels| pixels as u32)
        }
        _ => {
            wrong(format!(
                "the size of the pictures of camera \"{}\" is not known; state it with --resolution",
                arguments.camera
            ))?;
            [0, 0]
        }
    })
}

/// The camera as the rig has it, or a new one. Its lens is not used.
fn camera(
    arguments: &LensArguments,
    rig: &[Camera],
    resolution: [u32; 2],
) -> anyhow::Result<Camera> {
    let known = rig.iter().find(|camera| camera.id == arguments.camera);
    let [width, height] = resolution.map(f64::from);
    let placeholder = Lens::pinhole(Intrinsics {
        fx: width,
        fy: width,
        cx: width / 2.0,
        cy: height / 2.0,
    });
    Ok(Camera {
        id: arguments.camera.clone(),
        resolution,
        lens: placeholder.exit_with(Exit::Input)?,
        world_from_camera: known.and_then(|camera| camera.world_from_camera),
    })
}

/// The rig with the camera's lens.
fn with_lens(rig: &Rig, camera: Camera, found: &LensCalibration) -> anyhow::Result<Rig> {
    let mut cameras = rig.cameras().to_vec();
    let calibrated = Camera {
        lens: found.lens,
        ..camera
    };
    let stated = (calibrated.id.clone(), found.sigma());
    match cameras.iter_mut().find(|known| known.id == calibrated.id) {
        Some(known) => *known = calibrated,
        None => cameras.push(calibrated),
    }
    let calibrated = Rig::new(cameras).context("the rig with the new lens")?;
    Ok(calibrated.with_lens_sigmas([stated])?.holding_on_to(rig))
}
