//! Boards of other tools: Kalibr's AprilGrid, OpenCV's ChArUco board and plain chessboards, with object files that
//! describe them.

use crate::sheet::{MARGIN, NOTE, Sheet};
use crate::{Paper, PrintJob, SheetError, check_size};
use sextant_site_files::{AprilGrid, CharucoBoard, Chessboard};

/// Height of ruler and notes under the board.
const FOOT: f64 = 34.0;

/// Lays out the grid.
///
/// # Errors
/// An invalid grid, or one larger than the paper.
pub fn aprilgrid(grid: &AprilGrid, id: &str, paper: Paper) -> Result<PrintJob, SheetError> {
    let &AprilGrid {
        columns,
        rows,
        size_m: size,
        spacing,
        first,
    } = grid;
    check_size(size * 1e3)?;
    let model = grid.object(id.parse()?)?;
    let edge = grid.square_m() * 1e3;
    let across = [columns, rows].map(|n| f64::from(n) * grid.pitch_m() * 1e3 + edge);
    let lower_left = place(across, paper)?;
    let on_paper = |at: [f64; 2]| [0, 1].map(|axis| lower_left[axis] + edge + at[axis] * 1e3);
    let mut sheet = Sheet::new(paper);
    for (tag, centre) in grid.tags() {
        sheet.tag(tag, on_paper(centre), size * 1e3);
    }
    sheet.squares(grid.squares().map(on_paper), edge);
    foot(
        &mut sheet,
        format!(
            "AprilGrid: tagCols {columns}, tagRows {rows}, tagSize {size}, tagSpacing {spacing}; \
             tag36h11 from {first} on."
        ),
    );
    Ok(PrintJob {
        title: format!("Sextant AprilGrid {id}"),
        pages: vec![sheet.into_page()],
        model,
        size: size * 1e3,
    })
}

/// Lays out the board.
///
/// # Errors
/// An invalid board, or one larger than the paper.
pub fn charuco(board: &CharucoBoard, id: &str, paper: Paper) -> Result<PrintJob, SheetError> {
    let &CharucoBoard {
        columns,
        rows,
        square_m: size,
        marker_m: marker,
        family,
        ..
    } = board;
    check_size(size * 1e3)?;
    let model = board.object(id.parse()?)?;
    let edge = size * 1e3;
    let lower_left = place([columns, rows].map(|n| f64::from(n) * edge), paper)?;
    // Rows are numbered from above.
    let corner = |[column, row]: [u16; 2]| {
        let up = rows - 1 - row;
        [
            lower_left[0] + f64::from(column) * edge,
            lower_left[1] + f64::from(up) * edge,
        ]
    };
    let mut sheet = Sheet::new(paper);
    sheet.squares(board.black_squares().map(corner), edge);
    for (tag, square) in board.squares() {
        let centre = corner(square).map(|at| at + edge / 2.0);
        sheet.tag(tag, centre, marker * 1e3);
    }
    foot(
        &mut sheet,
        format!(
            "ChArUco: {columns} x {rows} squares, squareLength {size}, markerLength {}, {family}.",
            (marker * 1e6).round() * 1e-6
        ),
    );
    Ok(PrintJob {
        title: format!("Sextant ChArUco board {id}"),
        pages: vec![sheet.into_page()],
        model,
        size: edge,
    })
}

/// Lays out the board.
///
/// # Errors
/// An invalid board, or one larger than the paper.
pub fn chessboard(board: &Chessboard, id: &str, paper: Paper) -> Result<PrintJob, SheetError> {
    let &Chessboard {
        columns,
        rows,
        square_m: size,
    } = board;
    check_size(size * 1e3)?;
    let model = board.object(id.parse()?)?;
    let edge = size * 1e3;
    let lower_left = place([columns + 1, rows + 1].map(|n| f64::from(n) * edge), paper)?;
    // The upper left square is black.
    let squares = (0..=rows).flat_map(|row| (0..=columns).map(move |column| [column, row]));
    let black = squares.filter(|[column, row]| (column + row) % 2 == 0);
    let corner = |[column, row]: [u16; 2]| {
        [
            lower_left[0] + f64::from(column) * edge,
            lower_left[1] + f64::from(rows - row) * edge,
        ]
    };
    let mut sheet = Sheet::new(paper);
    sheet.squares(black.map(corner), edge);
    foot(
        &mut sheet,
        format!("Chessboard: {columns} x {rows} inner corners, squares of {size} m."),
    );
    Ok(PrintJob {
        title: format!("Sextant chessboard {id}"),
        pages: vec![sheet.into_page()],
        model,
        size: edge,
    })
}

/// Lower left corner of a board of this size, above ruler and notes.
fn place([across, down]: [f64; 2], paper: Paper) -> Result<[f64; 2], SheetError> {
    let [width, height] = paper.size();
    let room = [width - 2.0 * MARGIN, height - 2.0 * MARGIN - FOOT];
    if across > room[0] || down > room[1] {
        return Err(SheetError::TooLarge {
            what: "board",
            size: [across, down],
            room,
            paper,
        });
    }
    Ok([(width - across) / 2.0, height - MARGIN - down])
}

fn foot(sheet: &mut Sheet, board: String) {
    sheet.ruler_right([MARGIN + 5.0, MARGIN + 4.0]);
    let notes = [
        board,
        "Print at 100 % and glue it onto something stiff and flat. The ruler must be 100 mm \
         long; if it is not, measure"
            .to_owned(),
        "a black square from edge to edge in metres and run the same command with --measured-size."
            .to_owned(),
    ];
    let top = MARGIN + 4.0 + 8.0 + 1.35 * NOTE * (notes.len() - 1) as f64;
    sheet.notes([MARGIN + 5.0, top], &notes);
}
