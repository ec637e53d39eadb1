//! An 8-bit image without gaps between its rows, and what stands beyond its edges.

/// A borrowed 8-bit image: `width * height` bytes, row after row.
#[derive(Debug, Clone, Copy)]
pub struct Raster<'a> {
    pixels: &'a [u8],
    width: usize,
    height: usize,
}

/// The bytes are no image of that size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{found} bytes are no image of {width}x{height} pixels (2x2 to 1280x960)")]
pub struct SizeError {
    /// Bytes given.
    pub found: usize,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl<'a> Raster<'a> {
    /// Greatest width that a circuit takes.
    pub const MAX_WIDTH: usize = 1280;
    /// Greatest height that a circuit takes.
    pub const MAX_HEIGHT: usize = 960;

    /// An image of a size.
    ///
    /// # Errors
    /// A size outside 2x2 to 1280x960, or another number of bytes.
    pub fn new(pixels: &'a [u8], [width, height]: [usize; 2]) -> Result<Self, SizeError> {
        let in_range =
            (2..=Self::MAX_WIDTH).contains(&width) && (2..=Self::MAX_HEIGHT).contains(&height);
        if !in_range || pixels.len() != width * height {
            let found = pixels.len();
            return Err(SizeError {
                found,
                width,
                height,
            });
        }
        Ok(Self {
            pixels,
            width,
            height,
        })
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The pixel in column `x` of row `y`.
    ///
    /// # Panics
    /// Outside the image.
    pub fn pixel(&self, x: usize, y: usize) -> u8 {
        self.pixels[y * self.width..][..self.width][x]
    }

    pub(crate) fn row(&self, y: usize) -> &'a [u8] {
        &self.pixels[y * self.width..][..self.width]
    }
}

/// What a 3x3 window sees beyond the edge of an image; names as in OpenCV.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Border {
    /// `BORDER_REFLECT_101`: the pixel next to the one at the edge.
    Reflect101,
    /// `BORDER_REPLICATE`: the pixel at the edge.
    Replicate,
}

impl Border {
    /// Indices of the pixels before, at and after index `i` of `n`, `n` at least 2.
    pub(crate) fn around(self, i: usize, n: usize) -> [usize; 3] {
        let (first, last) = match self {
            Self::Reflect101 => (1, n - 2),
            Self::Replicate => (0, n - 1),
        };
        [
            if i == 0 { first } else { i - 1 },
            i,
            if i + 1 == n { last } else { i + 1 },
        ]
    }
}

/// A pixel and its neighbours, row after row, and the parity of its column and row: whether each is odd.
pub(crate) struct Window {
    pub(crate) rows: [[u8; 3]; 3],
    pub(crate) is_odd: [bool; 2],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_are_those_of_opencv() {
        assert_eq!(Border::Reflect101.around(0, 5), [1, 0, 1]);
        assert_eq!(Border::Reflect101.around(4, 5), [3, 4, 3]);
        assert_eq!(Border::Replicate.around(0, 5), [0, 0, 1]);
        assert_eq!(Border::Replicate.around(4, 5), [3, 4, 4]);
        assert_eq!(Border::Replicate.around(2, 5), [1, 2, 3]);
    }

    #[test]
    fn bytes_must_fit_the_size() {
        assert!(Raster::new(&[0; 6], [3, 2]).is_ok());
        assert!(Raster::new(&[0; 7], [3, 2]).is_err());
        assert!(Raster::new(&[0; 2], [2, 1]).is_err());
        assert!(Raster::new(&[], [0, 0]).is_err());
    }
}
