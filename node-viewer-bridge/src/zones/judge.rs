//! Which object is in which zone, by its poses and their covariance.
//!
//! A boundary is crossed when the object's origin lies beyond it by more than two sigma along the boundary's normal and
//! at least 5 mm, and has done so for a tenth of a second. Between the two thresholds an object stays where it was, so
//! that neither noise nor an object at rest on the boundary makes events. The first judgement of an object in a zone is
//! silent: it was there before.

use super::event::EventKind;
use super::fall::FallDetector;
use super::sample::Sample;
use super::zone::Zone;
use sextant_site_mirror::limits::{FORGOTTEN_NS, OBJECTS};
use sextant_site_model::ObjectId;
use std::collections::BTreeMap;

/// A pose that is older by more than this begins anew: the clock of the site was set.
const CLOCK_SET_NS: u64 = 10_000_000_000;
const SIGMAS: f64 = 2.0;
const MARGIN_M: f64 = 0.005;
const HOLD_NS: u64 = 100_000_000;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Inside,
    Outside,
}

/// An object and a zone.
#[derive(Debug, Clone, Copy, Default)]
struct Presence {
    side: Option<Side>,
    /// Since when it is beyond the threshold of the other side.
    crossing_since_ns: Option<u64>,
}

impl Presence {
    /// Takes what the newest pose shows, if it shows a side clearly; returns the side on a change.
    fn handle(&mut self, t_ns: u64, clear: Option<Side>) -> Option<Side> {
        let Some(clear) = clear.filter(|side| self.side != Some(*side)) else {
            self.crossing_since_ns = None;
            return None;
        };
        let since = *self.crossing_since_ns.get_or_insert(t_ns);
        if t_ns - since < HOLD_NS {
            return None;
        }
        self.crossing_since_ns = None;
        self.side = Some(clear);
        Some(clear)
    }
}

#[derive(Debug, Default)]
struct Track {
    last_ns: u64,
    /// By the zone's name.
    presences: BTreeMap<String, Presence>,
    fall: FallDetector,
}

/// What a pose brought.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Judgement {
    pub(crate) events: Vec<EventKind>,
    /// Whether the lists of objects inside differ.
    pub(crate) occupancy_changed: bool,
}

/// Follows all objects. Drop rule: a new one takes the place of the one that was silent longest, for [`FORGOTTEN_NS`]
/// at least.
#[derive(Debug, Default)]
pub(crate) struct Judge {
    zones: Vec<Zone>,
    tracks: BTreeMap<ObjectId, Track>,
}

impl Judge {
    pub(crate) fn zones(&self) -> &[Zone] {
        &self.zones
    }

    /// Judgements about zones that stay as they are remain.
    pub(crate) fn set_zones(&mut self, zones: Vec<Zone>) {
        let unchanged = |name: &str| {
            let of = |zones: &[Zone]| zones.iter().find(|zone| zone.name() == name).cloned();
            of(&zones) == of(&self.zones)
        };
        for track in self.tracks.values_mut() {
            track.presences.retain(|name, _| unchanged(name));
        }
        self.zones = zones;
    }

    /// Objects in a zone.
    pub(crate) fn inside<'a>(&'a self, zone: &'a Zone) -> impl Iterator<Item = &'a ObjectId> {
        let tracks = self.tracks.iter();
        tracks.filter_map(|(object, track)| {
            let side = track.presences.get(zone.name())?.side;
            (side == Some(Side::Inside)).then_some(object)
        })
    }

    /// There is no such object any more. Returns whether it was in a zone.
    pub(crate) fn forget(&mut self, object: &ObjectId) -> bool {
        let track = self.tracks.remove(object);
        track.is_some_and(|track| {
            let mut sides = track.presences.values().map(|presence| presence.side);
            sides.any(|side| side == Some(Side::Inside))
        })
    }

    /// Takes a pose. One that is not newer than the object's last is passed over.
    pub(crate) fn handle(&mut self, object: &ObjectId, sample: &Sample) -> Judgement {
        let mut judgement = Judgement::default();
        let Some(track) = track_of(&mut self.tracks, object, sample.t_ns) else {
            return judgement;
        };
        if sample.t_ns <= track.last_ns {
            return judgement;
        }
        track.last_ns = sample.t_ns;
        for zone in &self.zones {
            let name = zone.name();
            let presence = match track.presences.get_mut(name) {
                Some(known) => known,
                None => track.presences.entry(name.to_owned()).or_default(),
            };
            let before = presence.side;
            let Some(side) = presence.handle(sample.t_ns, clear_side(zone, sample)) else {
                continue;
            };
            judgement.occupancy_changed |= before.is_some() || side == Side::Inside;
            let zone = name.to_owned();
            judgement.events.extend(before.map(|_| match side {
                Side::Inside => EventKind::Entered { zone },
                Side::Outside => EventKind::Left { zone },
            }));
        }
        if sample.is_measured {
            let fall = track.fall.handle(sample);
            judgement
                .events
                .extend(fall.map(|cause| EventKind::Fell { cause }));
        }
        judgement
    }
}

/// The side that the pose shows clearly, if any.
fn clear_side(zone: &Zone, sample: &Sample) -> Option<Side> {
    let at = zone.depth_of(&sample.position);
    let threshold = MARGIN_M.max(SIGMAS * sample.sigma_along(&at.inward));
    if at.depth > threshold {
        Some(Side::Inside)
    } else if at.depth < -threshold {
        Some(Side::Outside)
    } else {
        None
    }
}

fn track_of<'a>(
    tracks: &'a mut BTreeMap<ObjectId, Track>,
    object: &ObjectId,
    t_ns: u64,
) -> Option<&'a mut Track> {
    let is_new = !tracks.contains_key(object);
    if is_new && tracks.len() >= OBJECTS {
        let (oldest, last_ns) = tracks
            .iter()
            .map(|(id, track)| (id, track.last_ns))
            .min_by_key(|(_, last_ns)| *last_ns)?;
        if t_ns.saturating_sub(last_ns) < FORGOTTEN_NS {
            return None;
        }
        let oldest = oldest.clone();
        tracks.remove(&oldest);
    }
    let track = tracks.entry(object.clone()).or_default();
    if track.last_ns.saturating_sub(t_ns) > CLOCK_SET_NS {
        *track = Track::default();
    }
    Some(track)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix6, UnitQuaternion, Vector3};

    const FRAME_NS: u64 = 33_000_000;

    fn dock() -> Zone {
        Zone::Box {
            name: "dock".to_owned(),
            centre: [0.0; 3],
            size: [1.0; 3],
            yaw_deg: 0.0,
        }
    }

    fn sample(frame: u64, x: f64, sigma: f64) -> Sample {
        Sample {
            t_ns: 1 + frame * FRAME_NS,
            position: Vector3::new(x, 0.0, 0.0),
            orientation: UnitQuaternion::identity(),
            covariance: Matrix6::identity() * sigma * sigma,
            speed: 0.0,
            angular_speed: 0.0,
            is_measured: true,
        }
    }

    fn cube() -> ObjectId {
        ObjectId::new("cube").unwrap()
    }

    /// What is reported while the cube goes through these x, a pose each.
    fn events(sigma: f64, path: impl IntoIterator<Item = f64>) -> Vec<EventKind> {
        let mut judge = Judge::default();
        judge.set_zones(vec![dock()]);
        let samples = path.into_iter().zip(0..);
        samples
            .flat_map(|(x, frame)| judge.handle(&cube(), &sample(frame, x, sigma)).events)
            .collect()
    }

    fn stay(x: f64) -> [f64; 10] {
        [x; 10]
    }

    fn entered() -> EventKind {
        EventKind::Entered {
            zone: "dock".to_owned(),
        }
    }

    fn left() -> EventKind {
        EventKind::Left {
            zone: "dock".to_owned(),
        }
    }

    #[test]
    fn crossing_the_boundary_is_an_event_each_way() {
        let path = [stay(1.0), stay(0.2), stay(1.0)].concat();
        assert_eq!(events(0.001, path), [entered(), left()]);
    }

    #[test]
    fn where_an_object_is_first_seen_is_no_event() {
        assert_eq!(events(0.001, stay(0.0)), []);
        let mut judge = Judge::default();
        judge.set_zones(vec![dock()]);
        for frame in 0..10 {
            judge.handle(&cube(), &sample(frame, 0.0, 0.001));
        }
        assert_eq!(judge.inside(&dock()).collect::<Vec<_>>(), [&cube()]);
        assert!(judge.forget(&cube()));
        assert_eq!(judge.inside(&dock()).count(), 0);
    }

    #[test]
    fn an_object_that_trembles_on_the_boundary_makes_no_events() {
        let trembling = (0..200).map(|frame| if frame % 2 == 0 { 0.496 } else { 0.504 });
        assert_eq!(events(0.001, stay(1.0).into_iter().chain(trembling)), []);
    }

    #[test]
    fn an_outlier_shorter_than_the_hold_time_is_no_event() {
        let path = [&stay(1.0)[..], &[0.0; 3], &stay(1.0)].concat();
        assert_eq!(events(0.001, path), []);
    }

    #[test]
    fn what_the_covariance_leaves_open_is_no_event() {
        let path = [stay(1.0), stay(0.4)].concat();
        assert_eq!(events(0.06, path.clone()), []);
        assert_eq!(events(0.04, path), [entered()]);
    }

    #[test]
    fn late_poses_are_passed_over() {
        let mut judge = Judge::default();
        judge.set_zones(vec![dock()]);
        for frame in 10..20 {
            judge.handle(&cube(), &sample(frame, 1.0, 0.001));
        }
        for frame in 0..10 {
            let judgement = judge.handle(&cube(), &sample(frame, 0.0, 0.001));
            assert_eq!(judgement, Judgement::default());
        }
    }

    #[test]
    fn changing_one_zone_leaves_the_others_alone() {
        let mut judge = Judge::default();
        let ball = |radius| Zone::Sphere {
            name: "ball".to_owned(),
            centre: [0.0; 3],
            radius,
        };
        judge.set_zones(vec![dock(), ball(1.0)]);
        for frame in 0..10 {
            judge.handle(&cube(), &sample(frame, 0.0, 0.001));
        }
        judge.set_zones(vec![dock(), ball(2.0)]);
        assert_eq!(judge.inside(&dock()).count(), 1);
        assert_eq!(judge.inside(&ball(2.0)).count(), 0);
    }

    #[test]
    fn a_flood_of_objects_ends_at_the_bound_and_silent_ones_give_way() {
        let mut judge = Judge::default();
        judge.set_zones(vec![dock()]);
        let object = |n: usize| ObjectId::new(&format!("o{n}")).unwrap();
        for n in 0..2 * OBJECTS {
            judge.handle(&object(n), &sample(0, 0.0, 0.001));
        }
        assert_eq!(judge.tracks.len(), OBJECTS);
        assert!(!judge.tracks.contains_key(&object(OBJECTS)));
        let later = FORGOTTEN_NS / FRAME_NS + 1;
        judge.handle(&object(OBJECTS), &sample(later, 0.0, 0.001));
        assert_eq!(judge.tracks.len(), OBJECTS);
        assert!(judge.tracks.contains_key(&object(OBJECTS)));
    }
}
