//! Apparent ages of images on arrival. No image arrives before it was taken, and the quickest images of a camera arrive
//! about as quickly as those of others, so that timestamps which are wrong by seconds show in the age.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Images of a camera of which the quickest counts: about a second of them.
const REMEMBERED: usize = 32;
/// Fewest images that are equally late, and the largest difference between them, ns: less than the time between images,
/// so that delayed images which arrive at once do not count.
const LASTING: usize = 3;
const EQUALLY_NS: i64 = 15_000_000;

/// Differences of clocks and of ways to this host together that are no reason to doubt a clock, ns: offsets within it
/// show in the motion.
const TOGETHER_NS: i64 = 1_000_000_000;

/// The apparent ages of the cameras' last images on arrival.
#[derive(Debug, Default)]
pub(crate) struct ArrivalDelays {
    /// By camera index.
    cameras: BTreeMap<usize, Ages>,
    majority: Option<Majority>,
}

/// The time that most clocks agree on, this host's among them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Majority {
    /// The cameras that agree, by index.
    pub cameras: BTreeSet<usize>,
    /// Whether this host's clock is one of them.
    pub has_host: bool,
    /// Least apparent age of the images of these cameras on arrival, ns: beyond a second the host's clock is off by
    /// about that.
    pub age_ns: i64,
}

/// In ns.
#[derive(Debug, Default)]
struct Ages {
    last: VecDeque<i64>,
    /// [`least_but_one`] of them; cached, since every image needs that of every camera.
    least: Option<i64>,
}

impl ArrivalDelays {
    /// An image with this stamp arrived at `now_ns`. Clocks within `together_ns`, or a second, agree.
    pub fn record(&mut self, camera_index: usize, now_ns: u64, stamp_ns: u64, together_ns: i64) {
        let ages = self.cameras.entry(camera_index).or_default();
        if ages.last.len() == REMEMBERED {
            ages.last.pop_front();
        }
        ages.last.push_back(now_ns.wrapping_sub(stamp_ns) as i64);
        let least = least_but_one(&ages.last);
        if ages.least != least {
            ages.least = least;
            self.majority = self.find_majority(together_ns);
        }
    }

    /// Forgets a camera whose timestamps have been corrected.
    pub fn forget(&mut self, camera_index: usize) {
        self.cameras.remove(&camera_index);
    }

    /// The time that most clocks agree on; `None` before any image.
    pub fn majority(&self) -> Option<&Majority> {
        self.majority.as_ref()
    }

    /// The largest set of cameras whose images seem to be of one age. This host's clock is one voter more; of equal
    /// sets the one with the host counts, or that which is nearest to it.
    fn find_majority(&self, together_ns: i64) -> Option<Majority> {
        let together_ns = TOGETHER_NS.max(together_ns);
        let cameras = self.cameras.iter();
        let ages = cameras.filter_map(|(camera, ages)| Some((ages.least?, *camera)));
        let mut ages: Vec<(i64, usize)> = ages.collect();
        ages.sort_unstable();
        let set_from = |first: usize| {
            let (age_ns, _) = ages[first];
            let last_ns = age_ns.saturating_add(together_ns);
            let end = ages.partition_point(|(age_ns, _)| *age_ns <= last_ns);
            let has_host = (-together_ns..=together_ns).contains(&age_ns);
            (first..end, has_host)
        };
        let (set, has_host) = (0..ages.len())
            .map(set_from)
            .max_by_key(|(set, has_host)| {
                let apart_ns = ages[set.start].0.unsigned_abs();
                (
                    set.len() + usize::from(*has_host),
                    *has_host,
                    Reverse(apart_ns),
                )
            })?;
        Some(Majority {
            age_ns: ages[set.start].0,
            cameras: ages[set].iter().map(|(_, camera)| *camera).collect(),
            has_host,
        })
    }

    /// The age of the quickest of the camera's last images, if these came equally late.
    fn equal_age_ns(&self, camera_index: usize) -> Option<i64> {
        let ages = self.cameras.get(&camera_index)?.last.iter().rev();
        let last: Vec<i64> = ages.take(LASTING).copied().collect();
        let (least, most) = last.iter().min().zip(last.iter().max())?;
        let equal = most.saturating_sub(*least) < EQUALLY_NS && last.len() == LASTING;
        equal.then_some(*least)
    }

    /// Cameras with images, by index.
    pub fn all(&self) -> impl Iterator<Item = usize> {
        self.cameras.keys().copied()
    }

    /// Number of cameras with images.
    pub fn cameras(&self) -> usize {
        self.cameras.len()
    }

    /// Apparent age of the camera's quickest image, ns; below zero where stamps lie ahead.
    pub fn age_ns(&self, camera_index: usize) -> Option<i64> {
        self.cameras.get(&camera_index)?.least
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
        let others = self
            .cameras
            .iter()
            .filter(|(other, _)| **other != camera_index);
        let mut ages: Vec<i64> = others.filter_map(|(_, ages)| ages.least).collect();
        ages.sort_unstable();
        let last = ages.len().checked_sub(1)?;
        let leads = [last / 2, last.div_ceil(2)].map(|middle| ages[middle].saturating_sub(own));
        leads.into_iter().min_by_key(|lead| lead.saturating_abs())
    }
}

/// The least age but one, so that a single stamp that is wrong does not count; of fewer than three the least.
fn least_but_one(ages: &VecDeque<i64>) -> Option<i64> {
    let mut least = [i64::MAX; 2];
    for age_ns in ages {
        if *age_ns < least[0] {
            least = [*age_ns, least[0]];
        } else {
            least[1] = least[1].min(*age_ns);
        }
    }
    match ages.len() {
        0 => None,
        1 | 2 => Some(least[0]),
        _ => Some(least[1]),
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
                latencies.record(camera, 5_000, 5_000_u64.wrapping_sub_signed(age), 0);
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
    fn most_clocks_are_right_and_of_two_the_one_that_agrees_with_the_host() {
        let majority = |ages_s: &[i64]| {
            let mut latencies = ArrivalDelays::default();
            for (camera, age_s) in ages_s.iter().enumerate() {
                let stamp_ns = 10_000_u64.wrapping_sub_signed(age_s * 1_000_000_000);
                latencies.record(camera, 10_000, stamp_ns, 0);
            }
            let found = latencies.majority()?;
            Some((
                found.cameras.iter().copied().collect::<Vec<_>>(),
                found.has_host,
            ))
        };
        assert_eq!(majority(&[]), None);
        assert_eq!(majority(&[3600]), Some((vec![0], false)));
        assert_eq!(majority(&[3600, 0]), Some((vec![1], true)));
        assert_eq!(majority(&[3600, 3600, 0]), Some((vec![2], true)));
        assert_eq!(
            majority(&[3600, 0, 3600, 3600]),
            Some((vec![0, 2, 3], false))
        );
        assert_eq!(majority(&[0, -7200, 0]), Some((vec![0, 2], true)));
        assert_eq!(majority(&[5000, -7200]), Some((vec![0], false)));
    }

    #[test]
    fn a_camera_that_falls_behind_is_seen_by_its_last_images() {
        let mut latencies = ArrivalDelays::default();
        for image in 0..40 {
            let stamp_ns = image * 33_000_000;
            let age_ns = if image < 37 { 10_000_000 } else { 110_000_000 };
            latencies.record(0, stamp_ns + 10_000_000, stamp_ns, 0);
            latencies.record(1, stamp_ns + age_ns, stamp_ns, 0);
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
            latencies.record(0, 2 * second, stamp_ns, 0);
            latencies.record(1, stamp_ns + 300_000_000 + image, stamp_ns, 0);
        }
        assert_eq!(latencies.last_lead_ns(0), None);
        assert!(latencies.last_lead_ns(1).is_some());
    }
}
