//! The detector's output for one tag.

use crate::quad::middle;
use sextant_tag_families::Family;

/// A decoded tag in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The tag's family.
    pub family: Family,
    /// The tag's number within its family.
    pub id: u32,
    /// Number of corrected bit errors.
    pub hamming: u8,
    /// Decision margin: mean distance of the bits from their threshold, in grey levels, of the weaker colour.
    pub margin: f32,
    /// Corners of the square's border: top left, top right, bottom right, bottom left of the upright tag, x and y in
    /// pixels with (0, 0) at the centre of the top left pixel.
    pub corners: [[f32; 2]; 4],
    /// Covariance of each corner as (xx, xy, yy) in square pixels.
    pub corner_covariance: [[f32; 3]; 4],
    /// Covariance between the corners of each of [`sextant_geometry::CORNER_PAIRS`] as (xx, xy, yx, yy) in square
    /// pixels.
    pub corner_cross_covariance: [[f32; 4]; 6],
    /// How the corners were refined.
    pub refinement: Refinement,
}

/// Method of sub-pixel corner refinement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Refinement {
    /// Straight lines fitted to the outer edges of the border.
    Edges,
    /// The whole pattern fitted to the pixels, if that explains them better than the edges.
    #[default]
    Photometric,
}

impl Detection {
    /// Mean of the corners, in pixels.
    pub fn centre(&self) -> [f32; 2] {
        middle(&self.corners)
    }
}
