//! Motion blur and rolling shutter: the instants at which objects are drawn for an image, and the rows that each
//! contributes to.
//!
//! A row is exposed for T; the first and the last row start the readout time R apart (0 with a global shutter). The
//! instants are spread evenly over the total T + R, and each serves all rows that are exposed at that time: every row
//! has equally many, and their mean is the middle of its exposure to within half a step.

use super::Scene;
use crate::model::SolidModel;
use std::ops::Range;

/// Largest motion of objects between two instants of an exposure, px.
const STEP_PX: f64 = 0.5;
/// Most instants in an exposure.
const MAX_INSTANTS: u64 = 32;
/// Largest motion of objects between two instants where rows have times of their own, px.
const ROLLING_STEP_PX: f64 = 0.1;
/// Most instants in an image whose rows have times of their own, apart from rounding.
const MAX_ROLLING: f64 = 256.0;

/// Instants spread evenly over an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instants {
    start_ns: u64,
    /// Instants per row.
    count: u64,
    /// Exposure of a row; longer than configured where that is less than a step.
    exposure_ns: u64,
    readout: Readout,
}

/// Start of the rows of an image.
#[derive(Clone, Copy, Debug)]
struct Readout {
    rows: usize,
    line_delay_ns: f64,
}

impl Readout {
    fn from_scene(scene: &Scene) -> Self {
        Self {
            rows: scene.camera.resolution[1] as usize,
            line_delay_ns: scene.camera.line_delay_s * 1e9,
        }
    }

    /// From the start of the first row to that of the last.
    fn whole_ns(&self) -> f64 {
        self.line_delay_ns.abs() * (self.rows - 1) as f64
    }

    /// Relative to the start of the first row.
    fn begins_after_ns(&self, row: usize) -> f64 {
        let rows_before = if self.line_delay_ns < 0.0 {
            self.rows - 1 - row
        } else {
            row
        };
        self.line_delay_ns.abs() * rows_before as f64
    }
}

impl Instants {
    /// Total number of instants.
    pub fn total(&self) -> u64 {
        self.steps(self.readout.whole_ns()) + self.count
    }

    /// An instant, and the rows exposed then.
    pub fn at(&self, k: u64) -> (u64, Range<usize>) {
        let true_ns = self.start_ns + self.exposure_ns * (2 * k + 1) / (2 * self.count);
        let is_exposed = |row: &usize| {
            let first = self.steps(self.readout.begins_after_ns(*row));
            (first..first + self.count).contains(&k)
        };
        let exposed = || (0..self.readout.rows).filter(is_exposed);
        let rows = exposed().next().zip(exposed().next_back());
        (true_ns, rows.map_or(0..0, |(first, last)| first..last + 1))
    }

    /// Share of a row's light per instant.
    pub fn weight(&self) -> f64 {
        1.0 / self.count as f64
    }

    /// Nearest number of steps to a duration.
    fn steps(&self, after_ns: f64) -> u64 {
        if after_ns == 0.0 {
            return 0;
        }
        (after_ns * self.count as f64 / self.exposure_ns as f64).round() as u64
    }
}

/// As many instants as the fastest visible point requires.
pub(super) fn instants(scene: &Scene, true_capture_ns: u64) -> Instants {
    let readout = Readout::from_scene(scene);
    let readout_ns = readout.whole_ns().round() as u64;
    let exposure_ns = scene.camera.exposure_ns;
    let whole_ns = exposure_ns + readout_ns;
    let start_ns = true_capture_ns.saturating_sub(whole_ns / 2);
    let solids = scene.model.solids.iter();
    let ways = solids.map(|solid| way_px(scene, solid, start_ns..start_ns + whole_ns));
    let longest = ways.fold(0.0, f64::max);
    if readout_ns == 0 {
        return Instants {
            start_ns,
            count: ((longest / STEP_PX).ceil() as u64).clamp(1, MAX_INSTANTS),
            exposure_ns,
            readout,
        };
    }
    let steps = (longest / ROLLING_STEP_PX).clamp(1.0, MAX_ROLLING);
    let step_ns = (whole_ns as f64 / steps).ceil() as u64;
    let exposure_ns = exposure_ns.max(step_ns);
    Instants {
        start_ns: true_capture_ns.saturating_sub((exposure_ns + readout_ns) / 2),
        count: exposure_ns.div_ceil(step_ns),
        exposure_ns,
        readout,
    }
}

/// Largest motion of the corners of a solid in the image during a time, px.
fn way_px(scene: &Scene, solid: &SolidModel, time_ns: Range<u64>) -> f64 {
    let path = &scene.model.paths[solid.object];
    let pose_at = |true_ns| scene.camera_from_world * path.world_from_object(true_ns);
    let longest = |start_ns, end_ns| {
        let (start, end) = (pose_at(start_ns), pose_at(end_ns));
        let ways = solid.vertices.iter().filter_map(|vertex| {
            let from = scene.optics.project(&(start * vertex))?;
            let to = scene.optics.project(&(end * vertex))?;
            Some((to - from).norm())
        });
        ways.fold(0.0, f64::max)
    };
    if path.events.is_empty() {
        return longest(time_ns.start, time_ns.end);
    }
    // A point that moves back within the time may end where it began.
    let middle_ns = time_ns.start + (time_ns.end - time_ns.start) / 2;
    longest(time_ns.start, middle_ns) + longest(middle_ns, time_ns.end)
}
