//! A million spoilt images: `cargo bench -p sextant-estimator --bench stamina`. The test of this name takes fewer of
//! the same.
//!
//! Prints after each tenth the share of poses said to be tracked that are off by more than a centimetre, and the memory
//! held.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    dead_code,
    unused_imports,
    reason = "shares its scene with the tests"
)]

#[path = "../tests/fusion/scene.rs"]
mod scene;
#[path = "../tests/fusion/stamina.rs"]
mod stamina;

use sextant_estimator::FusionOptions;

const IMAGES: u64 = 1_000_000;

fn main() {
    let mut fusion = scene::fusion(&scene::rig(4), &scene::cube(), FusionOptions::default());
    for tenth in 0..10 {
        let range = tenth * IMAGES / 10..(tenth + 1) * IMAGES / 10;
        let (wrong, poses) = stamina::endure(&mut fusion, range);
        println!("{poses} poses, {wrong:.2e} off, {} kB", resident_kb());
    }
}

/// 0 where the system does not say.
fn resident_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS:"));
    let number = line.and_then(|line| line.split_whitespace().nth(1));
    number.and_then(|number| number.parse().ok()).unwrap_or(0)
}
