//! The circuits: their names, the sizes that they accept, and their models.

use crate::Model;
use crate::model::{BAYER, DILATE, ERODE, GAUSSIAN, MEDIAN};
use std::fmt;

/// A circuit that turns an 8-bit image into another of the same size. Each occupies one of the six tiles, takes the
/// same parameters and can work on bands of an image side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Circuit {
    /// Raw Bayer image, red at (0, 0), to grey (manual, section 4.4.2).
    Bayer2Grayscale,
    /// Median of 3x3 pixels (section 4.3.8).
    MedianBlur,
    /// Gaussian of 3x3 pixels (section 4.3.7).
    GaussianBlur,
    /// Greatest of 3x3 pixels (section 4.3.4).
    Dilate,
    /// Least of 3x3 pixels (section 4.3.5).
    Erode,
}

impl Circuit {
    /// Every circuit.
    pub const ALL: [Self; 5] = [
        Self::Bayer2Grayscale,
        Self::MedianBlur,
        Self::GaussianBlur,
        Self::Dilate,
        Self::Erode,
    ];

    /// Its name in the manual.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bayer2Grayscale => "Bayer2Grayscale",
            Self::MedianBlur => "MedianBlur",
            Self::GaussianBlur => "GaussianBlur",
            Self::Dilate => "Dilate",
            Self::Erode => "Erode",
        }
    }

    /// Least width and height of a band, in pixels.
    pub fn least_size(self) -> [usize; 2] {
        match self {
            Self::Bayer2Grayscale => [16, 4],
            Self::MedianBlur => [24, 8],
            Self::GaussianBlur | Self::Dilate | Self::Erode => [16, 8],
        }
    }

    /// Its models, the likeliest first: one where the manual determines the formula.
    pub fn models(self) -> &'static [Model] {
        match self {
            Self::Bayer2Grayscale => &BAYER,
            Self::MedianBlur => &MEDIAN,
            Self::GaussianBlur => &GAUSSIAN,
            Self::Dilate => &DILATE,
            Self::Erode => &ERODE,
        }
    }
}

impl fmt::Display for Circuit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
