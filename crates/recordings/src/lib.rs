//! Recorded images, detections and poses on disk.
//!
//! - [`Dataset`], [`CameraRecording`]: folders in the EuRoC ASL layout, `data.csv` with pictures or `detections.jsonl`;
//!   or of pictures alone.
//! - [`read_picture`], [`write_grey_png`], [`write_colour_png`]: pictures of any kind as 8-bit grey, and PNG files.
//! - [`DetectionsLine`]: a line of `detections.jsonl`, read and written.
//! - [`bounded_lines`]: the lines of a text, none of them endless.
//! - [`pose_json`], [`pose_csv`], [`pose_tum`], [`tum_line`]: poses as lines of text.
//! - `mcap`, `foxglove`, `compressed_image`: a site in one MCAP file; what viewers show of it, from a file or live.
//!
//! Times are ns since the Unix epoch, pixels have (0, 0) at the centre of the top-left one, metres, quaternions x, y,
//! z, w. Everything read is checked; every error names file and line and says what to do. Nothing here knows a rig, a
//! detector or a network.

#[cfg(feature = "mcap")]
pub mod compressed_image;
mod data_csv;
mod dataset;
mod detections;
mod error;
#[cfg(feature = "mcap")]
pub mod foxglove;
mod lines;
#[cfg(feature = "mcap")]
pub mod mcap;
mod picture;
mod poses;

pub use dataset::{CameraRecording, Dataset, Frame, Row};
pub use detections::{DetectedTag, DetectionsLine};
pub use error::RecordingError;
pub use lines::{MOST_LINE_BYTES, bounded_lines};
pub use picture::{
    ColourImage, GreyImage, decode_picture, grey_png, is_grey_png, read_picture, write_colour_png,
    write_grey_png,
};
pub use poses::{csv_header, pose_csv, pose_json, pose_tum, tum_line};
