//! A part of an image that is searched for tags.
//!
//! In: where it lies in the image. Out: that part as an image of its own, of the same pixels, and the way back from its
//! places to the image's.

use crate::Image;
use crate::quad::Point;

/// A rectangle of an image, or every so many-th row of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Area {
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) width: usize,
    /// Rows of the image that it reaches over.
    pub(crate) height: usize,
    /// From one row that is looked at to the next.
    pub(crate) row_step: usize,
}

impl Area {
    pub(crate) fn whole(image: &Image<'_>) -> Self {
        Self {
            left: 0,
            top: 0,
            width: image.width(),
            height: image.height(),
            row_step: 1,
        }
    }

    /// Its pixels. It must lie within the image.
    pub(crate) fn of<'a>(&self, image: &Image<'a>) -> Image<'a> {
        image.part(self)
    }

    /// From a place in the part to one in the image.
    pub(crate) fn to_image(self, [x, y]: Point) -> Point {
        [
            self.left as f32 + x,
            self.top as f32 + y * self.row_step as f32,
        ]
    }
}
