//! Calibration boards: Kalibr's AprilGrid, OpenCV's ChArUco board and grid of markers, and plain chessboards, from
//! their files to objects.
//!
//! Each keeps the frame of the tool that it comes from: the AprilGrid's origin is the lower left corner of its first
//! tag, x to the right, y up. The others' is the upper left corner (of the chessboard, the first marker, the first
//! inner corner), x to the right, y down, so that z looks into the board. Metres.

mod anipose;
mod chessboard;
pub(crate) mod layouts;
mod marker_grid;
mod reading;

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use sextant_geometry::Pose;
use sextant_site_model::{ObjectError, ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_tag_families::{Board, CHESSBOARD_SQUARES, Family};
use thiserror::Error;

pub(crate) use anipose::AniposeFile;
pub use chessboard::Chessboard;
pub use layouts::field_layout;
pub use marker_grid::MarkerGrid;
pub(crate) use reading::parse_board;
pub use reading::read_board;

/// Most columns and rows of a board.
const MOST: u16 = 100;
/// Gap of an AprilGrid as a share of its tags' edge: below, the squares at their corners are narrower than the detector
/// needs.
const SPACING: std::ops::RangeInclusive<f64> = 0.15..=1.0;
/// Share of a chessboard's square that a marker takes: beyond, too little white is left around it.
const SHARE: std::ops::RangeInclusive<f64> = 0.45..=0.87;

/// Why there is no such board.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BoardError {
    /// Columns or rows.
    #[error("a board has 1 to {MOST} columns and rows, not {columns} x {rows}")]
    Grid {
        /// As given.
        columns: u16,
        /// As given.
        rows: u16,
    },
    /// Inner corners of a chessboard.
    #[error(
        "a chessboard has 3 to {} inner corners in a row and in a column, not {columns} x \
         {rows}; inner corners are one fewer than squares",
        CHESSBOARD_SQUARES + 1
    )]
    Corners {
        /// As given.
        columns: u16,
        /// As given.
        rows: u16,
    },
    /// No gap between markers.
    #[error("a separation of {0} m leaves no white between the markers")]
    Separation(f64),
    /// A gap between tags that is too narrow, or wider than the tags.
    #[error(
        "a spacing of {0} is outside {start} to {end}, as a share of a tag's edge",
        start = SPACING.start(),
        end = SPACING.end()
    )]
    Spacing(f64),
    /// Markers that leave too little white or too little to read.
    #[error("markers of {0:.2} of a square are outside {start} to {end}", start = SHARE.start(), end = SHARE.end())]
    Share(f64),
    /// Another family than such a board has.
    #[error("{0} is no family of ChArUco boards; those are charuco4x4-50 and so on")]
    Family(Family),
    /// The family ends before the board does.
    #[error("the board has tags up to {wanted}, but {family} ends with {last}")]
    Ids {
        /// Last id of the board.
        wanted: u32,
        /// Its family.
        family: Family,
        /// Last id of that.
        last: u32,
    },
    /// The tags make no object.
    #[error(transparent)]
    Object(#[from] ObjectError),
}

/// Kalibr's AprilGrid: tags in columns and rows, ids row by row from the lower left, and a black square at each of
/// their corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AprilGrid {
    /// Tags in a row.
    pub columns: u16,
    /// Rows of tags.
    pub rows: u16,
    /// Edge of a tag's black square, metres: Kalibr's `tagSize`.
    pub size_m: f64,
    /// Gap between tags as a share of their edge, which is the edge of the squares at their corners too: Kalibr's
    /// `tagSpacing`.
    pub spacing: f64,
    /// Id of the tag at the lower left.
    pub first: u32,
}

impl AprilGrid {
    /// The family of its tags.
    pub const FAMILY: Family = Family::Tag36h11b2;

    /// From one tag to the next, metres.
    pub fn pitch_m(&self) -> f64 {
        self.size_m * (1.0 + self.spacing)
    }

    /// Ids and middles of the tags, metres.
    pub fn tags(&self) -> impl Iterator<Item = (TagId, [f64; 2])> {
        let (first, pitch, size) = (self.first, self.pitch_m(), self.size_m);
        let place = move |index: u16| f64::from(index) * pitch + size / 2.0;
        let places = places(self.columns, self.rows);
        places.zip(0..).map(move |([column, row], index)| {
            let tag = TagId {
                family: Self::FAMILY,
                id: first.saturating_add(index),
            };
            (tag, [place(column), place(row)])
        })
    }

    /// Lower left corners of the black squares at the tags' corners, metres.
    pub fn squares(&self) -> impl Iterator<Item = [f64; 2]> {
        let (pitch, edge) = (self.pitch_m(), self.square_m());
        let places = places(self.columns.saturating_add(1), self.rows.saturating_add(1));
        places.map(move |place| place.map(|index| f64::from(index) * pitch - edge))
    }

    /// Edge of the squares at the tags' corners, metres.
    pub fn square_m(&self) -> f64 {
        self.size_m * self.spacing
    }

    /// The board as an object.
    ///
    /// # Errors
    /// A grid without tags, with ids that the family lacks, or with sizes that no tag has.
    pub fn object(&self, id: ObjectId) -> Result<ObjectModel, BoardError> {
        check_grid(self.columns, self.rows)?;
        if !SPACING.contains(&self.spacing) {
            return Err(BoardError::Spacing(self.spacing));
        }
        let tags = self.tags().map(|(tag, [x, y])| {
            ObjectTag::new(tag, self.size_m, Some(Pose::translation(x, y, 0.0)))
        });
        object_of(id, tags.collect())
    }
}

/// OpenCV's ChArUco board: a chessboard with a marker in the middle of each white square, ids row by row from the upper
/// left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharucoBoard {
    /// Squares in a row, black and white.
    pub columns: u16,
    /// Rows of squares.
    pub rows: u16,
    /// Edge of a square, metres: OpenCV's `squareLength`.
    pub square_m: f64,
    /// Edge of a marker's black square, metres: OpenCV's `markerLength`.
    pub marker_m: f64,
    /// The squares' family, which names the dictionary.
    pub family: Family,
    /// Id of the first marker.
    pub first: u32,
    /// Colour of the upper left square.
    pub upper_left: UpperLeft,
}

/// The upper left square of a ChArUco board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpperLeft {
    /// Black, as OpenCV draws it since version 4.6.
    Black,
    /// White with a marker: boards with an even number of rows of earlier versions, and of `legacyPattern`.
    Marker,
}

impl CharucoBoard {
    /// Ids, columns and rows of the white squares.
    pub fn squares(&self) -> impl Iterator<Item = (TagId, [u16; 2])> {
        let (family, first) = (self.family, self.first);
        let odd = u32::from(self.upper_left == UpperLeft::Black);
        let is_white =
            move |[column, row]: &[u16; 2]| (u32::from(*column) + u32::from(*row)) % 2 == odd;
        let white = places(self.columns, self.rows).filter(is_white);
        white.zip(0..).map(move |(place, index)| {
            let id = first.saturating_add(index);
            (TagId { family, id }, place)
        })
    }

    /// Columns and rows of the black squares.
    pub fn black_squares(&self) -> impl Iterator<Item = [u16; 2]> {
        let odd = u32::from(self.upper_left == UpperLeft::Marker);
        places(self.columns, self.rows)
            .filter(move |[column, row]| (u32::from(*column) + u32::from(*row)) % 2 == odd)
    }

    /// The board as an object.
    ///
    /// # Errors
    /// A board without white squares, with ids that the dictionary lacks, or with sizes that no tag has.
    pub fn object(&self, id: ObjectId) -> Result<ObjectModel, BoardError> {
        check_grid(self.columns, self.rows)?;
        if self.family.data().board != Some(Board::Charuco) {
            return Err(BoardError::Family(self.family));
        }
        let share = self.marker_m / self.square_m;
        if !SHARE.contains(&share) {
            return Err(BoardError::Share(share));
        }
        let middle = |index: u16| (f64::from(index) + 0.5) * self.square_m;
        let tags = self.squares().map(|(tag, place)| {
            ObjectTag::new(tag, self.square_m, Some(upside_down(place.map(middle))))
        });
        object_of(id, tags.collect())
    }
}

/// A tag centred at a point of a board whose y runs down and whose z looks into it: half a turn about x.
fn upside_down([x, y]: [f64; 2]) -> Pose {
    let turned = UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0));
    Pose::from_parts(Translation3::new(x, y, 0.0), turned)
}

fn check_grid(columns: u16, rows: u16) -> Result<(), BoardError> {
    let is_some = [columns, rows].iter().all(|n| (1..=MOST).contains(n));
    is_some
        .then_some(())
        .ok_or(BoardError::Grid { columns, rows })
}

fn object_of(id: ObjectId, tags: Vec<ObjectTag>) -> Result<ObjectModel, BoardError> {
    if let Some(TagId { family, id: wanted }) = tags.iter().map(|tag| tag.tag).max() {
        let last = family.data().codes.len().saturating_sub(1) as u32;
        if wanted > last {
            return Err(BoardError::Ids {
                wanted,
                family,
                last,
            });
        }
    }
    Ok(ObjectModel::new(id, tags)?)
}

/// Columns and rows of a grid, row by row.
fn places(columns: u16, rows: u16) -> impl Iterator<Item = [u16; 2]> {
    (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]))
}

#[cfg(test)]
mod tests;
