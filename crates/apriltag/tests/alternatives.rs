//! Images in which nothing is found, but would be otherwise.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag};
use sextant_apriltag::{Alternative, Detector, Family, Image, Options};

const SIZE: usize = 160;

/// Two tags of a family on a bright ground.
fn picture(family: Family) -> Vec<u8> {
    let tag = |id, x, turn| Tag {
        family,
        position_m: [x, 0.0, 0.5],
        turn_deg: [15.0, -10.0, turn],
        ..Tag::new(id)
    };
    let tags = [tag(3, -0.035, 25.0), tag(11, 0.035, 200.0)];
    let camera = Camera::new(SIZE, SIZE);
    Picture::draw(&camera, &tags, 200.0)
        .blurred(0.5)
        .pixels(1.5, 7)
}

fn mirrored(pixels: &[u8]) -> Vec<u8> {
    let rows = pixels.chunks(SIZE);
    rows.flat_map(|row| row.iter().rev()).copied().collect()
}

fn inverted(pixels: &[u8]) -> Vec<u8> {
    pixels.iter().map(|grey| 255 - grey).collect()
}

/// What else is found where the detector has found nothing.
fn alternative(pixels: &[u8], options: &Options) -> Option<Alternative> {
    let image = Image::new(pixels, SIZE, SIZE, SIZE).unwrap();
    assert_eq!(Detector::new(options.clone()).unwrap().detect(&image), []);
    let others = [Family::Tag36h10, Family::Aruco5x5With1000];
    Alternative::find(&image, options, &others)
}

fn sentence(pixels: &[u8]) -> String {
    let found = alternative(pixels, &Options::default());
    found.map_or_else(String::new, |found| found.to_string())
}

#[test]
fn what_would_be_read_otherwise_is_named() {
    let plain = picture(Family::Tag36h11);
    assert_eq!(sentence(&mirrored(&plain)), "2 mirrored tags of tag36h11");
    assert_eq!(sentence(&inverted(&plain)), "2 inverted tags of tag36h11");
    let both = inverted(&mirrored(&plain));
    assert_eq!(sentence(&both), "2 inverted mirrored tags of tag36h11");
    let other = picture(Family::Tag36h10);
    assert_eq!(sentence(&other), "2 tags of tag36h10");
    assert_eq!(sentence(&mirrored(&other)), "2 mirrored tags of tag36h10");
}

#[test]
fn ordinary_tags_are_named_where_inverted_ones_are_sought() {
    let options = Options {
        inverted: true,
        ..Options::default()
    };
    let found = alternative(&picture(Family::Tag36h11), &options).unwrap();
    assert_eq!(
        (found.inverted, found.mirrored, found.n_tags),
        (false, false, 2)
    );
}

#[test]
fn nothing_is_said_of_images_without_tags() {
    let mut random = Random(5);
    let noise: Vec<u8> = (0..SIZE * SIZE)
        .map(|_| random.between(0.0, 255.0) as u8)
        .collect();
    assert_eq!(sentence(&noise), "");
    assert_eq!(sentence(&vec![128; SIZE * SIZE]), "");
}
