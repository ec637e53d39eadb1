//! After it has seen an image of a size, the detector takes nothing more from the heap.

#![allow(clippy::unwrap_used)]

mod drawing;

use drawing::{Camera, Picture, Tag};
use sextant_apriltag::{Detector, Family, Image, Options, Tracker};

const CAMERA: (usize, usize) = (320, 240);

/// Seven tags, two of them of boards, moved by so many metres; in focus or under noise.
fn picture(x: f64, y: f64) -> Picture {
    let at = |id, tag_x, tag_y| Tag {
        position_m: [tag_x + x, tag_y + y, 0.7],
        turn_deg: [20.0, 10.0, 30.0],
        ..Tag::new(id)
    };
    let of_board = |family, margin, tag: Tag| Tag {
        family,
        margin,
        share: 0.6,
        ..tag
    };
    let tags = [
        at(1, -0.1, -0.05),
        at(2, 0.0, -0.05),
        at(3, 0.1, -0.05),
        at(4, -0.1, 0.05),
        at(5, 0.1, 0.05),
        of_board(Family::Tag36h11b2, 3.0, at(6, 0.0, 0.02)),
        of_board(Family::Charuco4x4With50, 12.0, at(7, 0.0, 0.095)),
    ];
    Picture::draw(&Camera::new(CAMERA.0, CAMERA.1), &tags, 128.0).blurred(0.5)
}

fn options() -> Options {
    Options {
        families: vec![
            Family::Tag36h11,
            Family::Tag36h11b2,
            Family::Charuco4x4With50,
        ],
        ..Options::default()
    }
}

/// How many tags are found in an image, and how often memory is asked for meanwhile.
fn allocations(pixels: &[u8], detect: impl FnOnce(&Image<'_>) -> usize) -> (usize, u64) {
    let image = Image::new(pixels, CAMERA.0, CAMERA.1, CAMERA.0).unwrap();
    let mut n_tags = 0;
    let asked = allocation_counter::measure(|| n_tags = detect(&image));
    (n_tags, asked.count_total)
}

#[test]
fn a_seen_size_needs_no_more_memory_whatever_the_image_shows() {
    let empty = vec![128; CAMERA.0 * CAMERA.1];
    let tagged = picture(0.0, 0.0).pixels(2.0, 1);
    let noisy = picture(0.0, 0.0).pixels(60.0, 2);
    let mut detector = Detector::new(options()).unwrap();
    let mut detect = |pixels: &[u8]| allocations(pixels, |image| detector.detect(image).len());
    detect(&empty);
    for (pixels, n_tags) in [(&tagged, 7), (&empty, 0), (&tagged, 7)] {
        assert_eq!(detect(pixels), (n_tags, 0));
    }
    assert_eq!(detect(&noisy).1, 0);
}

#[test]
fn inverted_tags_need_no_more_memory_either() {
    let options = Options {
        inverted: true,
        ..options()
    };
    let tagged = picture(0.0, 0.0).pixels(2.0, 1);
    let negative: Vec<u8> = tagged.iter().map(|grey| 255 - grey).collect();
    let mut detector = Detector::new(options).unwrap();
    let mut detect = |pixels: &[u8]| allocations(pixels, |image| detector.detect(image).len());
    detect(&tagged);
    assert_eq!(detect(&negative), (7, 0));
}

#[test]
fn tracking_needs_no_more_memory_after_the_first_image() {
    let empty = vec![128; CAMERA.0 * CAMERA.1];
    let tagged = picture(0.0, 0.0).pixels(2.0, 1);
    let moved = picture(0.005, 0.004).pixels(2.0, 2);
    let noisy = picture(0.0, 0.0).pixels(60.0, 3);
    let mut tracker = Tracker::new(options()).unwrap();
    let mut detect = |pixels: &[u8]| allocations(pixels, |image| tracker.detect(image).len());
    detect(&empty);
    for pixels in [&noisy, &tagged].repeat(10) {
        assert_eq!(detect(pixels).1, 0);
    }
    for pixels in [&tagged, &moved, &tagged] {
        assert_eq!(detect(pixels), (7, 0));
    }
    for _ in 0..5 {
        assert_eq!(detect(&empty), (0, 0));
    }
}
