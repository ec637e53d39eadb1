//! The pictures of whole images: one a stage, each with a legend below.

use crate::record::{PassRecord, Quad, Record};
use sextant_apriltag::{Detection, Rejection};
use sextant_drawing::{
    Canvas, CanvasView, Colour, Font, GROUND, INK, LegendLine, legend_height, legend_width,
    write_legend,
};
use sextant_recordings::GreyImage;
use std::collections::BTreeMap;

/// Of corners with which a tag was read, and of those after the fit.
pub const BEFORE: Colour = [255, 80, 60];
pub const AFTER: Colour = [60, 230, 110];
const FIRST_CORNER: Colour = [255, 220, 0];

/// Of quads, pass after pass.
const PASS_COLOURS: [Colour; 3] = [[255, 220, 0], [0, 210, 255], [255, 120, 255]];

/// Pixels of the canvas along a picture's longer side, about: small pictures are enlarged.
const USUAL_WIDTH: usize = 1280;
/// Brightness of an image behind drawings.
const DIM: f32 = 0.45;

/// The picture as a ground for drawings: so bright that all but its brightest hundredth keeps below white.
pub fn brightened(picture: &GreyImage) -> GreyImage {
    let mut counts = [0_usize; 256];
    for &grey in &picture.pixels {
        counts[usize::from(grey)] += 1;
    }
    let brightest = picture.pixels.len() / 100;
    let mut above = 0;
    let white = (1..256).rev().find(|&grey| {
        above += counts[grey];
        above > brightest
    });
    let gain = 255.0 / white.unwrap_or(255) as f32;
    let brighter = |&grey: &u8| (f32::from(grey) * gain) as u8;
    GreyImage {
        pixels: picture.pixels.iter().map(brighter).collect(),
        ..*picture
    }
}

/// Pixels that have the border's colour, as black, and all others.
pub fn threshold(picture: &GreyImage, pass: &PassRecord) -> Canvas {
    let flat = |value| GreyImage {
        pixels: vec![value; picture.pixels.len()],
        ..*picture
    };
    let mut plane = flat(255);
    for ([x, y], _) in &pass.pixels {
        plane.pixels[usize::from(*y) * picture.width + usize::from(*x)] = 0;
    }
    let legend = vec![
        (
            [0; 3],
            format!("pixels of the border colour: {}", pass.pixels.len()),
        ),
        (INK, "all others".to_owned()),
    ];
    on_picture(&plane, |grey| [grey; 3], &legend).0
}

/// Each component of those pixels in a colour of its own.
pub fn components(picture: &GreyImage, pass: &PassRecord) -> Canvas {
    let mut areas: BTreeMap<u32, usize> = BTreeMap::new();
    for (_, component) in &pass.pixels {
        *areas.entry(*component).or_default() += 1;
    }
    let largest = areas.values().max().copied().unwrap_or(0);
    let legend = vec![(
        INK,
        format!(
            "{} components, a colour each, the largest of {largest} pixels",
            areas.len()
        ),
    )];
    let (mut canvas, view) = on_picture(picture, dim, &legend);
    let edge = |value: u16, i: usize| (f32::from(value) * view.scale + view.to[i]) as usize;
    for &([x, y], component) in &pass.pixels {
        let area = [edge(x, 0)..edge(x + 1, 0), edge(y, 1)..edge(y + 1, 1)];
        canvas.fill(area, colour_of(component));
    }
    canvas
}

/// Every quad, by pass.
pub fn quads(picture: &GreyImage, record: &Record) -> Canvas {
    let legend: Vec<LegendLine> = record
        .passes
        .iter()
        .zip(PASS_COLOURS)
        .map(|(pass, colour)| {
            (
                colour,
                format!("quads of pass {}: {}", pass.name(), pass.quads.len()),
            )
        })
        .collect();
    let (mut canvas, view) = on_picture(picture, dim, &legend);
    for (pass, colour) in record.passes.iter().zip(PASS_COLOURS) {
        for quad in &pass.quads {
            canvas.outline(quad.map(|corner| view.at(corner)), colour);
        }
    }
    canvas
}

/// Every candidate that was no tag, in the colour of the reason.
pub fn rejected(picture: &GreyImage, record: &Record) -> Canvas {
    let count = |reason| record.rejected().filter(|(why, _)| *why == reason).count();
    let legend = Rejection::ALL.map(|reason| {
        (
            reason_colour(reason),
            format!("{}: {}", reason_in_words(reason), count(reason)),
        )
    });
    let (mut canvas, view) = on_picture(picture, dim, &legend);
    // In the order of the reasons: what came farther is drawn over what was turned down at once.
    for reason in Rejection::ALL {
        for (_, quad) in record.rejected().filter(|(why, _)| *why == reason) {
            canvas.outline(quad.map(|corner| view.at(corner)), reason_colour(reason));
        }
    }
    canvas
}

/// The tags as they are reported.
pub fn tags(picture: &GreyImage, detections: &[Detection]) -> Canvas {
    let legend = [
        (AFTER, format!("tags: {}", detections.len())),
        (
            FIRST_CORNER,
            "top edge of the upright tag, from its first corner".to_owned(),
        ),
    ];
    let (mut canvas, view) = on_picture(picture, |grey| [grey; 3], &legend);
    for detection in detections {
        let corners = detection.corners.map(|corner| view.at(corner));
        canvas.outline(corners, AFTER);
        canvas.line(corners[0], corners[1], FIRST_CORNER);
        canvas.cross(corners[0], 4.0, FIRST_CORNER);
    }
    for detection in detections {
        let font = label_font(&detection.corners, view.scale);
        let text = detection.id.to_string();
        canvas.label(view.at(detection.centre()), font, &text, INK);
    }
    canvas
}

/// Large text on large tags: a label covers no more than a part of its tag.
fn label_font(corners: &Quad, scale: f32) -> Font {
    const LARGE_PX: f32 = 120.0;
    let [[ax, ay], _, [cx, cy], _] = *corners;
    let diagonal = (cx - ax).hypot(cy - ay) * scale;
    if diagonal < LARGE_PX {
        Font::Body
    } else {
        Font::Heading
    }
}

/// The whole picture, enlarged if it is small, with a legend below.
fn on_picture(
    picture: &GreyImage,
    colour_of: impl Fn(u8) -> Colour,
    legend: &[LegendLine],
) -> (Canvas, CanvasView) {
    let scale = (USUAL_WIDTH / picture.width.max(picture.height)).clamp(1, 4);
    let (width, height) = (picture.width * scale, picture.height * scale);
    let view = CanvasView {
        scale: scale as f32,
        from: [0.0; 2],
        to: [0.0; 2],
    };
    let whole_height = height + legend_height(legend.len());
    let mut canvas = Canvas::new(width.max(legend_width(legend)), whole_height, GROUND);
    canvas.show(picture, &view, [0..width, 0..height], colour_of);
    write_legend(&mut canvas, height, legend);
    (canvas, view)
}

fn dim(grey: u8) -> Colour {
    [(f32::from(grey) * DIM) as u8; 3]
}

/// Hues a golden angle apart, so that labels in a row look unlike each other.
fn colour_of(label: u32) -> Colour {
    const GOLDEN: f32 = 0.618_034;
    let hue = (label as f32 * GOLDEN).fract() * 6.0;
    [0.0, 4.0, 2.0].map(|turn| {
        let way = (hue + turn) % 6.0;
        let share = ((way - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (60.0 + 195.0 * share) as u8
    })
}

fn reason_colour(reason: Rejection) -> Colour {
    match reason {
        Rejection::NotAQuad => [90, 130, 255],
        Rejection::Shape => [0, 210, 255],
        Rejection::FaintBorder => [255, 220, 0],
        Rejection::NoCode => [255, 120, 0],
        Rejection::SmallMargin => [255, 60, 200],
    }
}

fn reason_in_words(reason: Rejection) -> &'static str {
    match reason {
        Rejection::NotAQuad => "outline is no quadrilateral (box)",
        Rejection::Shape => "too small, narrow or skewed (quad or box)",
        Rejection::FaintBorder => "border without contrast",
        Rejection::NoCode => "no code word is near",
        Rejection::SmallMargin => "decision margin too small",
    }
}
