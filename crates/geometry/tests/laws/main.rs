//! The laws of the geometry, each written once and tested for every type that must obey it.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "tests")]

mod generators;
mod groups;
mod homographies;
mod least_squares;
mod lens_file;
mod lenses;
mod numeric;
mod planar_poses;
