//! A flat board of tags for the calibration of lenses and rigs: its sheet and its object file.
//!
//! The origin of the board's frame is the centre of the grid; x points right, y up and z out of the paper, as for each
//! of its tags. Ids run from the top left, row by row.

use crate::sheet::{MARGIN, NOTE, SMALL, Sheet, label_of, length_text, printed_edge};
use crate::{Paper, PrintJob, SheetError, check_size, ids_from};
use sextant_calibrator::{PrintedGrid, STRIP_MM};

/// Height of ruler and notes under the grid.
const FOOT: f64 = 30.0;

/// Lays out the board.
///
/// # Errors
/// A family with too few tags, or a grid larger than the paper.
pub fn board(grid: &PrintedGrid, id: &str, paper: Paper) -> Result<PrintJob, SheetError> {
    let ids = ids_from(grid.family, grid.first, grid.tags())?;
    let size = grid.size_m * 1e3;
    check_size(size)?;
    let pitch = grid.pitch_mm();
    let [width, height] = paper.size();
    let across = pitch * f64::from(grid.columns) - STRIP_MM;
    let down = pitch * f64::from(grid.rows);
    let room = [width - 2.0 * MARGIN, height - 2.0 * MARGIN - FOOT];
    if across > room[0] || down > room[1] {
        return Err(SheetError::TooLarge {
            what: "grid",
            size: [across, down],
            room,
            paper,
        });
    }
    let model = grid.object(id)?;
    let middle = [width / 2.0, height - MARGIN - down / 2.0];
    let mut sheet = Sheet::new(paper);
    for (tag, place) in ids.iter().zip(grid.places_mm()) {
        let centre = [middle[0] + place[0], middle[1] + place[1]];
        sheet.tag(*tag, centre, size);
        let below = centre[1] - printed_edge(*tag, size) / 2.0 - 0.75 * SMALL;
        sheet.text([centre[0] - size / 2.0, below], SMALL, label_of(*tag, size));
    }
    foot(&mut sheet, grid, size);
    sheet.ruler_up([width - MARGIN + 1.0, middle[1] - 50.0]);
    Ok(PrintJob {
        title: format!("Sextant board {id}"),
        pages: vec![sheet.into_page()],
        model,
        size,
    })
}

fn foot(sheet: &mut Sheet, grid: &PrintedGrid, size: f64) {
    sheet.ruler_right([MARGIN + 5.0, MARGIN + 4.0]);
    let notes = [
        format!(
            "{} x {} tags {}, ids {} to {}, black squares of {}. Print at 100 % and glue it onto \
             something stiff and flat.",
            grid.columns,
            grid.rows,
            grid.family,
            grid.first,
            grid.first + grid.tags() - 1,
            length_text(size)
        ),
        "Both rulers must be 100 mm long. If they are not, measure a black square from edge to \
         edge in metres"
            .to_owned(),
        "and run the same command with --measured-size, or state it to `sextant calibrate lens`."
            .to_owned(),
    ];
    let top = MARGIN + 4.0 + 8.0 + 1.35 * NOTE * (notes.len() - 1) as f64;
    sheet.notes([MARGIN + 5.0, top], &notes);
}
