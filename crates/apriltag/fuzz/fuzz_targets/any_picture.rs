//! `cargo +nightly fuzz run any_picture` in `crates/apriltag`.

#![no_main]

#[path = "../any_picture.rs"]
mod any_picture;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| any_picture::detect(bytes));
