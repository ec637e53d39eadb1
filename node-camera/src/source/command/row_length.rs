//! How long the rows of a raw stream are. Nothing in it says so, and a wrong length shears the picture so that no tag
//! is found.

use crate::config::StreamFormat;

/// Programs of Raspberry Pi that pad each row to a multiple of this many bytes.
const PADDING_PROGRAMS: [&str; 2] = ["rpicam-vid", "libcamera-vid"];
const PADDING: usize = 64;
/// Paddings that other programs have.
const OTHER_PADDINGS: [usize; 5] = [16, 32, 64, 128, 256];
/// Neighbouring rows of a sheared picture differ by at least this much, on average.
const LEAST_DIFFERENCE: f64 = 3.0;
/// A row length is the right one if neighbouring rows differ by less than this share of what they do otherwise.
const CLEAR: f64 = 0.5;
/// Images in a row that have to agree.
const IMAGES: usize = 5;
/// Every so many bytes are compared.
const SAMPLING: usize = 7;

/// Bytes from one row to the next: stated, as the program is known to write, or the width.
pub(super) fn row_length(
    program: &str,
    format: StreamFormat,
    width: usize,
    stated: Option<u32>,
) -> usize {
    let program = program.rsplit('/').next().unwrap_or_default();
    let is_raw = matches!(format, StreamFormat::Grey | StreamFormat::Yuv420);
    match stated {
        Some(length) => length as usize,
        None if is_raw && PADDING_PROGRAMS.contains(&program) => width.next_multiple_of(PADDING),
        None => width,
    }
}

/// Watches the first images of a stream without padding for rows of another length.
#[derive(Debug, Default)]
pub(super) struct ShearCheck {
    seen: usize,
    suspected: Option<usize>,
}

impl ShearCheck {
    /// The length that rows seem to have, once enough images agree that it is not the width.
    pub(super) fn look(&mut self, pixels: &[u8], width: usize) -> Option<usize> {
        if self.seen >= IMAGES {
            return None;
        }
        let found = better_length(pixels, width);
        if self.seen > 0 && found != self.suspected || found.is_none() {
            self.seen = IMAGES;
            return None;
        }
        (self.seen, self.suspected) = (self.seen + 1, found);
        found.filter(|_| self.seen == IMAGES)
    }

    /// Whether the last images seem to be sheared, and it is not sure yet.
    pub(super) fn is_suspicious(&self) -> bool {
        self.suspected.is_some() && self.seen < IMAGES
    }
}

/// A row length by which neighbouring rows are clearly more alike than by the width.
fn better_length(bytes: &[u8], width: usize) -> Option<usize> {
    let by_width = difference(bytes, width);
    let lengths = OTHER_PADDINGS.map(|padding| width.next_multiple_of(padding));
    let lengths = lengths.into_iter().filter(|length| *length != width);
    let rated = lengths.map(|length| (length, difference(bytes, length)));
    let best = rated.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (by_width >= LEAST_DIFFERENCE && best.1 < CLEAR * by_width).then_some(best.0)
}

/// Mean difference of bytes that are so far apart.
fn difference(bytes: &[u8], apart: usize) -> f64 {
    let pairs = bytes.iter().zip(bytes.iter().skip(apart)).step_by(SAMPLING);
    let (sum, n) = pairs.fold((0_u64, 0_u64), |(sum, n), (a, b)| {
        (sum + u64::from(a.abs_diff(*b)), n + 1)
    });
    sum as f64 / n.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture with edges in both directions, with rows of a length, read as rows without padding.
    fn read_as_unpadded(width: usize, height: usize, length: usize) -> Vec<u8> {
        let bytes = (0..length * height).map(|at| match (at % length, at / length) {
            (x, _) if x >= width => 0,
            (x, y) => {
                if (x / 40 + y / 30) % 2 == 0 {
                    40
                } else {
                    210
                }
            }
        });
        bytes.take(width * height).collect()
    }

    #[test]
    fn rows_of_raspberry_pis_programs_are_padded() {
        let length = |program, stated| row_length(program, StreamFormat::Yuv420, 1456, stated);
        assert_eq!(length("rpicam-vid", None), 1472);
        assert_eq!(length("/usr/bin/libcamera-vid", None), 1472);
        assert_eq!(length("rpicam-vid", Some(1456)), 1456);
        assert_eq!(length("ffmpeg", None), 1456);
        assert_eq!(
            row_length("rpicam-vid", StreamFormat::Mjpeg, 1456, None),
            1456
        );
    }

    #[test]
    fn a_sheared_picture_is_noticed_and_a_right_one_is_not() {
        let looked = |pixels: &[u8], width| {
            let mut check = ShearCheck::default();
            (0..IMAGES).find_map(|_| check.look(pixels, width))
        };
        assert_eq!(looked(&read_as_unpadded(1456, 400, 1472), 1456), Some(1472));
        assert_eq!(looked(&read_as_unpadded(1000, 400, 1024), 1000), Some(1024));
        assert_eq!(looked(&read_as_unpadded(1456, 400, 1456), 1456), None);
        assert_eq!(looked(&vec![90; 1456 * 400], 1456), None);
    }
}
