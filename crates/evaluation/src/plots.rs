//! Errors of an object over time as a picture: position, attitude and NEES, each in a panel of its own.

use crate::comparison::{ObjectComparison, TimedError};
use sextant_drawing::{Canvas, Colour, FAINT, Font, GROUND, INK};
use sextant_recordings::{RecordingError, write_colour_png};
use std::io;
use std::path::{Path, PathBuf};

const WIDTH: usize = 1200;
/// Height of a panel, title and axis included.
const PANEL: usize = 260;
const LEFT: usize = 90;
const RIGHT: usize = 20;
const TOP: usize = 40;
const BOTTOM: usize = 40;
/// Lines across a panel.
const GRID: usize = 4;
const ERROR: Colour = [255, 170, 60];
const EXPECTED: Colour = [90, 160, 255];
const RULE: Colour = [60, 62, 68];

/// Values over time, and what is expected of them.
struct Panel<'a> {
    title: &'a str,
    value: fn(&TimedError) -> Option<f64>,
    expected: fn(&TimedError) -> f64,
}

const PANELS: [Panel<'static>; 3] = [
    Panel {
        title: "position error, mm (blue: published sigma)",
        value: |error| Some(error.position_m[0] * 1e3),
        expected: |error| error.position_m[1] * 1e3,
    },
    Panel {
        title: "attitude error, degrees (blue: published sigma)",
        value: |error| Some(error.attitude_rad[0].to_degrees()),
        expected: |error| error.attitude_rad[1].to_degrees(),
    },
    Panel {
        title: "NEES (blue: expected mean)",
        value: |error| error.nees,
        expected: |_| 6.0,
    },
];

/// Why a plot is not written.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The folder cannot be made.
    #[error("{}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A picture cannot be written.
    #[error(transparent)]
    Picture(#[from] RecordingError),
}

/// Writes `FOLDER/<object>.png` for each object.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn write(folder: &Path, comparisons: &[ObjectComparison]) -> Result<(), PlotError> {
    std::fs::create_dir_all(folder).map_err(|source| PlotError::Folder {
        path: folder.to_owned(),
        source,
    })?;
    for one in comparisons {
        let file = folder.join(format!("{}.png", one.object));
        write_colour_png(&file, drawn(one).image())?;
    }
    Ok(())
}

fn drawn(comparison: &ObjectComparison) -> Canvas {
    let mut canvas = Canvas::new(WIDTH, TOP + PANELS.len() * PANEL, GROUND);
    canvas.write([LEFT, 8], Font::Heading, comparison.object.as_str(), INK);
    for (number, panel) in PANELS.iter().enumerate() {
        panel.draw(&mut canvas, TOP + number * PANEL, &comparison.errors);
    }
    canvas
}

impl Panel<'_> {
    fn draw(&self, canvas: &mut Canvas, top: usize, errors: &[TimedError]) {
        canvas.write([LEFT, top + 8], Font::Body, self.title, INK);
        let (Some(first), Some(last)) = (errors.first(), errors.last()) else {
            return;
        };
        let (from_ns, span_s) = (first.t_ns, seconds(last.t_ns - first.t_ns).max(1e-9));
        let full = self.full(errors);
        let (low, high) = ((top + PANEL - BOTTOM) as f32, (top + TOP) as f32);
        let width = (WIDTH - LEFT - RIGHT) as f32;
        let at = |error: &TimedError, value: f64| {
            let x = seconds(error.t_ns - from_ns) / span_s;
            let y = (value / full).min(1.0);
            [
                LEFT as f32 + width * x as f32,
                low - (low - high) * y as f32,
            ]
        };
        for step in 0..=GRID {
            let share = step as f64 / GRID as f64;
            let y = low - (low - high) * share as f32;
            canvas.line([LEFT as f32, y], [(WIDTH - RIGHT) as f32, y], RULE);
            let text = number(full * share);
            let left = LEFT.saturating_sub(Font::Body.extent(&text)[0] + 8);
            canvas.write([left, y as usize - 8], Font::Body, &text, FAINT);
            let x = LEFT as f32 + width * share as f32;
            let text = format!("{} s", number(span_s * share));
            let left = (x as usize).saturating_sub(Font::Body.extent(&text)[0] / 2);
            let left = left.min(WIDTH - Font::Body.extent(&text)[0]);
            canvas.write([left, low as usize + 8], Font::Body, &text, FAINT);
        }
        for pair in errors.windows(2) {
            let ends = [&pair[0], &pair[1]].map(|error| at(error, (self.expected)(error)));
            canvas.line(ends[0], ends[1], EXPECTED);
        }
        for pair in errors.windows(2) {
            let [before, after] = [&pair[0], &pair[1]];
            if let (Some(a), Some(b)) = ((self.value)(before), (self.value)(after)) {
                canvas.line(at(before, a), at(after, b), ERROR);
            }
        }
    }

    /// The value of the top line: above nearly all, so that one outlier does not flatten the rest.
    fn full(&self, errors: &[TimedError]) -> f64 {
        let mut values: Vec<f64> = errors.iter().filter_map(self.value).collect();
        values.extend(errors.iter().map(self.expected));
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        let most = values.get(values.len().saturating_sub(1) * 199 / 200);
        let most = most.copied().unwrap_or(1.0).max(1e-9);
        let unit = 10_f64.powf(most.log10().floor());
        let steps = [1.0, 2.0, 4.0, 6.0, 8.0, 10.0];
        let step = steps.into_iter().find(|step| step * unit >= most);
        step.unwrap_or(10.0) * unit
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

/// With three digits.
fn number(value: f64) -> String {
    let digits = if value >= 100.0 || value == 0.0 {
        0
    } else if value >= 10.0 {
        1
    } else if value >= 0.1 {
        2
    } else {
        4
    };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(t_ns: u64, position_m: f64) -> TimedError {
        TimedError {
            t_ns,
            position_m: [position_m, 0.001],
            attitude_rad: [0.01, 0.01],
            nees: Some(5.0),
        }
    }

    #[test]
    fn the_scale_is_that_of_nearly_all_values() {
        let mut errors: Vec<_> = (0..1000).map(|k| error(k, 0.0015)).collect();
        errors[500].position_m[0] = 3.0;
        assert_eq!(PANELS[0].full(&errors), 2.0);
    }

    #[test]
    fn values_are_drawn_in_their_panel_and_nowhere_else() {
        let mut canvas = Canvas::new(WIDTH, 2 * PANEL, GROUND);
        let errors: Vec<_> = (0..100).map(|k| error(k * 1_000_000, 0.001)).collect();
        PANELS[0].draw(&mut canvas, PANEL, &errors);
        let pixels = canvas.image().pixels.chunks(3);
        let drawn: Vec<_> = pixels.enumerate().filter(|(_, p)| *p == ERROR).collect();
        assert!(drawn.len() > 1000);
        assert!(drawn.iter().all(|(at, _)| at / WIDTH > PANEL));
    }
}
