//! Samples in rows of bytes: of one byte among others, of words, packed as MIPI CSI-2 packs them, or in colours. Each
//! comes out as its eight most significant bits.

use super::{Broken, Geometry};

/// How the samples of a row lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Samples {
    /// One byte in every `step`, from the byte `first` on.
    Bytes { step: usize, first: usize },
    /// Words of 16 bits, little-endian, of which the lower `bits` (8 to 16) count.
    Words { bits: u32 },
    /// Four samples of 10 bits in five bytes: their upper eight bits, then their lower two together.
    Packed10,
    /// Two samples of 12 bits in three bytes: their upper eight bits, then their lower four together.
    Packed12,
    /// Red, green and blue bytes among `step`; the sample is their luma after ITU-R BT.601, (77 R + 150 G + 29 B)
    /// / 256.
    Rgb {
        step: usize,
        red: usize,
        green: usize,
        blue: usize,
    },
}

impl Samples {
    /// Bytes of a row of so many samples.
    pub(crate) fn row_bytes(self, width: usize) -> usize {
        match self {
            Self::Bytes { step, .. } | Self::Rgb { step, .. } => width.saturating_mul(step),
            Self::Words { .. } => width.saturating_mul(2),
            Self::Packed10 => packed_bytes(width, 4),
            Self::Packed12 => packed_bytes(width, 2),
        }
    }

    /// Fills `pixels` with the samples of an image.
    ///
    /// # Errors
    /// [`Broken::Short`] where the image or `pixels` have too few bytes.
    pub(crate) fn read(
        self,
        image: &[u8],
        geometry: Geometry,
        pixels: &mut [u8],
    ) -> Result<(), Broken> {
        let Geometry { width, height, .. } = geometry;
        let row_bytes = self.row_bytes(width);
        let stride = geometry.stride.max(row_bytes);
        enough(image.len(), span(stride, height, row_bytes))?;
        enough(pixels.len(), span(width, height, width))?;
        if width == 0 {
            return Ok(());
        }
        for (row, out) in image
            .chunks(stride)
            .zip(pixels.chunks_exact_mut(width))
            .take(height)
        {
            self.read_row(&row[..row_bytes], out);
        }
        Ok(())
    }

    fn read_row(self, row: &[u8], out: &mut [u8]) {
        match self {
            Self::Bytes { step: 1, .. } => out.copy_from_slice(row),
            Self::Bytes { step, first } => each(row, step, out, |bytes| bytes[first]),
            Self::Words { bits } => {
                let shift = bits.clamp(8, 16) - 8;
                // Bits above those that count are noise of some drivers: they are cut off.
                each(row, 2, out, |word| {
                    (u16::from_le_bytes([word[0], word[1]]) >> shift) as u8
                });
            }
            Self::Packed10 => unpack(row, out, 4),
            Self::Packed12 => unpack(row, out, 2),
            Self::Rgb {
                step,
                red,
                green,
                blue,
            } => {
                let share = |level: u8, of_256: u32| u32::from(level) * of_256;
                each(row, step, out, |pixel| {
                    let sum =
                        share(pixel[red], 77) + share(pixel[green], 150) + share(pixel[blue], 29);
                    ((sum + 128) >> 8) as u8
                });
            }
        }
    }
}

/// Groups of `samples` and a byte of remainders; the last group may lack samples, never the remainders.
fn packed_bytes(width: usize, samples: usize) -> usize {
    width.saturating_add(width.div_ceil(samples))
}

/// Rows that begin `stride` bytes apart, the last one without what lies between.
fn span(stride: usize, height: usize, row: usize) -> usize {
    let before_last = stride.saturating_mul(height.saturating_sub(1));
    if height == 0 {
        0
    } else {
        before_last.saturating_add(row)
    }
}

fn enough(bytes: usize, expected: usize) -> Result<(), Broken> {
    if bytes < expected {
        return Err(Broken::Short { bytes, expected });
    }
    Ok(())
}

fn each(row: &[u8], step: usize, out: &mut [u8], sample: impl Fn(&[u8]) -> u8) {
    for (bytes, grey) in row.chunks_exact(step).zip(out) {
        *grey = sample(bytes);
    }
}

/// Groups of `samples` upper bytes with one byte of lower bits behind them, which is passed over.
fn unpack(row: &[u8], out: &mut [u8], samples: usize) {
    for (group, greys) in row.chunks(samples + 1).zip(out.chunks_mut(samples)) {
        let upper = &group[..greys.len()];
        greys.copy_from_slice(upper);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use sextant_simulator::Random;

    const ALL: [Samples; 12] = [
        Samples::Bytes { step: 1, first: 0 },
        Samples::Bytes { step: 2, first: 0 },
        Samples::Bytes { step: 2, first: 1 },
        Samples::Words { bits: 8 },
        Samples::Words { bits: 10 },
        Samples::Words { bits: 12 },
        Samples::Words { bits: 16 },
        Samples::Packed10,
        Samples::Packed12,
        Samples::Rgb {
            step: 3,
            red: 0,
            green: 1,
            blue: 2,
        },
        Samples::Rgb {
            step: 4,
            red: 2,
            green: 1,
            blue: 0,
        },
        Samples::Rgb {
            step: 4,
            red: 1,
            green: 2,
            blue: 3,
        },
    ];

    /// One sample at a time, by its place.
    fn naive(samples: Samples, row: &[u8], x: usize) -> u8 {
        let word = |place: usize| u32::from(row[place]) | u32::from(row[place + 1]) << 8;
        match samples {
            Samples::Bytes { step, first } => row[x * step + first],
            Samples::Words { bits } => (word(2 * x) >> (bits - 8)) as u8,
            Samples::Packed10 => row[x / 4 * 5 + x % 4],
            Samples::Packed12 => row[x / 2 * 3 + x % 2],
            Samples::Rgb {
                step,
                red,
                green,
                blue,
            } => {
                let level = |colour: usize| f64::from(row[x * step + colour]);
                let luma = (77.0 * level(red) + 150.0 * level(green) + 29.0 * level(blue)) / 256.0;
                (luma + 0.5).floor() as u8
            }
        }
    }

    proptest! {
        #[test]
        fn rows_are_those_of_the_naive_twin(
            kind in 0..ALL.len(), width in 1usize..40, height in 1usize..6, padding in 0usize..9, seed: u64,
        ) {
            let samples = ALL[kind];
            let stride = samples.row_bytes(width) + padding;
            let length = stride * (height - 1) + samples.row_bytes(width);
            let mut random = Random::new(seed);
            let image: Vec<u8> = (0..length).map(|_| random.bits() as u8).collect();
            let geometry = Geometry { width, height, stride };
            let mut pixels = vec![0; width * height];
            samples.read(&image, geometry, &mut pixels).unwrap();
            for y in 0..height {
                for x in 0..width {
                    prop_assert_eq!(pixels[y * width + x], naive(samples, &image[y * stride..], x));
                }
            }
            let short = samples.read(&image[..length - 1], geometry, &mut pixels);
            prop_assert_eq!(short, Err(Broken::Short { bytes: length - 1, expected: length }));
            let small = samples.read(&image, geometry, &mut pixels[1..]);
            prop_assert!(small.is_err());
        }
    }

    #[test]
    fn a_stride_below_the_rows_own_length_counts_as_that() {
        let geometry = Geometry {
            width: 2,
            height: 2,
            stride: 0,
        };
        let mut pixels = [0; 4];
        let yuyv = Samples::Bytes { step: 2, first: 0 };
        yuyv.read(&[1, 9, 2, 9, 3, 9, 4, 9], geometry, &mut pixels)
            .unwrap();
        assert_eq!(pixels, [1, 2, 3, 4]);
    }

    #[test]
    fn sizes_that_overflow_are_refused() {
        let geometry = Geometry {
            width: usize::MAX,
            height: usize::MAX,
            stride: usize::MAX,
        };
        for samples in ALL {
            assert!(samples.read(&[0; 64], geometry, &mut [0; 64]).is_err());
        }
    }
}
