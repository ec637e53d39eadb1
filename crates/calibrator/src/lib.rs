//! Calibration: from the tag corners of recorded images to lenses, camera poses and constellations.
//!
//! Metres, radians, pixels, seconds and the frames of `crates/geometry/FRAMES.md`. Procedures that a person runs now and then;
//! nothing of the live path depends on this crate. It knows no image, file, clock or network.
//!
//! - [`bundle`]: bundle adjustment of tag corners, the core of every procedure.

pub mod bundle;
mod intake;
mod resection;
