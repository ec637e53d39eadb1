//! Every processor finds the same tags, with corners within 0.01 px of those that an x86-64 found, which are in
//! `processors.txt`.
//!
//! With `SEXTANT_WRITE_PROCESSORS=1` the test writes that file anew instead of reading it.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod drawing;

use drawing::{Camera, Picture, Tag};
use sextant_apriltag::{Detector, Image, Options};
use std::fmt::Write;
use std::fs;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/processors.txt");
const SIZE: (usize, usize) = (640, 480);
const TOLERANCE_PX: f32 = 0.01;
/// Blur in pixels and noise in grey levels.
const PICTURES: [(f64, f64); 2] = [(0.5, 1.5), (0.8, 10.0)];

/// Twelve tags at all angles.
fn tags() -> Vec<Tag> {
    let tag = |k: u32| Tag {
        position_m: [
            -0.18 + 0.12 * f64::from(k % 4),
            -0.12 + 0.12 * f64::from(k / 4),
            0.7 + 0.02 * f64::from(k),
        ],
        turn_deg: [
            7.0 * f64::from(k % 5),
            30.0 - 5.0 * f64::from(k),
            29.0 * f64::from(k),
        ],
        ..Tag::new(11 + 3 * k)
    };
    (0..12).map(tag).collect()
}

/// A row a tag: picture, id, and the corners' coordinates.
fn found() -> Vec<(usize, u32, [f32; 8])> {
    let mut detector = Detector::new(Options::default()).unwrap();
    let mut rows = Vec::new();
    for (picture, (blur, noise)) in PICTURES.into_iter().enumerate() {
        let drawn = Picture::draw(&Camera::new(SIZE.0, SIZE.1), &tags(), 128.0);
        let pixels = drawn.blurred(blur).pixels(noise, picture as u64);
        let image = Image::new(&pixels, SIZE.0, SIZE.1, SIZE.0).unwrap();
        for tag in detector.detect(&image) {
            let corners = tag.corners.concat().try_into().unwrap();
            rows.push((picture, tag.id, corners));
        }
    }
    rows.sort_by_key(|(picture, id, _)| (*picture, *id));
    rows
}

fn read() -> Vec<(usize, u32, [f32; 8])> {
    let text = fs::read_to_string(FILE).unwrap();
    let rows = text.lines().map(|line| {
        let numbers: Vec<f32> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        let corners = numbers[2..].try_into().unwrap();
        (numbers[0] as usize, numbers[1] as u32, corners)
    });
    rows.collect()
}

fn write(rows: &[(usize, u32, [f32; 8])]) {
    let mut text = String::new();
    for (picture, id, corners) in rows {
        write!(text, "{picture} {id}").unwrap();
        corners
            .iter()
            .for_each(|px| write!(text, " {px:.4}").unwrap());
        text.push('\n');
    }
    fs::write(FILE, text).unwrap();
}

#[test]
fn every_processor_finds_the_same() {
    let found = found();
    if std::env::var_os("SEXTANT_WRITE_PROCESSORS").is_some() {
        write(&found);
    }
    let expected = read();
    assert!(expected.len() >= 20, "{} tags", expected.len());
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!((found.0, found.1), (expected.0, expected.1));
        let mut off = found.2.iter().zip(expected.2).map(|(a, b)| (a - b).abs());
        assert!(off.all(|px| px <= TOLERANCE_PX), "{found:?}, {expected:?}");
    }
}
