//! Apparent ages of images on arrival. No image arrives before it was taken, and the quickest images of a camera arrive about as quickly as
//! those of others, so that timestamps which are wrong by seconds show in the age.

use std::collections::{BTreeMap, VecDeque};

/// Images of a camera of which the quickest counts: about a second of them.
const REMEMBERED: usize = 32;
/// Fewest images that are equally late, and the largest difference between them, ns: less than the time between images, so that delayed
/// images which arrive at once do not count.
const LASTING: usize = 3;
const EQUALLY_NS: i64 = 15_000_000;

/// The apparent ages of the cameras' last images on arrival, by camera index.
#[derive(Debug, Default)]
pub(crate) struct ArrivalDelays(BTreeMap<usize, Ages>);

/// In ns.
#[derive(Debug, Default)]
struct Ages {
    last: VecDeque<i64>,
    /// The least of them; cached, since every image needs that of every camera.
    least: Option<i64>,
}

impl ArrivalDelays {
    /// An image with this stamp arrived at `now_ns`.
    pub fn record(&mut self, camera_index: usize, now_ns: u64, stamp_ns: u64) {
        let ages = self.0.entry(camera_index).or_default();
        if ages.last.len() == REMEMBERED {
            ages.last.pop_front();
        }
        ages.last.push_back(now_ns.wrapping_sub(stamp_ns) as i64);
        ages.least = ages.last.iter().min().copied();
    }

    /// Forgets a camera whose timestamps have been corrected.
    pub fn forget(&mut self, camera_index: usize) {
        self.0.remove(&camera_index);
    }

    /// The age of the quickest of the camera's last images, if these came equally late.
    fn equal_age_ns(&self, camera_index: usize) -> Option<i64> {
        let ages = self.0.get(&camera_index)?.last.iter().rev();
        let last: Vec<i64> = ages.take(LASTING).copied().collect();
        let (least, most) = last.iter().min().zip(last.iter().max())?;
        let equal = most.saturating_sub(*least) < EQUALLY_NS && last.len() == LASTING;
        equal.then_some(*least)
    }

    /// Cameras with images, by index.
    pub fn all(&self) -> impl Iterator<Item = usize> {
        self.0.keys().copied()
    }

    /// Number of cameras with images.
    pub fn cameras(&self) -> usize {
        self.0.len()
    }

    /// Apparent age of the camera's quickest image, ns; below zero where stamps lie ahead.
    pub fn age_ns(&self, camera_index: usize) -> Option<i64> {
        self.0.get(&camera_index)?.least
    }

    /// Lead of the camera's timestamps over those of the other cameras, ns: against the median, or the nearer of two.
    pub fn lead_ns(&self, camera_index: usize) -> Option<i64> {
        self.lead_at(camera_index, self.age_ns(camera_index)?)
    }

    /// The same by the camera's last images, if they were equally late.
    pub fn last_lead_ns(&self, camera_index: usize) -> Option<i64> {
        self.lead_at(camera_index, self.equal_age_ns(camera_index)?)
    }

    fn lead_at(&self, camera_index: usize, own: i64) -> Option<i64> {
        let others = self.0.iter().filter(|(other, _)| **other != camera_index);
        let mut ages: Vec<i64> = others.filter_map(|(_, ages)| ages.least).collect();
        ages.sort_unstable();
        let last = ages.len().checked_sub(1)?;
        let leads = [last / 2, last.div_ceil(2)].map(|middle| ages[middle].saturating_sub(own));
        leads.into_iter().min_by_key(|lead| lead.saturating_abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_ahead_of_the_others_is_seen_by_its_quickest_image() {
        let mut latencies = ArrivalDelays::default();
        for (camera, ages) in [(0, [30, 12]), (1, [-88, 40]), (2, [11, 900])] {
            for age in ages {
                latencies.record(camera, 5_000, 5_000_u64.wrapping_sub_signed(age));
            }
        }
        assert_eq!(latencies.age_ns(1), Some(-88));
        assert_eq!(latencies.lead_ns(1), Some(99));
        assert_eq!(latencies.lead_ns(2), Some(1));
        assert_eq!(latencies.last_lead_ns(0), None);
        latencies.forget(1);
        assert_eq!(latencies.lead_ns(1), None);
    }

    #[test]
    fn a_camera_that_falls_behind_is_seen_by_its_last_images() {
        let mut latencies = ArrivalDelays::default();
        for image in 0..40 {
            let stamp_ns = image * 33_000_000;
            let age_ns = if image < 37 { 10_000_000 } else { 110_000_000 };
            latencies.record(0, stamp_ns + 10_000_000, stamp_ns);
            latencies.record(1, stamp_ns + age_ns, stamp_ns);
        }
        assert_eq!(latencies.lead_ns(1), Some(0));
        assert_eq!(latencies.last_lead_ns(1), Some(-100_000_000));
    }

    #[test]
    fn images_that_come_at_once_after_a_pause_are_not_equally_late() {
        let mut latencies = ArrivalDelays::default();
        let second = 1_000_000_000;
        for image in 0..3 {
            let stamp_ns = second + image * 33_000_000;
            latencies.record(0, 2 * second, stamp_ns);
            latencies.record(1, stamp_ns + 300_000_000 + image, stamp_ns);
        }
        assert_eq!(latencies.last_lead_ns(0), None);
        assert!(latencies.last_lead_ns(1).is_some());
    }
}
