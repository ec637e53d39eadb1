//! From pixels to decoded tags with sub-pixel corners.
//!
//! - [`Image`]: a borrowed grey image with any stride.
//! - [`Detector`]: the pipeline. It is built from [`Options`] and returns the tags of an image as [`Detection`]s.
//! - [`Tracker`]: a detector for image sequences that searches only areas of each image.
//! - [`Alternative`]: what an image without tags would show if they were inverted, mirrored or of other families.
//! - [`Report`], [`Observer`]: counts and events of a detection.
//! - [`find_chessboard`]: the inner corners of a plain chessboard.
//!
//! Corners are pixels with (0, 0) at the centre of the top left pixel. The detector knows no metres, no clock and no
//! network, and a lens only if one is given to fit distorted edges. It does not allocate once it has processed an image
//! of a size.

mod agreement;
mod alternative;
mod area;
mod bit_plane;
mod board_corners;
mod chessboard;
mod code_index;
mod components;
mod detection;
mod detector;
mod edges;
mod homography;
mod hull;
mod image;
mod kernels;
mod match_quality;
mod negative;
mod options;
mod photometric;
mod quad;
mod quad_finder;
mod reading;
mod report;
mod saddle;
mod sighting;
mod tiles;
mod tracker;
mod view;

pub use alternative::Alternative;
pub use chessboard::{BoardShape, ChessboardView, Extent, find_chessboard};
pub use detection::{Detection, Refinement};
pub use detector::Detector;
pub use image::{Image, ImageError};
pub use options::{Options, OptionsError};
pub use report::{Observer, Pass, Rejection, Report, Stage};
pub use sextant_tag_families::{BorderColour, Family};
pub use tracker::{Tracker, TrackingReport};
