//! The formulas: each the value of a pixel from the 3x3 window around it.

use crate::binomial::{self, Weights};
use crate::raster::{Border, Window};
use crate::{Raster, SizeError, bayer};
use std::fmt;

/// How far the manual determines a formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Standing {
    /// The manual gives every output value.
    Exact,
    /// The manual leaves something open, mostly rounding; this is one reading of it, numbered from 1.
    Interpretation(u8),
}

impl fmt::Display for Standing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact => f.write_str("exact"),
            Self::Interpretation(number) => write!(f, "interpretation {number}"),
        }
    }
}

/// The formula of a circuit.
#[derive(Debug, Clone, Copy)]
pub struct Model {
    standing: Standing,
    formula: &'static str,
    border: Border,
    pixel: fn(&Window) -> u8,
    /// The same for a whole image, where there is a faster way.
    image: Option<fn(&Raster<'_>, &mut [u8])>,
}

impl Model {
    /// How far the manual determines it.
    pub fn standing(&self) -> Standing {
        self.standing
    }

    /// The formula, for people.
    pub fn formula(&self) -> &'static str {
        self.formula
    }

    /// The output at column `x` of row `y` of an image of `size`; `input(x, y)` gives its input pixels.
    pub fn pixel(
        &self,
        [width, height]: [usize; 2],
        [x, y]: [usize; 2],
        input: impl Fn(usize, usize) -> u8,
    ) -> u8 {
        let columns = self.border.around(x, width);
        let rows = self.border.around(y, height);
        (self.pixel)(&Window {
            rows: rows.map(|y| columns.map(|x| input(x, y))),
            is_odd: [x % 2 == 1, y % 2 == 1],
        })
    }

    /// The output for a whole image.
    ///
    /// # Errors
    /// An `output` of another size than the input.
    pub fn run(&self, input: &Raster<'_>, output: &mut [u8]) -> Result<(), SizeError> {
        let size = input.size();
        Raster::new(output, size)?;
        if let Some(image) = self.image {
            image(input, output);
            return Ok(());
        }
        for (y, row) in output.chunks_exact_mut(size[0]).enumerate() {
            for (x, out) in row.iter_mut().enumerate() {
                *out = self.pixel(size, [x, y], |x, y| input.pixel(x, y));
            }
        }
        Ok(())
    }
}

const fn reading(number: u8, formula: &'static str, pixel: fn(&Window) -> u8) -> Model {
    Model {
        standing: Standing::Interpretation(number),
        formula,
        border: Border::Reflect101,
        pixel,
        image: None,
    }
}

/// **Interpretations 1 to 5.** The manual gives weights, densities and luma coefficients, but not where values are
/// rounded: R, G and B are the sums of their pixels weighted by \[1 2 1; 2 4 2; 1 2 1\] / 16, times 4, 2 and 4; Y = (76
/// R + 152 G + 28 B) / 256; `BORDER_REFLECT_101`.
pub(crate) static BAYER: [Model; 5] = [
    Model {
        image: Some(bayer::to_grey::<0>),
        ..reading(1, "one division at the end, truncated", |window| {
            bayer::luma(&bayer::sums(window), 0)
        })
    },
    Model {
        image: Some(bayer::to_grey::<128>),
        ..reading(2, "one division at the end, rounded", |window| {
            bayer::luma(&bayer::sums(window), 128)
        })
    },
    reading(3, "R, G, B and Y truncated", |window| {
        bayer::luma_of_bytes(&bayer::sums(window), 0, 0)
    }),
    reading(4, "R, G, B rounded, Y truncated", |window| {
        bayer::luma_of_bytes(&bayer::sums(window), 1, 0)
    }),
    reading(5, "R, G, B and Y rounded", |window| {
        bayer::luma_of_bytes(&bayer::sums(window), 1, 128)
    }),
];

/// **Exact.** The fifth of nine pixels in ascending order. The manual states the border only by its equality with
/// `cv::medianBlur`, which replicates.
pub(crate) static MEDIAN: [Model; 1] = [exact("median of 3x3", |window| {
    let mut pixels = [0; 9];
    pixels.copy_from_slice(window.rows.as_flattened());
    pixels.sort_unstable();
    pixels[4]
})];

const PLAIN: [Weights; 2] = [Weights::PLAIN, Weights::PLAIN];

/// **Interpretations 1 and 2.** The manual prints the kernel \[1 2 1; 2 4 2; 1 2 1\] / 16 with `BORDER_REFLECT_101` and
/// no rounding. It also claims equality with `cv::GaussianBlur` of sigma 1.3, which has another kernel; that claim is
/// passed over. Of a Bayer mosaic of any order the kernel makes (R + 2 G + B) / 4.
pub(crate) static GAUSSIAN: [Model; 2] = [
    Model {
        image: Some(|input, output| binomial::filter::<4>(input, &PLAIN, 8, output)),
        ..reading(1, "sum of the kernel / 16, rounded", |window| {
            ((gaussian_sum(window) + 8) >> 4) as u8
        })
    },
    Model {
        image: Some(|input, output| binomial::filter::<4>(input, &PLAIN, 0, output)),
        ..reading(2, "sum of the kernel / 16, truncated", |window| {
            (gaussian_sum(window) >> 4) as u8
        })
    },
];

/// **Exact.** The greatest of nine pixels, `BORDER_REPLICATE`.
pub(crate) static DILATE: [Model; 1] = [exact("maximum of 3x3", |window| {
    let pixels = window.rows.as_flattened();
    pixels.iter().fold(0, |most, &pixel| most.max(pixel))
})];

/// **Exact.** The least of nine pixels, `BORDER_REPLICATE`.
pub(crate) static ERODE: [Model; 1] = [exact("minimum of 3x3", |window| {
    let pixels = window.rows.as_flattened();
    pixels
        .iter()
        .fold(u8::MAX, |least, &pixel| least.min(pixel))
})];

const fn exact(formula: &'static str, pixel: fn(&Window) -> u8) -> Model {
    Model {
        standing: Standing::Exact,
        formula,
        border: Border::Replicate,
        pixel,
        image: None,
    }
}

fn gaussian_sum(window: &Window) -> u32 {
    const KERNEL: [u32; 9] = [1, 2, 1, 2, 4, 2, 1, 2, 1];
    let pixels = window.rows.as_flattened().iter();
    pixels
        .zip(KERNEL)
        .map(|(&pixel, weight)| u32::from(pixel) * weight)
        .sum()
}
