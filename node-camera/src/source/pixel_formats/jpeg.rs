//! The luma of a JPEG, decoded straight into the image; the chroma is never unpacked. The decoder allocates tables and
//! some rows for each image.

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::Broken;

const START: [u8; 2] = [0xff, 0xd8];
const END: [u8; 2] = [0xff, 0xd9];
const START_OF_SCAN: u8 = 0xda;
/// An empty segment that marks a JPEG as one image of an AVI, for which the decoder supposes the standard's tables.
const AVI_SEGMENT: [u8; 10] = [0xff, 0xe0, 0, 8, b'A', b'V', b'I', b'1', 0, 0];

/// Decodes the images of one camera; keeps a buffer for those without tables.
#[derive(Debug, Default)]
pub(super) struct JpegLuma {
    completed: Vec<u8>,
}

impl JpegLuma {
    /// Fills `pixels` with the luma of a JPEG of this width and height. Bytes behind its end are passed over.
    ///
    /// # Errors
    /// What is no JPEG, is damaged, has no end or another size.
    pub(super) fn decode(
        &mut self,
        jpeg: &[u8],
        size: [usize; 2],
        pixels: &mut [u8],
    ) -> Result<(), Broken> {
        if !jpeg.starts_with(&START) {
            return Err(Broken::Jpeg("no JPEG".to_owned()));
        }
        let end = jpeg.windows(2).rposition(|pair| pair == END);
        let jpeg = &jpeg[..end.ok_or(Broken::Unfinished)? + 2];
        if has_tables(jpeg) {
            return decode_complete(jpeg, size, pixels);
        }
        // Many USB cameras leave the tables out that are always the same.
        self.completed.clear();
        self.completed.extend_from_slice(&START);
        self.completed.extend_from_slice(&AVI_SEGMENT);
        self.completed.extend_from_slice(&jpeg[START.len()..]);
        decode_complete(&self.completed, size, pixels)
    }
}

fn decode_complete(
    jpeg: &[u8],
    [width, height]: [usize; 2],
    pixels: &mut [u8],
) -> Result<(), Broken> {
    let damaged = |cause: zune_jpeg::errors::DecodeErrors| Broken::Jpeg(format!("{cause:?}"));
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(jpeg), options);
    decoder.decode_headers().map_err(damaged)?;
    let found = decoder.dimensions().unwrap_or_default();
    if found != (width, height) || decoder.output_buffer_size() != Some(width * height) {
        let (found_width, found_height) = found;
        return Err(Broken::Jpeg(format!(
            "a JPEG of {found_width}x{found_height} instead of {width}x{height}"
        )));
    }
    decoder.decode_into(pixels).map_err(damaged)
}

/// Whether Huffman tables stand before the coded pixels.
fn has_tables(jpeg: &[u8]) -> bool {
    let mut at = START.len();
    while let Some([0xff, marker, high, low]) = jpeg.get(at..at + 4) {
        match *marker {
            0xc4 => return true,
            START_OF_SCAN => return false,
            _ => at += 2 + usize::from(u16::from_be_bytes([*high, *low])),
        }
    }
    // What is no chain of segments is the decoder's to refuse.
    true
}

/// Width and height that a JPEG states.
pub(crate) fn dimensions(jpeg: &[u8]) -> Option<(usize, usize)> {
    let mut decoder = JpegDecoder::new(ZCursor::new(jpeg));
    decoder.decode_headers().ok()?;
    decoder.dimensions()
}

#[cfg(test)]
mod tests {
    use super::*;
    use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

    const SIZE: [usize; 2] = [37, 21];

    fn grey_at(n: usize) -> u8 {
        (20 + n % 37 * 4 + n / 37 * 3) as u8
    }

    /// A smooth picture with strong colours besides.
    fn picture(sampling: SamplingFactor) -> Vec<u8> {
        let mut jpeg = Vec::new();
        let pixels: Vec<u8> = (0..37 * 21).flat_map(|n| [grey_at(n), 60, 200]).collect();
        let mut encoder = Encoder::new(&mut jpeg, 95);
        encoder.set_sampling_factor(sampling);
        encoder.encode(&pixels, 37, 21, ColorType::Ycbcr).unwrap();
        jpeg
    }

    fn decoded(jpeg: &[u8]) -> Result<Vec<u8>, Broken> {
        let mut pixels = vec![0; 37 * 21];
        JpegLuma::default().decode(jpeg, SIZE, &mut pixels)?;
        Ok(pixels)
    }

    fn assert_is_the_picture(pixels: &[u8]) {
        for (n, pixel) in pixels.iter().enumerate() {
            assert!(pixel.abs_diff(grey_at(n)) <= 4, "{n}: {pixel}");
        }
    }

    /// A JPEG without its Huffman tables, as many USB cameras write them.
    fn without_tables(jpeg: &[u8]) -> Vec<u8> {
        let (mut bare, mut at) = (jpeg[..2].to_vec(), 2);
        loop {
            let length = usize::from(u16::from_be_bytes([jpeg[at + 2], jpeg[at + 3]])) + 2;
            if jpeg[at + 1] == START_OF_SCAN {
                bare.extend(&jpeg[at..]);
                return bare;
            }
            if jpeg[at + 1] != 0xc4 {
                bare.extend(&jpeg[at..at + length]);
            }
            at += length;
        }
    }

    #[test]
    fn the_luma_comes_out_whatever_the_chromas_sampling() {
        for sampling in [
            SamplingFactor::F_1_1,
            SamplingFactor::F_2_1,
            SamplingFactor::F_1_2,
            SamplingFactor::F_2_2,
        ] {
            assert_is_the_picture(&decoded(&picture(sampling)).unwrap());
        }
    }

    #[test]
    fn tables_that_are_left_out_are_the_standards() {
        let bare = without_tables(&picture(SamplingFactor::F_2_1));
        assert!(has_tables(&picture(SamplingFactor::F_2_1)) && !has_tables(&bare));
        assert_is_the_picture(&decoded(&bare).unwrap());
    }

    #[test]
    fn bytes_behind_the_end_are_passed_over() {
        let mut jpeg = picture(SamplingFactor::F_2_2);
        jpeg.extend([0; 100]);
        assert_is_the_picture(&decoded(&jpeg).unwrap());
    }

    #[test]
    fn another_size_no_end_and_no_jpeg_are_refused() {
        let jpeg = picture(SamplingFactor::F_2_2);
        let mut pixels = vec![0; 40 * 21];
        let other = JpegLuma::default().decode(&jpeg, [40, 21], &mut pixels);
        assert!(
            other
                .unwrap_err()
                .to_string()
                .contains("37x21 instead of 40x21")
        );
        assert_eq!(decoded(&jpeg[..jpeg.len() - 2]), Err(Broken::Unfinished));
        assert!(decoded(b"GIF89a").is_err());
        assert_eq!(dimensions(&jpeg), Some((37, 21)));
    }

    #[test]
    fn damaged_images_are_decoded_or_refused() {
        let jpeg = picture(SamplingFactor::F_2_2);
        for at in 2..jpeg.len() - 2 {
            for flip in [0xff, 0x01] {
                let mut damaged = jpeg.clone();
                damaged[at] ^= flip;
                let _ = decoded(&damaged);
                let _ = dimensions(&damaged);
            }
        }
    }
}
