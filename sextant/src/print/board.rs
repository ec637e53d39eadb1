//! A flat board of tags for the calibration of lenses and rigs: its sheet and its object file.
//!
//! The origin of the board's frame is the centre of the grid; x points right, y up and z out of the paper, as for each of its
//! tags. Ids run from the top left, row by row.

use super::PrintJob;
use super::sheet::{MARGIN, NOTE, Paper, SMALL, Sheet, label_of, length_text, printed_edge};
use anyhow::ensure;
use clap::Args;
use sextant_calibrator::{PrintedGrid, STRIP_MM};
use sextant_tag_families::Family;

/// Height of ruler and notes under the grid.
const FOOT: f64 = 30.0;

/// Options of a board.
#[derive(Args, Debug, Clone)]
pub struct BoardArguments {
    /// Tags per row.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub columns: u16,
    /// Rows of tags.
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=100))]
    pub rows: u16,
    /// Edge of each black square, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.028)]
    pub size: f64,
    /// The tags' family.
    #[arg(long, default_value = "tag36h11")]
    pub family: Family,
    /// Id of the tag at the top left; the others follow row by row.
    #[arg(long, value_name = "ID", default_value_t = 0)]
    pub first: u32,
}

/// Lays out the board.
///
/// # Errors
/// A family with too few tags, or a grid larger than the paper.
pub fn board(arguments: &BoardArguments, id: &str, paper: Paper) -> anyhow::Result<PrintJob> {
    let ids = super::ids_from(arguments.family, arguments.first, arguments.tags())?;
    let size = arguments.size * 1e3;
    super::check_size(size)?;
    let grid = arguments.grid();
    let pitch = grid.pitch_mm();
    let [width, height] = paper.size();
    let across = pitch * f64::from(arguments.columns) - STRIP_MM;
    let down = pitch * f64::from(arguments.rows);
    let room = [width - 2.0 * MARGIN, height - 2.0 * MARGIN - FOOT];
    ensure!(
        across <= room[0] && down <= room[1],
        "the grid is {across:.0} x {down:.0} mm with its white, but {} leaves {:.0} x {:.0} mm; take fewer tags or a smaller --size",
        paper.name(),
        room[0],
        room[1]
    );
    let model = grid.object(id)?;
    let middle = [width / 2.0, height - MARGIN - down / 2.0];
    let mut sheet = Sheet::new(paper);
    for (tag, place) in ids.iter().zip(grid.places_mm()) {
        let centre = [middle[0] + place[0], middle[1] + place[1]];
        sheet.tag(*tag, centre, size);
        let below = centre[1] - printed_edge(*tag, size) / 2.0 - 0.75 * SMALL;
        sheet.text([centre[0] - size / 2.0, below], SMALL, label_of(*tag, size));
    }
    foot(&mut sheet, arguments, size);
    sheet.ruler_up([width - MARGIN + 1.0, middle[1] - 50.0]);
    Ok(PrintJob {
        title: format!("Sextant board {id}"),
        pages: vec![sheet.into_page()],
        model,
        size,
    })
}

fn foot(sheet: &mut Sheet, arguments: &BoardArguments, size: f64) {
    sheet.ruler_right([MARGIN + 5.0, MARGIN + 4.0]);
    let notes = [
        format!(
            "{} x {} tags {}, ids {} to {}, black squares of {}. Print at 100 % and glue it onto something stiff and flat.",
            arguments.columns,
            arguments.rows,
            arguments.family,
            arguments.first,
            arguments.first + arguments.tags() - 1,
            length_text(size)
        ),
        "Both rulers must be 100 mm long. If they are not, measure a black square from edge to edge in metres".to_owned(),
        "and run the same command with --measured-size, or state it to `sextant calibrate lens`.".to_owned(),
    ];
    let top = MARGIN + 4.0 + 8.0 + 1.35 * NOTE * (notes.len() - 1) as f64;
    sheet.notes([MARGIN + 5.0, top], &notes);
}

impl BoardArguments {
    fn tags(&self) -> u32 {
        self.grid().tags()
    }

    fn grid(&self) -> PrintedGrid {
        PrintedGrid {
            columns: self.columns,
            rows: self.rows,
            size_m: self.size,
            family: self.family,
            first: self.first,
        }
    }
}
