//! Plain chessboards: their inner corners with sub-pixel accuracy, in columns and rows.
//!
//! Input: an image and the number of inner corners. Output: squares of the board between inner corners, as detections
//! of the family `chessboard`. The stages: candidates (saddle points of the smoothed image), links between neighbours
//! along edges of squares, the lattice that links span, missing corners by local prediction, and the place of the
//! lattice on the board. Nothing assumes straight lines beyond neighbours, so that fisheye lenses work. Blurred images
//! are searched at half, a quarter and an eighth of their size.
//!
//! A chessboard has no ids. If it is seen in part, its place on the board remains unknown: indices then start at 0 in
//! the seen part, which serves to calibrate a lens, but not to compare cameras. A whole board has one orientation if it
//! has an even number of squares in one direction and an odd one in the other; otherwise it looks the same upside down,
//! and the orientation is the one in which the columns run to the right in the image.
//!
//! Unlike the detector, this allocates for every image.

mod candidates;
mod lattice;
mod links;
mod placement;
mod smoothed;

use crate::{Detection, Image};
use lattice::{Lattice, lattices};
use smoothed::Smoothed;

/// Least columns and rows of a partial view.
const LEAST_SEEN: u16 = 3;
/// Most lattices of an image that are completed, the largest first: others are texture.
const MOST_LATTICES: usize = 3;
/// Least size of a reduced image, in pixels.
const LEAST_PX: usize = 64;
/// Reduced images that are searched: a half, a quarter and an eighth of the size.
const REDUCED: usize = 3;

/// Inner corners of a chessboard, where four squares meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardShape {
    /// Inner corners in a row.
    pub columns: u16,
    /// Rows of inner corners.
    pub rows: u16,
}

/// How much of a board an image shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All columns and rows, although some corners may be hidden.
    Whole,
    /// Fewer columns or rows; which ones is not known.
    Part,
    /// More columns or rows: another board.
    Larger,
}

/// A chessboard in an image.
#[derive(Clone, Debug, PartialEq)]
pub struct ChessboardView {
    /// Columns and rows of inner corners that are seen.
    pub size: [u16; 2],
    /// How much of the board that is.
    pub extent: Extent,
    /// Squares that contain every corner seen, as few as possible; none of a larger board.
    pub squares: Vec<Detection>,
}

/// The chessboard in an image, if there is one.
pub fn find_chessboard(image: &Image<'_>, board: BoardShape) -> Option<ChessboardView> {
    let mut best = seen(image, board);
    let mut reduced = Reduced::halve(image);
    for level in 1..=REDUCED {
        let is_whole = best.as_ref().is_some_and(|view| view.n_missing(board) == 0);
        if is_whole || reduced.width.min(reduced.height) < LEAST_PX {
            break;
        }
        let Some(half) = reduced.image() else { break };
        if let Some(mut view) = seen(&half, board)
            && best.as_ref().is_none_or(|best| view.is_better(best))
        {
            view.enlarge(level);
            best = Some(view);
        }
        reduced = Reduced::halve(&half);
    }
    best
}

/// The chessboard in an image of one size.
fn seen(image: &Image<'_>, board: BoardShape) -> Option<ChessboardView> {
    let smoothed = Smoothed::smooth(image);
    let candidates = candidates::candidates(&smoothed);
    let links = links::links(&smoothed, &candidates);
    let mut best: Option<ChessboardView> = None;
    for mut lattice in lattices(&candidates, &links)
        .into_iter()
        .take(MOST_LATTICES)
    {
        lattice.complete(image, &smoothed);
        let view = view_of(&lattice, board);
        if let Some(view) = view
            && best.as_ref().is_none_or(|best| view.is_better(best))
        {
            best = Some(view);
        }
    }
    best
}

fn view_of(lattice: &Lattice, board: BoardShape) -> Option<ChessboardView> {
    let view = placement::placed(lattice, board)?;
    let least = LEAST_SEEN.min(board.columns).min(board.rows);
    view.size.iter().all(|seen| *seen >= least).then_some(view)
}

impl ChessboardView {
    fn n_missing(&self, board: BoardShape) -> usize {
        let all = usize::from(board.columns) * usize::from(board.rows);
        all.saturating_sub(self.n_corners())
    }

    fn n_corners(&self) -> usize {
        let [columns, rows] = self.size.map(usize::from);
        match self.squares.is_empty() {
            true => 0,
            false => columns * rows,
        }
    }

    fn is_better(&self, other: &Self) -> bool {
        let rank = |view: &Self| (view.extent == Extent::Whole, view.n_corners());
        rank(self) > rank(other)
    }

    /// From pixels of an image halved so many times to those of the image itself.
    fn enlarge(&mut self, times: usize) {
        let scale = (1_u32 << times) as f32;
        for square in &mut self.squares {
            for corner in &mut square.corners {
                *corner = corner.map(|at| (at + 0.5) * scale - 0.5);
            }
            for covariance in &mut square.corner_covariance {
                *covariance = covariance.map(|value| value * scale * scale);
            }
        }
    }
}

/// An image of half the size: means of four pixels.
struct Reduced {
    pixels: Vec<u8>,
    width: usize,
    height: usize,
}

impl Reduced {
    fn halve(image: &Image<'_>) -> Self {
        let (width, height) = (image.width() / 2, image.height() / 2);
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            let rows = [image.row(2 * y), image.row(2 * y + 1)];
            pixels.extend((0..width).map(|x| {
                let four = rows.map(|row| u16::from(row[2 * x]) + u16::from(row[2 * x + 1]));
                ((four[0] + four[1] + 2) / 4) as u8
            }));
        }
        Self {
            pixels,
            width,
            height,
        }
    }

    fn image(&self) -> Option<Image<'_>> {
        Image::new(&self.pixels, self.width, self.height, self.width).ok()
    }
}
