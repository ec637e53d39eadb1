//! Images out of a stream of bytes that a program writes. Planes go straight from the pipe into the image; only JPEGs
//! and headers are kept on their way.

use super::jpeg_stream::JpegStream;
use crate::config::StreamFormat;
use crate::source::pixel_formats::{Broken, Coding, Geometry, GreyReader, jpeg_dimensions};

/// How much is taken from the pipe at once of what does not go straight into the image.
const CHUNK_BYTES: usize = 64 << 10;
/// The longest header of a YUV4MPEG2 stream.
const MAX_LINE_BYTES: usize = 4096;

/// Reads images from a stream: [`FrameReader::room`] says where the next bytes go, [`FrameReader::filled`] that they
/// are there, and [`FrameReader::complete`] whether that makes an image.
#[derive(Debug)]
pub(super) struct FrameReader {
    kind: FrameKind,
    chunk: Box<[u8]>,
}

#[derive(Debug)]
enum FrameKind {
    Planes(Planes),
    Y4m {
        line: Vec<u8>,
        planes: Option<Planes>,
        is_in_planes: bool,
    },
    Jpegs(Box<Jpegs>),
}

#[derive(Debug)]
struct Jpegs {
    stream: JpegStream,
    /// The first image, from which the size was read, until it is decoded.
    first: Option<Vec<u8>>,
    decoder: Option<(GreyReader, [usize; 2])>,
}

/// A stream that is not what it shall be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub(super) struct NotThatFormat(String);

impl FrameReader {
    /// A reader of a format; a size that is given holds. Rows of raw planes have the length, bytes.
    pub(super) fn new(format: StreamFormat, size: Option<[usize; 2]>, row_length: usize) -> Self {
        let size_of_planes = size.unwrap_or_default();
        let planes = |chroma| FrameKind::Planes(Planes::new(size_of_planes, row_length, chroma));
        let kind = match format {
            StreamFormat::Grey => planes(Chroma::None),
            StreamFormat::Yuv420 => planes(Chroma::Quarter),
            StreamFormat::Y4m => FrameKind::Y4m {
                line: Vec::new(),
                planes: None,
                is_in_planes: false,
            },
            StreamFormat::Mjpeg => FrameKind::Jpegs(Box::new(Jpegs {
                stream: JpegStream::default(),
                first: None,
                decoder: size.map(jpeg_decoder),
            })),
        };
        Self {
            kind,
            chunk: vec![0; CHUNK_BYTES].into(),
        }
    }

    /// Width and height, once they are known.
    pub(super) fn size(&self) -> Option<[usize; 2]> {
        match &self.kind {
            FrameKind::Planes(planes) => Some(planes.size),
            FrameKind::Y4m { planes, .. } => planes.as_ref().map(|planes| planes.size),
            FrameKind::Jpegs(jpegs) => jpegs.decoder.as_ref().map(|(_, size)| *size),
        }
    }

    /// Whether some bytes of an image are there, and not all.
    pub(super) fn is_within_image(&self) -> bool {
        match &self.kind {
            FrameKind::Planes(planes) => planes.at > 0,
            FrameKind::Y4m {
                line,
                planes,
                is_in_planes,
            } => planes.is_some() && (*is_in_planes || !line.is_empty()),
            FrameKind::Jpegs(jpegs) => jpegs.stream.is_within_image(),
        }
    }

    /// Where the next bytes of the stream go; never empty unless `pixels` are too few.
    pub(super) fn room<'a>(&'a mut self, pixels: &'a mut [u8]) -> &'a mut [u8] {
        match &self.kind {
            FrameKind::Planes(planes) => planes.room(pixels, &mut self.chunk),
            FrameKind::Y4m {
                planes: Some(planes),
                is_in_planes: true,
                ..
            } => planes.room(pixels, &mut self.chunk),
            FrameKind::Y4m { .. } => &mut self.chunk[..1],
            FrameKind::Jpegs(_) => &mut self.chunk,
        }
    }

    /// So many bytes were put there.
    ///
    /// # Errors
    /// A header that says nothing that is known here.
    pub(super) fn filled(&mut self, count: usize) -> Result<(), NotThatFormat> {
        match &mut self.kind {
            FrameKind::Planes(planes) => planes.at += count,
            FrameKind::Y4m {
                planes: Some(planes),
                is_in_planes: true,
                ..
            } => planes.at += count,
            FrameKind::Y4m {
                line,
                planes,
                is_in_planes,
            } => {
                line.extend_from_slice(&self.chunk[..count]);
                if line.len() > MAX_LINE_BYTES {
                    return Err(NotThatFormat("no YUV4MPEG2 stream".to_owned()));
                }
                if line.last() == Some(&b'\n') {
                    match planes {
                        None => *planes = Some(Planes::of_header(line)?),
                        Some(_) if line.starts_with(b"FRAME") => *is_in_planes = true,
                        Some(_) => {
                            return Err(NotThatFormat(
                                "a YUV4MPEG2 stream that lost its frames".to_owned(),
                            ));
                        }
                    }
                    line.clear();
                }
            }
            FrameKind::Jpegs(jpegs) => jpegs.push(&self.chunk[..count])?,
        }
        Ok(())
    }

    /// Whether an image is complete; it then is in `pixels`, or it was broken.
    pub(super) fn complete(&mut self, pixels: &mut [u8]) -> Option<Result<(), Broken>> {
        match &mut self.kind {
            FrameKind::Planes(planes) => planes.take().then_some(Ok(())),
            FrameKind::Y4m {
                planes: Some(planes),
                is_in_planes,
                ..
            } => {
                let is_complete = *is_in_planes && planes.take();
                *is_in_planes &= !is_complete;
                is_complete.then_some(Ok(()))
            }
            FrameKind::Y4m { planes: None, .. } => None,
            FrameKind::Jpegs(jpegs) => jpegs.complete(pixels),
        }
    }
}

impl Jpegs {
    /// Takes bytes of the stream; the first image says the size, where it is not given.
    fn push(&mut self, bytes: &[u8]) -> Result<(), NotThatFormat> {
        self.stream.push(bytes);
        if self.decoder.is_none()
            && let Some(jpeg) = self.stream.next()
        {
            let (width, height) = jpeg_dimensions(jpeg)
                .ok_or_else(|| NotThatFormat("a JPEG without a size".to_owned()))?;
            self.decoder = Some(jpeg_decoder([width, height]));
            self.first = Some(jpeg.to_vec());
        }
        Ok(())
    }

    fn complete(&mut self, pixels: &mut [u8]) -> Option<Result<(), Broken>> {
        let (decoder, _) = self.decoder.as_mut()?;
        match self.first.take() {
            Some(jpeg) => Some(decoder.read(&jpeg, pixels)),
            None => self.stream.next().map(|jpeg| decoder.read(jpeg, pixels)),
        }
    }
}

fn jpeg_decoder(size: [usize; 2]) -> (GreyReader, [usize; 2]) {
    let [width, height] = size;
    let geometry = Geometry {
        width,
        height,
        stride: 0,
    };
    (GreyReader::new(Coding::Jpeg, geometry), size)
}

/// A plane of luma with chroma behind it that is passed over.
#[derive(Debug)]
struct Planes {
    size: [usize; 2],
    /// Bytes from one row of the luma to the next, at least its width.
    row_length: usize,
    image_bytes: usize,
    at: usize,
}

/// Chroma planes in shares of the luma.
#[derive(Debug, Clone, Copy)]
enum Chroma {
    None,
    /// Two of half the width and height.
    Quarter,
    /// Two of half the width.
    Half,
    /// Two as large as the luma.
    Full,
}

impl Planes {
    fn new([width, height]: [usize; 2], row_length: usize, chroma: Chroma) -> Self {
        let row_length = row_length.max(width);
        let luma = row_length * height;
        let two = match chroma {
            Chroma::None => 0,
            Chroma::Quarter => 2 * row_length.div_ceil(2) * height.div_ceil(2),
            Chroma::Half => 2 * row_length.div_ceil(2) * height,
            Chroma::Full => 2 * luma,
        };
        Self {
            size: [width, height],
            row_length,
            image_bytes: luma + two,
            at: 0,
        }
    }

    /// As the header line of a YUV4MPEG2 stream says: words of a letter and a value, W width, H height, C chroma.
    fn of_header(line: &[u8]) -> Result<Self, NotThatFormat> {
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_ascii_whitespace();
        if words.next() != Some("YUV4MPEG2") {
            return Err(NotThatFormat("no YUV4MPEG2 stream".to_owned()));
        }
        let (mut width, mut height, mut chroma) = (None, None, Chroma::Quarter);
        for word in words {
            let value = word.get(1..).unwrap_or_default();
            match word.as_bytes()[0] {
                b'W' => width = value.parse().ok().filter(|pixels| *pixels <= 1 << 15),
                b'H' => height = value.parse().ok().filter(|pixels| *pixels <= 1 << 15),
                b'C' => chroma = chroma_of(value)?,
                _ => {}
            }
        }
        match (width, height) {
            (Some(width @ 1..), Some(height @ 1..)) => {
                Ok(Self::new([width, height], width, chroma))
            }
            _ => Err(NotThatFormat(
                "a YUV4MPEG2 stream without a size".to_owned(),
            )),
        }
    }

    fn room<'a>(&self, pixels: &'a mut [u8], chunk: &'a mut [u8]) -> &'a mut [u8] {
        let [width, height] = self.size;
        let (row, column) = (
            self.at / self.row_length.max(1),
            self.at % self.row_length.max(1),
        );
        let is_luma = row < height;
        // Rows without padding are one.
        let (from, to) = match self.row_length == width {
            true => (self.at, width * height),
            false => (row * width + column, (row + 1) * width),
        };
        let room = pixels
            .get_mut(from..to)
            .filter(|room| is_luma && !room.is_empty());
        match room {
            Some(room) => room,
            None => {
                let left = match is_luma {
                    true => self.row_length - column,
                    false => self.image_bytes.saturating_sub(self.at),
                };
                &mut chunk[..left.min(CHUNK_BYTES)]
            }
        }
    }

    fn take(&mut self) -> bool {
        let is_complete = self.at > 0 && self.at >= self.image_bytes;
        if is_complete {
            self.at = 0;
        }
        is_complete
    }
}

fn chroma_of(name: &str) -> Result<Chroma, NotThatFormat> {
    match name {
        "mono" => Ok(Chroma::None),
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => Ok(Chroma::Quarter),
        "422" => Ok(Chroma::Half),
        "444" => Ok(Chroma::Full),
        other => Err(NotThatFormat(format!(
            "a YUV4MPEG2 stream of the kind {other}; choose grey or yuv420p of 8 bits"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jpeg_encoder::{ColorType, Encoder};

    const SIZE: [usize; 2] = [7, 5];

    fn image(seed: usize) -> Vec<u8> {
        (0..35).map(|n| (n * seed + 3) as u8).collect()
    }

    /// The images of a stream that arrives in pieces, and the size that was found.
    fn images(
        mut reader: FrameReader,
        stream: &[u8],
        piece: usize,
    ) -> Result<Vec<Vec<u8>>, NotThatFormat> {
        let mut pixels = vec![0; 35];
        let mut found = Vec::new();
        let mut rest = stream;
        while !rest.is_empty() {
            let room = reader.room(&mut pixels);
            let count = room.len().min(piece).min(rest.len());
            assert!(count > 0);
            room[..count].copy_from_slice(&rest[..count]);
            rest = &rest[count..];
            reader.filled(count)?;
            while let Some(image) = reader.complete(&mut pixels) {
                image.unwrap();
                found.push(pixels.clone());
            }
        }
        assert!(!reader.is_within_image());
        assert_eq!(reader.size(), Some(SIZE));
        Ok(found)
    }

    #[test]
    fn grey_images_follow_one_another() {
        let stream = [image(1), image(2), image(3)].concat();
        for piece in [1, 2, 34, 35, 36, 1000] {
            let reader = FrameReader::new(StreamFormat::Grey, Some(SIZE), 7);
            let found = images(reader, &stream, piece).unwrap();
            assert_eq!(found, [image(1), image(2), image(3)]);
        }
    }

    #[test]
    fn chroma_is_passed_over_also_of_odd_sizes() {
        let chroma = vec![99; 2 * 4 * 3];
        let stream = [image(1), chroma.clone(), image(2), chroma].concat();
        for piece in [1, 24, 1000] {
            let reader = FrameReader::new(StreamFormat::Yuv420, Some(SIZE), 7);
            assert_eq!(
                images(reader, &stream, piece).unwrap(),
                [image(1), image(2)]
            );
        }
    }

    #[test]
    fn padding_of_rows_is_passed_over() {
        let padded = |seed| {
            let rows: Vec<u8> = image(seed)
                .chunks(7)
                .flat_map(|row| [row, &[77; 9]].concat())
                .collect();
            [rows, vec![99; 2 * 8 * 3]].concat()
        };
        let stream = [padded(1), padded(2)].concat();
        for piece in [1, 5, 7, 16, 1000] {
            let reader = FrameReader::new(StreamFormat::Yuv420, Some(SIZE), 16);
            let found = images(reader, &stream, piece).unwrap();
            assert_eq!(found, [image(1), image(2)], "{piece}");
        }
    }

    #[test]
    fn a_yuv4mpeg_stream_says_its_size() {
        for (chroma, bytes) in [(" Cmono", 0), ("", 24), (" C422", 40), (" C444", 70)] {
            let mut stream = format!("YUV4MPEG2 W7 H5 F30:1 Ip A1:1{chroma} XA=B\n").into_bytes();
            for seed in [1, 2] {
                stream.extend(b"FRAME\n");
                stream.extend(image(seed));
                stream.extend(vec![99; bytes]);
            }
            for piece in [1, 50, 1000] {
                let reader = FrameReader::new(StreamFormat::Y4m, None, 0);
                assert_eq!(
                    images(reader, &stream, piece).unwrap(),
                    [image(1), image(2)]
                );
            }
        }
    }

    #[test]
    fn another_stream_is_refused() {
        for (stream, expected) in [
            (&b"\xff\xd8 no header\n"[..], "no YUV4MPEG2 stream"),
            (b"YUV4MPEG2 W7 F30:1\n", "without a size"),
            (b"YUV4MPEG2 W7 H0\n", "without a size"),
            (b"YUV4MPEG2 W7 H5 C420p10\n", "of the kind 420p10"),
            (b"YUV4MPEG2 W7 H5 Cmono\nFRANK\n", "lost its frames"),
        ] {
            let reader = FrameReader::new(StreamFormat::Y4m, None, 0);
            let error = images(reader, stream, 1).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let endless = vec![b'x'; 5000];
        let reader = FrameReader::new(StreamFormat::Y4m, None, 0);
        assert!(images(reader, &endless, 100).is_err());
    }

    #[test]
    fn jpegs_say_their_size_and_follow_one_another() {
        let mut stream = Vec::new();
        for grey in [40, 200] {
            let pixels = vec![grey; 35];
            Encoder::new(&mut stream, 90)
                .encode(&pixels, 7, 5, ColorType::Luma)
                .unwrap();
        }
        for size in [None, Some(SIZE)] {
            for piece in [1, 100, 100_000] {
                let reader = FrameReader::new(StreamFormat::Mjpeg, size, 0);
                let found = images(reader, &stream, piece).unwrap();
                assert_eq!(found.len(), 2);
                for (image, grey) in found.iter().zip([40_u8, 200]) {
                    assert!(image.iter().all(|pixel| pixel.abs_diff(grey) < 3));
                }
            }
        }
    }
}
