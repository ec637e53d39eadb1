//! What the detector says about a tag.

use crate::quad::middle;
use sextant_tag_families::Family;

/// A decoded tag in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// The tag's family.
    pub family: Family,
    /// The tag's number within its family.
    pub id: u32,
    /// Wrong bits that were corrected.
    pub hamming: u8,
    /// Decision margin: how far the bits stand from their threshold on average, in grey levels, of the weaker colour.
    pub margin: f32,
    /// Corners of the square's border: top left, top right, bottom right, bottom left of the upright tag, x and y in
    /// pixels with (0, 0) at the centre of the top left pixel.
    pub corners: [[f32; 2]; 4],
    /// Covariance of each corner as (xx, xy, yy) in square pixels.
    pub corner_covariance: [[f32; 3]; 4],
    /// Covariance between the corners of each of [`sextant_geometry::CORNER_PAIRS`] in square pixels: x of the one with x and with y of the
    /// other, then y of the one with both.
    pub corner_cross_covariance: [[f32; 4]; 6],
    /// What the corners come from.
    pub refinement: Refinement,
}

/// How corners are found below the pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Refinement {
    /// Straight lines through the border's outer edges.
    Edges,
    /// The whole known pattern fitted to the pixels, where that explains them better than the edges do.
    #[default]
    Photometric,
}

impl Detection {
    /// Mean of the corners, in pixels.
    pub fn centre(&self) -> [f32; 2] {
        middle(&self.corners)
    }
}
