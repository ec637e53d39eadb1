//! An image in which borders of one colour are searched.

use crate::Image;
use sextant_tag_families::BorderColour;

#[derive(Clone, Copy)]
pub(crate) struct ImageView<'a> {
    pub(crate) image: &'a Image<'a>,
    pub(crate) border: BorderColour,
    /// Least difference between black and white, in grey levels.
    pub(crate) min_contrast: f32,
}

impl ImageView<'_> {
    /// Sign of the step in grey from the inside of a border outwards.
    pub(crate) fn sign(&self) -> f32 {
        match self.border {
            BorderColour::Black => 1.0,
            BorderColour::White => -1.0,
        }
    }
}
