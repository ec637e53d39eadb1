//! Samples of any depth and number of channels as 8-bit grey.

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

/// How a channel of a pixel is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Depth {
    /// A byte.
    Eight,
    /// Two bytes, the higher one first.
    SixteenBigEndian,
    /// Two bytes in the order of this machine.
    #[cfg(feature = "pictures")]
    Sixteen,
    /// A float in the order of this machine, 1 is white.
    #[cfg(feature = "pictures")]
    Float,
}

/// A decoded picture as it was in its file.
#[derive(Debug)]
pub(super) struct Samples {
    pub(super) size: [usize; 2],
    /// 1: grey; 2: grey and alpha; 3: red, green, blue; 4: these and alpha.
    pub(super) channels: usize,
    pub(super) depth: Depth,
    pub(super) bytes: Vec<u8>,
}

impl Samples {
    /// In the memory of the samples. What is transparent becomes white; more than 8 bits are scaled to the range that
    /// is in them.
    pub(super) fn into_grey(mut self) -> GreyImage {
        let bytes = &mut self.bytes;
        let channels = self.channels.max(1);
        match self.depth {
            Depth::Eight if channels == 1 => {}
            Depth::Eight => from_bytes(bytes, channels),
            Depth::SixteenBigEndian => from_deep(bytes, channels, u16::from_be_bytes),
            #[cfg(feature = "pictures")]
            Depth::Sixteen => from_deep(bytes, channels, u16::from_ne_bytes),
            #[cfg(feature = "pictures")]
            Depth::Float => from_floats(bytes, channels),
        }
        let [width, height] = self.size;
        GreyImage {
            width,
            height,
            pixels: self.bytes,
        }
    }
}

/// Puts a byte for each pixel of `stride` bytes to the front. A byte is never written beyond what was read.
fn in_place(bytes: &mut Vec<u8>, stride: usize, grey: impl Fn(&[u8]) -> u8) {
    let count = bytes.len() / stride;
    for pixel in 0..count {
        bytes[pixel] = grey(&bytes[pixel * stride..(pixel + 1) * stride]);
    }
    bytes.truncate(count);
}

fn from_bytes(bytes: &mut Vec<u8>, channels: usize) {
    in_place(bytes, channels, |pixel| {
        let values = pixel.iter().map(|&value| u32::from(value));
        on_white(values, 255) as u8
    });
}

/// Grey of a pixel of one to four channels, before paper of this value.
fn on_white(mut channels: impl ExactSizeIterator<Item = u32>, white: u32) -> u32 {
    let n = channels.len();
    let mut next = || channels.next().unwrap_or(0);
    let grey = match n {
        1 | 2 => next(),
        _ => luma([next(), next(), next()]),
    };
    match n {
        // Of sixteen bits the products exceed those of an integer of 32.
        2 | 4 => {
            let [grey, alpha, white] = [grey, next(), white].map(u64::from);
            ((grey * alpha + white * (white - alpha) + white / 2) / white) as u32
        }
        _ => grey,
    }
}

/// The darkest pixels become black and the brightest white, but for one in [`OUTSTANDING`] each, which may be defects.
fn from_deep(bytes: &mut Vec<u8>, channels: usize, value: fn([u8; 2]) -> u16) {
    let grey = |pixel: &[u8]| {
        let channels = pixel.as_chunks().0.iter();
        on_white(
            channels.map(|bytes| u32::from(value(*bytes))),
            u16::MAX.into(),
        )
    };
    let stride = 2 * channels;
    let mut counts = vec![0_u32; 1 << 16];
    for pixel in bytes.chunks_exact(stride) {
        counts[grey(pixel) as usize] += 1;
    }
    let few = bytes.len() / stride / OUTSTANDING;
    let (black, white) = (
        beyond_few(counts.iter(), few),
        u32::from(u16::MAX) - beyond_few(counts.iter().rev(), few),
    );
    let range = white.saturating_sub(black).max(1);
    in_place(bytes, stride, |pixel| {
        let above = grey(pixel).clamp(black, black.max(white)) - black;
        ((above * 255 + range / 2) / range) as u8
    });
}

/// See [`from_deep`].
const OUTSTANDING: usize = 5_000;

/// Index of the first value with which there are more than a few.
fn beyond_few<'a>(counts: impl Iterator<Item = &'a u32>, few: usize) -> u32 {
    let sums = counts.scan(0, |sum, &count| {
        *sum += count as usize;
        Some(*sum)
    });
    sums.take_while(|&sum| sum <= few).count() as u32
}

/// 1 becomes white, or what is brighter.
#[cfg(feature = "pictures")]
fn from_floats(bytes: &mut Vec<u8>, channels: usize) {
    let grey = |pixel: &[u8]| {
        let channel = |at: usize| {
            let bytes = &pixel[4 * at..4 * at + 4];
            let value = f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            if value.is_finite() {
                value.max(0.0)
            } else {
                0.0
            }
        };
        match channels {
            1 | 2 => channel(0),
            _ => 0.299 * channel(0) + 0.587 * channel(1) + 0.114 * channel(2),
        }
    };
    let stride = 4 * channels;
    let white = bytes.chunks_exact(stride).map(grey).fold(1.0, f32::max);
    in_place(bytes, stride, |pixel| {
        (grey(pixel) / white * 255.0).round() as u8
    });
}

/// 0.299 R + 0.587 G + 0.114 B, rounded.
fn luma([red, green, blue]: [u32; 3]) -> u32 {
    (299 * red + 587 * green + 114 * blue + 500) / 1000
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(channels: usize, depth: Depth, bytes: Vec<u8>) -> Vec<u8> {
        let samples = Samples {
            size: [2, 1],
            channels,
            depth,
            bytes,
        };
        samples.into_grey().pixels
    }

    #[test]
    fn what_is_transparent_is_white() {
        assert_eq!(grey(2, Depth::Eight, vec![9, 0, 8, 255]), [255, 8]);
        let colours = vec![255, 0, 0, 0, 0, 0, 255, 255];
        assert_eq!(grey(4, Depth::Eight, colours), [255, 29]);
    }

    #[test]
    fn deep_pictures_are_scaled_to_their_range() {
        let deep = |values: &[u16]| values.iter().flat_map(|v| v.to_be_bytes()).collect();
        let big = Depth::SixteenBigEndian;
        assert_eq!(grey(1, big, deep(&[0, 4095])), [0, 255]);
        assert_eq!(grey(1, big, deep(&[29_315, 29_310])), [255, 0]);
        assert_eq!(grey(1, big, deep(&[1000, 1000])), [0, 0]);
        assert_eq!(grey(2, big, deep(&[1000, 0, 500, 65535])), [255, 0]);
        assert_eq!(
            grey(3, big, deep(&[65535, 0, 0, 65535, 65535, 65535])),
            [0, 255]
        );
    }

    #[test]
    fn a_hot_pixel_leaves_the_others_their_range() {
        let mut values = vec![30_000_u16; 10_000];
        values[..5_000].fill(29_000);
        values[77] = u16::MAX;
        let samples = Samples {
            size: [100, 100],
            channels: 1,
            depth: Depth::SixteenBigEndian,
            bytes: values.iter().flat_map(|v| v.to_be_bytes()).collect(),
        };
        let pixels = samples.into_grey().pixels;
        assert_eq!((pixels[0], pixels[77], pixels[9_000]), (0, 255, 255));
    }

    #[cfg(feature = "pictures")]
    #[test]
    fn floats_are_scaled_to_white_at_one_or_their_brightest_pixel() {
        let floats = |values: [f32; 2]| values.iter().flat_map(|v| v.to_ne_bytes()).collect();
        assert_eq!(grey(1, Depth::Float, floats([0.5, 1.0])), [128, 255]);
        assert_eq!(grey(1, Depth::Float, floats([1000.0, -3.0])), [255, 0]);
        assert_eq!(grey(1, Depth::Float, floats([f32::NAN, 0.2])), [0, 51]);
    }
}
