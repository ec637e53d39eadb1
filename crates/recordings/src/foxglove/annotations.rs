//! The tags of an image, drawn over it: outlines and numbers. Pixels as Foxglove counts them: (0, 0) is the corner of the first pixel, half
//! a pixel before Sextant's. They are those of the whole image; a preview is smaller, and viewers scale it by the camera's calibration.

use super::{ViewerMessage, colour, json_message, schema::Schema, time};
use serde_json::{Value, json};
use sextant_proto::{Observations, TagObservation};

const LINE_LOOP: u8 = 2;
const OUTLINE: [f64; 4] = [0.15, 0.95, 0.45, 1.0];
const BACKGROUND: [f64; 4] = [0.0, 0.0, 0.0, 0.6];
const CLEAR: [f64; 4] = [0.0; 4];

/// Topic of a camera's annotations.
pub(super) fn topic(camera: impl std::fmt::Display) -> String {
    format!("/camera/{camera}/annotations")
}

pub(super) fn message(image: &Observations) -> ViewerMessage {
    let points = image.tags.iter().map(|tag| outline(image, tag));
    let texts = image.tags.iter().map(|tag| label(image, tag));
    let annotations = json!({
        "timestamp": time(image.capture_ns),
        "circles": [],
        "points": points.collect::<Vec<_>>(),
        "texts": texts.collect::<Vec<_>>(),
    });
    json_message(topic(&image.camera), Schema::ImageAnnotations, &annotations)
}

fn outline(image: &Observations, tag: &TagObservation) -> Value {
    json!({
        "timestamp": time(image.capture_ns),
        "type": LINE_LOOP,
        "points": tag.corners.map(point),
        "outline_color": colour(OUTLINE),
        "outline_colors": [],
        "fill_color": colour(CLEAR),
        "thickness": 2.0,
    })
}

fn label(image: &Observations, tag: &TagObservation) -> Value {
    json!({
        "timestamp": time(image.capture_ns),
        "position": point(tag.corners[0]),
        "text": tag.id.to_string(),
        "font_size": 14.0,
        "text_color": colour(OUTLINE),
        "background_color": colour(BACKGROUND),
    })
}

/// To a hundredth of a pixel, which is more than is drawn: recordings have one of these for each corner of each image.
fn point(corner: [f32; 2]) -> Value {
    let [x, y] = corner.map(|pixels| ((f64::from(pixels) + 0.5) * 100.0).round() / 100.0);
    json!({ "x": x, "y": y })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_counted_from_the_corner_of_the_first() {
        assert_eq!(point([0.0, 1.234_567]), json!({ "x": 0.5, "y": 1.73 }));
    }
}
