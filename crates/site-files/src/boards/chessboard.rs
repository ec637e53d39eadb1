//! A plain chessboard as an object: its tags are the squares between inner corners.

use super::{BoardError, check_grid, object_of, places, upside_down};
use sextant_site_model::{ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_tag_families::{CHESSBOARD_SQUARES, Family, chessboard_id, chessboard_place};

/// A plain chessboard. Its origin is the first inner corner: the one in the upper left if the square beyond it, in the
/// corner of the board, is black. x runs along the columns, y down along the rows, z into the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chessboard {
    /// Inner corners in a row, one fewer than squares.
    pub columns: u16,
    /// Rows of inner corners.
    pub rows: u16,
    /// Edge of a square, metres.
    pub square_m: f64,
}

impl Chessboard {
    /// The board as an object.
    ///
    /// # Errors
    /// Fewer than three or too many columns or rows, or a size that no tag has.
    pub fn object(&self, id: ObjectId) -> Result<ObjectModel, BoardError> {
        let &Self {
            columns,
            rows,
            square_m,
        } = self;
        check_grid(columns, rows)?;
        let is_board = |n: u16| (3..=CHESSBOARD_SQUARES + 1).contains(&n);
        if !is_board(columns) || !is_board(rows) {
            return Err(BoardError::Corners { columns, rows });
        }
        let middle = |index: u16| (f64::from(index) + 0.5) * square_m;
        let tags = places(columns - 1, rows - 1).map(|place| {
            ObjectTag::new(
                TagId {
                    family: Family::Chessboard,
                    id: chessboard_id(place),
                },
                square_m,
                Some(upside_down(place.map(middle))),
            )
        });
        object_of(id, tags.collect())
    }

    /// The chessboard that an object is, if it is one.
    pub fn from_object(object: &ObjectModel) -> Option<Self> {
        let squares = object
            .tags()
            .iter()
            .filter(|tag| tag.tag.family == Family::Chessboard);
        let last = squares.clone().map(|tag| chessboard_place(tag.tag.id));
        let [column, row] = last.reduce(|a, b| [a[0].max(b[0]), a[1].max(b[1])])?;
        Some(Self {
            columns: column + 2,
            rows: row + 2,
            square_m: squares.clone().next()?.size_m,
        })
    }

    /// Whether the board looks the same after half a turn, so that images do not tell which end is up.
    pub fn is_symmetric(&self) -> bool {
        (self.columns + self.rows).is_multiple_of(2)
    }
}
