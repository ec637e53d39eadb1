//! A first focal length of a camera from its single tags.
//!
//! Z. Zhang, A flexible new technique for camera calibration, PAMI 2000, section 3.1, with square pixels, the principal
//! point in the middle of the image and no skew: the two constraints of each tag's homography are then linear in 1/f^2.
//! A single tag says little, thousands enough for the start of an adjustment.

use nalgebra::{Matrix3, Point2};
use sextant_geometry::{Homography, tag_corners_in_tag};

/// Focal lengths as shares of the image width that an ordinary lens has: horizontal fields of view from 120 to 14
/// degrees.
const ORDINARY: std::ops::Range<f64> = 0.29..4.0;
/// Where single tags say nothing: 58 degrees.
const USUAL: f64 = 0.9;

/// The focal length, pixels, from the corners of tags.
pub(super) fn focal_length<'a>(
    tags: impl Iterator<Item = &'a [Point2<f64>; 4]>,
    [width, height]: [u32; 2],
) -> f64 {
    let [width, height] = [width, height].map(f64::from);
    let unit = width / 2.0;
    let to_unit = Matrix3::new(
        1.0 / unit,
        0.0,
        -(width - 1.0) / width,
        0.0,
        1.0 / unit,
        -(height - 1.0) / width,
        0.0,
        0.0,
        1.0,
    );
    let square = tag_corners_in_tag(2.0).map(|corner| corner.xy());
    let (mut normal, mut right) = (0.0, 0.0);
    for corners in tags {
        let Some(map) = Homography::from_corners(&square, corners) else {
            continue;
        };
        let map = to_unit * map.matrix();
        let scale = map.fixed_view::<3, 2>(0, 0).norm();
        let (a, b) = (map.column(0) / scale, map.column(1) / scale);
        // The perspective of a tag has an error that falls with the square of its size in the image.
        let edge = (corners[2] - corners[0]).norm() / unit;
        let weight = edge.powi(4);
        for (by_inverse_square, constant) in [
            (a[0] * b[0] + a[1] * b[1], a[2] * b[2]),
            (
                a[0] * a[0] + a[1] * a[1] - b[0] * b[0] - b[1] * b[1],
                a[2] * a[2] - b[2] * b[2],
            ),
        ] {
            normal += weight * by_inverse_square * by_inverse_square;
            right -= weight * by_inverse_square * constant;
        }
    }
    let focal = unit * (normal / right).sqrt();
    if ORDINARY.contains(&(focal / width)) {
        focal
    } else {
        USUAL * width
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Isometry3, Vector3};
    use sextant_geometry::{Intrinsics, Lens};

    #[test]
    fn exact_tags_give_the_exact_focal_length() {
        let lens = Lens::pinhole(Intrinsics {
            fx: 710.0,
            fy: 710.0,
            cx: 319.5,
            cy: 239.5,
        });
        let lens = lens.unwrap();
        let tags: Vec<[Point2<f64>; 4]> = (0..20)
            .map(|k| {
                let tilt = Vector3::new(0.2 + 0.04 * f64::from(k), 0.5 - 0.03 * f64::from(k), 0.3);
                let pose = Isometry3::new(Vector3::new(0.1, -0.05, 0.6), tilt);
                tag_corners_in_tag(0.08).map(|corner| lens.project(&(pose * corner)).unwrap())
            })
            .collect();
        let found = focal_length(tags.iter(), [640, 480]);
        assert!((found - 710.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn without_tags_it_is_a_usual_one() {
        assert_eq!(focal_length([].iter(), [1000, 500]), 900.0);
    }
}
