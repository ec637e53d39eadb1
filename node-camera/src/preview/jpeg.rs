//! Grey pixels to a JPEG of bounded size.

use jpeg_encoder::{ColorType, Encoder, EncodingError};
use sextant_proto::limits::MAX_JPEG_BYTES;

/// The lowest quality that is tried.
const WORST_QUALITY: u8 = 10;

/// Makes pictures; keeps its buffer for the reduced image.
#[derive(Debug)]
pub struct JpegMaker {
    quality: u8,
    max_width: u16,
    reduced: Vec<u8>,
}

impl JpegMaker {
    /// JPEG quality, 1 to 100, and the widest picture in pixels.
    #[must_use]
    pub fn new(quality: u8, max_width: u16) -> Self {
        Self {
            quality,
            max_width,
            reduced: Vec::new(),
        }
    }

    /// The picture, reduced by the least whole factor that makes it narrow enough; where it is over the limit of a
    /// message, at lower quality, and in the end smaller still. `pixels` has `height` rows of `stride` bytes,
    /// `stride >= width`.
    ///
    /// # Errors
    /// An image without pixels.
    pub fn encode(
        &mut self,
        pixels: &[u8],
        width: u16,
        height: u16,
        stride: usize,
    ) -> Result<Vec<u8>, EncodingError> {
        let mut factor = width.div_ceil(self.max_width.max(1)).max(1);
        loop {
            let [reduced_width, reduced_height] =
                self.reduce(pixels, [width, height], stride, factor);
            let mut quality = self.quality;
            loop {
                let mut jpeg = Vec::with_capacity(MAX_JPEG_BYTES / 2);
                Encoder::new(&mut jpeg, quality).encode(
                    &self.reduced,
                    reduced_width,
                    reduced_height,
                    ColorType::Luma,
                )?;
                if jpeg.len() <= MAX_JPEG_BYTES {
                    return Ok(jpeg);
                }
                if quality == WORST_QUALITY {
                    break;
                }
                quality = (quality / 2).max(WORST_QUALITY);
            }
            factor += 1;
        }
    }

    /// Means of `factor` x `factor` pixels; what is left over at the right and below is cut off.
    fn reduce(
        &mut self,
        pixels: &[u8],
        [width, height]: [u16; 2],
        stride: usize,
        factor: u16,
    ) -> [u16; 2] {
        let factor = factor.min(width).min(height).max(1);
        let size = [width / factor, height / factor];
        let (step, [columns, rows]) = (usize::from(factor), size.map(usize::from));
        self.reduced.clear();
        self.reduced.reserve(columns * rows);
        for row in 0..rows {
            let lines = pixels.chunks(stride).skip(row * step).take(step);
            if factor == 1 {
                lines.for_each(|line| self.reduced.extend_from_slice(&line[..columns]));
                continue;
            }
            let mean = |column: usize| {
                let sum: u32 = lines
                    .clone()
                    .flat_map(|line| &line[column * step..][..step])
                    .map(|pixel| u32::from(*pixel))
                    .sum();
                (sum / u32::from(factor).pow(2)) as u8
            };
            self.reduced.extend((0..columns).map(mean));
        }
        size
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_simulator::Random;

    /// Noise, the worst picture for a JPEG.
    fn noise(bytes: usize) -> Vec<u8> {
        let mut random = Random::new(1);
        (0..bytes).map(|_| random.bits() as u8).collect()
    }

    #[test]
    fn even_noise_fits_into_a_message() {
        let jpeg = JpegMaker::new(90, 4096)
            .encode(&noise(1280 * 800), 1280, 800, 1280)
            .unwrap();
        assert!(jpeg.len() <= MAX_JPEG_BYTES);
        assert_eq!(jpeg[..2], [0xff, 0xd8]);
    }

    #[test]
    fn a_wide_image_is_reduced_by_a_whole_factor() {
        let mut maker = JpegMaker::new(60, 800);
        let factor = |width: u16| width.div_ceil(maker.max_width);
        assert_eq!(
            [factor(640), factor(800), factor(801), factor(1920)],
            [1, 1, 2, 3]
        );
        assert_eq!(
            maker.reduce(&[10, 20, 99, 30, 40, 99, 7, 7, 7], [3, 3], 3, 2),
            [1, 1]
        );
        assert_eq!(maker.reduced, [25]);
    }

    #[test]
    fn padding_is_left_out() {
        let mut maker = JpegMaker::new(60, 800);
        assert_eq!(maker.reduce(&[1, 2, 99, 3, 4], [2, 2], 3, 1), [2, 2]);
        assert_eq!(maker.reduced, [1, 2, 3, 4]);
    }
}
