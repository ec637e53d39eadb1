//! Selects the part of an image that is searched for new tags.
//!
//! Overlapping bands from top to bottom, so that each small tag is within one of them; then the whole image
//! for taller tags.

use crate::Image;
use crate::area::Area;
use crate::kernels::TILE;

/// Bands from the top of an image to its bottom.
const BANDS: usize = 8;

/// Overlap of adjacent bands as a share of the image's height. Taller tags, and those that move towards the scan
/// by more than the rest of it, are found in the whole image.
const SHARED: usize = 8;

/// Images with fewer rows are searched as a whole: their bands would consist mostly of overlap.
const LEAST_HEIGHT: usize = 128;

/// Position of the scan.
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
        let pixels = vec![0; 32_768 * 4096];
        for (width, height) in [
            (16, 128),
            (17, 129),
            (640, 480),
            (752, 479),
            (3072, 4096),
            (32_768, 4096),
        ] {
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
