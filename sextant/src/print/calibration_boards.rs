//! Boards of other tools: Kalibr's AprilGrid, OpenCV's ChArUco board and plain chessboards, with object files that describe them.

use super::PrintJob;
use super::sheet::{MARGIN, NOTE, Paper, Sheet};
use anyhow::ensure;
use clap::Args;
use sextant_site_files::{AprilGrid, CharucoBoard, Chessboard, UpperLeft};
use sextant_tag_families::Family;

/// Height of ruler and notes under the board.
const FOOT: f64 = 34.0;

/// Options of an AprilGrid.
#[derive(Args, Debug, Clone)]
pub struct AprilgridArguments {
    /// Tags per row: Kalibr's tagCols.
    #[arg(long, default_value_t = 6)]
    pub columns: u16,
    /// Rows of tags: Kalibr's tagRows.
    #[arg(long, default_value_t = 6)]
    pub rows: u16,
    /// Edge of each tag's black square, metres: Kalibr's tagSize.
    #[arg(long, value_name = "METRES", default_value_t = 0.022)]
    pub size: f64,
    /// Gap between tags as a share of their edge: Kalibr's tagSpacing.
    #[arg(long, value_name = "SHARE", default_value_t = 0.3)]
    pub spacing: f64,
    /// Id of the tag at the lower left; the others follow row by row.
    #[arg(long, value_name = "ID", default_value_t = 0)]
    pub first: u32,
}

/// Options of a ChArUco board.
#[derive(Args, Debug, Clone)]
pub struct CharucoArguments {
    /// Squares per row: OpenCV's squaresX.
    #[arg(long, default_value_t = 5)]
    pub columns: u16,
    /// Rows of squares: OpenCV's squaresY.
    #[arg(long, default_value_t = 7)]
    pub rows: u16,
    /// Edge of each square, metres: OpenCV's squareLength.
    #[arg(long, value_name = "METRES", default_value_t = 0.033)]
    pub size: f64,
    /// Edge of each marker as a share of its square: OpenCV's markerLength / squareLength.
    #[arg(long, value_name = "SHARE", default_value_t = 0.75)]
    pub marker: f64,
    /// The squares' family: charuco and OpenCV's dictionary.
    #[arg(long, default_value = "charuco5x5-100")]
    pub family: Family,
}

/// Options of a plain chessboard.
#[derive(Args, Debug, Clone)]
pub struct ChessboardArguments {
    /// Inner corners per row, one fewer than squares. With an even number of columns and an odd one of rows, or the other way round,
    /// images tell which end is up.
    #[arg(long, default_value_t = 6)]
    pub columns: u16,
    /// Rows of inner corners.
    #[arg(long, default_value_t = 9)]
    pub rows: u16,
    /// Edge of each square, metres.
    #[arg(long, value_name = "METRES", default_value_t = 0.022)]
    pub size: f64,
}

/// Lays out the grid.
///
/// # Errors
/// An invalid grid, or one larger than the paper.
pub fn aprilgrid(
    arguments: &AprilgridArguments,
    id: &str,
    paper: Paper,
) -> anyhow::Result<PrintJob> {
    let &AprilgridArguments {
        columns,
        rows,
        size,
        spacing,
        first,
    } = arguments;
    super::check_size(size * 1e3)?;
    let grid = AprilGrid {
        columns,
        rows,
        size_m: size,
        spacing,
        first,
    };
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
            "AprilGrid: tagCols {columns}, tagRows {rows}, tagSize {size}, tagSpacing {spacing}; tag36h11 from {first} on."
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
pub fn charuco(arguments: &CharucoArguments, id: &str, paper: Paper) -> anyhow::Result<PrintJob> {
    let &CharucoArguments {
        columns,
        rows,
        size,
        marker,
        family,
    } = arguments;
    super::check_size(size * 1e3)?;
    let board = CharucoBoard {
        columns,
        rows,
        square_m: size,
        marker_m: size * marker,
        family,
        first: 0,
        upper_left: UpperLeft::Black,
    };
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
        sheet.tag(tag, centre, edge * marker);
    }
    foot(
        &mut sheet,
        format!(
            "ChArUco: {columns} x {rows} squares, squareLength {size}, markerLength {}, {family}.",
            (size * marker * 1e6).round() * 1e-6
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
pub fn chessboard(
    arguments: &ChessboardArguments,
    id: &str,
    paper: Paper,
) -> anyhow::Result<PrintJob> {
    let &ChessboardArguments {
        columns,
        rows,
        size,
    } = arguments;
    super::check_size(size * 1e3)?;
    let board = Chessboard {
        columns,
        rows,
        square_m: size,
    };
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
fn place([across, down]: [f64; 2], paper: Paper) -> anyhow::Result<[f64; 2]> {
    let [width, height] = paper.size();
    let room = [width - 2.0 * MARGIN, height - 2.0 * MARGIN - FOOT];
    ensure!(
        across <= room[0] && down <= room[1],
        "the board is {across:.0} x {down:.0} mm, but {} leaves {:.0} x {:.0} mm; take fewer columns or rows or a smaller --size",
        paper.name(),
        room[0],
        room[1]
    );
    Ok([(width - across) / 2.0, height - MARGIN - down])
}

fn foot(sheet: &mut Sheet, board: String) {
    sheet.ruler_right([MARGIN + 5.0, MARGIN + 4.0]);
    let notes = [
        board,
        "Print at 100 % and glue it onto something stiff and flat. The ruler must be 100 mm long; if it is not, measure".to_owned(),
        "a black square from edge to edge in metres and run the same command with --measured-size.".to_owned(),
    ];
    let top = MARGIN + 4.0 + 8.0 + 1.35 * NOTE * (notes.len() - 1) as f64;
    sheet.notes([MARGIN + 5.0, top], &notes);
}
