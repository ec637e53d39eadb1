//! The negative of an image, in which tags printed white on black are ordinary ones.

use crate::Image;

/// Memory of the negative.
#[derive(Debug, Default)]
pub(crate) struct Negative {
    pixels: Vec<u8>,
}

impl Negative {
    /// Grey levels subtracted from the brightest one, so that a dim image remains dim. Allocates only if no image of
    /// this size came before.
    pub(crate) fn invert(&mut self, image: &Image<'_>) -> Image<'_> {
        let (width, height) = (image.width(), image.height());
        let rows = (0..height).map(|y| image.row(y));
        let brightest = rows.clone().flatten().copied().max().unwrap_or(u8::MAX);
        self.pixels.clear();
        self.pixels.reserve_exact(width * height);
        for row in rows {
            self.pixels.extend(row.iter().map(|grey| brightest - grey));
        }
        image.with_pixels(&self.pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_brightest_level_becomes_black() {
        let pixels: Vec<u8> = (0..20 * 16).map(|i| (i % 20) as u8 * 2).collect();
        let image = Image::new(&pixels, 18, 16, 20).unwrap();
        let mut negative = Negative::default();
        let expected: Vec<u8> = (0..18).map(|x| 34 - 2 * x).collect();
        assert_eq!(negative.invert(&image).row(15), expected);
    }
}
