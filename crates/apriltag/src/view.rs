//! An image in which borders of a colour are looked for, and how it is sampled.

use crate::Image;
use crate::homography::Homography;
use crate::kernels::{Points, sample, vectorised};
use sextant_tag_families::BorderColour;

#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) border: BorderColour,
}

impl View<'_> {
    /// Sign of the step in grey from within a border outwards.
    pub(crate) fn sign(&self) -> f32 {
        match self.border {
            BorderColour::Black => 1.0,
            BorderColour::White => -1.0,
        }
    }

    /// Grey where places are mapped to, NaN outside the image.
    pub(crate) fn sample(&self, map: &Homography, places: &[[Points; 2]], greys: &mut [Points]) {
        vectorised(
            #[inline(always)]
            || sample(self.image, map, places, greys),
        );
    }
}
