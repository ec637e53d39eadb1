//! Coverage, residuals and uncertainty over the picture, as pictures.

use crate::detect::explain::canvas::{Canvas, Colour};
use anyhow::Context;
use sextant_calibrator::lens::{COLUMNS, LensMaps, MapCell, ROWS};
use sextant_calibrator::procedure::LensReport;
use sextant_recordings::write_colour_png;
use sextant_site_files::write_atomically;
use std::fs;
use std::path::Path;

/// Edge of a cell, pixels.
const CELL: usize = 60;
/// Height of the heading.
const HEAD: usize = 34;
/// Pixels of an arrow per pixel of mean residual.
const ARROW: f64 = 200.0;

const GROUND: Colour = [24, 26, 30];
const INK: Colour = [235, 235, 235];
const NONE: Colour = [60, 62, 68];

/// Writes the pictures and the report's JSON into a folder.
///
/// # Errors
/// A folder that cannot be written.
pub fn write(folder: &Path, report: &LensReport) -> anyhow::Result<()> {
    let maps = &report.maps;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let covered = |cell: &MapCell| {
        let value = f64::from(cell.corners) / 40.0;
        (value, cell.corners.to_string())
    };
    let coverage = drawn("corners seen", maps, |cell| Some(covered(cell)), |_| None);
    write_colour_png(&folder.join("coverage.png"), coverage.image())?;
    let residuals = drawn(
        "what is left: rms, px; mean as arrow, 200 times",
        maps,
        |cell| (cell.corners > 0).then(|| (cell.rms_px / 0.5, format!("{:.2}", cell.rms_px))),
        |cell| (cell.corners > 0).then_some(cell.mean_px),
    );
    write_colour_png(&folder.join("residuals.png"), residuals.image())?;
    let uncertainty = drawn(
        "how uncertain the lens is, px",
        maps,
        |cell| {
            cell.sigma_px
                .map(|sigma| (sigma / 0.5, format!("{sigma:.2}")))
        },
        |_| None,
    );
    write_colour_png(&folder.join("uncertainty.png"), uncertainty.image())?;
    write_atomically(
        &folder.join("lens.json"),
        serde_json::to_string(report)?.as_bytes(),
    )?;
    Ok(())
}

/// The picture's cells in colours, each with a value from 0 to 1 and its text, some with an arrow.
fn drawn(
    heading: &str,
    maps: &LensMaps,
    value: impl Fn(&MapCell) -> Option<(f64, String)>,
    arrow: impl Fn(&MapCell) -> Option<[f64; 2]>,
) -> Canvas {
    let mut canvas = Canvas::new(COLUMNS * CELL, ROWS * CELL + HEAD, GROUND);
    canvas.write([8, 8], 2, heading, INK);
    for (row, cells) in maps.cells.iter().enumerate() {
        for (column, cell) in cells.iter().enumerate() {
            let (left, top) = (column * CELL, HEAD + row * CELL);
            let area = [left..left + CELL - 1, top..top + CELL - 1];
            let Some((value, text)) = value(cell) else {
                canvas.fill(area, NONE);
                continue;
            };
            canvas.fill(area, heat(value));
            canvas.write([left + 6, top + 6], 2, &text, INK);
            if let Some([x, y]) = arrow(cell) {
                let middle = [left as f32 + 30.0, top as f32 + 38.0];
                let reach = |d: f64| (d * ARROW).clamp(-25.0, 25.0) as f32;
                canvas.line(middle, [middle[0] + reach(x), middle[1] + reach(y)], INK);
            }
        }
    }
    canvas
}

/// Dark blue for nothing over green to red for one and more.
fn heat(value: f64) -> Colour {
    const STEPS: [[f64; 3]; 4] = [
        [24.0, 30.0, 70.0],
        [20.0, 90.0, 110.0],
        [60.0, 130.0, 50.0],
        [170.0, 60.0, 40.0],
    ];
    let at = value.clamp(0.0, 1.0) * 3.0;
    let from = (at as usize).min(2);
    let share = at - from as f64;
    let mix = |i: usize| STEPS[from][i] * (1.0 - share) + STEPS[from + 1][i] * share;
    [0, 1, 2].map(|i| mix(i) as u8)
}
