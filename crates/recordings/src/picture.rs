//! Pictures as people have them, read as 8-bit grey by what is in the file, and PNG files written.

mod flaw;
mod grey;
#[cfg(feature = "pictures")]
mod jpeg_survey;
mod kind;
#[cfg(feature = "pictures")]
mod others;
mod png_file;

use crate::error::RecordingError;
use flaw::Flaw;
pub use grey::GreyImage;
use kind::{HEAD, PictureKind};
use png::ColorType;
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Seek, Write};
use std::path::Path;

/// A colour picture: `3 * width * height` bytes, red, green and blue of each pixel, row after row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColourImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue values.
    pub pixels: Vec<u8>,
}

/// Reads a picture as 8-bit grey. What it is, its content says, not its name: PNG of any kind and, with the feature
/// `pictures`, JPEG, PNM, WebP, TIFF and BMP, turned as EXIF or TIFF say.
///
/// Colour becomes grey (luma after ITU-R BT.601). What is transparent becomes white, as paper behind the picture would.
/// Of a picture with more than 8 bits the range that is in it is kept: its darkest pixels become 0 and its brightest
/// 255, but for a few that stand out. A camera's 12 bits in a file of 16 are therefore not dark, nor is the narrow
/// range of a thermal camera flat.
///
/// # Errors
/// A file that is missing, no picture of a kind that is read, truncated, damaged, or of more than 384 MB once it is
/// decoded (100 MB of a progressive JPEG or a WebP).
pub fn read_picture(path: &Path) -> Result<GreyImage, RecordingError> {
    let file = File::open(path).map_err(RecordingError::unreadable(path, CHECK))?;
    decode_picture(BufReader::new(file), path)
}

/// The same of a picture that is open, or in memory; `path` is for what errors say.
///
/// # Errors
/// As [`read_picture`].
pub fn decode_picture(
    mut file: impl BufRead + Seek,
    path: &Path,
) -> Result<GreyImage, RecordingError> {
    let head = head_of(&mut file).map_err(RecordingError::unreadable(path, CHECK))?;
    decode(PictureKind::from_head(&head), file)
        .map_err(|flaw| RecordingError::wrong(path, None, flaw.cause, flaw.remedy))
}

/// Endings of the names of pictures. A file so named that is none is reported as a fault, not a file of another
/// purpose.
const ENDINGS: [&str; 12] = [
    "png", "jpg", "jpeg", "pgm", "ppm", "pnm", "webp", "tif", "tiff", "bmp", "gif", "heic",
];

/// Whether a file is a picture by its first bytes, or is named like one.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn is_picture(path: &Path) -> Result<bool, RecordingError> {
    let ending = path.extension().unwrap_or_default();
    if ENDINGS
        .iter()
        .any(|known| ending.eq_ignore_ascii_case(known))
    {
        return Ok(true);
    }
    let read = File::open(path).and_then(|file| head_of(&mut BufReader::new(file)));
    let head = read.map_err(RecordingError::unreadable(path, CHECK))?;
    Ok(PictureKind::from_head(&head).is_read())
}

/// Whether these bytes begin a PNG of 8-bit grey, which is what recordings in one file consist of.
#[must_use]
pub fn is_grey_png(bytes: &[u8]) -> bool {
    png_file::is_grey(bytes)
}

const CHECK: &str = "check the path";
const SAVE_AS_PNG: &str = "save it as PNG, for example with `magick IN OUT.png`";

fn head_of(file: &mut (impl BufRead + Seek)) -> io::Result<Vec<u8>> {
    let mut head = Vec::with_capacity(HEAD);
    file.by_ref().take(HEAD as u64).read_to_end(&mut head)?;
    file.rewind()?;
    Ok(head)
}

fn decode(kind: PictureKind, file: impl BufRead + Seek) -> Result<GreyImage, Flaw> {
    let cause = match kind {
        PictureKind::Png => return Ok(png_file::decode(file)?.into_grey()),
        PictureKind::Jpeg
        | PictureKind::Pnm
        | PictureKind::Webp
        | PictureKind::Tiff
        | PictureKind::Bmp => {
            return decode_other(kind, file);
        }
        PictureKind::Other(name) => format!("{name}, which is not supported"),
        PictureKind::Unknown => format!("no picture that is known ({KNOWN})"),
        PictureKind::Empty => {
            return Err(Flaw::new("the file is empty", "copy or record it again"));
        }
    };
    Err(Flaw::new(cause, SAVE_AS_PNG))
}

#[cfg(feature = "pictures")]
const KNOWN: &str = "JPEG, PNG, PNM, WebP, TIFF, BMP";
#[cfg(not(feature = "pictures"))]
const KNOWN: &str = "PNG";

#[cfg(feature = "pictures")]
use others::decode as decode_other;

#[cfg(not(feature = "pictures"))]
fn decode_other(kind: PictureKind, _: impl BufRead + Seek) -> Result<GreyImage, Flaw> {
    let name = format!("{kind:?}").to_uppercase();
    let cause = format!("a {name} picture, and this program reads only PNG");
    Err(Flaw::new(cause, SAVE_AS_PNG))
}

/// Writes a PNG of 8-bit grey. Not atomic: for folders of pictures that are made as a whole.
///
/// # Errors
/// What the system refuses, and a picture whose size and pixels disagree.
pub fn write_grey_png(path: &Path, image: &GreyImage) -> Result<(), RecordingError> {
    let size = [image.width, image.height];
    write_png(path, size, ColorType::Grayscale, &image.pixels)
}

/// A PNG of 8-bit grey in memory.
///
/// # Errors
/// A picture whose size and pixels disagree.
pub fn grey_png(image: &GreyImage) -> Result<Vec<u8>, RecordingError> {
    let mut png = Vec::with_capacity(image.pixels.len());
    let size = [image.width, image.height];
    png_file::encode(&mut png, size, ColorType::Grayscale, &image.pixels).map_err(|error| {
        RecordingError::wrong(Path::new("PNG"), None, error.to_string(), REPORT)
    })?;
    Ok(png)
}

/// Writes a PNG of 8-bit colour, like [`write_grey_png`].
///
/// # Errors
/// What the system refuses, and a picture whose size and pixels disagree.
pub fn write_colour_png(path: &Path, image: &ColourImage) -> Result<(), RecordingError> {
    let size = [image.width, image.height];
    write_png(path, size, ColorType::Rgb, &image.pixels)
}

fn write_png(
    path: &Path,
    size: [usize; 2],
    colour: ColorType,
    bytes: &[u8],
) -> Result<(), RecordingError> {
    let unwritable = |source| RecordingError::Unreadable {
        path: path.to_owned(),
        source,
        remedy: "check the folder and the space on the disk",
    };
    let mut sink = BufWriter::new(File::create(path).map_err(unwritable)?);
    let written = png_file::encode(&mut sink, size, colour, bytes);
    written.map_err(|error| RecordingError::wrong(path, None, error.to_string(), REPORT))?;
    sink.flush().map_err(unwritable)
}

const REPORT: &str = "report this";

#[cfg(test)]
mod tests {
    use super::*;
    use png::BitDepth;
    use std::fs;
    use std::io::Cursor;

    fn written(colour: ColorType, depth: BitDepth, bytes: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 2, 2);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(vec![255, 0, 0, 9, 9, 9]);
            encoder.set_trns(vec![0, 255]);
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(bytes).unwrap();
        writer.finish().unwrap();
        file
    }

    fn read(file: &[u8]) -> Result<Vec<u8>, String> {
        let image = decode_picture(Cursor::new(file), Path::new("a.png"));
        let image = image.map_err(|error| error.to_string())?;
        assert_eq!((image.width, image.height), (2, 2));
        Ok(image.pixels)
    }

    #[test]
    fn grey_comes_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let image = GreyImage {
            width: 3,
            height: 2,
            pixels: vec![0, 1, 2, 253, 254, 255],
        };
        write_grey_png(&path, &image).unwrap();
        assert_eq!(read_picture(&path).unwrap(), image);
        assert!(is_grey_png(&fs::read(&path).unwrap()));
    }

    #[test]
    fn colour_becomes_grey() {
        let colours = [255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9];
        let rgb = written(ColorType::Rgb, BitDepth::Eight, &colours);
        assert_eq!(read(&rgb).unwrap(), [76, 150, 29, 9]);
        assert!(!is_grey_png(&rgb));
    }

    #[test]
    fn palettes_become_grey_and_transparency_white() {
        let palette = written(ColorType::Indexed, BitDepth::One, &[0x80, 0x40]);
        assert_eq!(read(&palette).unwrap(), [9, 255, 255, 9]);
        let alpha = [7, 0, 8, 255, 9, 128, 10, 1];
        let alpha = written(ColorType::GrayscaleAlpha, BitDepth::Eight, &alpha);
        assert_eq!(read(&alpha).unwrap(), [255, 8, 132, 254]);
    }

    #[test]
    fn few_bits_are_spread_over_eight() {
        let bits = written(ColorType::Grayscale, BitDepth::One, &[0x80, 0x40]);
        assert_eq!(read(&bits).unwrap(), [255, 0, 0, 255]);
    }

    #[test]
    fn twelve_bits_in_sixteen_are_not_dark() {
        let values = [0, 1000, 2000, 4000_u16].map(u16::to_be_bytes).concat();
        let deep = written(ColorType::Grayscale, BitDepth::Sixteen, &values);
        assert_eq!(read(&deep).unwrap(), [0, 64, 128, 255]);
    }

    /// The decoder would panic.
    #[test]
    fn a_palette_of_an_impossible_length_is_refused() {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(ColorType::Indexed);
        encoder.set_palette(vec![9; 4]);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[0, 0]).unwrap();
        writer.finish().unwrap();
        let message = read(&bytes).unwrap_err();
        assert!(message.contains("palette of 4 bytes"), "{message}");
    }

    #[test]
    fn a_cut_picture_is_refused_wherever_it_is_cut() {
        let whole = written(ColorType::Grayscale, BitDepth::Eight, &[1, 2, 3, 4]);
        for length in 0..whole.len() {
            let message = read(&whole[..length]).unwrap_err();
            assert!(message.starts_with("a.png: "), "{length}: {message}");
        }
        let message = read(&whole[..whole.len() - 20]).unwrap_err();
        assert!(message.contains("truncated"), "{message}");
    }

    #[test]
    fn a_changed_byte_is_refused() {
        let mut file = written(ColorType::Grayscale, BitDepth::Eight, &[1, 2, 3, 4]);
        file[20] ^= 1;
        let message = read(&file).unwrap_err();
        assert!(
            message.starts_with("a.png: the PNG is damaged: "),
            "{message}"
        );
    }

    #[test]
    fn what_is_no_picture_that_is_read_is_named() {
        for (bytes, expected) in [
            (&b""[..], "the file is empty; "),
            (b"hello, this is text", "no picture that is known ("),
            (b"GIF89a", "a GIF picture, which is not supported; save"),
            (
                b"\0\0\0\x18ftypheic",
                "a HEIC picture, which is not supported; save",
            ),
        ] {
            let message = read(bytes).unwrap_err();
            let expected = format!("a.png: {expected}");
            assert!(message.starts_with(&expected), "{message}");
        }
        let missing = read_picture(Path::new("/nowhere/a.png")).unwrap_err();
        assert_eq!(
            missing.to_string(),
            "/nowhere/a.png: there is no such file or folder; check the path"
        );
        let folder = tempfile::tempdir().unwrap();
        let message = read_picture(folder.path()).unwrap_err().to_string();
        assert!(message.contains("this is a folder"), "{message}");
    }

    #[cfg(not(feature = "pictures"))]
    #[test]
    fn a_program_without_them_names_other_pictures() {
        let message = read(b"\xff\xd8\xff\xe0").unwrap_err();
        let expected = "a.png: a JPEG picture, and this program reads only PNG; save";
        assert!(message.starts_with(expected), "{message}");
    }
}
