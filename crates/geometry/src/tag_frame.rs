//! Where a tag's corners are in the tag's own frame (x right, y up, z out of the face towards the viewer).

use nalgebra::Point3;

/// The corners of a tag's black square with edge `size_m`, in metres in the tag frame: top left, top right, bottom
/// right, bottom left, clockwise for a viewer of the upright tag.
pub fn tag_corners_in_tag(size_m: f64) -> [Point3<f64>; 4] {
    let half = 0.5 * size_m;
    [
        Point3::new(-half, half, 0.0),
        Point3::new(half, half, 0.0),
        Point3::new(half, -half, 0.0),
        Point3::new(-half, -half, 0.0),
    ]
}
