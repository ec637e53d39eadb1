//! Grey images out of what cameras deliver: raw samples, luma among colour, Bayer mosaics, JPEG.
//!
//! Pure functions over byte slices. An image that is shorter than its format says is refused, never read past its end;
//! nothing allocates for an image but the JPEG decoder.
//!
//! - `samples`: where the samples lie in a row, and a row of them as bytes.
//! - `mosaic`: from the samples of a Bayer mosaic to grey, in place.
//! - `jpeg`: the luma of a JPEG.

mod jpeg;
mod mosaic;
mod samples;

use jpeg::JpegLuma;
pub(crate) use jpeg::dimensions as jpeg_dimensions;
use mosaic::MosaicFilter;
pub(crate) use samples::Samples;

/// How the pixels of an image are coded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Coding {
    /// Samples of grey or luma, row by row from the start of the image; chroma may follow behind the last row.
    Luma(Samples),
    /// Samples behind a Bayer filter; in which order its colours are does not matter.
    Mosaic(Samples),
    /// One JPEG an image.
    Jpeg,
}

/// Width, height and bytes from one row to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Geometry {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// At least the row's own bytes; of no meaning for JPEG.
    pub(crate) stride: usize,
}

/// A format of Video4Linux.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PixelFormat {
    /// Its code, as the kernel prints it.
    pub(crate) fourcc: [u8; 4],
    pub(crate) coding: Coding,
}

/// Why there is no grey image.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Broken {
    /// Fewer bytes than the format says.
    #[error("{bytes} bytes instead of {expected}")]
    Short { bytes: usize, expected: usize },
    /// A JPEG without its end.
    #[error("a JPEG without its end")]
    Unfinished,
    /// A JPEG that cannot be decoded, or of another size.
    #[error("{0}")]
    Jpeg(String),
}

/// Makes grey images of one camera's images; keeps its buffers.
#[derive(Debug)]
pub(crate) struct GreyReader {
    coding: Coding,
    geometry: Geometry,
    mosaic: MosaicFilter,
    jpeg: JpegLuma,
}

impl GreyReader {
    pub(crate) fn new(coding: Coding, geometry: Geometry) -> Self {
        let mosaic_width = match coding {
            Coding::Mosaic(_) => geometry.width,
            Coding::Luma(_) | Coding::Jpeg => 0,
        };
        Self {
            coding,
            geometry,
            mosaic: MosaicFilter::new(mosaic_width),
            jpeg: JpegLuma::default(),
        }
    }

    /// Fills `pixels` (width x height) from the bytes of an image.
    ///
    /// # Errors
    /// An image that is incomplete or damaged; `pixels` then hold anything.
    pub(crate) fn read(&mut self, image: &[u8], pixels: &mut [u8]) -> Result<(), Broken> {
        let Geometry { width, height, .. } = self.geometry;
        match self.coding {
            Coding::Luma(samples) => samples.read(image, self.geometry, pixels),
            Coding::Mosaic(samples) => {
                samples.read(image, self.geometry, pixels)?;
                self.mosaic.apply(pixels);
                Ok(())
            }
            Coding::Jpeg => self.jpeg.decode(image, [width, height], pixels),
        }
    }
}

const BYTES: Samples = Samples::Bytes { step: 1, first: 0 };
const EVEN_BYTES: Samples = Samples::Bytes { step: 2, first: 0 };
const ODD_BYTES: Samples = Samples::Bytes { step: 2, first: 1 };

const fn words(bits: u32) -> Samples {
    Samples::Words { bits }
}

const fn rgb(step: usize, [red, green, blue]: [usize; 3]) -> Samples {
    Samples::Rgb {
        step,
        red,
        green,
        blue,
    }
}

const fn luma(fourcc: &[u8; 4], samples: Samples) -> PixelFormat {
    PixelFormat {
        fourcc: *fourcc,
        coding: Coding::Luma(samples),
    }
}

const fn mosaic(fourcc: &[u8; 4], samples: Samples) -> PixelFormat {
    PixelFormat {
        fourcc: *fourcc,
        coding: Coding::Mosaic(samples),
    }
}

const fn jpeg(fourcc: &[u8; 4]) -> PixelFormat {
    PixelFormat {
        fourcc: *fourcc,
        coding: Coding::Jpeg,
    }
}

/// Every format that is read, the best first: grey as it is, then luma beside chroma, mosaics, colours, and JPEG, whose
/// compression moves corners and whose decoding costs most. Codes after `linux/videodev2.h`.
pub(crate) const FORMATS: &[PixelFormat] = &[
    luma(b"GREY", BYTES),
    luma(b"Y10P", Samples::Packed10),
    luma(b"Y12P", Samples::Packed12),
    luma(b"Y10 ", words(10)),
    luma(b"Y12 ", words(12)),
    luma(b"Y14 ", words(14)),
    luma(b"Y16 ", words(16)),
    luma(b"NV12", BYTES),
    luma(b"NM12", BYTES),
    luma(b"NV21", BYTES),
    luma(b"NM21", BYTES),
    luma(b"YU12", BYTES),
    luma(b"YM12", BYTES),
    luma(b"YV12", BYTES),
    luma(b"YM21", BYTES),
    luma(b"NV16", BYTES),
    luma(b"NM16", BYTES),
    luma(b"NV61", BYTES),
    luma(b"NM61", BYTES),
    luma(b"NV24", BYTES),
    luma(b"NV42", BYTES),
    luma(b"422P", BYTES),
    luma(b"411P", BYTES),
    luma(b"YUYV", EVEN_BYTES),
    luma(b"YVYU", EVEN_BYTES),
    luma(b"UYVY", ODD_BYTES),
    luma(b"VYUY", ODD_BYTES),
    mosaic(b"RGGB", BYTES),
    mosaic(b"GRBG", BYTES),
    mosaic(b"GBRG", BYTES),
    mosaic(b"BA81", BYTES),
    mosaic(b"pRAA", Samples::Packed10),
    mosaic(b"pgAA", Samples::Packed10),
    mosaic(b"pGAA", Samples::Packed10),
    mosaic(b"pBAA", Samples::Packed10),
    mosaic(b"RG10", words(10)),
    mosaic(b"BA10", words(10)),
    mosaic(b"GB10", words(10)),
    mosaic(b"BG10", words(10)),
    mosaic(b"pRCC", Samples::Packed12),
    mosaic(b"pgCC", Samples::Packed12),
    mosaic(b"pGCC", Samples::Packed12),
    mosaic(b"pBCC", Samples::Packed12),
    mosaic(b"RG12", words(12)),
    mosaic(b"BA12", words(12)),
    mosaic(b"GB12", words(12)),
    mosaic(b"BG12", words(12)),
    mosaic(b"RG16", words(16)),
    mosaic(b"GR16", words(16)),
    mosaic(b"GB16", words(16)),
    mosaic(b"BYR2", words(16)),
    luma(b"RGB3", rgb(3, [0, 1, 2])),
    luma(b"BGR3", rgb(3, [2, 1, 0])),
    luma(b"XR24", rgb(4, [2, 1, 0])),
    luma(b"AR24", rgb(4, [2, 1, 0])),
    luma(b"BGR4", rgb(4, [2, 1, 0])),
    luma(b"XB24", rgb(4, [0, 1, 2])),
    luma(b"AB24", rgb(4, [0, 1, 2])),
    luma(b"BX24", rgb(4, [1, 2, 3])),
    luma(b"BA24", rgb(4, [1, 2, 3])),
    luma(b"RGB4", rgb(4, [1, 2, 3])),
    jpeg(b"MJPG"),
    jpeg(b"JPEG"),
];

impl PixelFormat {
    /// The format of a code, if it is one that is read.
    pub(crate) fn from_fourcc(fourcc: [u8; 4]) -> Option<Self> {
        FORMATS
            .iter()
            .copied()
            .find(|format| format.fourcc == fourcc)
    }

    /// The code as text; bytes that are no printable ASCII appear as dots.
    pub(crate) fn name(fourcc: [u8; 4]) -> String {
        let printable = |byte: u8| match byte {
            b' '..=b'~' => char::from(byte),
            _ => '.',
        };
        let name: String = fourcc.into_iter().map(printable).collect();
        name.trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_stands_in_the_table_once() {
        for (index, format) in FORMATS.iter().enumerate() {
            let name = PixelFormat::name(format.fourcc);
            assert!(
                FORMATS[index + 1..]
                    .iter()
                    .all(|other| other.fourcc != format.fourcc),
                "{name}"
            );
            assert_eq!(PixelFormat::from_fourcc(format.fourcc), Some(*format));
        }
        assert_eq!(PixelFormat::from_fourcc(*b"H264"), None);
        assert_eq!(PixelFormat::name(*b"Y10 "), "Y10");
        assert_eq!(PixelFormat::name([b'Y', 0, b'6', 0xff]), "Y.6.");
    }

    /// Every format takes any bytes, of any length, into any image without a panic.
    #[test]
    fn any_bytes_are_an_image_or_refused() {
        let bytes: Vec<u8> = (0..600u32).map(|n| (n * 37 + n / 7) as u8).collect();
        for format in FORMATS {
            for (width, height, stride) in [(1, 1, 0), (7, 5, 3), (7, 5, 40), (16, 2, 16)] {
                let geometry = Geometry {
                    width,
                    height,
                    stride,
                };
                let mut reader = GreyReader::new(format.coding, geometry);
                for length in 0..=bytes.len() {
                    let mut pixels = vec![0; width * height];
                    let _ = reader.read(&bytes[..length], &mut pixels);
                    let _ = reader.read(&bytes[..length], &mut pixels[1..]);
                }
            }
        }
    }
}
