//! JPEGs one after the other in a stream of bytes, cut where each begins and ends.
//!
//! An image is followed segment by segment, so that a thumbnail within it does not end it. What is no JPEG is passed
//! over up to the next beginning.

use std::ops::Range;

/// The longest JPEG; what goes on for longer is none.
const MAX_BYTES: usize = 16 << 20;

const SOI: u8 = 0xd8;
const EOI: u8 = 0xd9;
const SOS: u8 = 0xda;

/// The bytes since the last image that was taken.
#[derive(Debug, Default)]
pub(super) struct JpegStream {
    bytes: Vec<u8>,
    /// Where an image begins, once that is found, and how far it has been followed.
    image: Option<Image>,
    /// How far the bytes were searched for a beginning.
    searched: usize,
    /// The image that was given last, to be forgotten.
    given: usize,
}

#[derive(Debug, Clone, Copy)]
struct Image {
    start: usize,
    /// At a marker, or within the coded pixels.
    at: usize,
    is_in_scan: bool,
}

enum Followed {
    /// The image ends before this.
    End(usize),
    /// More bytes are needed.
    Open(Image),
    /// It is no image; a search goes on from here.
    Broken(usize),
}

impl JpegStream {
    /// Takes more bytes of the stream.
    pub(super) fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// The next image that is there as a whole.
    pub(super) fn next(&mut self) -> Option<&[u8]> {
        self.forget();
        let range = self.find()?;
        self.given = range.end;
        Some(&self.bytes[range])
    }

    /// Whether bytes of an image are there that is not complete.
    pub(super) fn is_within_image(&self) -> bool {
        self.bytes.len() > self.given
    }

    fn forget(&mut self) {
        self.bytes.drain(..self.given);
        (self.given, self.searched, self.image) = (0, 0, self.image.filter(|_| self.given == 0));
    }

    fn find(&mut self) -> Option<Range<usize>> {
        loop {
            let image = match self.image {
                Some(image) => image,
                None => self.begin()?,
            };
            match follow(&self.bytes, image) {
                Followed::End(end) => {
                    self.image = None;
                    return Some(image.start..end);
                }
                Followed::Open(image) if self.bytes.len() - image.start <= MAX_BYTES => {
                    self.image = Some(image);
                    return None;
                }
                Followed::Open(Image { start, .. }) => self.give_up(start + 2),
                Followed::Broken(at) => self.give_up(at),
            }
        }
    }

    fn give_up(&mut self, search_from: usize) {
        self.image = None;
        self.searched = search_from;
    }

    /// Finds the next beginning; forgets what is before it.
    fn begin(&mut self) -> Option<Image> {
        let found = self.bytes[self.searched..]
            .windows(2)
            .position(|pair| pair == [0xff, SOI]);
        let Some(found) = found else {
            // The last byte may be the first of a beginning.
            let kept = self.bytes.len().min(1);
            self.bytes.drain(..self.bytes.len() - kept);
            self.searched = 0;
            return None;
        };
        self.bytes.drain(..self.searched + found);
        self.searched = 0;
        Some(Image {
            start: 0,
            at: 2,
            is_in_scan: false,
        })
    }
}

/// Follows an image from marker to marker as far as the bytes go.
fn follow(bytes: &[u8], mut image: Image) -> Followed {
    loop {
        let rest = &bytes[image.at..];
        if image.is_in_scan {
            let marker = rest
                .windows(2)
                .position(|pair| pair[0] == 0xff && !is_within_scan(pair[1]));
            let Some(marker) = marker else {
                image.at = bytes.len().saturating_sub(1).max(image.at);
                return Followed::Open(image);
            };
            (image.at, image.is_in_scan) = (image.at + marker, false);
            continue;
        }
        match *rest {
            [0xff, EOI, ..] => return Followed::End(image.at + 2),
            // A beginning within an image: the one before was cut short.
            [0xff, SOI, ..] => return Followed::Broken(image.at),
            [0xff, 0xff, ..] => image.at += 1,
            [0xff, marker, high, low, ..] => {
                let length = usize::from(u16::from_be_bytes([high, low]));
                if length < 2 || marker == 0 {
                    return Followed::Broken(image.at + 1);
                }
                if rest.len() < 2 + length {
                    return Followed::Open(image);
                }
                image.at += 2 + length;
                image.is_in_scan = marker == SOS;
            }
            [0xff, _] | [0xff, _, _] | [0xff] | [] => return Followed::Open(image),
            [_, ..] => return Followed::Broken(image.at),
        }
    }
}

/// What follows 0xff within coded pixels: a zero that stands for nothing, a restart, or padding.
fn is_within_scan(byte: u8) -> bool {
    matches!(byte, 0 | 0xd0..=0xd7 | 0xff)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A picture with a thumbnail in a segment, and an end of image within that.
    fn jpeg(seed: u8) -> Vec<u8> {
        let mut jpeg = vec![
            0xff, SOI, 0xff, 0xe1, 0, 8, 0xff, SOI, seed, seed, 0xff, EOI,
        ];
        jpeg.extend([0xff, SOS, 0, 3, 7]);
        jpeg.extend([seed, 0xff, 0, 0xff, 0xd3, seed, seed]);
        jpeg.extend([0xff, 0xc4, 0, 4, 1, 2, 0xff, SOS, 0, 2, seed]);
        jpeg.extend([0xff, EOI]);
        jpeg
    }

    fn cut(stream: &[u8], piece: usize) -> Vec<Vec<u8>> {
        let mut images = JpegStream::default();
        let mut found = Vec::new();
        for piece in stream.chunks(piece) {
            images.push(piece);
            while let Some(image) = images.next() {
                found.push(image.to_vec());
            }
        }
        found
    }

    #[test]
    fn images_are_cut_where_they_begin_and_end_however_they_arrive() {
        let images = [jpeg(1), jpeg(2), jpeg(3)];
        let mut stream = b"noise \xff".to_vec();
        stream.extend(&images[0]);
        stream.extend(&images[1]);
        stream.extend(b"--boundary\r\n\r\n");
        stream.extend(&images[2]);
        for piece in 1..=stream.len() {
            assert_eq!(cut(&stream, piece), images, "pieces of {piece}");
        }
    }

    /// A segment's length that is wrong may swallow what follows, at most 64 KiB.
    #[test]
    fn the_stream_recovers_from_an_image_that_is_cut_short() {
        for kept in 1..jpeg(1).len() {
            let mut stream = jpeg(1)[..kept].to_vec();
            (0..2000).for_each(|_| stream.extend(jpeg(2)));
            stream.extend(jpeg(3));
            let found = cut(&stream, 1000);
            assert!(found.len() > 200, "{kept}: {}", found.len());
            assert!(found.ends_with(&[jpeg(2), jpeg(3)]), "{kept}");
        }
    }

    #[test]
    fn a_stream_without_images_is_not_kept() {
        let mut images = JpegStream::default();
        for _ in 0..1000 {
            images.push(&[7; 1000]);
            assert!(images.next().is_none());
        }
        assert!(images.bytes.len() <= 1000);
    }

    #[test]
    fn an_endless_image_is_given_up() {
        let mut images = JpegStream::default();
        images.push(&jpeg(1)[..18]);
        for _ in 0..40 {
            images.push(&vec![5; 1 << 20]);
            assert!(images.next().is_none());
            assert!(images.bytes.len() <= MAX_BYTES + (2 << 20));
        }
        images.push(&jpeg(9));
        assert_eq!(images.next().map(<[u8]>::to_vec), Some(jpeg(9)));
    }

    proptest! {
        #[test]
        fn any_bytes_are_taken(
            stream in proptest::collection::vec(
                prop_oneof![Just(0xff_u8), Just(SOI), Just(EOI), Just(SOS), Just(0), Just(2), any::<u8>()],
                0..300,
            ),
            piece in 1usize..40,
        ) {
            let pieces = cut(&stream, piece);
            prop_assert_eq!(&pieces, &cut(&stream, stream.len().max(1)));
            for image in pieces {
                prop_assert!(image.starts_with(&[0xff, SOI]) && image.ends_with(&[0xff, EOI]));
            }
        }
    }
}
