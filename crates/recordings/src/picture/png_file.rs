//! PNG of any kind read, of 8 bits written.

use super::flaw::{Flaw, MAX_BYTES};
use super::grey::{Depth, Samples};
use png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Transformations};
use std::io::{BufRead, Seek, Write};

/// Reads a PNG: palettes become colours, fewer than 8 bits become 8.
pub(super) fn decode(file: impl BufRead + Seek) -> Result<Samples, Flaw> {
    let limits = Limits { bytes: MAX_BYTES };
    let mut decoder = Decoder::new_with_limits(file, limits);
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(flaw)?;
    let length = reader
        .output_buffer_size()
        .filter(|length| *length <= MAX_BYTES)
        .ok_or_else(|| Flaw::too_large(MAX_BYTES))?;
    if let Some(palette) = &reader.info().palette
        && (palette.len() % 3 != 0 || palette.len() > 3 * 256)
    {
        // The decoder would panic.
        return Err(Flaw::damaged(
            "PNG",
            format!("a palette of {} bytes", palette.len()),
        ));
    }
    let mut bytes = vec![0; length];
    let info = reader.next_frame(&mut bytes).map_err(flaw)?;
    // What follows the pixels tells whether the file is whole.
    reader.finish().map_err(flaw)?;
    bytes.truncate(info.buffer_size());
    let depth = match info.bit_depth {
        BitDepth::Sixteen => Depth::SixteenBigEndian,
        _ => Depth::Eight,
    };
    Ok(Samples {
        size: [info.width as usize, info.height as usize],
        channels: info.color_type.samples(),
        depth,
        bytes,
    })
}

fn flaw(error: DecodingError) -> Flaw {
    match error {
        DecodingError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            Flaw::truncated()
        }
        DecodingError::LimitsExceeded => Flaw::too_large(MAX_BYTES),
        other => Flaw::damaged("PNG", other),
    }
}

/// Writes a PNG of 8 bits.
pub(super) fn encode(
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

/// Whether these bytes begin a PNG of 8-bit grey.
pub(super) fn is_grey(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.get(24..26) == Some(&[8, 0])
}
