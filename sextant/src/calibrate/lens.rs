//! `sextant calibrate lens`: a camera's lens, from images of a board of tags.

mod chart;
mod pictures;
mod words;

use crate::model_files::{read_object, read_rig};
use crate::output::{Format, print_line};
use crate::print::with_remedy;
use crate::procedure::{ImageArguments, ImageSelection, Images, wrong};
use anyhow::{bail, ensure};
use clap::Args;
use sextant_calibrator::lens::Selection;
use sextant_calibrator::procedure::{LensPlan, Plan, Procedure, ProcedureOutcome, Product, Report};
use sextant_geometry::{Intrinsics, Lens, LensModel};
use sextant_process::{Exit, WithExit};
use sextant_recordings::{Dataset, Frame, read_picture};
use sextant_replay::{ChessboardSearch, PartialViews};
use sextant_sheets::enlarged;
use sextant_site_files::write_rig;
use sextant_site_model::{Camera, CameraId, ObjectModel, Rig};
use std::path::{Path, PathBuf};

/// More images than this are treated as a stream, of which only images with new views of the board are kept.
const MANY: usize = 60;

/// Arguments of `sextant calibrate lens`.
#[derive(Args, Debug)]
#[command(
    after_help = "Print a board (`sextant print board`), glue it onto something flat, and take 30 images of it:
everywhere in the image, above all at its edges and corners, large enough to fill a third of it, tilted by 30 degrees or
more in every direction. It may be partly visible. Without --model cross-validation selects the simplest model that
predicts corners best in images it was not fitted to. If the images do not determine the lens, the cause is reported and
nothing is written. The camera keeps its pose in the rig file, or is added to it; the previous file is kept as
FILE.former.

Of more than 60 images those are used that show the board in another place, tilt or size than the ones before; the
report says how many.

DIR may also be a folder of pictures (JPEG, PNG and others) without data.csv, or have one named after the camera.

With --live the images come from a camera of the running site: hold the board as instructed until there are enough
images, or press Ctrl-C; then the lens is solved. With --json, progress is one line per second at most: {\"kind\",
\"images\",\"fraction\",\"is_enough\",\"hint\",\"details\":{\"views\",\"coverage\":[[corners]],\"tilted\":[left,right,
upper,lower]}}.

The scale of the board does not affect the lens.

--report DIR writes residuals.png, uncertainty.png and lens.json.
With --json, the result is one line on standard output: {\"camera\",\"resolution\",\"lens\",\"sigmas\",\"rms_px\",
\"noise_px\",\"images\",\"views\",\"alike\",\"without_board\",\"tags\",\"wrong_tags\",\"suspicious\",
\"models\":[{\"model\",\"held_out_rms_px\"}],\"coverage\",\"uncertainty_px\":{\"mean\",\"largest\"},
\"cells\":[[{\"corners\",\"mean_px\",\"rms_px\",\"sigma_px\"}]],\"verdict\":{\"grade\",\"because\"}}"
)]
pub struct LensArguments {
    #[command(flatten)]
    images: ImageArguments,
    /// Object file of the board, as written by `sextant print board`, or the board of another tool (docs/boards.md).
    #[arg(long, value_name = "FILE")]
    board: PathBuf,
    /// The camera.
    #[arg(long, value_name = "ID")]
    camera: CameraId,
    /// Rig file to write the lens into; created if it does not exist.
    #[arg(long, value_name = "FILE")]
    rig: PathBuf,
    /// Lens model: pinhole, brown-conrady or kannala-brandt. By default it is selected by cross-validation.
    #[arg(long)]
    model: Option<LensModel>,
    /// Measured edge of a black square of the board, metres; by default that of the board file.
    #[arg(long, value_name = "METRES")]
    measured_size: Option<f64>,
    /// Width and height of the images, such as 640x480; needed for detections of a camera that is not in the rig.
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    resolution: Option<[u32; 2]>,
    /// Folder for charts of residuals and uncertainty.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
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
    let chessboard = ChessboardSearch::among([&board], PartialViews::Used);
    let camera = Some(&arguments.camera);
    let mut images = arguments.images.open(format, chessboard.as_ref(), camera)?;
    let (resolution, selection) = pictures_of(&mut images, arguments, &known)?;
    let plan = Plan::Lens(LensPlan {
        camera: arguments.camera.clone(),
        board,
        resolution,
        model: arguments.model,
        selection,
    });
    let looking = ImageSelection {
        rig: Rig::new(vec![placeholder(arguments, resolution)?])?,
        cameras: vec![arguments.camera.clone()],
        families: plan.families(),
        chessboard,
    };
    let procedure = Procedure::start(known, plan).exit_with(Exit::Input)?;
    finish(&images.outcome(procedure, &looking)?, arguments, format)
}

/// Writes the lens and prints the report.
fn finish(
    outcome: &ProcedureOutcome,
    arguments: &LensArguments,
    format: Format,
) -> anyhow::Result<()> {
    let (Product::Rig(rig), Report::Lens(report)) = (&outcome.product, &outcome.report) else {
        bail!("the calibration of a lens gave no lens");
    };
    write_rig(&arguments.rig, rig)?;
    if let Some(folder) = &arguments.report {
        pictures::write(folder, report)?;
    }
    match format {
        Format::Json => print_line(&serde_json::to_string(report)?)?,
        Format::Text => {
            print_line(&words::text(report, &arguments.rig))?;
            if let Some(line) = arguments.images.handing_over("rig", &arguments.rig) {
                print_line(&line)?;
            }
        }
    }
    Ok(())
}

/// The size of the camera's pictures, and which of them are kept.
fn pictures_of(
    images: &mut Images<'_>,
    arguments: &LensArguments,
    known: &Rig,
) -> anyhow::Result<([u32; 2], Selection)> {
    match images {
        Images::Live(live) => Ok((live.resolution_of(&arguments.camera)?, Selection::New)),
        Images::Recorded {
            folder, recorded, ..
        } => {
            let frames = frames(arguments, folder, &recorded.dataset)?;
            let selection = if frames.len() > MANY {
                Selection::New
            } else {
                Selection::All
            };
            let resolution = resolution_of(arguments, known.cameras(), &frames)?;
            Ok((resolution, selection))
        }
    }
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
    enlarged(&board, measured / size).map_err(with_remedy)
}

/// The cameras of a rig file that may not be there yet.
fn existing(path: &Path) -> anyhow::Result<Rig> {
    if !path.exists() {
        return Ok(Rig::default());
    }
    Ok(read_rig(path)?)
}

/// What the recording has of the camera.
fn frames(
    arguments: &LensArguments,
    recording: &Path,
    dataset: &Dataset,
) -> anyhow::Result<Vec<Frame>> {
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

/// Resolution: from the arguments, the rig, or the first image.
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
            let picture = read_picture(path).exit_with(Exit::Input)?;
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

/// A placeholder for the camera while images are read; its lens is not used.
fn placeholder(arguments: &LensArguments, resolution: [u32; 2]) -> anyhow::Result<Camera> {
    let [width, height] = resolution.map(f64::from);
    let lens = Lens::pinhole(Intrinsics {
        fx: width,
        fy: width,
        cx: width / 2.0,
        cy: height / 2.0,
    });
    Ok(Camera::new(
        arguments.camera.clone(),
        resolution,
        lens.exit_with(Exit::Input)?,
        None,
    ))
}
