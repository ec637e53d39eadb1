//! Scores of a running site: published poses against the simulator's truth, per object, and the latency of all.
//!
//! Input: published poses, with the true pose at their capture time. Output: RMS errors of the last seconds beside the
//! published sigmas, coverage, percentiles. Memory is constant.

use crate::alignment::{PosePairs, Rms};
use serde::Serialize;
use sextant_geometry::Pose;
use std::collections::BTreeMap;

/// Scores of every object and of the latency.
#[derive(Debug)]
pub struct LiveScore {
    slot_ns: u64,
    from_ns: u64,
    newest_slot: u64,
    objects: BTreeMap<String, ObjectScore>,
    latency: Latency,
    frame: WorldFrame,
}

/// The frame in which estimates are compared with the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorldFrame {
    /// The world frame: the cameras' files are exact.
    Exact,
    /// The best-fitting frame: the cameras' files have errors.
    Fitted,
}

/// A published pose, and the true pose at its capture time.
#[derive(Debug, Clone, Copy)]
pub struct ScoredPose<'a> {
    /// Middle of the exposure, ns.
    pub capture_ns: u64,
    /// The estimate.
    pub estimate: &'a Pose,
    /// Its covariance, 6x6 row-major over (x, y, z, rx, ry, rz).
    pub covariance: &'a [f64; 36],
    /// The true pose.
    pub truth: &'a Pose,
}

impl LiveScore {
    /// Scores of these objects and links from `from_ns` on; coverage is counted in slots of one image period.
    pub fn new(
        objects: impl IntoIterator<Item = String>,
        rate_hz: f64,
        from_ns: u64,
        frame: WorldFrame,
    ) -> Self {
        let slot_ns = (1e9 / rate_hz) as u64;
        let objects = objects
            .into_iter()
            .map(|id| (id, ObjectScore::default()))
            .collect();
        Self {
            slot_ns: slot_ns.max(1),
            from_ns,
            newest_slot: 0,
            objects,
            latency: Latency::default(),
            frame,
        }
    }

    /// Counts a pose of an object or link. Poses captured before the start are ignored.
    pub fn count(&mut self, name: &str, judged: &ScoredPose) {
        let Some(since_ns) = judged.capture_ns.checked_sub(self.from_ns) else {
            return;
        };
        let Some(object) = self.objects.get_mut(name) else {
            return;
        };
        let slot = since_ns / self.slot_ns;
        self.newest_slot = self.newest_slot.max(slot);
        object.count(slot, judged);
    }

    /// The motion from the true world frame to the one of the estimates.
    pub fn site_from_world(&self) -> Pose {
        let fitted = match self.frame {
            WorldFrame::Exact => None,
            WorldFrame::Fitted => {
                PosePairs::alignment(self.objects.values().map(|object| &object.pairs))
            }
        };
        fitted.unwrap_or_else(Pose::identity)
    }

    /// Counts the latency of a pose.
    pub fn count_latency(&mut self, capture_ns: u64, published_ns: u64) {
        if capture_ns >= self.from_ns {
            self.latency.count(published_ns.saturating_sub(capture_ns));
        }
    }

    /// The scores so far, sorted by object.
    pub fn objects(&self) -> Vec<ObjectSummary> {
        let site_from_world = self.site_from_world();
        let n_slots = self.newest_slot + 1;
        let objects = self.objects.iter();
        objects
            .map(|(id, score)| score.summary(id, n_slots, &site_from_world))
            .collect()
    }

    /// Percentiles of capture to publication.
    pub fn latency(&self) -> LatencySummary {
        LatencySummary {
            p50: self.latency.percentile_ms(0.5),
            p99: self.latency.percentile_ms(0.99),
        }
    }
}

/// An object or a link in the summary.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectSummary {
    /// Its name.
    pub id: String,
    /// Poses published.
    pub poses: u64,
    /// Share of image periods with a pose.
    pub coverage: f64,
    /// RMS distance of the origins over the last seconds; none without a pose.
    pub position_rms_mm: Option<f64>,
    /// The same as predicted by the published covariances.
    pub position_sigma_mm: Option<f64>,
    /// RMS angle; none without a pose.
    pub attitude_rms_deg: Option<f64>,
    /// The same as predicted by the published covariances.
    pub attitude_sigma_deg: Option<f64>,
}

/// Latency from capture to the published pose in ms; none without a pose.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LatencySummary {
    /// Median.
    pub p50: Option<f64>,
    /// 99th percentile.
    pub p99: Option<f64>,
}

#[derive(Debug, Default)]
struct ObjectScore {
    poses: u64,
    pairs: PosePairs,
    slots: Slots,
}

impl ObjectScore {
    fn count(&mut self, slot: u64, judged: &ScoredPose) {
        self.poses += 1;
        let (estimate, covariance) = (judged.estimate, judged.covariance);
        self.pairs
            .add(judged.capture_ns, estimate, covariance, judged.truth);
        self.slots.mark(slot);
    }

    fn summary(&self, id: &str, n_slots: u64, site_from_world: &Pose) -> ObjectSummary {
        let (errors, sigmas) = (self.pairs.errors(site_from_world), self.pairs.sigmas());
        let millimetres = |rms: Option<Rms>| rms.map(|rms| rms.position_m * 1e3);
        let degrees = |rms: Option<Rms>| rms.map(|rms| rms.attitude_rad.to_degrees());
        ObjectSummary {
            id: id.to_owned(),
            poses: self.poses,
            coverage: if self.poses > 0 {
                self.slots.covered as f64 / n_slots as f64
            } else {
                0.0
            },
            position_rms_mm: millimetres(errors),
            position_sigma_mm: millimetres(sigmas),
            attitude_rms_deg: degrees(errors),
            attitude_sigma_deg: degrees(sigmas),
        }
    }
}

/// Counts distinct slots that arrive almost in order: the newest 64 are remembered, older ones are ignored.
#[derive(Debug, Default)]
struct Slots {
    newest: u64,
    recent: u64,
    covered: u64,
}

impl Slots {
    fn mark(&mut self, slot: u64) {
        if slot > self.newest {
            let shift = slot - self.newest;
            self.recent = if shift < 64 { self.recent << shift } else { 0 };
            self.newest = slot;
        }
        let age = self.newest - slot;
        if age < 64 && self.recent & (1 << age) == 0 {
            self.recent |= 1 << age;
            self.covered += 1;
        }
    }
}

/// Histogram of latencies: bins of 0.1 ms up to 1 s, then one bin for the rest.
#[derive(Debug)]
struct Latency {
    bins: Vec<u64>,
    n: u64,
}

const BIN_NS: u64 = 100_000;
const BINS: usize = 10_000;

impl Default for Latency {
    fn default() -> Self {
        Self {
            bins: vec![0; BINS + 1],
            n: 0,
        }
    }
}

impl Latency {
    fn count(&mut self, ns: u64) {
        let bin = usize::try_from(ns / BIN_NS).map_or(BINS, |bin| bin.min(BINS));
        self.bins[bin] += 1;
        self.n += 1;
    }

    /// Upper edge of the bin at this quantile.
    fn percentile_ms(&self, share: f64) -> Option<f64> {
        let wanted = (share * self.n as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        let bin = self.bins.iter().position(|count| {
            below += count;
            below >= wanted
        })?;
        Some((bin as u64 + 1) as f64 * BIN_NS as f64 / 1e6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slot_counts_once_however_often_and_late_it_is_marked() {
        let mut slots = Slots::default();
        for slot in [0, 1, 1, 3, 2, 3, 70, 6, 69] {
            slots.mark(slot);
        }
        // Slot 6 arrives outside the window of 64 slots and is not counted.
        assert_eq!(slots.covered, 6);
    }

    #[test]
    fn percentiles_are_bin_edges() {
        let mut latency = Latency::default();
        assert_eq!(latency.percentile_ms(0.5), None);
        for ms in 1..=100 {
            latency.count(ms * 1_000_000 - 1);
        }
        assert_eq!(latency.percentile_ms(0.5), Some(50.0));
        assert_eq!(latency.percentile_ms(0.99), Some(99.0));
        latency.count(u64::MAX);
        assert_eq!(latency.percentile_ms(1.0), Some(1000.1));
    }

    #[test]
    fn an_object_without_a_pose_has_no_error_and_no_coverage() {
        let score = LiveScore::new(["cube".to_owned()], 30.0, 0, WorldFrame::Fitted);
        let summary = &score.objects()[0];
        assert_eq!((summary.coverage, summary.position_rms_mm), (0.0, None));
    }
}
