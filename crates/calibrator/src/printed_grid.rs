//! A flat board of tags, as printed by `sextant print board`: the tag poses from the numbers on the sheet.
//!
//! The board's frame has its origin in the middle of the grid, x to the right, y up and z out of the paper, like each
//! of its tags. Ids run from the top left, row by row. Millimetres on the paper, metres in the object.

use sextant_geometry::Pose;
use sextant_site_model::{IdError, ObjectError, ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;
use thiserror::Error;

/// Width of the white strip between the rings of the tags, which has the ids, millimetres.
pub const STRIP_MM: f64 = 3.0;

/// Parameters of a printed board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintedGrid {
    /// Tags in a row.
    pub columns: u16,
    /// Rows of tags.
    pub rows: u16,
    /// Nominal edge of each black square, metres; a measured one scales the whole board.
    pub size_m: f64,
    /// The tags' family.
    pub family: Family,
    /// Id of the tag at the top left.
    pub first: u32,
}

/// Why a board is invalid.
#[derive(Clone, Debug, Error)]
pub enum GridError {
    /// No rows or no columns.
    #[error("a board has at least one row and one column")]
    Empty,
    /// The family ends before the grid does.
    #[error("the board has {wanted} tags from {first} on, but {family} ends with {last}")]
    TooManyTags {
        /// Tags of the grid.
        wanted: u32,
        /// Where it begins.
        first: u32,
        /// Of which family.
        family: Family,
        /// Its last tag.
        last: u32,
    },
    /// The tags do not form a valid object.
    #[error(transparent)]
    Object(#[from] ObjectError),
    /// An invalid name.
    #[error(transparent)]
    Id(#[from] IdError),
}

impl PrintedGrid {
    /// How many tags it has.
    #[must_use]
    pub fn tags(&self) -> u32 {
        u32::from(self.columns) * u32::from(self.rows)
    }

    /// From the centre of one tag to that of the next, millimetres.
    #[must_use]
    pub fn pitch_mm(&self) -> f64 {
        let data = self.family.data();
        let module = self.size_m * 1e3 / f64::from(data.border_width);
        module * f64::from(data.total_width) + STRIP_MM
    }

    /// The tags' centres about the middle of the grid, in the order of their ids: right and up, millimetres.
    pub fn places_mm(&self) -> impl Iterator<Item = [f64; 2]> {
        let (pitch, columns, rows) = (self.pitch_mm(), self.columns, self.rows);
        let centred =
            move |index: u16, count: u16| pitch * (f64::from(index) - f64::from(count - 1) / 2.0);
        (0..rows).flat_map(move |row| {
            (0..columns).map(move |column| [centred(column, columns), -centred(row, rows)])
        })
    }

    /// The board as an object.
    ///
    /// # Errors
    /// An empty grid, one with more tags than the family has, sizes that no tag has.
    pub fn object(&self, id: &str) -> Result<ObjectModel, GridError> {
        if self.tags() == 0 {
            return Err(GridError::Empty);
        }
        let last = self.family.data().codes.len().saturating_sub(1) as u32;
        if u64::from(self.first) + u64::from(self.tags()) - 1 > u64::from(last) {
            return Err(GridError::TooManyTags {
                wanted: self.tags(),
                first: self.first,
                family: self.family,
                last,
            });
        }
        let tag = |(id, [x, y]): (u32, [f64; 2])| {
            ObjectTag::new(
                TagId {
                    family: self.family,
                    id,
                },
                self.size_m,
                Some(Pose::translation(x * 1e-3, y * 1e-3, 0.0)),
            )
        };
        let tags = (self.first..).zip(self.places_mm()).map(tag);
        let id: ObjectId = id.parse()?;
        Ok(ObjectModel::new(id, tags.collect())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> PrintedGrid {
        PrintedGrid {
            columns: 5,
            rows: 6,
            size_m: 0.028,
            family: Family::Tag36h11,
            first: 10,
        }
    }

    #[test]
    fn ids_run_from_the_top_left_about_the_middle() {
        let board = grid().object("board").unwrap();
        let place = |at: usize| board.tags()[at].object_from_tag.unwrap().translation.vector;
        assert_eq!(board.tags().len(), 30);
        assert_eq!(board.tags()[0].tag.id, 10);
        assert!(place(0).x < 0.0 && place(0).y > 0.0 && place(29).x > 0.0 && place(29).y < 0.0);
        assert!((place(0) + place(29)).norm() < 1e-12);
        // 28 mm of eight modules make a print of 35 mm; 3 mm of white lie between two.
        assert!((place(1).x - place(0).x - 0.038).abs() < 1e-12);
    }

    #[test]
    fn a_grid_beyond_its_family_is_refused() {
        let long = PrintedGrid {
            first: 580,
            ..grid()
        };
        assert!(matches!(
            long.object("board"),
            Err(GridError::TooManyTags { last: 586, .. })
        ));
        let empty = PrintedGrid { rows: 0, ..grid() };
        assert!(matches!(empty.object("board"), Err(GridError::Empty)));
        let huge = PrintedGrid {
            first: u32::MAX,
            ..grid()
        };
        assert!(huge.object("board").is_err());
    }
}
