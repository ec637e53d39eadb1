//! 8-bit pictures as PNG files.

use crate::error::RecordingError;
use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Seek, Write};
use std::path::Path;

/// More memory than any picture that a camera here takes; a malicious one asks for more.
const MAX_BYTES: usize = 256 << 20;

/// A grey picture: `width * height` bytes, row after row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GreyImage {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Grey values.
    pub pixels: Vec<u8>,
}

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

/// Reads a PNG of 8-bit grey: what recordings consist of.
///
/// # Errors
/// A file that is missing, no PNG, truncated or damaged, of colour, or not of 8 bits.
pub fn read_grey_png(path: &Path) -> Result<GreyImage, RecordingError> {
    let picture = read_png(path)?;
    match picture.colour {
        ColorType::Grayscale => Ok(picture.into_grey()),
        other => {
            let cause = format!("a picture of colour type {other:?} instead of 8-bit grey");
            Err(RecordingError::wrong(path, None, cause, TO_GREY))
        }
    }
}

/// Reads a PNG of 8 bits, grey or colour; colour becomes grey (luma after ITU-R BT.601), transparency is ignored.
///
/// # Errors
/// A file that is missing, no PNG, truncated or damaged, or of 16 bits.
pub fn read_any_png(path: &Path) -> Result<GreyImage, RecordingError> {
    Ok(read_png(path)?.into_grey())
}

/// The same of a PNG that is open, or in memory; `path` is for what errors say.
///
/// # Errors
/// As [`read_any_png`].
pub fn decode_any_png(file: impl BufRead + Seek, path: &Path) -> Result<GreyImage, RecordingError> {
    Ok(decode_png(file, path)?.into_grey())
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
    encode_png(&mut png, size, ColorType::Grayscale, &image.pixels).map_err(|error| {
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
    let written = encode_png(&mut sink, size, colour, bytes);
    written.map_err(|error| RecordingError::wrong(path, None, error.to_string(), REPORT))?;
    sink.flush().map_err(unwritable)
}

const REPORT: &str = "report this";

fn encode_png(
    sink: impl Write,
    size: [usize; 2],
    colour: ColorType,
    bytes: &[u8],
) -> Result<(), png::EncodingError> {
    let [width, height] = size.map(|length| u32::try_from(length).unwrap_or(u32::MAX));
    let mut encoder = png::Encoder::new(sink, width, height);
    encoder.set_color(colour);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.write_header()?.write_image_data(bytes)
}

const TO_GREY: &str =
    "convert it to 8-bit grey, for example with `convert IN -colorspace Gray -depth 8 OUT`";

struct Picture {
    width: usize,
    height: usize,
    colour: ColorType,
    bytes: Vec<u8>,
}

fn read_png(path: &Path) -> Result<Picture, RecordingError> {
    let remedy = "check the path";
    let file = File::open(path).map_err(RecordingError::unreadable(path, remedy))?;
    decode_png(BufReader::new(file), path)
}

fn decode_png(file: impl BufRead + Seek, path: &Path) -> Result<Picture, RecordingError> {
    let flawed = |error: DecodingError| flaw(path, &error);
    let limits = Limits { bytes: MAX_BYTES };
    let mut decoder = Decoder::new_with_limits(file, limits);
    // Palettes become colours, fewer than 8 bits become 8.
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(flawed)?;
    let length = reader
        .output_buffer_size()
        .filter(|length| *length <= MAX_BYTES);
    let Some(length) = length else {
        let cause = "a picture of more than 256 MB";
        return Err(RecordingError::wrong(path, None, cause, "make it smaller"));
    };
    if reader.info().bit_depth == BitDepth::Sixteen {
        let cause = "a picture of 16 bits instead of 8";
        return Err(RecordingError::wrong(path, None, cause, TO_GREY));
    }
    if let Some(palette) = &reader.info().palette
        && (palette.len() % 3 != 0 || palette.len() > 3 * 256)
    {
        let cause = format!("a palette of {} bytes", palette.len());
        return Err(RecordingError::wrong(path, None, cause, TO_GREY));
    }
    let mut bytes = vec![0; length];
    let info = reader.next_frame(&mut bytes).map_err(flawed)?;
    // What follows the pixels tells whether the file is whole.
    reader.finish().map_err(flawed)?;
    bytes.truncate(info.buffer_size());
    Ok(Picture {
        width: info.width as usize,
        height: info.height as usize,
        colour: info.color_type,
        bytes,
    })
}

fn flaw(path: &Path, error: &DecodingError) -> RecordingError {
    let ended =
        matches!(error, DecodingError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof);
    if ended {
        let remedy = "copy or record it again";
        return RecordingError::wrong(path, None, "the picture is truncated", remedy);
    }
    let cause = format!("no sound PNG: {error}");
    RecordingError::wrong(path, None, cause, "give an undamaged PNG file")
}

impl Picture {
    fn into_grey(self) -> GreyImage {
        let Self {
            width,
            height,
            colour,
            bytes,
        } = self;
        let pixels = match colour {
            ColorType::Grayscale => bytes,
            ColorType::GrayscaleAlpha => bytes.chunks_exact(2).map(|p| p[0]).collect(),
            ColorType::Rgb => bytes.chunks_exact(3).map(luma).collect(),
            ColorType::Rgba | ColorType::Indexed => bytes.chunks_exact(4).map(luma).collect(),
        };
        GreyImage {
            width,
            height,
            pixels,
        }
    }
}

/// 0.299 R + 0.587 G + 0.114 B, rounded.
fn luma(pixel: &[u8]) -> u8 {
    let [red, green, blue] = [pixel[0], pixel[1], pixel[2]].map(u32::from);
    ((299 * red + 587 * green + 114 * blue + 500) / 1000) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::io::Cursor;

    fn written(colour: ColorType, depth: BitDepth, bytes: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 2, 2);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(bytes).unwrap();
        writer.finish().unwrap();
        file
    }

    fn read(
        file: &[u8],
        reader: fn(&Path) -> Result<GreyImage, RecordingError>,
    ) -> Result<Vec<u8>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, file).unwrap();
        let root = format!("{}/", folder.path().display());
        let image = reader(&path).map_err(|error| error.to_string().replace(&root, ""))?;
        assert_eq!((image.width, image.height), (2, 2));
        Ok(image.pixels)
    }

    #[test]
    fn grey_comes_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let image = GreyImage {
            width: 3,
            height: 2,
            pixels: vec![0, 1, 2, 253, 254, 255],
        };
        write_grey_png(&path, &image).unwrap();
        assert_eq!(read_grey_png(&path).unwrap(), image);
        assert_eq!(read_any_png(&path).unwrap(), image);
    }

    #[test]
    fn colour_becomes_grey_only_where_that_is_wanted() {
        let rgb = written(
            ColorType::Rgb,
            BitDepth::Eight,
            &[255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9],
        );
        assert_eq!(read(&rgb, read_any_png).unwrap(), [76, 150, 29, 9]);
        let message = read(&rgb, read_grey_png).unwrap_err();
        assert!(
            message.starts_with("a.png: a picture of colour type Rgb instead of 8-bit grey"),
            "{message}"
        );
    }

    #[test]
    fn few_bits_are_spread_over_eight() {
        let bits = written(ColorType::Grayscale, BitDepth::One, &[0x80, 0x40]);
        assert_eq!(read(&bits, read_grey_png).unwrap(), [255, 0, 0, 255]);
    }

    #[test]
    fn sixteen_bits_are_refused() {
        let deep = written(ColorType::Grayscale, BitDepth::Sixteen, &[0; 8]);
        for reader in [read_grey_png, read_any_png] {
            let message = read(&deep, reader).unwrap_err();
            assert!(
                message.starts_with("a.png: a picture of 16 bits instead of 8; convert"),
                "{message}"
            );
        }
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
        let error = decode_any_png(Cursor::new(&bytes), Path::new("a.png")).unwrap_err();
        assert!(error.to_string().contains("palette of 4 bytes"), "{error}");
    }

    #[test]
    fn a_cut_picture_is_refused_wherever_it_is_cut() {
        let whole = written(ColorType::Grayscale, BitDepth::Eight, &[1, 2, 3, 4]);
        for length in 0..whole.len() {
            let message = read(&whole[..length], read_grey_png).unwrap_err();
            assert!(message.starts_with("a.png: "), "{length}: {message}");
        }
        let message = read(&whole[..whole.len() - 20], read_grey_png).unwrap_err();
        assert!(message.contains("truncated"), "{message}");
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        let message = read(b"hello, this is text", read_grey_png).unwrap_err();
        assert!(message.starts_with("a.png: no sound PNG: "), "{message}");
        let missing = read_grey_png(Path::new("/nowhere/a.png")).unwrap_err();
        assert_eq!(
            missing.to_string(),
            "/nowhere/a.png: there is no such file or folder; check the path"
        );
    }
}
