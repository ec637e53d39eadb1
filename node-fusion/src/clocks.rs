//! How the offsets of the cameras' clocks grow: the slope of what the estimator reports, over the last minute.
//!
//! Input: the estimator's offsets, about once a second. Output: the report with drifts. The slope is that of the least
//! squares line; neighbouring offsets share most of their images and with them their errors, so that its sigma is taken
//! from the ends alone: sqrt(2) sigma / span, twice for safety.

use sextant_proto::{CameraClock, ClockReport, NodeId, limits};
use sextant_site_model::CameraId;
use sextant_site_report::ClockOffset;
use std::collections::{BTreeMap, VecDeque};

/// Offsets remembered of a camera: a minute of them.
const REMEMBERED: usize = 60;
/// Fewest offsets that make a line.
const FEWEST: usize = 5;
/// Seconds by which no clock drifts from one report to the next.
const JUMP_S: f64 = 0.001;
/// Largest standard deviation of a published slope: 50 ppm, by which crystals differ.
const SURE: f64 = 50e-6;

/// The offsets of the last minute, by camera.
#[derive(Debug, Default)]
pub struct DriftEstimator {
    cameras: BTreeMap<CameraId, VecDeque<(u64, ClockOffset)>>,
}

impl DriftEstimator {
    /// Takes the offsets of `now_ns` in and reports.
    pub fn report(
        &mut self,
        node: &NodeId,
        offsets: BTreeMap<CameraId, ClockOffset>,
        now_ns: u64,
    ) -> ClockReport {
        self.cameras
            .retain(|camera, _| offsets.contains_key(camera));
        let clocks = offsets.into_iter().take(limits::MAX_CAMERAS);
        let cameras = clocks.map(|(camera, clock)| {
            let history = self.cameras.entry(camera.clone()).or_default();
            if history
                .back()
                .is_some_and(|(_, last)| is_jump(last, &clock))
            {
                history.clear();
            }
            history.push_back((now_ns, clock));
            if history.len() > REMEMBERED {
                history.pop_front();
            }
            CameraClock {
                camera,
                offset_s: clock.offset_s,
                sigma_s: clock.sigma_s,
                drift: drift(history),
            }
        });
        ClockReport {
            node: node.clone(),
            cameras: cameras.collect(),
        }
    }
}

/// Whether the clock was set, or found to be off by something else.
fn is_jump(before: &ClockOffset, now: &ClockOffset) -> bool {
    let sigma_s = before.sigma_s.hypot(now.sigma_s);
    (now.offset_s - before.offset_s).abs() > (10.0 * sigma_s).max(JUMP_S)
}

/// The slope in s/s, once the history is long enough.
fn drift(history: &VecDeque<(u64, ClockOffset)>) -> Option<f64> {
    let (first_ns, first) = history.front()?;
    let (last_ns, last) = history.back()?;
    let span_s = last_ns.saturating_sub(*first_ns) as f64 * 1e-9;
    let sigma = 2.0 * first.sigma_s.hypot(last.sigma_s) / span_s;
    if history.len() < FEWEST || !sigma.is_finite() || sigma > SURE {
        return None;
    }
    let points = history.iter().map(|(at_ns, clock)| {
        let seconds = at_ns.saturating_sub(*first_ns) as f64 * 1e-9;
        (seconds, clock.offset_s)
    });
    slope(&points.collect::<Vec<_>>()).filter(|slope| slope.is_finite())
}

/// Slope of the least squares line through (x, y).
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let n = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / n;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / n;
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        points.iter().map(|(x, y)| of(x - mean_x, y - mean_y)).sum()
    };
    let xx = sum(&|x, _| x * x);
    (xx > 0.0).then(|| sum(&|x, y| x * y) / xx)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_is_no_drift() {
        let mut estimator = DriftEstimator::default();
        let (node, camera) = (NodeId::new("f").unwrap(), CameraId::new("north").unwrap());
        for second in 0..30 {
            let clock = ClockOffset {
                offset_s: if second < 20 { 0.0 } else { 0.4 },
                sigma_s: 1e-5,
            };
            let offsets = BTreeMap::from([(camera.clone(), clock)]);
            let now_ns = 1_800_000_000_000_000_000 + second * 1_000_000_000;
            let drift = estimator.report(&node, offsets, now_ns).cameras[0].drift;
            assert!(drift.is_none_or(|drift| drift.abs() < 1e-9), "{drift:?}");
        }
    }

    fn after(seconds: u64, sigma_s: f64, drift: f64) -> Option<f64> {
        let mut estimator = DriftEstimator::default();
        let (node, camera) = (NodeId::new("f").unwrap(), CameraId::new("north").unwrap());
        let mut last = None;
        for second in 0..seconds {
            let clock = ClockOffset {
                offset_s: 0.01 + drift * second as f64,
                sigma_s,
            };
            let offsets = BTreeMap::from([(camera.clone(), clock)]);
            let report = estimator.report(
                &node,
                offsets,
                1_800_000_000_000_000_000 + second * 1_000_000_000,
            );
            last = report.cameras[0].drift;
        }
        last
    }

    #[test]
    fn a_steady_drift_is_reported_once_it_is_sure() {
        assert_eq!(after(3, 1e-4, 2e-5), None);
        assert_eq!(after(60, 1e-2, 2e-5), None);
        let drift = after(200, 1e-4, 2e-5).unwrap();
        assert!((drift - 2e-5).abs() < 1e-9, "{drift}");
    }

    #[test]
    fn equal_times_give_no_drift() {
        let mut estimator = DriftEstimator::default();
        let camera = CameraId::new("north").unwrap();
        let clock = ClockOffset {
            offset_s: 0.0,
            sigma_s: 0.0,
        };
        for _ in 0..20 {
            let offsets = BTreeMap::from([(camera.clone(), clock)]);
            let report = estimator.report(&NodeId::new("f").unwrap(), offsets, 5);
            assert_eq!(report.cameras[0].drift, None);
        }
    }
}
