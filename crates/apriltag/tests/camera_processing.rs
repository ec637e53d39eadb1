//! Tags in pictures as cameras process them: grain in black, sharpening with undershoot, black lifted by stray light.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag};
use sextant_apriltag::{Detection, Detector, Image, Options};

const WIDTH: usize = 320;
const HEIGHT: usize = 240;

/// Greys of a picture, row after row.
type Greys = Vec<f64>;

fn camera() -> Camera {
    Camera::new(WIDTH, HEIGHT)
}

fn tag(id: u32, edge_px: f64) -> Tag {
    let turn = f64::from(id);
    Tag {
        position_m: [0.0, 0.0, 600.0 * 0.04 / edge_px],
        turn_deg: [20.0 * turn.sin(), 20.0 * turn.cos(), 40.0 * turn],
        greys: [40.0, 200.0],
        ..Tag::new(id)
    }
}

fn draw(tag: &Tag) -> Greys {
    let picture = Picture::draw(&camera(), std::slice::from_ref(tag), 150.0).blurred(0.6);
    picture.pixels(0.5, 1).into_iter().map(f64::from).collect()
}

fn detect(greys: &[f64]) -> Vec<Detection> {
    let pixels: Vec<u8> = greys.iter().map(|grey| grey.round() as u8).collect();
    let image = Image::new(&pixels, WIDTH, HEIGHT, WIDTH).unwrap();
    Detector::new(Options::default())
        .unwrap()
        .detect(&image)
        .to_vec()
}

/// The tag is found, once, and no corner is farther from the truth.
fn assert_found(greys: &[f64], tag: &Tag, most_px: f64, what: &str) {
    let found = detect(greys);
    let ids: Vec<u32> = found.iter().map(|found| found.id).collect();
    assert_eq!(ids, [tag.id], "{what}");
    let truth = tag.corners(&camera());
    for (corner, [x, y]) in found[0].corners.iter().zip(truth) {
        let off = (f64::from(corner[0]) - x).hypot(f64::from(corner[1]) - y);
        assert!(off < most_px, "{what}: a corner is off by {off} px");
    }
}

/// Adds what differs from the mean of the pixels within a distance, as unsharp masking does.
fn sharpened(greys: &[f64], reach: usize, amount: f64) -> Greys {
    let mean = |x: usize, y: usize| {
        let columns = x.saturating_sub(reach)..(x + reach + 1).min(WIDTH);
        let rows = y.saturating_sub(reach)..(y + reach + 1).min(HEIGHT);
        let n = (columns.len() * rows.len()) as f64;
        let row = |y: usize| greys[y * WIDTH..][columns.clone()].iter().sum::<f64>();
        rows.map(row).sum::<f64>() / n
    };
    let each = greys.iter().enumerate();
    each.map(|(i, grey)| grey + amount * (grey - mean(i % WIDTH, i / WIDTH)))
        .collect()
}

#[test]
fn grain_in_black_breaks_no_border() {
    for (id, edge_px) in [(1, 60.0), (2, 90.0), (3, 140.0)] {
        let tag = tag(id, edge_px);
        let mut random = Random(u64::from(id));
        // Grains of 3x3 pixels, of up to a third of the step, where it is black.
        let grains: Vec<f64> = (0..WIDTH * HEIGHT)
            .map(|_| random.between(0.0, 55.0))
            .collect();
        let worn = draw(&tag).into_iter().enumerate().map(|(i, grey)| {
            let grain = grains[i / WIDTH / 3 * WIDTH + i % WIDTH / 3];
            if grey < 80.0 { grey + grain } else { grey }
        });
        let worn: Greys = worn.collect();
        assert_found(&worn, &tag, 0.7, &format!("{edge_px} px"));
    }
}

#[test]
fn undershoot_over_lifted_black_hides_no_tag() {
    for (id, edge_px) in [(1, 24.0), (2, 32.0), (3, 48.0), (4, 90.0)] {
        for (reach, amount) in [(1, 2.0), (2, 1.5), (4, 1.0)] {
            let tag = tag(id, edge_px);
            let lifted: Greys = draw(&tag)
                .iter()
                .map(|grey| 80.0 + grey * 175.0 / 255.0)
                .collect();
            let what = format!("{edge_px} px, sharpened by {amount} over {reach} px");
            assert_found(&sharpened(&lifted, reach, amount), &tag, 0.5, &what);
        }
    }
}

#[test]
fn tags_are_found_wherever_they_are_in_the_grid_of_pixels() {
    for shift in 0..16_u32 {
        let [dx, dy] = [shift % 4, shift / 4].map(|px| f64::from(px) + 0.3);
        let at = tag(7, 22.0);
        let px_m = at.position_m[2] / 600.0;
        let tag = Tag {
            position_m: [dx * px_m, dy * px_m, at.position_m[2]],
            ..at
        };
        assert_found(&draw(&tag), &tag, 0.1, &format!("moved by {dx}, {dy} px"));
    }
}

#[test]
fn sharpening_moves_no_corner() {
    for (id, edge_px) in [(1, 40.0), (2, 60.0), (3, 90.0)] {
        for (reach, amount) in [(1, 1.0), (2, 1.0), (2, 2.0)] {
            let tag = tag(id, edge_px);
            // A lower contrast, of which sharpening clips nothing.
            let flat: Greys = draw(&tag).iter().map(|grey| 80.0 + 0.4 * grey).collect();
            let what = format!("{edge_px} px, sharpened by {amount} over {reach} px");
            assert_found(&sharpened(&flat, reach, amount), &tag, 0.05, &what);
        }
    }
}

/// As compression leaves them: areas of one grey, on either side of the edges.
fn denoised(greys: &[f64]) -> Greys {
    let even = |grey: &f64| match *grey {
        grey if grey < 46.0 => 40.0,
        grey if grey > 194.0 => 200.0,
        grey => grey,
    };
    greys.iter().map(even).collect()
}

#[test]
fn exposure_moves_no_corner_of_a_picture_without_noise() {
    for (id, edge_px) in [(1, 40.0), (2, 60.0), (3, 90.0)] {
        let tag = tag(id, edge_px);
        let picture = denoised(&draw(&tag));
        let curved: Greys = picture
            .iter()
            .map(|grey| 255.0 * (grey / 255.0).powf(0.45))
            .collect();
        assert_found(&curved, &tag, 0.05, &format!("{edge_px} px, gamma .45"));
        let bright: Greys = picture
            .iter()
            .map(|grey| (1.8 * grey + 10.0).min(255.0))
            .collect();
        assert_found(&bright, &tag, 0.08, &format!("{edge_px} px, over-exposed"));
    }
}
