//! JPEG, PNM, WebP, TIFF and BMP.

use super::flaw::{Flaw, MAX_BYTES};
use super::grey::{Depth, GreyImage, Samples};
use super::jpeg_survey::survey;
use super::kind::PictureKind;
use image::codecs::{bmp, jpeg, pnm, tiff, webp};
use image::metadata::Orientation;
use image::{DynamicImage, GrayImage, ImageDecoder, ImageError, ImageResult, Limits};
use std::error::Error;
use std::io::{self, BufRead, Read, Seek};

/// For decoders that need three times the memory of the picture: 100 megapixels of grey.
const MAX_BYTES_OF_HEAVY: usize = 100_000_000;

/// Reads a picture of that kind, turned as its EXIF says.
pub(super) fn decode(kind: PictureKind, file: impl BufRead + Seek) -> Result<GreyImage, Flaw> {
    match kind {
        PictureKind::Jpeg => decode_jpeg(file),
        PictureKind::Pnm => read(pnm::PnmDecoder::new(file), "PNM", MAX_BYTES),
        PictureKind::Webp => read(webp::WebPDecoder::new(file), "WebP", MAX_BYTES_OF_HEAVY),
        PictureKind::Tiff => read(tiff::TiffDecoder::new(file), "TIFF", MAX_BYTES),
        _ => read(bmp::BmpDecoder::new(file), "BMP", MAX_BYTES),
    }
}

fn decode_jpeg(mut file: impl BufRead + Seek) -> Result<GreyImage, Flaw> {
    let mut bytes = Vec::new();
    let damaged = |error: io::Error| Flaw::damaged("JPEG", error);
    (&mut file)
        .take(MAX_BYTES as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(damaged)?;
    if bytes.len() > MAX_BYTES {
        return Err(Flaw::too_large(MAX_BYTES));
    }
    let found = survey(&bytes);
    drop(bytes);
    if !found.whole {
        return Err(Flaw::truncated());
    }
    let most = if found.progressive {
        MAX_BYTES_OF_HEAVY
    } else {
        MAX_BYTES
    };
    file.rewind().map_err(damaged)?;
    read(jpeg::JpegDecoder::new(file), "JPEG", most)
}

fn read<D: ImageDecoder>(
    decoder: ImageResult<D>,
    name: &'static str,
    most: usize,
) -> Result<GreyImage, Flaw> {
    let flawed = |error: ImageError| flaw(name, most, &error);
    let mut decoder = decoder.map_err(flawed)?;
    let length = usize::try_from(decoder.total_bytes())
        .ok()
        .filter(|length| *length <= most)
        .ok_or_else(|| Flaw::too_large(most))?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MAX_BYTES as u64);
    decoder.set_limits(limits).map_err(flawed)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let (width, height) = decoder.dimensions();
    let colour = decoder.color_type();
    let channels = usize::from(colour.channel_count());
    let depth = match usize::from(colour.bytes_per_pixel()) / channels.max(1) {
        1 => Depth::Eight,
        2 => Depth::Sixteen,
        _ => Depth::Float,
    };
    let mut bytes = vec![0; length];
    decoder.read_image(&mut bytes).map_err(flawed)?;
    let samples = Samples {
        size: [width as usize, height as usize],
        channels,
        depth,
        bytes,
    };
    Ok(turned(samples.into_grey(), orientation))
}

fn turned(picture: GreyImage, orientation: Orientation) -> GreyImage {
    if orientation == Orientation::NoTransforms {
        return picture;
    }
    let [width, height] = [picture.width, picture.height].map(|length| length as u32);
    let pixels = GrayImage::from_raw(width, height, picture.pixels).unwrap_or_default();
    let mut image = DynamicImage::ImageLuma8(pixels);
    image.apply_orientation(orientation);
    GreyImage {
        width: image.width() as usize,
        height: image.height() as usize,
        pixels: image.into_bytes(),
    }
}

fn flaw(name: &str, most: usize, error: &ImageError) -> Flaw {
    match error {
        _ if is_cut(error) => Flaw::truncated(),
        ImageError::Limits(_) => Flaw::too_large(most),
        ImageError::Unsupported(what) => {
            let cause = format!("a {name} of a kind that is not supported: {what}");
            Flaw::new(cause, "save it as PNG or as an ordinary JPEG")
        }
        other => Flaw::damaged(name, other),
    }
}

/// Whether the file ended before the picture did.
fn is_cut(error: &ImageError) -> bool {
    let mut cause: Option<&(dyn Error + 'static)> = Some(error);
    while let Some(current) = cause {
        let system = current.downcast_ref::<io::Error>();
        if system.is_some_and(|e| e.kind() == io::ErrorKind::UnexpectedEof) {
            return true;
        }
        cause = current.source();
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RecordingError, decode_picture};
    use image::{ExtendedColorType, ImageEncoder};
    use jpeg_encoder::{ColorType, Encoder};
    use proptest::prelude::*;
    use std::io::Cursor;
    use std::path::Path;

    const WIDTH: usize = 24;
    const HEIGHT: usize = 16;

    fn read(file: &[u8]) -> Result<GreyImage, RecordingError> {
        decode_picture(Cursor::new(file), Path::new("a"))
    }

    fn complaint(file: &[u8]) -> String {
        read(file).unwrap_err().to_string()
    }

    /// Bright in the upper left quarter, dark elsewhere.
    fn quarter(channels: usize) -> Vec<u8> {
        let of = |at: usize| match (at % WIDTH < WIDTH / 2, at / WIDTH < HEIGHT / 2) {
            (true, true) => 200,
            _ => 40,
        };
        (0..WIDTH * HEIGHT)
            .flat_map(|at| vec![of(at); channels])
            .collect()
    }

    /// The middles of the quarters: upper left, upper right, lower left, lower right.
    fn quarters(image: &GreyImage) -> [bool; 4] {
        let [x, y] = [image.width / 4, image.height / 4];
        [(x, y), (3 * x, y), (x, 3 * y), (3 * x, 3 * y)]
            .map(|(x, y)| image.pixels[y * image.width + x] > 120)
    }

    fn jpeg(colour: ColorType, progressive: bool, turn: Option<u8>) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = Encoder::new(&mut file, 95);
        encoder.set_progressive(progressive);
        if let Some(turn) = turn {
            let exif = [
                b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".as_slice(),
                &[turn, 0, 0, 0, 0, 0, 0],
            ];
            encoder.add_exif_metadata(&exif.concat()).unwrap();
        }
        let pixels = quarter(if colour == ColorType::Luma { 1 } else { 3 });
        encoder
            .encode(&pixels, WIDTH as u16, HEIGHT as u16, colour)
            .unwrap();
        file
    }

    /// A file of each kind, written by `image`, with exactly the pixels of [`quarter`].
    fn exact() -> Vec<Vec<u8>> {
        let [mut pnm, mut webp, mut tiff, mut bmp] = [const { Vec::new() }; 4];
        let [width, height] = [WIDTH as u32, HEIGHT as u32];
        let grey = ExtendedColorType::L8;
        pnm::PnmEncoder::new(&mut pnm)
            .write_image(&quarter(1), width, height, grey)
            .unwrap();
        webp::WebPEncoder::new_lossless(&mut webp)
            .write_image(&quarter(3), width, height, ExtendedColorType::Rgb8)
            .unwrap();
        tiff::TiffEncoder::new(Cursor::new(&mut tiff))
            .write_image(&quarter(1), width, height, grey)
            .unwrap();
        bmp::BmpEncoder::new(&mut bmp)
            .write_image(&quarter(3), width, height, ExtendedColorType::Rgb8)
            .unwrap();
        vec![pnm, webp, tiff, bmp]
    }

    fn all() -> Vec<Vec<u8>> {
        let mut files = exact();
        files.push(jpeg(ColorType::Rgb, false, Some(6)));
        files.push(jpeg(ColorType::Luma, true, None));
        files
    }

    #[test]
    fn jpegs_are_read() {
        for colour in [ColorType::Luma, ColorType::Rgb] {
            for progressive in [false, true] {
                let image = read(&jpeg(colour, progressive, None)).unwrap();
                assert_eq!((image.width, image.height), (WIDTH, HEIGHT));
                assert_eq!(quarters(&image), [true, false, false, false]);
                let near = |at: usize, grey: u8| image.pixels[at].abs_diff(grey) <= 3;
                assert!(near(0, 200) && near(WIDTH * HEIGHT - 1, 40));
            }
        }
    }

    #[test]
    fn a_jpeg_is_turned_as_its_exif_says() {
        for (turn, size, bright) in [
            (1, (WIDTH, HEIGHT), [true, false, false, false]),
            (2, (WIDTH, HEIGHT), [false, true, false, false]),
            (3, (WIDTH, HEIGHT), [false, false, false, true]),
            (6, (HEIGHT, WIDTH), [false, true, false, false]),
            (8, (HEIGHT, WIDTH), [false, false, true, false]),
        ] {
            let image = read(&jpeg(ColorType::Rgb, false, Some(turn))).unwrap();
            assert_eq!((image.width, image.height), size, "{turn}");
            assert_eq!(quarters(&image), bright, "{turn}");
        }
    }

    #[test]
    fn other_kinds_are_read_exactly() {
        for file in exact() {
            let image = read(&file).unwrap();
            assert_eq!((image.width, image.height), (WIDTH, HEIGHT));
            assert_eq!(image.pixels, quarter(1));
        }
    }

    #[test]
    fn pnm_as_text_and_of_twelve_bits_is_read() {
        let text = read(b"P2\n# a comment\n2 1\n255\n7 200\n").unwrap();
        assert_eq!(text.pixels, [7, 200]);
        let deep = read(b"P5 3 1 4095\n\x0f\xff\x07\xff\0\0").unwrap();
        assert_eq!(deep.pixels, [255, 127, 0]);
    }

    #[test]
    fn a_cut_picture_is_named_so() {
        for file in [
            jpeg(ColorType::Rgb, false, None),
            jpeg(ColorType::Luma, true, None),
        ] {
            for length in [3, 30, file.len() / 2, file.len() - 1] {
                let message = complaint(&file[..length]);
                assert!(
                    message.starts_with("a: the picture is truncated; "),
                    "{message}"
                );
            }
        }
        for file in exact() {
            let message = complaint(&file[..file.len() / 2]);
            assert!(
                message.contains("truncated") || message.contains("damaged"),
                "{message}"
            );
        }
    }

    #[test]
    fn a_damaged_jpeg_is_named_so() {
        let message = complaint(b"\xff\xd8\xff\xe0\x00\x04AB\xff\xd9");
        assert!(message.starts_with("a: the JPEG is damaged: "), "{message}");
    }

    #[test]
    fn a_picture_that_asks_for_much_memory_is_refused() {
        let message = complaint(b"P6 60000 60000 255\n");
        assert!(message.contains("more than 384 MB"), "{message}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn changed_bytes_never_panic(
            which in 0..6_usize,
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            cut in prop::option::of(any::<prop::sample::Index>()),
        ) {
            let mut file = all().swap_remove(which);
            for (at, byte) in changes {
                let at = at.index(file.len());
                file[at] = byte;
            }
            if let Some(cut) = cut {
                file.truncate(cut.index(file.len()));
            }
            if let Ok(image) = read(&file) {
                prop_assert_eq!(image.pixels.len(), image.width * image.height);
            }
        }
    }
}
