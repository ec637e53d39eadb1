//! An image divided among copies of a circuit.

use crate::Circuit;

/// A horizontal band of an image: rows `top..top + height`. What its 3x3 windows see beyond it are the image's rows,
/// where there are any.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Band {
    /// First row; even, so that a band of a Bayer image begins with red.
    pub top: usize,
    /// Rows.
    pub height: usize,
    /// Whether the band contains the first row of the image.
    pub is_first: bool,
    /// Whether the band contains the last row of the image.
    pub is_last: bool,
}

/// The bands of an image, from the top.
#[derive(Debug, Clone, Copy)]
pub struct Bands {
    height: usize,
    rows: usize,
    least: usize,
}

impl Bands {
    /// Divides an image of `height` rows among at most `n` copies of a circuit.
    pub fn new(circuit: Circuit, height: usize, n: usize) -> Self {
        let [_, least] = circuit.least_size();
        let rows = height.div_ceil(n.max(1)).next_multiple_of(2).max(least);
        Self {
            height,
            rows,
            least,
        }
    }
}

impl IntoIterator for Bands {
    type Item = Band;
    type IntoIter = std::vec::IntoIter<Band>;

    fn into_iter(self) -> Self::IntoIter {
        let mut tops: Vec<usize> = (0..self.height).step_by(self.rows).collect();
        // A rest too small for the circuit joins the band above it.
        if tops.len() > 1
            && tops
                .last()
                .is_some_and(|top| self.height - top < self.least)
        {
            tops.pop();
        }
        let ends: Vec<usize> = tops.iter().skip(1).copied().chain([self.height]).collect();
        let bands: Vec<Band> = tops
            .into_iter()
            .zip(ends)
            .map(|(top, end)| Band {
                top,
                height: end - top,
                is_first: top == 0,
                is_last: end == self.height,
            })
            .collect();
        bands.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn bands_cover_an_image_once(circuit in 0..5_usize, height in 8_usize..961, n in 1_usize..7) {
            let circuit = Circuit::ALL[circuit];
            let bands: Vec<Band> = Bands::new(circuit, height, n).into_iter().collect();
            prop_assert!(bands.len() <= n && !bands.is_empty());
            let mut next = 0;
            for band in &bands {
                prop_assert_eq!(band.top, next);
                prop_assert!(band.top.is_multiple_of(2));
                prop_assert!(band.height >= circuit.least_size()[1]);
                prop_assert_eq!(band.is_first, band.top == 0);
                next += band.height;
                prop_assert_eq!(band.is_last, next == height);
            }
            prop_assert_eq!(next, height);
        }
    }

    #[test]
    fn six_tiles_divide_vga_evenly() {
        let bands = Bands::new(Circuit::Bayer2Grayscale, 480, 6);
        let heights: Vec<usize> = bands.into_iter().map(|band| band.height).collect();
        assert_eq!(heights, [80; 6]);
    }
}
