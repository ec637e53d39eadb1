//! The picture of corners before and after the fit: each tag as a whole, and its four corners close up.

use crate::pictures::{AFTER, BEFORE};
use crate::record::{Quad, Record};
use sextant_apriltag::{Detection, Refinement};
use sextant_drawing::{Canvas, CanvasView, Font, GROUND, INK, legend_height, write_legend};
use sextant_recordings::GreyImage;

/// Side of the square that shows a tag, and of those that show its corners, pixels of the canvas.
const WHOLE: usize = 300;
const CORNER: usize = 148;
const GAP: usize = 4;
const CAPTION: usize = 22;
const CELL: [usize; 2] = [
    WHOLE + 2 * (CORNER + GAP) + 5 * GAP,
    WHOLE + CAPTION + 3 * GAP,
];
/// Side of what a close-up shows, pixels of the picture.
const SEEN_PX: f32 = 9.0;

/// A cell a tag.
pub fn corners(picture: &GreyImage, record: &Record) -> Canvas {
    let columns = if record.refined.len() > 1 { 2 } else { 1 };
    let rows = record.refined.len().div_ceil(columns);
    let mut canvas = Canvas::new(columns * CELL[0], rows * CELL[1] + legend_height(2), GROUND);
    for (i, (before, tag)) in record.refined.iter().enumerate() {
        let at = [i % columns * CELL[0], i / columns * CELL[1]];
        draw_tag(&mut canvas, picture, at, before, tag);
    }
    let legend = [
        (BEFORE, "with which the tag was read".to_owned()),
        (AFTER, "after the fit, as reported".to_owned()),
    ];
    write_legend(&mut canvas, rows * CELL[1], &legend);
    canvas
}

fn draw_tag(
    canvas: &mut Canvas,
    picture: &GreyImage,
    [left, top]: [usize; 2],
    before: &Quad,
    tag: &Detection,
) {
    canvas.write(
        [left + 2 * GAP, top + GAP],
        Font::Body,
        &caption(before, tag),
        INK,
    );
    let (left, top) = (left + 2 * GAP, top + CAPTION);
    let mut draw = |place: [usize; 2], side: usize, middle: [f32; 2], seen: f32| {
        let view = CanvasView {
            scale: side as f32 / seen,
            from: middle.map(|value| value + 0.5 - seen / 2.0),
            to: [0.0; 2],
        };
        let mut part = Canvas::new(side, side, GROUND);
        part.show(picture, &view, [0..side, 0..side], |grey| [grey; 3]);
        part.outline(before.map(|corner| view.at(corner)), BEFORE);
        part.outline(tag.corners.map(|corner| view.at(corner)), AFTER);
        canvas.place(place, &part);
    };
    draw([left, top], WHOLE, tag.centre(), 1.25 * side(&tag.corners));
    let beside = left + WHOLE + GAP;
    let places = [[0, 0], [1, 0], [1, 1], [0, 1]];
    for ([column, row], corner) in places.into_iter().zip(tag.corners) {
        let step = CORNER + GAP;
        draw(
            [beside + column * step, top + row * step],
            CORNER,
            corner,
            SEEN_PX,
        );
    }
}

fn caption(before: &Quad, tag: &Detection) -> String {
    let moved = before.iter().zip(tag.corners);
    let moved = moved.map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1]));
    let refinement = match tag.refinement {
        Refinement::Edges => "edges",
        Refinement::Photometric => "pattern",
    };
    format!(
        "{} {}: {refinement}, moved up to {:.2} px",
        tag.family,
        tag.id,
        moved.fold(0.0, f32::max)
    )
}

/// Of the upright square around the corners.
fn side(corners: &Quad) -> f32 {
    let extent = |axis: usize| {
        let values = corners.map(|corner| corner[axis]);
        let high = values.into_iter().fold(f32::MIN, f32::max);
        high - values.into_iter().fold(f32::MAX, f32::min)
    };
    extent(0).max(extent(1)).max(SEEN_PX)
}
