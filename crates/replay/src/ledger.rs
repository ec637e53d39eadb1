//! Which pose of a capture time is the final one: the one after the last image of exactly that time.

use sextant_site_model::ObjectId;
use sextant_site_report::{ObjectEstimate, State};
use std::collections::BTreeMap;

/// The capture times that are still open, with the last pose of each object.
#[derive(Debug, Default)]
pub struct Ledger {
    open: BTreeMap<u64, Page>,
}

#[derive(Debug, Default)]
struct Page {
    images_to_come: usize,
    poses: BTreeMap<ObjectId, ObjectEstimate>,
}

impl Ledger {
    /// The ledger of a recording with images of these capture times.
    pub fn new(capture_times_ns: impl Iterator<Item = u64>) -> Self {
        let mut ledger = Self::default();
        for time_ns in capture_times_ns {
            ledger.open.entry(time_ns).or_default().images_to_come += 1;
        }
        ledger
    }

    /// Notes what was said after an image; returns the final poses of its capture time, ordered by object, when it was
    /// the last one. Poses at another time are of an image whose stamp was put right, alone at that time, and final at
    /// once. A loss is said at a time of no image and is no pose of one.
    pub fn took(
        &mut self,
        capture_ns: u64,
        said: impl Iterator<Item = ObjectEstimate>,
    ) -> Vec<ObjectEstimate> {
        let poses = said.filter(|pose| pose.state != State::Lost);
        let (said, mut righted): (Vec<_>, Vec<_>) =
            poses.partition(|pose| pose.capture_ns == capture_ns);
        let Some(page) = self.open.get_mut(&capture_ns) else {
            return righted;
        };
        page.poses
            .extend(said.into_iter().map(|pose| (pose.object.clone(), pose)));
        page.images_to_come -= 1;
        if page.images_to_come == 0 {
            let page = self.open.remove(&capture_ns).unwrap_or_default();
            righted.extend(page.poses.into_values());
        }
        righted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::Pose;
    use sextant_site_report::State::Tracking;

    fn pose(object: &str, capture_ns: u64, x: f64, state: State) -> ObjectEstimate {
        ObjectEstimate {
            object: ObjectId::new(object).unwrap(),
            capture_ns,
            world_from_object: Pose::translation(x, 0.0, 0.0),
            covariance: Default::default(),
            twist: Default::default(),
            state,
            cameras: 1,
            tags: 1,
            rms_px: 0.0,
            articulated: None,
        }
    }

    fn xs(poses: &[ObjectEstimate]) -> Vec<(String, u64, f64)> {
        let x = |p: &ObjectEstimate| p.world_from_object.translation.x;
        let rows = poses.iter();
        rows.map(|p| (p.object.to_string(), p.capture_ns, x(p)))
            .collect()
    }

    #[test]
    fn the_pose_after_the_last_image_of_a_time_is_final() {
        let mut ledger = Ledger::new([1, 2, 1].into_iter());
        assert!(
            ledger
                .took(1, [pose("a", 1, 0.5, Tracking)].into_iter())
                .is_empty()
        );
        let at_two = ledger.took(2, [pose("a", 2, 2.0, Tracking)].into_iter());
        assert_eq!(xs(&at_two), [("a".into(), 2, 2.0)]);
        let said = [pose("b", 1, 3.0, Tracking), pose("a", 1, 1.0, Tracking)];
        let at_one = ledger.took(1, said.into_iter());
        assert_eq!(xs(&at_one), [("a".into(), 1, 1.0), ("b".into(), 1, 3.0)]);
    }

    #[test]
    fn an_image_that_says_nothing_keeps_what_was_said_before() {
        let mut ledger = Ledger::new([1, 1].into_iter());
        ledger.took(1, [pose("a", 1, 0.5, Tracking)].into_iter());
        let finals = ledger.took(1, std::iter::empty());
        assert_eq!(xs(&finals), [("a".into(), 1, 0.5)]);
    }

    #[test]
    fn losses_are_no_poses_of_an_image() {
        let mut ledger = Ledger::new([1].into_iter());
        let said = [
            pose("a", 1, 0.0, State::Lost),
            pose("b", 9, 0.0, State::Lost),
        ];
        assert!(ledger.took(1, said.into_iter()).is_empty());
        assert!(ledger.took(1, std::iter::empty()).is_empty());
    }

    #[test]
    fn a_pose_at_a_stamp_that_was_put_right_is_final() {
        let mut ledger = Ledger::new([1, 1].into_iter());
        let righted = ledger.took(1, [pose("a", 9, 2.0, Tracking)].into_iter());
        assert_eq!(xs(&righted), [("a".into(), 9, 2.0)]);
        let at_one = ledger.took(1, [pose("a", 1, 1.0, Tracking)].into_iter());
        assert_eq!(xs(&at_one), [("a".into(), 1, 1.0)]);
    }
}
