//! The detector and the tracker on any picture, with any options.

#![no_main]

use sextant_fuzz as _;

#[path = "../../crates/apriltag/tests/any_bytes/any_picture.rs"]
mod any_picture;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| any_picture::detect(bytes));
