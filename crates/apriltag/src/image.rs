//! A borrowed grey image and how to read it between pixels.
//!
//! Pixel (0, 0) is the *centre* of the top left pixel; x runs right, y down.

use crate::area::Area;

/// An 8-bit grey image that belongs to somebody else.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    pixels: &'a [u8],
    width: usize,
    height: usize,
    stride: usize,
}

/// Why bytes are no image to the detector.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// Width or height out of range.
    #[error("an image of {width}x{height} pixels is outside 16x16 to 4096x3072")]
    Size {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Rows would overlap.
    #[error("a stride of {stride} bytes is shorter than a row of {width} pixels")]
    Stride {
        /// Bytes from one row to the next.
        stride: usize,
        /// Pixels in a row.
        width: usize,
    },
    /// The last row is not all there.
    #[error("{found} bytes are fewer than the {needed} that the image takes")]
    TooShort {
        /// Bytes that were given.
        found: usize,
        /// Bytes up to the last pixel.
        needed: usize,
    },
}

impl<'a> Image<'a> {
    /// Least width and height.
    pub const MIN_SIZE: usize = 16;
    /// Greatest width.
    pub const MAX_WIDTH: usize = 4096;
    /// Greatest height.
    pub const MAX_HEIGHT: usize = 3072;

    /// `pixels` row after row, `stride` bytes apart; the last row may end with its last pixel.
    pub fn new(
        pixels: &'a [u8],
        width: usize,
        height: usize,
        stride: usize,
    ) -> Result<Self, ImageError> {
        let in_range = |n, max| (Self::MIN_SIZE..=max).contains(&n);
        if !in_range(width, Self::MAX_WIDTH) || !in_range(height, Self::MAX_HEIGHT) {
            return Err(ImageError::Size { width, height });
        }
        if stride < width {
            return Err(ImageError::Stride { stride, width });
        }
        match (height - 1)
            .checked_mul(stride)
            .and_then(|rows| rows.checked_add(width))
        {
            Some(needed) if needed <= pixels.len() => Ok(Self {
                pixels,
                width,
                height,
                stride,
            }),
            needed => Err(ImageError::TooShort {
                found: pixels.len(),
                needed: needed.unwrap_or(usize::MAX),
            }),
        }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The pixels of row `y`.
    ///
    /// # Panics
    /// When `y` is not below the height.
    pub fn row(&self, y: usize) -> &'a [u8] {
        &self.pixels[y * self.stride..][..self.width]
    }

    /// The rows and columns of an area, which must lie within the image and leave no less than the least size.
    pub(crate) fn part(&self, area: &Area) -> Self {
        debug_assert!(
            area.left + area.width <= self.width && area.top + area.height <= self.height
        );
        Self {
            pixels: &self.pixels[area.top * self.stride + area.left..],
            width: area.width,
            height: area.height / area.row_step,
            stride: self.stride * area.row_step,
        }
    }

    /// Whether a point lies among the pixels' centres.
    #[inline]
    pub(crate) fn contains(&self, [x, y]: [f32; 2]) -> bool {
        x >= 0.0 && y >= 0.0 && x <= (self.width - 1) as f32 && y <= (self.height - 1) as f32
    }

    /// Row after row, with what lies between them, up to the last pixel at least.
    #[inline]
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn bytes(&self) -> (&'a [u8], usize) {
        (self.pixels, self.stride)
    }

    /// The grey value at a point by bilinear interpolation; NaN outside the pixels' centres.
    #[inline]
    pub(crate) fn sample(&self, [x, y]: [f32; 2]) -> f32 {
        if !self.contains([x, y]) {
            return f32::NAN;
        }
        let (column, row) = (
            (x as u32 as usize).min(self.width - 2),
            (y as u32 as usize).min(self.height - 2),
        );
        let (fx, fy) = (x - column as f32, y - row as f32);
        let at = row * self.stride + column;
        let four = &self.pixels[at..at + self.stride + 2];
        let mix = |a: u8, b: u8| f32::from(a) + fx * (f32::from(b) - f32::from(a));
        let (top, bottom) = (
            mix(four[0], four[1]),
            mix(four[self.stride], four[self.stride + 1]),
        );
        top + fy * (bottom - top)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_strides_are_checked() {
        let bytes = [0; 20 * 16];
        assert!(Image::new(&bytes, 16, 16, 20).is_ok());
        assert!(Image::new(&bytes[..20 * 15 + 16], 16, 16, 20).is_ok());
        let short = Image::new(&bytes[..20 * 15 + 15], 16, 16, 20);
        assert_eq!(
            short.unwrap_err(),
            ImageError::TooShort {
                found: 315,
                needed: 316
            }
        );
        assert_eq!(
            Image::new(&bytes, 16, 16, 15).unwrap_err(),
            ImageError::Stride {
                stride: 15,
                width: 16
            }
        );
        assert_eq!(
            Image::new(&bytes, 15, 16, 16).unwrap_err(),
            ImageError::Size {
                width: 15,
                height: 16
            }
        );
        assert!(Image::new(&bytes, 16, 16, usize::MAX).is_err());
    }

    #[test]
    fn integers_are_the_centres_of_pixels() {
        let bytes: Vec<u8> = (0..=255).collect();
        let image = Image::new(&bytes, 16, 16, 16).unwrap();
        assert_eq!(image.sample([3.0, 2.0]), 35.0);
        assert_eq!(image.sample([3.5, 2.5]), 43.5);
        assert_eq!(image.sample([15.0, 15.0]), 255.0);
        assert!(image.sample([15.01, 2.0]).is_nan());
        assert!(image.sample([f32::NAN, 2.0]).is_nan());
    }
}
