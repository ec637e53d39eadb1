//! From pixels to decoded tags with sub-pixel corners.
//!
//! - [`Image`]: what comes in, borrowed, any stride.
//! - [`Detector`]: the pipeline; made of [`Options`], it says of each image which tags ([`Detection`]) are where.
//! - [`Tracker`]: the same over a sequence of images, looking at parts of each only.
//! - [`Report`], [`Observer`]: what happened on the way.
//!
//! Corners are pixels with (0, 0) at the centre of the top left pixel. The detector knows no metres, no clock and no
//! network, a lens only where one is given to straighten tags' edges, and takes no memory from the heap once it has seen an
//! image of a size.

mod area;
mod bit_plane;
mod board_corners;
mod code_index;
mod components;
mod detection;
mod detector;
mod edges;
mod homography;
mod hull;
mod image;
mod kernels;
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

pub use detection::{Detection, Refinement};
pub use detector::Detector;
pub use image::{Image, ImageError};
pub use options::{Options, OptionsError};
pub use report::{Observer, Pass, Rejection, Report, Stage};
pub use sextant_tag_families::{BorderColour, Family};
pub use tracker::{Tracker, TrackingReport};
