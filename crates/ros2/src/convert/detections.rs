//! The tags of an image.

use nalgebra::Point2;
use sextant_geometry::Homography;
use sextant_proto::{Observations, TagObservation};

use super::frames::optical_frame;
use crate::messages::{AprilTagDetection, AprilTagDetectionArray, Header, PixelPoint};

/// The tags of an image. Those without an area, which no detector reports, are left out.
#[must_use]
pub fn detections(image: &Observations) -> AprilTagDetectionArray {
    AprilTagDetectionArray {
        header: Header::new(image.capture_ns, &optical_frame(&image.camera)),
        detections: image.tags.iter().filter_map(detection).collect(),
    }
}

fn detection(tag: &TagObservation) -> Option<AprilTagDetection> {
    let corners = tag
        .corners
        .map(|corner| Point2::from(corner.map(f64::from)));
    let pixel_from_tag = pixel_from_tag(&corners)?;
    Some(AprilTagDetection {
        family: tag.family.to_string(),
        id: i32::try_from(tag.id).ok()?,
        hamming: i32::from(tag.hamming),
        // The AprilTag library has left it at zero since its third version.
        goodness: 0.0,
        decision_margin: tag.margin,
        centre: PixelPoint {
            x: pixel_from_tag[2],
            y: pixel_from_tag[5],
        },
        corners: from_bottom_left(corners).map(|corner| PixelPoint {
            x: corner.x,
            y: corner.y,
        }),
        homography: pixel_from_tag,
    })
}

/// In the AprilTag library's order: bottom left, bottom right, top right, top left.
fn from_bottom_left(
    [top_left, top_right, bottom_right, bottom_left]: [Point2<f64>; 4],
) -> [Point2<f64>; 4] {
    [bottom_left, bottom_right, top_right, top_left]
}

/// Row-major; takes (-1, -1) to the top left corner and (1, 1) to the bottom right one. The last element is 1, as in
/// the AprilTag library, so that the last column is the centre.
fn pixel_from_tag(corners: &[Point2<f64>; 4]) -> Option<[f64; 9]> {
    const SQUARE: [Point2<f64>; 4] = [
        Point2::new(-1.0, -1.0),
        Point2::new(1.0, -1.0),
        Point2::new(1.0, 1.0),
        Point2::new(-1.0, 1.0),
    ];
    let map = *Homography::from_corners(&SQUARE, corners)?.matrix();
    let map = map / map[(2, 2)];
    let mut row_major = [0.0; 9];
    row_major.copy_from_slice(map.transpose().as_slice());
    row_major
        .iter()
        .all(|element| element.is_finite())
        .then_some(row_major)
}
