//! Which part of an image is searched for tags that are not known yet.
//!
//! Bands from top to bottom that reach into one another, so that small tags lie wholly in one of them; then the whole image,
//! for tags too tall for that.

use crate::Image;
use crate::area::Area;
use crate::kernels::TILE;

/// Bands from the top of an image to its bottom.
const BANDS: usize = 8;

/// Rows that neighbouring bands share, as a part of the image's height. Taller tags, and those that move towards the scan
/// by what is left, are seen in the whole image.
const SHARED: usize = 8;

/// Images lower than this are searched whole: bands of them would be hardly higher than what they share.
const LEAST_HEIGHT: usize = 128;

/// Where the scan stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scan {
    step: usize,
}

impl Scan {
    pub(super) fn next(&mut self, image: &Image<'_>) -> Area {
        let (whole, step) = (Area::whole(image), self.step);
        self.step = (step + 1) % (BANDS + 1);
        if step == BANDS || image.height() < LEAST_HEIGHT {
            return whole;
        }
        let shared = image.height() / SHARED;
        let height = (image.height() + (BANDS - 1) * shared).div_ceil(BANDS);
        let bottom = step * (image.height() - height) / (BANDS - 1) + height;
        let top = (bottom - height) / TILE * TILE;
        Area {
            top,
            height: bottom - top,
            ..whole
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bands_reach_into_one_another_from_top_to_bottom() {
        let pixels = vec![0; 4096 * 3072];
        for (width, height) in [(16, 128), (17, 129), (640, 480), (752, 479), (4096, 3072)] {
            let image = Image::new(&pixels, width, height, width).unwrap();
            let mut scan = Scan::default();
            let mut bottom = height / SHARED;
            for _ in 0..BANDS {
                let band = scan.next(&image);
                assert_eq!((band.left, band.width), (0, width));
                assert!(
                    band.top + height / SHARED <= bottom,
                    "{width}x{height} {band:?}"
                );
                assert!(
                    band.n_pixels() * 7 < width * height * 2,
                    "{width}x{height} {band:?}"
                );
                bottom = band.top + band.height;
            }
            assert_eq!(bottom, height);
            assert_eq!(scan.next(&image), Area::whole(&image));
            assert_eq!(scan.next(&image).top, 0);
        }
    }
}
