//! A borrowed grey image.
//!
//! Pixel (0, 0) is the *centre* of the top left pixel; x points right, y down.

use std::ops::Range;

/// A borrowed 8-bit grey image.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    pixels: &'a [u8],
    width: usize,
    height: usize,
    stride: usize,
}

/// Invalid image dimensions or buffers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// Width, height or the number of pixels out of range.
    #[error(
        "an image of {width}x{height} pixels is outside {} to {} pixels a side and {} megapixels in all",
        Image::MIN_SIZE, Image::MAX_SIZE, Image::MAX_PIXELS / 1_000_000
    )]
    Size {
        /// Pixels in a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Rows overlap or are too far apart.
    #[error("a stride of {stride} bytes is none of rows of {width} pixels: {width} to 1048576 are")]
    Stride {
        /// Bytes from one row to the next.
        stride: usize,
        /// Pixels in a row.
        width: usize,
    },
    /// The buffer ends before the last row does.
    #[error("{found} bytes are fewer than the {needed} that the image takes")]
    TooShort {
        /// Length of the buffer in bytes.
        found: usize,
        /// Required length in bytes.
        needed: usize,
    },
}

impl<'a> Image<'a> {
    /// Least width and height.
    pub const MIN_SIZE: usize = 16;
    /// Greatest width and height.
    pub const MAX_SIZE: usize = 1 << 15;
    /// Most pixels: cameras of 100 megapixels have a few more than that.
    pub const MAX_PIXELS: usize = 1 << 27;
    /// Largest distance of rows in bytes: pixel indices have 32 bits.
    pub const MAX_STRIDE: usize = 1 << 20;

    /// An image of `pixels`, row by row, `stride` bytes apart; the last row may end with its last pixel.
    pub fn new(
        pixels: &'a [u8],
        width: usize,
        height: usize,
        stride: usize,
    ) -> Result<Self, ImageError> {
        Self::check_size(width, height)?;
        if !(width..=Self::MAX_STRIDE).contains(&stride) {
            return Err(ImageError::Stride { stride, width });
        }
        let (needed, found) = ((height - 1) * stride + width, pixels.len());
        if found < needed {
            return Err(ImageError::TooShort { found, needed });
        }
        Ok(Self {
            pixels: &pixels[..needed],
            width,
            height,
            stride,
        })
    }

    /// Whether images of this many columns and rows can be searched, in either orientation.
    pub const fn check_size(width: usize, height: usize) -> Result<(), ImageError> {
        let too_small = width < Self::MIN_SIZE || height < Self::MIN_SIZE;
        let too_long = width > Self::MAX_SIZE || height > Self::MAX_SIZE;
        if too_small || too_long || width * height > Self::MAX_PIXELS {
            return Err(ImageError::Size { width, height });
        }
        Ok(())
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows, pixels.
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

    /// An image of the same size with these pixels, row by row without padding.
    pub(crate) fn with_pixels<'b>(&self, pixels: &'b [u8]) -> Image<'b> {
        debug_assert_eq!(pixels.len(), self.width * self.height);
        Image {
            pixels,
            stride: self.width,
            ..*self
        }
    }

    /// A rectangle of the image, which must lie within it and have at least the least size.
    pub(crate) fn crop(&self, columns: Range<usize>, rows: Range<usize>) -> Self {
        debug_assert!(columns.end <= self.width && rows.end <= self.height);
        Self {
            pixels: &self.pixels[rows.start * self.stride + columns.start..],
            width: columns.len(),
            height: rows.len(),
            stride: self.stride,
        }
    }

    /// All rows with their padding, at least up to the last pixel; and the bytes from one row to the next.
    #[inline]
    pub(crate) fn bytes(&self) -> (&'a [u8], usize) {
        (self.pixels, self.stride)
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
    fn pictures_of_100_megapixels_have_any_shape() {
        for [long, short] in [
            [11_648, 8_736],
            [4_032, 3_024],
            [32_768, 4_096],
            [20_000, 16],
        ] {
            assert_eq!(Image::check_size(long, short), Ok(()));
            assert_eq!(Image::check_size(short, long), Ok(()));
        }
        for [width, height] in [[32_769, 16], [16, 32_769], [16_384, 8_193], [15, 100]] {
            let error = Image::check_size(width, height).unwrap_err().to_string();
            let expected = format!("{width}x{height} pixels is outside 16 to 32768 pixels a side");
            assert!(error.contains(&expected), "{error}");
        }
    }
}
