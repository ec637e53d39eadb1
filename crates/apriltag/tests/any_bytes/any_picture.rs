//! Any bytes as options and a picture, and what must hold of whatever the detector says of it.
//!
//! For the fuzz target `detector`, and for `tests/any_bytes.rs`, which draws the bytes from a seed.

use sextant_apriltag::{Detection, Detector, Family, Image, Options, Refinement, Tracker};
use sextant_tag_families::module_is_white;

/// Takes bytes one after the other; zeros after the last.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    fn below(&mut self, limit: usize) -> usize {
        usize::from(u16::from_le_bytes([self.byte(), self.byte()])) % limit
    }

    /// -1 to 1.
    fn share(&mut self) -> f32 {
        f32::from(self.byte()) / 127.5 - 1.0
    }
}

struct Picture {
    width: usize,
    height: usize,
    stride: usize,
    pixels: Vec<u8>,
}

/// Detects, by itself and as a sequence, in the picture that the bytes make. Panics when anything is said that must not
/// be.
pub fn detect(bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    let options = options(&mut bytes);
    let mut detector = Detector::new(options.clone()).expect("the options are within their ranges");
    let families = options.families.clone();
    let mut tracker = Tracker::new(options).expect("the options are within their ranges");
    for _ in 0..1 + bytes.below(3) {
        let picture = picture(&families, &mut bytes);
        let Picture {
            width,
            height,
            stride,
            ..
        } = picture;
        let image = Image::new(&picture.pixels, width, height, stride).expect("it is an image");
        check(detector.detect(&image), &picture);
        assert!(detector.report().noise_sigma.is_finite());
        for _ in 0..1 + bytes.below(12) {
            check(tracker.detect(&image), &picture);
        }
    }
}

fn options(bytes: &mut Bytes<'_>) -> Options {
    let coded: Vec<Family> = Family::coded().collect();
    let first = bytes.below(coded.len());
    let n = 1 + bytes.below(3);
    Options {
        families: coded.iter().copied().cycle().skip(first).take(n).collect(),
        max_hamming: bytes.below(3) as u8,
        min_edge_px: 6.0 + bytes.below(20) as f32,
        min_contrast: 4 + bytes.below(125) as u8,
        min_dim_contrast: 4 + bytes.below(125) as u8,
        min_contrast_in_sigma: 3.0 + bytes.below(17) as f32,
        min_margin: bytes.below(20) as f32,
        inverted: bytes.below(2) == 1,
        refinement: [Refinement::Photometric, Refinement::Edges][bytes.below(2)],
    }
}

/// Tags of the families that are looked for, among other things. Mostly small, so that much is tried; sometimes of any
/// size that there is.
fn picture(families: &[Family], bytes: &mut Bytes<'_>) -> Picture {
    let (widest, highest) = match bytes.byte() {
        0 => (4096, 4096),
        1..16 => (800, 600),
        _ => (200, 200),
    };
    let width = Image::MIN_SIZE + bytes.below(widest - Image::MIN_SIZE + 1);
    let height = Image::MIN_SIZE + bytes.below(highest - Image::MIN_SIZE + 1);
    let stride = width + bytes.below(70);
    let mut picture = Picture {
        width,
        height,
        stride,
        pixels: vec![bytes.byte(); (height - 1) * stride + width],
    };
    for _ in 0..bytes.below(6).saturating_sub(3) {
        cover(&mut picture, bytes);
    }
    for _ in 0..bytes.below(8) {
        let family = families[bytes.below(families.len())];
        draw_tag(&mut picture, family, bytes);
    }
    for _ in 0..bytes.below(64) {
        let at = bytes.below(usize::from(u16::MAX)) * bytes.below(256) % picture.pixels.len();
        picture.pixels[at] = bytes.byte();
    }
    picture
}

/// A pattern all over: the bytes themselves, checks, rings, waves, or noise.
fn cover(picture: &mut Picture, bytes: &mut Bytes<'_>) {
    let (kind, period, depth) = (bytes.below(5), 1 + bytes.below(40), bytes.byte());
    let given = bytes.0;
    let mut noise = 0x9e37_79b9_7f4a_7c15_u64 ^ u64::from(depth) << 20 ^ period as u64;
    for y in 0..picture.height {
        for x in 0..picture.width {
            noise ^= noise << 13;
            noise ^= noise >> 7;
            noise ^= noise << 17;
            let ring = x
                .min(y)
                .min(picture.width - 1 - x)
                .min(picture.height - 1 - y);
            let added = match kind {
                0 => given
                    .get((y * picture.width + x) % given.len().max(1))
                    .copied()
                    .unwrap_or(0),
                1 => depth * ((x / period + y / period) % 2) as u8,
                2 => depth * (ring / period % 2) as u8,
                3 => (x * period + y * usize::from(depth)) as u8,
                _ => (noise % (1 + u64::from(depth))) as u8,
            };
            let pixel = &mut picture.pixels[y * picture.stride + x];
            *pixel = pixel.wrapping_add(added);
        }
    }
}

/// A tag somewhere, turned, sheared and foreshortened, in two greys, not blurred.
fn draw_tag(picture: &mut Picture, family: Family, bytes: &mut Bytes<'_>) {
    let data = family.data();
    let id = bytes.below(data.codes.len()) as u32;
    let [middle_x, middle_y] = [picture.width, picture.height].map(|size| bytes.below(size) as f32);
    let scale = 0.7 + bytes.below(120) as f32 / 10.0;
    let turn = std::f32::consts::PI * bytes.share();
    let (sin, cos) = turn.sin_cos();
    let (shear, flat, far) = (
        bytes.share() * 0.4,
        1.0 + bytes.share() * 0.6,
        bytes.share() * 0.02,
    );
    let greys = [bytes.byte() / 2, 127 + bytes.byte() / 2];
    let width = usize::from(data.total_width);
    for y in 0..picture.height {
        for x in 0..picture.width {
            let (dx, dy) = ((x as f32 - middle_x) / scale, (y as f32 - middle_y) / scale);
            let depth = 1.0 + far * dx;
            let u = (cos * dx + sin * dy + shear * dy) / depth + width as f32 / 2.0;
            let v = (cos * dy - sin * dx) / flat / depth + width as f32 / 2.0;
            let around = -1.0..width as f32 + 1.0;
            if !around.contains(&u) || !around.contains(&v) || depth <= 0.0 {
                continue;
            }
            let (column, row) = (u.floor() as isize, v.floor() as isize);
            let on_tag = |place: isize| (0..width as isize).contains(&place);
            let white = !on_tag(column)
                || !on_tag(row)
                || module_is_white(family, id, column as usize, row as usize);
            picture.pixels[y * picture.stride + x] = greys[usize::from(white)];
        }
    }
}

fn check(found: &[Detection], picture: &Picture) {
    let size = (picture.width + picture.height) as f32;
    for tag in found {
        assert!((tag.id as usize) < tag.family.data().codes.len());
        assert!(tag.hamming <= 2 && tag.margin.is_finite());
        for corner in tag.corners.as_flattened() {
            assert!(corner.is_finite() && corner.abs() < 2.0 * size, "{tag:?}");
        }
        for [xx, xy, yy] in tag.corner_covariance {
            assert!(
                xx > 0.0 && yy > 0.0 && xy.is_finite() && xx.is_finite() && yy.is_finite(),
                "{tag:?}"
            );
            assert!(xy * xy <= xx * yy * 1.001, "{tag:?}");
        }
    }
}
