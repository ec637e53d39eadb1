//! Fiducial tag families as data: code words, the layout of a tag's modules, and what a printed tag looks like.
//!
//! - [`Family`]: the families by name; everything else hangs on it.
//! - [`FamilyData`]: code words and layout of one family, read from `data/` at compile time.
//! - [`module_is_white`], [`white_modules`], [`rotate_code`]: what follows from the data.
//! - [`chessboard_id`], [`chessboard_place`]: the squares of plain chessboards, which have no codes.
//!
//! No images, no metres: coordinates are modules of the upright tag, x right and y down.

mod chessboard;
mod family;
mod pattern;
mod table;

pub use chessboard::{CHESSBOARD_SQUARES, chessboard_id, chessboard_place};
pub use family::{Family, UnknownFamily};
pub use pattern::{module_is_white, rotate_code, white_modules};
pub use table::{Board, BorderColour, FamilyData};
