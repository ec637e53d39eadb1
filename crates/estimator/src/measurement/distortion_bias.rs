//! Tags seen through a lens that bends lines.
//!
//! Detectors take a tag for flat in a flat image: they fit one homography to the whole pattern, or straight lines to
//! its edges. Through a lens with distortion the pattern is bent, and its best homography misses the true corners by a
//! share of the bow: small, but the same in every image, so that no averaging takes it away. Lens and corners tell the
//! bow, so the miss can be computed: a homography is fitted to the bent square, and where its corners lie is what such
//! a detector says. Others give the very points, or something between; how much of the miss a camera's corners have is
//! learned while running.

use nalgebra::{Cholesky, Point2, SMatrix, SVector, Vector2};
use sextant_geometry::{Homography, Lens};
use sextant_tag_families::white_modules;

use sextant_site_model::TagId;

/// The tag's corners in its own plane: top left, top right, bottom right, bottom left, y down.
const SQUARE: [Point2<f64>; 4] = [
    Point2::new(-1.0, -1.0),
    Point2::new(1.0, -1.0),
    Point2::new(1.0, 1.0),
    Point2::new(-1.0, 1.0),
];
/// Modules along either side of a printed tag, at most, and one beyond.
const MOST_MODULES: usize = 16;

/// A small change of a homography, as the displacement that it brings about in the tag's plane.
type Change = SVector<f64, 8>;

/// Bias of each corner that is found by a homography, px; `None` where the lens bends no lines, and for boards' saddle
/// points.
pub(crate) fn distortion_bias(
    lens: &Lens,
    tag: TagId,
    corners: &[Point2<f64>; 4],
) -> Option<[Vector2<f64>; 4]> {
    if lens.distortion().is_empty() || tag.family.data().board.is_some() {
        return None;
    }
    let mut rays = *corners;
    for ray in &mut rays {
        *ray = lens.undistort(ray).ok()?;
    }
    let ray_from_tag = Homography::from_corners(&SQUARE, &rays)?;
    let pixel_from_tag = Homography::from_corners(&SQUARE, corners)?;
    let tag_from_pixel = pixel_from_tag.inverse()?;
    let bent = |point: &Point2<f64>| {
        let pixel = lens.distort(&ray_from_tag.apply(point)?)?;
        Some(tag_from_pixel.apply(&pixel)? - point)
    };
    let change = fitted(tag, bent)?;
    let mut distortion_bias = [Vector2::zeros(); 4];
    for (corner, place) in SQUARE.iter().enumerate() {
        distortion_bias[corner] =
            pixel_from_tag.apply(&(place + basis(place) * change))? - corners[corner];
    }
    Some(distortion_bias)
}

/// The change of a homography that follows the bow best, by least squares over the edges between the modules of the
/// tag, which show how far they have gone across.
fn fitted(
    tag: TagId,
    distortion_bias: impl Fn(&Point2<f64>) -> Option<Vector2<f64>>,
) -> Option<Change> {
    let data = tag.family.data();
    let (modules, border) = (usize::from(data.total_width), f64::from(data.border_width));
    let mut rows = [0_u32; MOST_MODULES];
    for (x, y) in white_modules(tag.family, tag.id) {
        rows[y] |= 1 << x;
    }
    let from_middle = |at: f64| (2.0 * at - modules as f64) / border;
    let mut matrix = SMatrix::<f64, 8, 8>::zeros();
    let mut vector = Change::zeros();
    let mut follow = |point: Point2<f64>, axis: usize| {
        let across = basis(&point).row(axis).transpose();
        matrix += across * across.transpose();
        vector += across * distortion_bias(&point)?[axis];
        Some(())
    };
    for line in 1..modules {
        let line_at = from_middle(line as f64);
        for module in 0..modules {
            let module_at = from_middle(module as f64 + 0.5);
            if (rows[module] >> (line - 1) ^ rows[module] >> line) & 1 == 1 {
                follow(Point2::new(line_at, module_at), 0)?;
            }
            if (rows[line - 1] ^ rows[line]) >> module & 1 == 1 {
                follow(Point2::new(module_at, line_at), 1)?;
            }
        }
    }
    Some(Cholesky::new(matrix)?.solve(&vector))
}

/// Displacement of a point of the tag by each of the eight parameters: d = A (1, x, y) + (x, y) (g x + h y).
fn basis(point: &Point2<f64>) -> SMatrix<f64, 2, 8> {
    let (x, y) = (point.x, point.y);
    SMatrix::<f64, 2, 8>::from_row_slice(&[
        1.0,
        x,
        y,
        0.0,
        0.0,
        0.0,
        x * x,
        x * y, //
        0.0,
        0.0,
        0.0,
        1.0,
        x,
        y,
        x * y,
        y * y,
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::lens::Intrinsics;
    use sextant_tag_families::Family;

    const INTRINSICS: Intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 320.0,
        cy: 240.0,
    };

    const TAG: TagId = TagId {
        family: Family::Tag36h11,
        id: 7,
    };

    #[test]
    fn tags_of_every_family_have_room() {
        let widths = Family::ALL.map(|family| usize::from(family.data().total_width));
        assert!(widths.iter().all(|&width| width < MOST_MODULES));
    }

    fn corners() -> [Point2<f64>; 4] {
        [
            (500.0, 350.0),
            (560.0, 345.0),
            (565.0, 400.0),
            (498.0, 410.0),
        ]
        .map(|(x, y)| Point2::new(x, y))
    }

    #[test]
    fn a_lens_without_distortion_changes_nothing() {
        let pinhole = Lens::pinhole(INTRINSICS).unwrap();
        assert_eq!(distortion_bias(&pinhole, TAG, &corners()), None);
        let straight = Lens::brown_conrady(INTRINSICS, [0.0; 5]).unwrap();
        let distortion_bias = distortion_bias(&straight, TAG, &corners()).unwrap();
        assert!(distortion_bias.iter().all(|missed| missed.norm() < 1e-9));
    }

    #[test]
    fn a_homography_fitted_to_the_bent_pattern_gives_the_corners_that_are_put_right() {
        let lens = Lens::brown_conrady(INTRINSICS, [-0.25, 0.07, 0.0005, -0.0004, 0.0]).unwrap();
        let truth = corners();
        let rays = truth.map(|corner| lens.undistort(&corner).unwrap());
        let ray_from_tag = Homography::from_corners(&SQUARE, &rays).unwrap();
        // By Gauss-Newton in pixels on the eight numbers of a homography, from the one through the true corners.
        let mut seen = truth;
        for _ in 0..5 {
            let pixel_from_tag = Homography::from_corners(&SQUARE, &seen).unwrap();
            let tag_from_pixel = pixel_from_tag.inverse().unwrap();
            let miss = |point: &Point2<f64>| {
                let pixel = lens.distort(&ray_from_tag.apply(point)?)?;
                Some(tag_from_pixel.apply(&pixel)? - point)
            };
            let change = fitted(TAG, miss).unwrap();
            seen = SQUARE.map(|place| {
                pixel_from_tag
                    .apply(&(place + basis(&place) * change))
                    .unwrap()
            });
        }
        let bias = seen
            .iter()
            .zip(&truth)
            .map(|(a, b)| (a - b).norm())
            .fold(0.0, f64::max);
        let distortion_bias = distortion_bias(&lens, TAG, &seen).unwrap();
        let left = (0..4)
            .map(|corner| (seen[corner] - distortion_bias[corner] - truth[corner]).norm())
            .fold(0.0, f64::max);
        assert!(bias > 0.02 && left < 0.02 * bias, "{bias} {left}");
    }
}
