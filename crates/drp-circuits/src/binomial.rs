//! The filter \[1 2 1\] down and across with a weight for each pixel of a mosaic: what takes most of the CPU's time in
//! place of a circuit.

use crate::Raster;
use crate::raster::Border;

/// Columns that are computed at a time: compilers make vectors of loops whose length they know.
pub(crate) const BLOCK: usize = 16;

/// What pixels of a row contribute to the sum down their columns, by column: the row itself, and those above and below
/// it.
pub(crate) struct Weights {
    pub(crate) own: [u16; BLOCK],
    pub(crate) beside: [u16; BLOCK],
}

impl Weights {
    /// Without a mosaic.
    pub(crate) const PLAIN: Self = Self {
        own: [2; BLOCK],
        beside: [1; BLOCK],
    };
}

/// Filters an image with weights for rows of even and of odd index and `BORDER_REFLECT_101`:
/// `(sum + rounding) >> SHIFT`. The sum must fit 16 bits.
pub(crate) fn filter<const SHIFT: u32>(
    input: &Raster<'_>,
    weights: &[Weights; 2],
    rounding: u16,
    output: &mut [u8],
) {
    // Filtered down, with a column to either side.
    let mut down = [0_u16; Raster::MAX_WIDTH + 2];
    let [width, height] = input.size();
    for (y, output) in output.chunks_exact_mut(width).enumerate() {
        let rows = Border::Reflect101.around(y, height).map(|y| input.row(y));
        filter_down(&weights[y % 2], rows, &mut down[1..=width]);
        (down[0], down[width + 1]) = (down[2], down[width - 1]);
        let (left, middle, right) = (&down[..width], &down[1..], &down[2..]);
        for (((out, left), middle), right) in output.iter_mut().zip(left).zip(middle).zip(right) {
            *out = ((left + 2 * middle + right + rounding) >> SHIFT) as u8;
        }
    }
}

fn filter_down(weights: &Weights, [above, here, below]: [&[u8]; 3], down: &mut [u16]) {
    let weigh = |i: usize, above: u8, here: u8, below: u8| {
        weights.own[i] * u16::from(here) + weights.beside[i] * (u16::from(above) + u16::from(below))
    };
    let (blocks, rest) = down.as_chunks_mut::<BLOCK>();
    let ((above, above_rest), (here, here_rest), (below, below_rest)) = (
        above.as_chunks::<BLOCK>(),
        here.as_chunks::<BLOCK>(),
        below.as_chunks::<BLOCK>(),
    );
    for (((down, above), here), below) in blocks.iter_mut().zip(above).zip(here).zip(below) {
        for i in 0..BLOCK {
            down[i] = weigh(i, above[i], here[i], below[i]);
        }
    }
    for (i, down) in rest.iter_mut().enumerate() {
        *down = weigh(i, above_rest[i], here_rest[i], below_rest[i]);
    }
}
