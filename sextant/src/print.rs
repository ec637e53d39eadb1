//! `sextant print`: boards, tags and cubes as PDF in true size, with their object files.

mod ids;

use crate::output::{Format, print_line};
use crate::words;
use anyhow::anyhow;
use clap::{Args, Subcommand, ValueEnum};
use ids::Ids;
use serde_json::json;
use sextant_calibrator::PrintedGrid;
use sextant_process::{Exit, WithExit};
use sextant_sheets::{Cube, Paper, PrintJob, SheetError, enlarged, length_text, pdf};
use sextant_site_files::{
    AprilGrid, CharucoBoard, Chessboard, UpperLeft, object_toml, write_atomically,
    write_keeping_former,
};
use sextant_tag_families::{Board, Family};
use std::path::PathBuf;

/// Arguments of `sextant print`.
#[derive(Args, Debug)]
#[command(
    after_help = "Writes a PDF in true size, with rulers to check the printer, and an object file (board.toml) with the
ids, sizes and poses of the tags. Print at 100 % (\"actual size\").

If the rulers are not 100 mm long, measure a black square from edge to edge and run the same command with
--measured-size: then only the object file is written, scaled to the measured size.

For example: sextant print board
             sextant print board --measured-size 0.0277
             sextant print aprilgrid --columns 6 --rows 6 --size 0.022
             sextant print charuco --family charuco5x5-100
             sextant print chessboard --columns 6 --rows 9 --size 0.022
             sextant print tags --ids 3-9 --size 0.03 --out gamepad.pdf
             sextant print starter
             sextant print cube --edge 0.06 --size 0.04 --first 10"
)]
pub struct PrintArguments {
    #[command(subcommand)]
    what: What,
    /// The paper.
    #[arg(long, value_enum, default_value = "a4", global = true)]
    paper: PaperName,
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

/// Value of `--paper`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PaperName {
    /// 210 x 297 mm.
    A4,
    /// 8.5 x 11 inches.
    Letter,
}

impl From<PaperName> for Paper {
    fn from(name: PaperName) -> Self {
        match name {
            PaperName::A4 => Self::A4,
            PaperName::Letter => Self::Letter,
        }
    }
}

#[derive(Subcommand, Debug)]
enum What {
    /// Flat board for calibrating lenses and rigs.
    Board(BoardArguments),
    /// Kalibr AprilGrid, for calibrating with Kalibr and with Sextant.
    Aprilgrid(AprilgridArguments),
    /// OpenCV ChArUco board, for calibrating with OpenCV and with Sextant.
    Charuco(CharucoArguments),
    /// Plain chessboard, for calibrating with any program.
    Chessboard(ChessboardArguments),
    /// Single tags to cut out and stick on objects.
    Tags(TagsArguments),
    /// Cube to fold, with a tag on each face.
    Cube(CubeArguments),
    /// One page for a first site: tags of two objects and of the floor, with an object file for each.
    Starter,
}

/// Options of a board.
#[derive(Args, Debug, Clone)]
struct BoardArguments {
    /// Tags per row.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=100))]
    columns: u16,
    /// Rows of tags.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=100))]
    rows: u16,
    /// Edge of each black square, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.028)]
    size: f64,
    /// The tags' family.
    #[arg(long, default_value = "tag36h11")]
    family: Family,
    /// Id of the tag at the top left; the others follow row by row.
    #[arg(long, value_name = "ID", default_value_t = 0)]
    first: u32,
}

/// Options of an AprilGrid.
#[derive(Args, Debug, Clone)]
struct AprilgridArguments {
    /// Tags per row: Kalibr's tagCols.
    #[arg(long, default_value_t = 6)]
    columns: u16,
    /// Rows of tags: Kalibr's tagRows.
    #[arg(long, default_value_t = 6)]
    rows: u16,
    /// Edge of each tag's black square, metres: Kalibr's tagSize.
    #[arg(long, value_name = "METRES", default_value_t = 0.022)]
    size: f64,
    /// Gap between tags as a share of their edge: Kalibr's tagSpacing.
    #[arg(long, value_name = "SHARE", default_value_t = 0.3)]
    spacing: f64,
    /// Id of the tag at the lower left; the others follow row by row.
    #[arg(long, value_name = "ID", default_value_t = 0)]
    first: u32,
}

/// Options of a ChArUco board.
#[derive(Args, Debug, Clone)]
struct CharucoArguments {
    /// Squares per row: OpenCV's squaresX.
    #[arg(long, default_value_t = 5)]
    columns: u16,
    /// Rows of squares: OpenCV's squaresY.
    #[arg(long, default_value_t = 7)]
    rows: u16,
    /// Edge of each square, metres: OpenCV's squareLength.
    #[arg(long, value_name = "METRES", default_value_t = 0.033)]
    size: f64,
    /// Edge of each marker as a share of its square: OpenCV's markerLength / squareLength.
    #[arg(long, value_name = "SHARE", default_value_t = 0.75)]
    marker: f64,
    /// The squares' family: charuco and OpenCV's dictionary.
    #[arg(long, default_value = "charuco5x5-100")]
    family: Family,
}

/// Options of a plain chessboard.
#[derive(Args, Debug, Clone)]
struct ChessboardArguments {
    /// Inner corners per row, one fewer than squares. With an even number of columns and an odd one of rows, or the
    /// other way round, images tell which end is up.
    #[arg(long, default_value_t = 6)]
    columns: u16,
    /// Rows of inner corners.
    #[arg(long, default_value_t = 9)]
    rows: u16,
    /// Edge of each square, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.022)]
    size: f64,
}

/// Options of single tags.
#[derive(Args, Debug, Clone)]
struct TagsArguments {
    /// Ids and ranges, such as 0-5,9.
    #[arg(long, value_name = "IDS", default_value = "0-5")]
    ids: Ids,
    /// Edge of each black square, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.04)]
    size: f64,
    /// The tags' family.
    #[arg(long, default_value = "tag36h11")]
    family: Family,
}

/// Options of a cube.
#[derive(Args, Debug, Clone)]
struct CubeArguments {
    /// Edge of the cube, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.06)]
    edge: f64,
    /// Edge of each black square, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.04)]
    size: f64,
    /// The tags' family.
    #[arg(long, default_value = "tag36h11")]
    family: Family,
    /// Id of the first tag; the others follow.
    #[arg(long, value_name = "ID", default_value_t = 0)]
    first: u32,
}

/// Runs `sextant print`.
///
/// # Errors
/// [`Exit::Usage`] for what is larger than the paper, and files that cannot be written.
pub fn run(arguments: &PrintArguments, format: Format) -> anyhow::Result<()> {
    let paper = Paper::from(arguments.paper);
    if matches!(arguments.what, What::Starter) {
        return print_starter(arguments, paper, format);
    }
    let id = arguments.id.as_deref().unwrap_or(arguments.what.word());
    let printed = arguments.what.printed(id, paper);
    let printed = printed.map_err(with_remedy).exit_with(Exit::Usage)?;
    let default = || PathBuf::from(format!("{}.pdf", arguments.what.word()));
    let pdf_file = arguments.out.clone().unwrap_or_else(default);
    let object_file = pdf_file.with_extension("toml");
    let model = match arguments.measured_size {
        Some(measured) => printed
            .as_measured(measured)
            .map_err(with_remedy)
            .exit_with(Exit::Usage)?,
        None => printed.model.clone(),
    };
    let toml = format!(
        "{}{}",
        heading(printed.size, arguments),
        object_toml(&model)
    );
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
            paper.name(),
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

/// The page with an object file for each of its objects, beside it.
fn print_starter(arguments: &PrintArguments, paper: Paper, format: Format) -> anyhow::Result<()> {
    if arguments.id.is_some() {
        let cause = anyhow!("--id: the starter sheet has three objects with names of their own");
        return Err(cause).exit_with(Exit::Usage);
    }
    let starter = sextant_sheets::starter(paper)?;
    let default = || PathBuf::from("starter.pdf");
    let pdf_file = arguments.out.clone().unwrap_or_else(default);
    let scale = arguments
        .measured_size
        .map(|measured| measured * 1e3 / starter.size);
    let heading = heading(starter.size, arguments);
    let mut files = Vec::new();
    for object in &starter.objects {
        let measured = scale.map(|scale| enlarged(object, scale)).transpose();
        let measured = measured.map_err(with_remedy).exit_with(Exit::Usage)?;
        let file = pdf_file.with_file_name(format!("{}.toml", object.id()));
        let toml = object_toml(measured.as_ref().unwrap_or(object));
        write_keeping_former(&file, format!("{heading}{toml}").as_bytes())?;
        files.push(file.display().to_string());
    }
    if scale.is_none() {
        let pages = [starter.page];
        write_atomically(&pdf_file, &pdf::pdf("Sextant starter sheet", &pages))?;
    }
    let pdf_file = scale.is_none().then_some(pdf_file);
    let words = match (format, pdf_file) {
        (Format::Json, pdf) => json!({"pdf": pdf, "objects": files}).to_string(),
        (Format::Text, Some(pdf)) => format!(
            "{}: one page on {}; print at 100 % and check the ruler\n{}: its objects",
            pdf.display(),
            paper.name(),
            files.join(", ")
        ),
        (Format::Text, None) => format!("{}: as measured", files.join(", ")),
    };
    Ok(print_line(&words)?)
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
            Self::Starter => "starter",
        }
    }

    fn printed(&self, id: &str, paper: Paper) -> Result<PrintJob, SheetError> {
        match self {
            Self::Board(arguments) => {
                let grid = PrintedGrid {
                    columns: arguments.columns,
                    rows: arguments.rows,
                    size_m: arguments.size,
                    family: arguments.family,
                    first: arguments.first,
                };
                sextant_sheets::board(&grid, id, paper)
            }
            Self::Aprilgrid(arguments) => {
                let grid = AprilGrid {
                    columns: arguments.columns,
                    rows: arguments.rows,
                    size_m: arguments.size,
                    spacing: arguments.spacing,
                    first: arguments.first,
                };
                sextant_sheets::aprilgrid(&grid, id, paper)
            }
            Self::Charuco(arguments) => {
                let board = CharucoBoard {
                    columns: arguments.columns,
                    rows: arguments.rows,
                    square_m: arguments.size,
                    marker_m: arguments.size * arguments.marker,
                    family: arguments.family,
                    first: 0,
                    upper_left: UpperLeft::Black,
                };
                sextant_sheets::charuco(&board, id, paper)
            }
            Self::Chessboard(arguments) => {
                let board = Chessboard {
                    columns: arguments.columns,
                    rows: arguments.rows,
                    square_m: arguments.size,
                };
                sextant_sheets::chessboard(&board, id, paper)
            }
            Self::Tags(arguments) => {
                let ids = arguments.ids.as_slice();
                sextant_sheets::tags(arguments.family, ids, arguments.size, id, paper)
            }
            Self::Cube(arguments) => {
                let cube = Cube {
                    edge_m: arguments.edge,
                    size_m: arguments.size,
                    family: arguments.family,
                    first: arguments.first,
                };
                sextant_sheets::cube(&cube, id, paper)
            }
            // Several objects: see `print_starter`.
            Self::Starter => sextant_sheets::tags(Family::Tag36h11, &[0], 0.04, id, paper),
        }
    }
}

/// An error with the options that remedy it.
pub fn with_remedy(error: SheetError) -> anyhow::Error {
    match &error {
        SheetError::TooLarge { what: "grid", .. } => {
            anyhow!("{error}; take fewer tags or a smaller --size")
        }
        SheetError::TooLarge { .. } => {
            anyhow!("{error}; take fewer columns or rows or a smaller --size")
        }
        SheetError::TagTooLarge { .. } => anyhow!("{error}; take a smaller --size"),
        SheetError::FaceTooSmall { .. } => {
            anyhow!("{error}; take a smaller --size or a larger --edge")
        }
        SheetError::NetTooLarge { largest, .. } => {
            anyhow!(
                "{error}; --edge can be {:.3} at most",
                largest.floor() * 1e-3
            )
        }
        SheetError::Size(_) => anyhow!("--size {error}"),
        SheetError::Scale(_) => anyhow!("--measured-size is {error}"),
        SheetError::OfBoard { board, .. } => {
            let command = match board {
                Board::Aprilgrid => "aprilgrid",
                Board::Charuco => "charuco",
                Board::Chessboard => "chessboard",
            };
            anyhow!("{error}; print one with `sextant print {command}`")
        }
        SheetError::UnknownTag { .. }
        | SheetError::Board(_)
        | SheetError::Grid(_)
        | SheetError::Object(_)
        | SheetError::Id(_) => error.into(),
    }
}

/// The comment at the top of the object file.
fn heading(size: f64, arguments: &PrintArguments) -> String {
    let nominal = length_text(size);
    match arguments.measured_size {
        Some(measured) => format!(
            "# Printed with black squares of {nominal}, measured as {}; sizes and places are those measured.\n",
            length_text(measured * 1e3)
        ),
        None => format!(
            "# Printed with black squares of {nominal}; if they measure otherwise, print again with --measured-size.\n"
        ),
    }
}
