//! Coverage, residuals and uncertainty over the picture, as pictures.

use crate::calibrate::lens::chart::{Chart, Colours, Shown};
use crate::detect::explain::canvas::Canvas;
use anyhow::Context;
use sextant_calibrator::lens::LensMaps;
use sextant_calibrator::procedure::LensReport;
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
        ("coverage.png", coverage(maps)),
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

fn coverage(maps: &LensMaps) -> Canvas {
    let chart = Chart {
        title: "coverage: corners seen",
        words: "the picture of the camera in 12 x 9 cells, each with the number of corners that the lens was fitted \
            to. grey cells: hold the board there, above all in the corners of the picture.",
        unit: "corners in a cell",
        full: 40.0,
        colours: Colours::MoreIsBetter,
        none: "no corner was seen",
        arrow: None,
    };
    chart.drawn(maps, |cell| {
        (cell.corners > 0).then(|| Shown {
            value: f64::from(cell.corners),
            text: cell.corners.to_string(),
            arrow: [0.0; 2],
        })
    })
}

fn residuals(maps: &LensMaps) -> Canvas {
    let chart = Chart {
        title: "residuals: what does not fit",
        words: "root mean square distance from each seen corner to where the lens puts it. noise alone gives about \
            the same number everywhere and short arrows in all directions. long arrows side by side: the board \
            is bent, or the lens needs another model.",
        unit: "rms distance, pixels",
        full: 0.5,
        colours: Colours::LessIsBetter,
        none: "no corner was seen",
        arrow: Some(ARROW),
    };
    chart.drawn(maps, |cell| {
        (cell.corners > 0).then(|| Shown {
            value: cell.rms_px,
            text: format!("{:.2}", cell.rms_px),
            arrow: cell.mean_px,
        })
    })
}

fn uncertainty(maps: &LensMaps) -> Canvas {
    let chart = Chart {
        title: "uncertainty of the lens",
        words: "one standard deviation of where the lens shows a ray, a turn of the whole camera left out. below \
            0.15 is good. where it is large, hold the board there.",
        unit: "one standard deviation, pixels",
        full: 0.5,
        colours: Colours::LessIsBetter,
        none: "the lens shows nothing here",
        arrow: None,
    };
    chart.drawn(maps, |cell| {
        cell.sigma_px.map(|sigma| Shown {
            value: sigma,
            text: format!("{sigma:.2}"),
            arrow: [0.0; 2],
        })
    })
}
