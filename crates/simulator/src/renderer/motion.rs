//! Motion blur and rolling shutters: the instants of an image at which the objects are drawn, and the rows that each is for.
//!
//! A row is exposed for T; the first and the last begin the readout R apart (0 with a global shutter). The instants lie evenly
//! in the T + R that the whole image takes, so that each serves all the rows that are exposed then: every row has as many, and
//! their mean is the middle of its exposure to half a step.

use super::Scene;
use crate::model::SolidModel;
use std::ops::Range;

/// Objects move at most this far between two instants of an exposure, px.
const STEP_PX: f64 = 0.5;
/// The most instants in an exposure.
const MAX_INSTANTS: u64 = 32;
/// Where rows have times of their own objects move at most this far between two instants, px.
const ROLLING_STEP_PX: f64 = 0.1;
/// The most instants in an image whose rows have times of their own, but for rounding.
const MAX_ROLLING: f64 = 256.0;

/// Instants evenly spread over an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instants {
    start_ns: u64,
    /// So many to a row.
    count: u64,
    /// How long a row is exposed; more than the camera says where that is less than a step.
    exposure_ns: u64,
    readout: Readout,
}

/// When the rows of an image begin.
#[derive(Clone, Copy, Debug)]
struct Readout {
    rows: usize,
    line_delay_ns: f64,
}

impl Readout {
    fn of(scene: &Scene) -> Self {
        Self {
            rows: scene.camera.resolution[1] as usize,
            line_delay_ns: scene.camera.line_delay_s * 1e9,
        }
    }

    /// From the first to the last.
    fn whole_ns(&self) -> f64 {
        self.line_delay_ns.abs() * (self.rows - 1) as f64
    }

    /// From the first that begins.
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
    /// How many there are in all.
    pub fn total(&self) -> u64 {
        self.steps(self.readout.whole_ns()) + self.count
    }

    /// An instant, and the rows that are exposed then.
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

    /// The share of a row's light of each instant.
    pub fn weight(&self) -> f64 {
        1.0 / self.count as f64
    }

    /// The nearest number of steps to a time.
    fn steps(&self, after_ns: f64) -> u64 {
        if after_ns == 0.0 {
            return 0;
        }
        (after_ns * self.count as f64 / self.exposure_ns as f64).round() as u64
    }
}

/// As many instants as the fastest point in the image needs.
pub(super) fn instants(scene: &Scene, true_capture_ns: u64) -> Instants {
    let readout = Readout::of(scene);
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

/// How far the corners of a solid move in the image over a time.
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
    // What rebounds within the time may end where it began.
    let middle_ns = time_ns.start + (time_ns.end - time_ns.start) / 2;
    longest(time_ns.start, middle_ns) + longest(middle_ns, time_ns.end)
}
