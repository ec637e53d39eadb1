//! Instructions on where to hold the board next.

use super::coverage::{COLUMNS, Coverage, ROWS};
use std::fmt;

/// Least share of covered cells of a covered ninth of the image.
const NINTH_COVERED: f64 = 0.6;
/// Least share of covered cells of a covered image.
const COVERED: f64 = 0.85;
/// Views needed with each side turned away.
pub(super) const TILTS: u32 = 3;
/// Views needed in which the board fills the image.
pub(super) const NEAR: u32 = 8;
/// Views needed in all.
pub(super) const VIEWS: u32 = 20;
/// Sufficient number of views if the board cannot come close, as with a lens that is sharp only at a distance.
const ENOUGH_FROM_AFAR: u32 = 45;

/// A ninth of the picture: thirds from the left and from the top, 0 to 2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// 0 left, 1 middle, 2 right.
    pub column: usize,
    /// 0 top, 1 middle, 2 bottom.
    pub row: usize,
}

/// Instruction for the next view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hint {
    /// Show the board.
    ShowBoard,
    /// Hold it in an uncovered part of the image, with a side turned away if that is missing too.
    HoldAt(Place, Option<Side>),
    /// Turn a side of it away.
    Tilt(Side),
    /// Hold it closer.
    Nearer,
    /// Hold it elsewhere, at another angle.
    Move,
    /// There are enough views.
    Enough,
}

/// A side of the board as the camera sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The left one in the image.
    Left,
    /// The right one in the image.
    Right,
    /// The upper one in the image.
    Upper,
    /// The lower one in the image.
    Lower,
}

impl Hint {
    pub(super) fn for_coverage(coverage: &Coverage) -> Self {
        if coverage.views == 0 {
            return Self::ShowBoard;
        }
        let side = lacking(coverage);
        match (emptiest(coverage), side) {
            (Some(place), side) => Self::HoldAt(place, side),
            (None, Some(side)) => Self::Tilt(side),
            (None, None) if coverage.near < NEAR && coverage.views < ENOUGH_FROM_AFAR => {
                Self::Nearer
            }
            (None, None) if coverage.views < VIEWS => Self::Move,
            (None, None) => Self::Enough,
        }
    }
}

/// The side that was turned away least often, if not often enough.
fn lacking(coverage: &Coverage) -> Option<Side> {
    let sides = [Side::Left, Side::Right, Side::Upper, Side::Lower];
    let counted = sides.into_iter().zip(coverage.tilted);
    let (side, count) = counted.min_by_key(|(_, count)| *count)?;
    (count < TILTS).then_some(side)
}

/// The ninth with the fewest covered cells, if it or the whole image is not covered.
fn emptiest(coverage: &Coverage) -> Option<Place> {
    let (part, place) = least_covered(coverage);
    (part < NINTH_COVERED || coverage.whole() < COVERED).then_some(place)
}

fn least_covered(coverage: &Coverage) -> (f64, Place) {
    let places = (0..3).flat_map(|row| (0..3).map(move |column| Place { column, row }));
    let covered = places.map(|place| {
        let columns = place.column * COLUMNS / 3..(place.column + 1) * COLUMNS / 3;
        let rows = place.row * ROWS / 3..(place.row + 1) * ROWS / 3;
        (coverage.part(columns, rows), place)
    });
    let first = (1.0, Place { column: 1, row: 1 });
    covered.fold(
        first,
        |least, next| if next.0 < least.0 { next } else { least },
    )
}

/// Coverage of the image relative to the required one, at most 1.
pub(super) fn covered(coverage: &Coverage) -> f64 {
    let (least, _) = least_covered(coverage);
    (coverage.whole() / COVERED).min(1.0) * (0.5 + 0.5 * (least / NINTH_COVERED).min(1.0))
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match (self.row, self.column) {
            (0, 0) => "the upper left",
            (0, 1) => "the upper edge",
            (0, _) => "the upper right",
            (1, 0) => "the left edge",
            (1, 1) => "the middle",
            (1, _) => "the right edge",
            (_, 0) => "the lower left",
            (_, 1) => "the lower edge",
            (_, _) => "the lower right",
        })
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Upper => "upper",
            Self::Lower => "lower",
        })
    }
}

impl fmt::Display for Hint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ShowBoard => f.write_str(
                "show the board to the camera, near enough to fill a third of the picture",
            ),
            Self::HoldAt(place, None) => write!(f, "hold the board to {place} of the picture"),
            Self::HoldAt(place, Some(side)) => {
                write!(
                    f,
                    "hold the board to {place} of the picture, its {side} side turned away"
                )
            }
            Self::Tilt(side) => write!(
                f,
                "turn the board's {side} side away from the camera, by 30 degrees or more"
            ),
            Self::Nearer => f.write_str(
                "hold the board nearer and turn it: it should fill the picture, its edges may be cut off",
            ),
            Self::Move => f.write_str("a few more views: move and turn the board"),
            Self::Enough => f.write_str("that is enough"),
        }
    }
}
