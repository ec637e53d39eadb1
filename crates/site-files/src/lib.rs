//! The TOML files people write: rig, object and node configuration; read strictly, written atomically.
//!
//! - [`read_rig`], [`read_object`]: checked models from files.
//! - [`write_rig`], [`write_object`]: models to files; numbers keep every digit.
//! - [`read_robot`], [`write_robot`]: a robot of the site.
//! - [`AprilGrid`], [`CharucoBoard`], [`MarkerGrid`], [`Chessboard`]: calibration boards; [`read_object`] reads their
//!   files as well.
//! - [`read_foreign`], [`foreign_text`]: calibrations of other tools; [`read_rig`] reads them as well.
//! - [`assumptions`]: what such a file leaves open, and what is assumed.
//! - [`read_toml`], [`read_toml_checked`], [`write_toml`]: any other configuration, with the same kind of errors.
//! - [`with_value`]: changes one value of a text and keeps comments.
//! - [`write_atomically`], [`Replacement`]: replace a file atomically.
//! - [`write_keeping_former`]: as well, and keeps former versions ([`former_of`]) in bounded number.
//! - [`keep_rig`], [`keep_object`]: for programs that save automatically; they replace only another version of the same
//!   rig or object.
//!
//! Every error names file, line, column and key, cause and remedy: [`FileError`].
//! Metres, pixels, quaternions x, y, z, w, as in the files; no network and no clock here.

mod assumptions;
mod atomic;
mod boards;
mod document;
mod edit;
mod error;
mod foreign;
mod hint;
mod keep;
mod object;
mod pose;
mod read;
mod rig;
mod robot;
mod values;

pub use assumptions::assumptions;
pub use atomic::{
    FORMER_VERSIONS, Replacement, former_of, former_version, write_atomically, write_keeping_former,
};
pub use boards::{
    AprilGrid, BoardError, CharucoBoard, Chessboard, MarkerGrid, UpperLeft, field_layout,
    read_board,
};
pub use edit::with_value;
pub use error::{Complaint, FileError, InvalidFile};
pub use foreign::{
    ForeignFormat, foreign_text, has_foreign_name, is_foreign, parse_foreign, read_foreign,
};
pub use keep::{keep_object, keep_rig, object_file, retire_object};
pub use object::{object_toml, parse_object, read_object, write_object};
pub use read::{parse_toml, read_text, read_toml, read_toml_checked, write_toml};
pub use rig::{parse_rig, read_rig, rig_toml, write_rig};
pub use robot::{Carried, RobotModel, UncertainPose, read_robot, write_robot};
