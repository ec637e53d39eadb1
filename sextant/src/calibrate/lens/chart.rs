//! A chart of the picture in cells: title, what it shows in words, the cells in colours, a scale with its unit.

use sextant_calibrator::lens::{COLUMNS, LensMaps, MapCell, ROWS};
use sextant_drawing::{Canvas, Colour, FAINT, Font, GROUND, INK, wrapped};

/// Edge of a cell, pixels.
const CELL: usize = 64;
/// About the cells.
const MARGIN: usize = 24;
/// Height of a line of small text.
const LINE: usize = 22;
/// Height of the title's line.
const TITLE: usize = 44;
/// Height of the scale, its numbers and its unit.
const SCALE: usize = 70;
/// Steps of the scale's bar.
const STEPS: usize = 256;

/// A cell without a value.
const NONE: Colour = [60, 62, 68];

/// Title, text and scale of a chart.
pub struct Chart<'a> {
    pub title: &'a str,
    /// Explanation below the title.
    pub words: &'a str,
    /// What the colours stand for.
    pub unit: &'a str,
    /// Value of the last colour; beyond it nothing changes.
    pub full: f64,
    /// What a cell without a value lacks.
    pub none: &'a str,
    /// Pixels of an arrow per pixel of its value; no arrows without.
    pub arrow: Option<f64>,
}

/// Contents of a cell.
pub struct CellContent {
    pub value: f64,
    pub text: String,
    /// Pixels of the camera, right and down.
    pub arrow: [f64; 2],
}

impl Chart<'_> {
    /// The cells as `shown` reads them.
    pub fn drawn(
        &self,
        maps: &LensMaps,
        shown: impl Fn(&MapCell) -> Option<CellContent>,
    ) -> Canvas {
        let lines = wrapped(self.words, COLUMNS * CELL);
        let head = TITLE + lines.len() * LINE + MARGIN;
        let (width, height) = (
            COLUMNS * CELL + 2 * MARGIN,
            head + ROWS * CELL + MARGIN + SCALE,
        );
        let mut canvas = Canvas::new(width, height, GROUND);
        canvas.write([MARGIN, MARGIN / 2], Font::Heading, self.title, INK);
        for (line, words) in lines.iter().enumerate() {
            canvas.write([MARGIN, TITLE + line * LINE], Font::Body, words, FAINT);
        }
        for (row, cells) in maps.cells.iter().enumerate() {
            for (column, cell) in cells.iter().enumerate() {
                let corner = [MARGIN + column * CELL, head + row * CELL];
                self.cell(&mut canvas, corner, shown(cell));
            }
        }
        self.scale(&mut canvas, head + ROWS * CELL + MARGIN / 2);
        canvas
    }

    fn cell(&self, canvas: &mut Canvas, [left, top]: [usize; 2], shown: Option<CellContent>) {
        let area = [left..left + CELL - 1, top..top + CELL - 1];
        let Some(shown) = shown else {
            canvas.fill(area, NONE);
            return;
        };
        let colour = colour_at(shown.value / self.full);
        canvas.fill(area, colour);
        canvas.write([left + 6, top + 5], Font::Body, &shown.text, ink_on(colour));
        if let Some(scale) = self.arrow {
            let middle = [(left + CELL / 2) as f32, (top + CELL / 2 + 9) as f32];
            let reach = |d: f64| (d * scale).clamp(-20.0, 20.0) as f32;
            let [x, y] = shown.arrow.map(reach);
            arrow(canvas, middle, [x, y], ink_on(colour));
        }
    }

    /// A bar with numbers, the unit, and what grey cells and arrows mean.
    fn scale(&self, canvas: &mut Canvas, top: usize) {
        let step = COLUMNS * CELL / 2 / STEPS;
        for at in 0..STEPS {
            let left = MARGIN + at * step;
            let colour = colour_at(at as f64 / (STEPS - 1) as f64);
            canvas.fill([left..left + step, top..top + 16], colour);
        }
        for part in 0..=2 {
            let mut text = number(self.full * f64::from(part) / 2.0);
            if part == 2 {
                text += " +";
            }
            let at = MARGIN + STEPS * step * part as usize / 2;
            let left = at.saturating_sub(if part == 0 {
                0
            } else {
                Font::Body.extent(&text)[0] / 2
            });
            canvas.write([left, top + 22], Font::Body, &text, INK);
        }
        canvas.write([MARGIN, top + 44], Font::Body, self.unit, FAINT);
        let right = MARGIN + STEPS * step + 3 * MARGIN;
        canvas.fill([right..right + 16, top..top + 16], NONE);
        canvas.write([right + 26, top], Font::Body, self.none, FAINT);
        if let Some(scale) = self.arrow {
            let example = 0.1;
            let length = (example * scale) as f32;
            arrow(
                canvas,
                [right as f32, (top + 32) as f32],
                [length, 0.0],
                INK,
            );
            let text = format!("arrow: mean error, this is {} px", number(example));
            canvas.write([right + 26, top + 24], Font::Body, &text, FAINT);
        }
    }
}

/// A number with up to three decimals, without trailing zeros.
fn number(value: f64) -> String {
    if value.fract() == 0.0 {
        format!("{value:.0}")
    } else {
        let text = format!("{value:.3}");
        text.trim_end_matches('0').to_owned()
    }
}

/// With a head where it is long enough for one.
fn arrow(canvas: &mut Canvas, [x, y]: [f32; 2], [dx, dy]: [f32; 2], colour: Colour) {
    let tip = [x + dx, y + dy];
    canvas.line([x, y], tip, colour);
    let length = dx.hypot(dy);
    if length < 4.0 {
        return;
    }
    let (ux, uy) = (dx / length, dy / length);
    for side in [-1.0, 1.0] {
        let back = [
            tip[0] - 5.0 * ux - side * 3.0 * uy,
            tip[1] - 5.0 * uy + side * 3.0 * ux,
        ];
        canvas.line(tip, back, colour);
    }
}

/// Dark green at 0, where the lens is good, over yellow to red at 1.
fn colour_at(value: f64) -> Colour {
    const STEPS: [[f64; 3]; 4] = [
        [28.0, 92.0, 62.0],
        [110.0, 150.0, 50.0],
        [225.0, 180.0, 60.0],
        [200.0, 55.0, 45.0],
    ];
    let at = value.clamp(0.0, 1.0) * 3.0;
    let from = (at as usize).min(2);
    let share = at - from as f64;
    let mix = |i: usize| STEPS[from][i] * (1.0 - share) + STEPS[from + 1][i] * share;
    [0, 1, 2].map(|i| mix(i) as u8)
}

fn ink_on([red, green, blue]: Colour) -> Colour {
    let light = 3 * u32::from(red) + 6 * u32::from(green) + u32::from(blue);
    if light > 1300 { GROUND } else { INK }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_long_as_they_must() {
        assert_eq!(
            [0.0, 40.0, 0.125, 0.5].map(number),
            ["0", "40", "0.125", "0.5"]
        );
    }

    #[test]
    fn a_cell_without_a_value_is_grey_and_others_are_coloured_by_theirs() {
        let cell = |corners| MapCell {
            corners,
            mean_px: [0.0; 2],
            rms_px: 0.1,
            sigma_px: None,
        };
        let row = (0..COLUMNS as u32).map(cell).collect();
        let maps = LensMaps {
            cells: vec![row; ROWS],
        };
        let chart = Chart {
            title: "corners",
            words: "words",
            unit: "corners",
            full: 11.0,
            none: "none",
            arrow: None,
        };
        let canvas = chart.drawn(&maps, |cell| {
            (cell.corners > 0).then(|| CellContent {
                value: f64::from(cell.corners),
                text: String::new(),
                arrow: [0.0; 2],
            })
        });
        let image = canvas.image();
        let colour = |column: usize| {
            let (x, y) = (
                MARGIN + column * CELL + 40,
                image.height - SCALE - MARGIN - 30,
            );
            let at = 3 * (y * image.width + x);
            [0, 1, 2].map(|i| image.pixels[at + i])
        };
        assert_eq!((colour(0), colour(11)), (NONE, colour_at(1.0)));
    }
}
