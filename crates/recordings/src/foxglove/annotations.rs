//! The tags of an image, drawn over it: outlines and numbers. Pixels as Foxglove counts them: (0, 0) is the corner of
//! the first pixel, half a pixel before Sextant's. They are those of the whole image; a preview is smaller, and viewers
//! scale it by the camera's calibration.

use super::{ViewerMessage, time};
use foxglove::messages::points_annotation::Type;
use foxglove::messages::{Color, ImageAnnotations, Point2, PointsAnnotation, TextAnnotation};
use sextant_proto::{Observations, TagObservation};

const OUTLINE: Color = Color {
    r: 0.15,
    g: 0.95,
    b: 0.45,
    a: 1.0,
};
const BACKGROUND: Color = Color {
    r: 0.0,
    g: 0.0,
    b: 0.0,
    a: 0.6,
};

/// Topic of a camera's annotations.
pub(super) fn topic(camera: impl std::fmt::Display) -> String {
    format!("/camera/{camera}/annotations")
}

pub(super) fn message(image: &Observations) -> ViewerMessage {
    let annotations = ImageAnnotations {
        timestamp: time(image.capture_ns),
        points: image.tags.iter().map(|tag| outline(image, tag)).collect(),
        texts: image.tags.iter().map(|tag| label(image, tag)).collect(),
        ..ImageAnnotations::default()
    };
    ViewerMessage::protobuf(topic(&image.camera), &annotations)
}

fn outline(image: &Observations, tag: &TagObservation) -> PointsAnnotation {
    PointsAnnotation {
        timestamp: time(image.capture_ns),
        r#type: Type::LineLoop.into(),
        points: tag.corners.map(point).into(),
        outline_color: Some(OUTLINE),
        thickness: 2.0,
        ..PointsAnnotation::default()
    }
}

fn label(image: &Observations, tag: &TagObservation) -> TextAnnotation {
    TextAnnotation {
        timestamp: time(image.capture_ns),
        position: Some(point(tag.corners[0])),
        text: tag.id.to_string(),
        font_size: 14.0,
        text_color: Some(OUTLINE),
        background_color: Some(BACKGROUND),
        ..TextAnnotation::default()
    }
}

fn point(corner: [f32; 2]) -> Point2 {
    let [x, y] = corner.map(|pixels| f64::from(pixels) + 0.5);
    Point2 { x, y }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_counted_from_the_corner_of_the_first() {
        assert_eq!(point([0.0, 1.25]), Point2 { x: 0.5, y: 1.75 });
    }
}
