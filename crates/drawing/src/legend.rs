//! Legends: colours with their meanings.

use crate::{Canvas, Colour, Font, INK};

/// A colour and its meaning.
pub type LegendLine = (Colour, String);

/// Edge of a colour's square, pixels.
const SWATCH: usize = 14;
/// From the canvas's edge to the square, and from there to the text.
const GAP: usize = 10;
/// Height of a line.
const LINE: usize = 24;

/// Height of a legend of `n_lines` lines, pixels.
pub fn legend_height(n_lines: usize) -> usize {
    n_lines * LINE + GAP
}

/// Width of a legend, pixels.
pub fn legend_width(legend: &[LegendLine]) -> usize {
    let widths = legend.iter().map(|(_, text)| Font::Body.extent(text)[0]);
    widths.max().unwrap_or(0) + SWATCH + 3 * GAP
}

/// Writes a legend from a row of the canvas on.
pub fn write_legend(canvas: &mut Canvas, top: usize, legend: &[LegendLine]) {
    for (i, (colour, text)) in legend.iter().enumerate() {
        let top = top + GAP + i * LINE;
        canvas.fill([GAP..GAP + SWATCH, top..top + SWATCH], *colour);
        canvas.write([2 * GAP + SWATCH, top - 1], Font::Body, text, INK);
    }
}
