//! Residuals and uncertainty of a lens over its image, as pictures.

use crate::calibrate::lens::chart::{CellContent, Chart};
use anyhow::Context;
use sextant_calibrator::lens::LensMaps;
use sextant_calibrator::procedure::LensReport;
use sextant_drawing::Canvas;
use sextant_recordings::write_colour_png;
use sextant_site_files::write_atomically;
use std::fs;
use std::path::Path;

/// Pixels of an arrow per pixel of mean residual.
const ARROW: f64 = 200.0;

/// Writes the pictures and the report's JSON into a folder.
///
/// # Errors
/// A folder that cannot be written.
pub fn write(folder: &Path, report: &LensReport) -> anyhow::Result<()> {
    let maps = &report.maps;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let pictures = [
        ("residuals.png", residuals(maps)),
        ("uncertainty.png", uncertainty(maps)),
    ];
    for (name, picture) in pictures {
        write_colour_png(&folder.join(name), picture.image())?;
    }
    write_atomically(
        &folder.join("lens.json"),
        serde_json::to_string(report)?.as_bytes(),
    )?;
    Ok(())
}

fn residuals(maps: &LensMaps) -> Canvas {
    let chart = Chart {
        title: "Residuals",
        words: "Root mean square distance between detected and reprojected corners in 12 x 9 \
            cells of the image. Noise alone \
            gives about the same number everywhere and short arrows in all directions. Long parallel arrows mean a \
            bent board or a lens model that does not fit. Hold the board in grey cells, above all in the corners of \
            the image.",
        unit: "RMS distance, px",
        full: 0.5,
        none: "no corner detected",
        arrow: Some(ARROW),
    };
    chart.drawn(maps, |cell| {
        (cell.corners > 0).then(|| CellContent {
            value: cell.rms_px,
            text: format!("{:.2}", cell.rms_px),
            arrow: cell.mean_px,
        })
    })
}

fn uncertainty(maps: &LensMaps) -> Canvas {
    let chart = Chart {
        title: "Uncertainty of the lens",
        words: "Standard deviation of the pixel of a ray, without a rotation of the whole camera. Below 0.15 px is \
            good. Hold the board where it is large.",
        unit: "standard deviation, px",
        full: 0.5,
        none: "outside the field of the lens",
        arrow: None,
    };
    chart.drawn(maps, |cell| {
        cell.sigma_px.map(|sigma| CellContent {
            value: sigma,
            text: format!("{sigma:.2}"),
            arrow: [0.0; 2],
        })
    })
}
