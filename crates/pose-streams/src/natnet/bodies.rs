//! The rigid bodies of a server: their descriptions, and the frames that their poses become.

use super::{FRAME, MAX_DATAGRAM_BYTES, MODEL_DEFINITIONS, Message, NatNetVersion};
use crate::axes::Axes;
use crate::narrowed;
use crate::roster::{Member, Roster};
use nalgebra::UnitQuaternion;
use sextant_geometry::Pose;
use sextant_proto::ObjectPose;
use sextant_site_model::{ObjectId, ObjectModel};
use std::collections::BTreeMap;

/// Most markers of a body, as the clients of the SDK have room for.
const MAX_MARKERS: usize = 20;
/// No body is part of another one.
const NO_PARENT: i32 = -1;
/// The type of a description.
const RIGID_BODY: i32 = 1;
/// Parameters of bodies and frames.
const TRACKING_VALID: u16 = 1;
const MODELS_CHANGED: u16 = 2;

/// The bodies of a server. An object becomes one when it is named, described or seen first, and keeps its number, which
/// counts from 1.
#[derive(Debug)]
pub struct NatNetBodies {
    axes: Axes,
    roster: Roster,
    markers: BTreeMap<ObjectId, Vec<Marker>>,
    frame: i32,
    changed: bool,
}

#[derive(Debug, PartialEq)]
struct Marker {
    name: String,
    position: [f32; 3],
}

impl NatNetBodies {
    /// Bodies with these names first, in their order.
    #[must_use]
    pub fn new(axes: Axes, names: &[ObjectId]) -> Self {
        Self {
            axes,
            roster: Roster::new(names),
            markers: BTreeMap::new(),
            frame: 1,
            changed: true,
        }
    }

    /// Takes the model of an object: its markers are the centres of the first tags that are placed.
    pub fn describe(&mut self, model: &ObjectModel) {
        let axes = self.axes;
        // The places of tags on links are those in their links.
        let tags = model.tags().iter().filter(|tag| tag.link.is_none());
        let placed = tags.filter_map(|tag| Some((tag.tag.to_string(), tag.object_from_tag?)));
        let markers = placed.take(MAX_MARKERS).map(|(name, object_from_tag)| {
            let centre = Pose::from_parts(object_from_tag.translation, UnitQuaternion::identity());
            Marker {
                name,
                position: axes.convert(&centre).position.map(narrowed),
            }
        });
        let markers: Vec<Marker> = markers.collect();
        self.changed |= self.roster.add(model.id());
        if self.roster.has(model.id()) && self.markers.get(model.id()) != Some(&markers) {
            self.markers.insert(model.id().clone(), markers);
            self.changed = true;
        }
    }

    /// Takes a pose; returns whether there is now a new pose of every body that is tracked.
    pub fn take(&mut self, pose: &ObjectPose) -> bool {
        self.changed |= self.roster.take(pose);
        self.roster.is_complete()
    }

    /// What follows belongs to the next frame.
    pub fn next_frame(&mut self) {
        self.frame = self.frame.wrapping_add(1) & i32::MAX;
        self.roster.age();
        self.changed = false;
    }

    /// The frame of the newest poses, sent at `sent_ns`. It has all bodies that have been seen; a body is valid where
    /// its pose is new and tracked.
    #[must_use]
    pub fn frame(&self, version: NatNetVersion, sent_ns: u64) -> Vec<u8> {
        let newest = self.roster.seen().map(|(.., pose)| pose);
        let newest = newest.max_by_key(|pose| pose.capture_ns);
        let (capture_ns, published_ns) =
            newest.map_or((0, 0), |pose| (pose.capture_ns, pose.published_ns));
        let mut message = Message::new(FRAME, version);
        message.i32(self.frame);
        let empty = |message: &mut Message| message.with_length(0, |_| {});
        // Marker sets, unlabelled markers.
        empty(&mut message);
        empty(&mut message);
        message.with_length(self.roster.seen().count() as i32, |message| {
            for (number, body, pose) in self.roster.seen() {
                self.write_pose(number, body, pose, message);
            }
        });
        // Skeletons; assets; labelled markers, force plates, devices.
        empty(&mut message);
        if version.states_lengths() {
            empty(&mut message);
        }
        (0..3).for_each(|_| empty(&mut message));
        // No time code and no fraction of it.
        message.i32(0);
        message.i32(0);
        message
            .bytes
            .extend((capture_ns as f64 * 1e-9).to_le_bytes());
        for time_ns in [capture_ns, published_ns, sent_ns] {
            message.u64(time_ns);
        }
        if version.states_lengths() {
            // No time of PTP.
            message.u64(0);
        }
        message.u16(if self.changed { MODELS_CHANGED } else { 0 });
        // The end.
        message.i32(0);
        message.finish()
    }

    /// The descriptions of all bodies, or of the first that a datagram has room for.
    #[must_use]
    pub fn definitions(&self, version: NatNetVersion) -> Vec<u8> {
        let mut list = Message::new(MODEL_DEFINITIONS, version);
        let at = list.bytes.len();
        list.i32(0);
        let mut n_described = 0_i32;
        for (number, body) in self.roster.numbered() {
            let end = list.bytes.len();
            list.with_length(RIGID_BODY, |message| {
                self.write_description(number, &body.name, message);
            });
            if list.bytes.len() > MAX_DATAGRAM_BYTES {
                list.bytes.truncate(end);
                break;
            }
            n_described += 1;
        }
        list.bytes[at..at + 4].copy_from_slice(&n_described.to_le_bytes());
        list.finish()
    }

    fn write_pose(&self, number: u16, body: &Member, pose: &ObjectPose, message: &mut Message) {
        let converted = self.axes.convert(&pose.world_from_object());
        message.i32(number.into());
        message.f32s(&converted.position.map(narrowed));
        message.f32s(&converted.orientation.map(narrowed));
        message.f32s(&[position_sigma(pose)]);
        message.u16(if body.is_measured() {
            TRACKING_VALID
        } else {
            0
        });
    }

    fn write_description(&self, number: u16, name: &ObjectId, message: &mut Message) {
        message.text(name.as_str());
        message.i32(number.into());
        message.i32(NO_PARENT);
        // The body is where its pose is.
        message.f32s(&[0.0; 3]);
        let markers = self.markers.get(name).map_or(&[][..], Vec::as_slice);
        message.i32(markers.len() as i32);
        for marker in markers {
            message.f32s(&marker.position);
        }
        for _ in markers {
            // A passive marker.
            message.i32(0);
        }
        if message.version.states_lengths() {
            for marker in markers {
                message.text(&marker.name);
            }
        }
    }
}

/// The mean error of a body, m: the root mean square over the axes of the standard deviations of its position.
fn position_sigma(pose: &ObjectPose) -> f32 {
    let [x, y, z] = [0, 7, 14].map(|place| pose.covariance[place]);
    narrowed(((x + y + z) / 3.0).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::limits;
    use sextant_site_model::{ObjectTag, TagId};
    use sextant_site_report::State;
    use sextant_tag_families::Family;

    const V3: NatNetVersion = NatNetVersion { major: 3, minor: 1 };
    const V4: NatNetVersion = NatNetVersion::NEWEST;

    fn pose(object: &str, capture_ns: u64) -> ObjectPose {
        ObjectPose {
            object: ObjectId::new(object).unwrap(),
            epoch: 1,
            sequence: 1,
            capture_ns,
            published_ns: capture_ns + 5,
            state: State::Tracking,
            position: [1.5, -2.25, 0.75],
            orientation: [0.0, 0.0, 0.0, 1.0],
            covariance: std::array::from_fn(|at| if at % 7 == 0 { 1e-6 } else { 0.0 }),
            twist: [0.0; 6],
            cameras: 2,
            tags: 3,
            rms_px: 0.1,
        }
    }

    fn hex(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// Made by Python's `struct` after `MoCapData` of the SDK's Python client and a frame recorded of Motive 2.0.
    #[test]
    fn frames_have_the_bytes_of_their_version() {
        let mut bodies = NatNetBodies::new(Axes::YUp, &[]);
        assert!(bodies.take(&pose("cube", 1_800_000_000_123_456_789)));
        assert_eq!(
            hex(&bodies.frame(V3, 7)),
            "0700740001000000000000000000000001000000010000000000c03f0000403f0000104000000000\
             00000000000000000000803f6f12833a010000000000000000000000000000000000000000000000\
             0000b8e6078074d2da4115cd0f9b76e2fa181acd0f9b76e2fa180700000000000000020000000000"
        );
        assert_eq!(
            hex(&bodies.frame(V4, 7)),
            "0700a00001000000000000000000000000000000000000000100000026000000010000000000c03f\
             0000403f000010400000000000000000000000000000803f6f12833a010000000000000000000000\
             0000000000000000000000000000000000000000000000000000000000000000000000000000b8e6\
             078074d2da4115cd0f9b76e2fa181acd0f9b76e2fa18070000000000000000000000000000000200\
             00000000"
        );
    }

    #[test]
    fn only_new_tracked_poses_are_valid() {
        let mut bodies = NatNetBodies::new(Axes::ZUp, &[]);
        let valid = |bodies: &NatNetBodies| {
            let frame = bodies.frame(V3, 0);
            [0, 1].map(|n| frame[20 + 38 * n + 36])
        };
        assert!(bodies.take(&pose("ball", 1)));
        assert!(bodies.take(&pose("cube", 1)));
        assert_eq!(valid(&bodies), [1, 1]);
        bodies.next_frame();
        assert!(!bodies.take(&pose("cube", 2)));
        assert_eq!(valid(&bodies), [0, 1]);
        let coasting = ObjectPose {
            state: State::Coasting,
            ..pose("ball", 3)
        };
        bodies.take(&coasting);
        assert_eq!(valid(&bodies), [0, 1]);
    }

    #[test]
    fn tags_become_markers_and_a_change_is_announced_once() {
        let cube = ObjectId::new("cube").unwrap();
        let mut bodies = NatNetBodies::new(Axes::YUp, &[ObjectId::new("tray").unwrap()]);
        let tags = (0..30).map(|id| {
            let place = Pose::translation(0.0, 0.0, f64::from(id));
            ObjectTag::new(
                TagId {
                    family: Family::Tag36h11,
                    id,
                },
                0.04,
                Some(place),
            )
        });
        let model = ObjectModel::new(cube, tags.collect()).unwrap();
        bodies.describe(&model);
        let params = |bodies: &NatNetBodies| bodies.frame(V4, 0).into_iter().nth_back(5);
        assert_eq!(params(&bodies), Some(2));
        bodies.next_frame();
        bodies.describe(&model);
        assert_eq!(params(&bodies), Some(0));
        let definitions = bodies.definitions(V3);
        let (tray, cube) = (4 + 4, 4 + 4 + 33);
        assert_eq!(definitions[4..tray + 4], [2, 0, 0, 0, 1, 0, 0, 0]);
        assert_eq!(definitions[cube + 4..cube + 9], *b"cube\0");
        // Its second marker lies a metre above the first.
        let markers = cube + 4 + 5 + 4 + 4 + 12;
        assert_eq!(definitions[markers..markers + 4], [20, 0, 0, 0]);
        assert_eq!(
            definitions[markers + 4 + 16..markers + 4 + 20],
            1_f32.to_le_bytes()
        );
        assert_eq!(definitions.len(), markers + 4 + 20 * 16);
    }

    #[test]
    fn a_flood_of_objects_ends_at_the_bound_and_fits_a_datagram() {
        let mut bodies = NatNetBodies::new(Axes::ZUp, &[]);
        for number in 0..2 * limits::MAX_OBJECTS {
            bodies.take(&pose(&format!("o{number}-{}", "x".repeat(20)), 1));
        }
        assert_eq!(bodies.roster.seen().count(), limits::MAX_OBJECTS);
        assert!(bodies.definitions(V4).len() <= MAX_DATAGRAM_BYTES);
        assert!(bodies.frame(V4, 0).len() <= MAX_DATAGRAM_BYTES);
    }
}
