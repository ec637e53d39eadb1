//! `sextant print`: boards, tags and cubes as PDF in true size, with their object files.

mod board;
mod calibration_boards;
mod cube;
mod pdf;
mod sheet;
mod tags;

use crate::output::{Format, print_line};
use crate::words;
use anyhow::{bail, ensure};
use clap::{Args, Subcommand};
use nalgebra::Translation3;
use pdf::Page;
use serde_json::json;
use sextant_process::{Exit, WithExit};
use sextant_site_files::{object_toml, write_atomically, write_keeping_former};
use sextant_site_model::{ObjectModel, ObjectTag, TagId};
use sextant_tag_families::{Board, Family};
use sheet::{Paper, length_text};
use std::path::PathBuf;

/// Arguments of `sextant print`.
#[derive(Args, Debug)]
#[command(
    after_help = "Writes a PDF in true size, with rulers to check the printer, and an object file (board.toml) with the ids, sizes and
poses of the tags. Print at 100 % (\"actual size\").

If the rulers are not 100 mm long, measure a black square from edge to edge and run the same command with --measured-size:
then only the object file is written, scaled to the measured size.

For example: sextant print board
             sextant print board --measured-size 0.0277
             sextant print aprilgrid --columns 6 --rows 6 --size 0.022
             sextant print charuco --family charuco5x5-100
             sextant print chessboard --columns 6 --rows 9 --size 0.022
             sextant print tags --ids 3-9 --size 0.03 --out gamepad.pdf
             sextant print cube --edge 0.06 --size 0.04 --first 10"
)]
pub struct PrintArguments {
    #[command(subcommand)]
    what: What,
    /// The paper.
    #[arg(long, value_enum, default_value = "a4", global = true)]
    paper: Paper,
    /// PDF to write; the object file has the same name with .toml. Default: board.pdf, tags.pdf and so on.
    #[arg(long, value_name = "FILE.pdf", global = true)]
    out: Option<PathBuf>,
    /// Id of the object. Default: board, tags and so on.
    #[arg(long, value_name = "ID", global = true)]
    id: Option<String>,
    /// Measured edge of a printed black square, metres.
    #[arg(long, value_name = "METRES", global = true)]
    measured_size: Option<f64>,
}

#[derive(Subcommand, Debug)]
enum What {
    /// Flat board for calibrating lenses and rigs.
    Board(board::BoardArguments),
    /// Kalibr AprilGrid, for calibrating with Kalibr and with Sextant.
    Aprilgrid(calibration_boards::AprilgridArguments),
    /// OpenCV ChArUco board, for calibrating with OpenCV and with Sextant.
    Charuco(calibration_boards::CharucoArguments),
    /// Plain chessboard, for calibrating with any program.
    Chessboard(calibration_boards::ChessboardArguments),
    /// Single tags to cut out and stick on objects.
    Tags(tags::TagsArguments),
    /// Cube to fold, with a tag on each face.
    Cube(cube::CubeArguments),
}

/// Pages with their object. Sizes on paper are in millimetres, those of the object in metres.
struct PrintJob {
    title: String,
    pages: Vec<Page>,
    model: ObjectModel,
    /// Edge of the black squares.
    size: f64,
}

/// Runs `sextant print`.
///
/// # Errors
/// [`Exit::Usage`] for what is larger than the paper, and files that cannot be written.
pub fn run(arguments: &PrintArguments, format: Format) -> anyhow::Result<()> {
    let id = arguments.id.as_deref().unwrap_or(arguments.what.word());
    let printed = arguments
        .what
        .printed(id, arguments.paper)
        .exit_with(Exit::Usage)?;
    let default = || PathBuf::from(format!("{}.pdf", arguments.what.word()));
    let pdf_file = arguments.out.clone().unwrap_or_else(default);
    let object_file = pdf_file.with_extension("toml");
    let model = match arguments.measured_size {
        Some(measured) => as_measured(&printed, measured).exit_with(Exit::Usage)?,
        None => printed.model.clone(),
    };
    let toml = format!("{}{}", heading(&printed, arguments), object_toml(&model));
    write_keeping_former(&object_file, toml.as_bytes())?;
    if arguments.measured_size.is_none() {
        write_atomically(&pdf_file, &pdf::pdf(&printed.title, &printed.pages))?;
    }
    let (pages, tags) = (printed.pages.len(), model.tags().len());
    let pdf_file = arguments.measured_size.is_none().then_some(pdf_file);
    match (format, pdf_file) {
        (Format::Json, pdf) => print_line(
            &json!({"pdf": pdf, "object": object_file, "pages": pages, "tags": tags}).to_string(),
        )?,
        (Format::Text, Some(pdf)) => print_line(&format!(
            "{}: {} on {}; print at 100 % and check the ruler\n{}: {} of {}",
            pdf.display(),
            words::count(pages, "page"),
            arguments.paper.name(),
            object_file.display(),
            words::count(tags, "tag"),
            length_text(printed.size)
        ))?,
        (Format::Text, None) => print_line(&format!(
            "{}: {} as measured",
            object_file.display(),
            words::count(tags, "tag")
        ))?,
    }
    Ok(())
}

impl What {
    fn word(&self) -> &'static str {
        match self {
            Self::Board(_) => "board",
            Self::Aprilgrid(_) => "aprilgrid",
            Self::Charuco(_) => "charuco",
            Self::Chessboard(_) => "chessboard",
            Self::Tags(_) => "tags",
            Self::Cube(_) => "cube",
        }
    }

    fn printed(&self, id: &str, paper: Paper) -> anyhow::Result<PrintJob> {
        match self {
            Self::Board(arguments) => board::board(arguments, id, paper),
            Self::Aprilgrid(arguments) => calibration_boards::aprilgrid(arguments, id, paper),
            Self::Charuco(arguments) => calibration_boards::charuco(arguments, id, paper),
            Self::Chessboard(arguments) => calibration_boards::chessboard(arguments, id, paper),
            Self::Tags(arguments) => tags::tags(arguments, id, paper),
            Self::Cube(arguments) => cube::cube(arguments, id, paper),
        }
    }
}

/// The comment at the top of the object file.
fn heading(printed: &PrintJob, arguments: &PrintArguments) -> String {
    let nominal = length_text(printed.size);
    match arguments.measured_size {
        Some(measured) => format!(
            "# PrintJob with black squares of {nominal}, measured as {}; sizes and places are those measured.\n",
            length_text(measured * 1e3)
        ),
        None => format!(
            "# PrintJob with black squares of {nominal}; if they measure otherwise, print again with --measured-size.\n"
        ),
    }
}

/// The object with the measured size of its tags.
fn as_measured(printed: &PrintJob, measured_m: f64) -> anyhow::Result<ObjectModel> {
    enlarged(&printed.model, measured_m * 1e3 / printed.size)
}

/// Scales an object as a whole, as a printer does.
///
/// # Errors
/// A scale that no printer causes.
pub fn enlarged(object: &ObjectModel, scale: f64) -> anyhow::Result<ObjectModel> {
    ensure!(
        (0.5..=2.0).contains(&scale),
        "--measured-size is {scale:.3} times what was printed; it is the edge of a black square in metres"
    );
    let tags = object.tags().iter().map(|tag| {
        let place = tag.object_from_tag.map(|mut pose| {
            pose.translation = Translation3::from(pose.translation.vector * scale);
            pose
        });
        ObjectTag::new(tag.tag, tag.size_m * scale, place)
    });
    Ok(ObjectModel::new(object.id().clone(), tags.collect())?)
}

/// `count` consecutive tags of a family.
fn ids_from(family: Family, first: u32, count: u32) -> anyhow::Result<Vec<TagId>> {
    (0..count)
        .map(|index| tag_of(family, first.saturating_add(index)))
        .collect()
}

fn tag_of(family: Family, id: u32) -> anyhow::Result<TagId> {
    if let Some(board) = family.data().board {
        let command = match board {
            Board::Aprilgrid => "aprilgrid",
            Board::Charuco => "charuco",
            Board::Chessboard => "chessboard",
        };
        bail!("tags of {family} are part of a board; print one with `sextant print {command}`");
    }
    let last = family.data().codes.len() - 1;
    ensure!(
        id as usize <= last,
        "{family} has no tag {id}; its ids are 0 to {last}"
    );
    Ok(TagId { family, id })
}

/// The comparison also refuses NaN.
fn check_size(mm: f64) -> anyhow::Result<()> {
    ensure!(
        (5.0..=300.0).contains(&mm),
        "--size {} is no tag for this paper; it is the edge of the black square in metres, 0.005 to 0.3",
        mm * 1e-3
    );
    Ok(())
}

#[cfg(test)]
mod tests;
