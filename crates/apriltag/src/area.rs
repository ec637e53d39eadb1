//! A part of an image that is searched for tags.
//!
//! Input: a rectangle of the image. Output: the rectangle as an image of its own that shares the pixels, and the map
//! from its coordinates to those of the image.

use crate::Image;
use crate::components::Component;
use crate::kernels::TILE;
use crate::quad::Quad;

/// A rectangle of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Area {
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl Area {
    pub(crate) fn whole(image: &Image<'_>) -> Self {
        Self {
            left: 0,
            top: 0,
            width: image.width(),
            height: image.height(),
        }
    }

    /// The area as an image of its own, which shares the pixels of `image`.
    pub(crate) fn crop<'a>(&self, image: &Image<'a>) -> Image<'a> {
        let columns = self.left..self.left + self.width;
        image.crop(columns, self.top..self.top + self.height)
    }

    /// From the part to the image.
    pub(crate) fn quad_to_image(&self, quad: Quad) -> Quad {
        quad.map(|[x, y]| [self.left as f32 + x, self.top as f32 + y])
    }

    /// Whether a component may continue beyond the area: it reaches an edge of the area that is not an edge of the
    /// image.
    pub(crate) fn cuts(&self, component: &Component, image: &Image<'_>) -> bool {
        let (columns, rows) = (component.columns(), component.rows());
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        columns.start == 0 && self.left > 0
            || rows.start == 0 && self.top > 0
            || columns.end as usize == self.width && right < image.width()
            || rows.end as usize >= self.height && bottom < image.height()
    }

    pub(crate) fn n_pixels(&self) -> usize {
        self.width * self.height
    }

    /// The smallest area that contains these columns and rows, starts at a tile and has the least size of an image;
    /// `None` if it is outside the image.
    pub(crate) fn enclosing(columns: [f32; 2], rows: [f32; 2], image: &Image<'_>) -> Option<Self> {
        let (left, width) = clip(columns, image.width())?;
        let (top, height) = clip(rows, image.height())?;
        Some(Self {
            left,
            top,
            width,
            height,
        })
    }
}

/// First pixel and number of pixels, of `size`, from `low` to `high`.
fn clip([low, high]: [f32; 2], size: usize) -> Option<(usize, usize)> {
    if high < 0.0 || low >= size as f32 {
        return None;
    }
    let first = (low.max(0.0) as usize).min(size - Image::MIN_SIZE) / TILE * TILE;
    let end = (high as usize)
        .saturating_add(1)
        .clamp(first + Image::MIN_SIZE, size);
    Some((first, end - first))
}
