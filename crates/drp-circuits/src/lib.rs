//! What circuits of the RZ/A2M's DRP library compute, as pure functions.
//!
//! - [`Circuit`]: the circuits that turn an 8-bit image into another of the same size, and the sizes they accept.
//! - [`Model`]: the formula of a circuit; [`Standing`] says whether the manual determines it.
//! - [`Raster`]: the image that goes in, rows without gaps.
//! - [`Bands`]: how an image is divided among copies of a circuit.
//!
//! Source of every formula: Renesas, "RZ/A2M Group DRP Library User's Manual", R01US0367EJ0101, Rev. 1.01, 2018. Rev.
//! 1.03 says the same. No model has been compared with silicon; the session that drives the hardware does so each time
//! it starts.
//!
//! Nothing here knows of a driver, of memory or of tags.

mod bands;
mod bayer;
mod binomial;
mod circuit;
mod model;
mod raster;

pub use bands::{Band, Bands};
pub use circuit::Circuit;
pub use model::{Model, Standing};
pub use raster::{Raster, SizeError};
