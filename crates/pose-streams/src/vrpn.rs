//! VRPN, the Virtual Reality Peripheral Network (Taylor et al. 2001; vrpn/vrpn, `Format_Of_Protocol.txt`,
//! `vrpn_Connection.C`), as a server of trackers: each object is a tracker of its name, with one sensor.
//!
//! Both ends open with a cookie of 24 bytes. Then each describes its senders and types, which gives its numbers of them
//! their names, and sends messages: a header of 24 bytes (length without the final padding, time, sender, type,
//! unused), then the payload, padded to eight bytes. Everything is big-endian. Negative types belong to the connection
//! itself.

pub(crate) mod connection;

use crate::axes::Axes;
use sextant_proto::{ObjectPose, limits};
use sextant_site_model::ObjectId;
use sextant_site_report::State;
use std::collections::BTreeMap;

/// The port that IANA has given to VRPN.
pub const VRPN_PORT: u16 = 3883;

const COOKIE_BYTES: usize = 24;
/// Version and a remote log mode of `0`: nothing is to be logged.
const COOKIE: &[u8] = b"vrpn: ver. 07.35  0";
/// The part of the cookie on which both ends must agree.
const PROTOCOL: &[u8] = b"vrpn: ver. 07.";
const HEADER_BYTES: usize = 24;
const ALIGNMENT: usize = 8;

/// Types of the connection itself.
const SENDER_DESCRIPTION: i32 = -1;
const TYPE_DESCRIPTION: i32 = -2;

/// Types of this server, each numbered by its place.
const TYPES: [&str; 3] = [
    "vrpn_Tracker Pos_Quat",
    "vrpn_Base ping_message",
    "vrpn_Base pong_message",
];
const POS_QUAT: i32 = 0;
const PONG: i32 = 2;
/// The only sensor of a tracker.
const SENSOR: i32 = 0;

/// The trackers of a server: an object becomes one with its first pose and keeps its number.
#[derive(Debug)]
pub struct VrpnTrackers {
    axes: Axes,
    numbers: BTreeMap<ObjectId, i32>,
}

/// What a pose becomes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrackerReport {
    /// The name of a new tracker, for clients that have had the descriptions of the others.
    pub description: Option<Vec<u8>>,
    /// The pose.
    pub pose: Vec<u8>,
}

impl VrpnTrackers {
    /// No trackers yet; poses will be in `axes`.
    #[must_use]
    pub fn new(axes: Axes) -> Self {
        Self {
            axes,
            numbers: BTreeMap::new(),
        }
    }

    /// What a server sends first.
    #[must_use]
    pub fn cookie() -> [u8; COOKIE_BYTES] {
        let mut cookie = [0; COOKIE_BYTES];
        cookie[..COOKIE.len()].copy_from_slice(COOKIE);
        cookie
    }

    /// The report of a tracked or coasting object; none of others, nor of more objects than a site may have.
    pub fn report(&mut self, pose: &ObjectPose) -> Option<TrackerReport> {
        if !matches!(pose.state, State::Tracking | State::Coasting) {
            return None;
        }
        let known = self.numbers.get(&pose.object).copied();
        let number = known.unwrap_or(self.numbers.len() as i32);
        if known.is_none() {
            if self.numbers.len() >= limits::MAX_OBJECTS {
                return None;
            }
            self.numbers.insert(pose.object.clone(), number);
        }
        let description = known.is_none().then(|| {
            let name = pose.object.as_str();
            describe(SENDER_DESCRIPTION, number, name, pose.capture_ns)
        });
        Some(TrackerReport {
            description,
            pose: self.pos_quat(pose, number),
        })
    }

    /// Sensor, the same once more as padding, position, quaternion x y z w.
    fn pos_quat(&self, pose: &ObjectPose, number: i32) -> Vec<u8> {
        let converted = self.axes.convert(&pose.world_from_object());
        let mut payload = [SENSOR.to_be_bytes(); 2].concat();
        for value in converted.position.into_iter().chain(converted.orientation) {
            payload.extend(value.to_be_bytes());
        }
        let header = Header {
            time_ns: pose.capture_ns,
            sender: number,
            kind: POS_QUAT,
        };
        header.message(&payload)
    }

    /// The names of all types and trackers.
    fn descriptions(&self, now_ns: u64) -> Vec<u8> {
        let types = (0..).zip(TYPES);
        let types = types.map(|(number, name)| describe(TYPE_DESCRIPTION, number, name, now_ns));
        let trackers = self.numbers.iter();
        let trackers = trackers
            .map(|(name, number)| describe(SENDER_DESCRIPTION, *number, name.as_str(), now_ns));
        types.chain(trackers).flatten().collect()
    }

    fn pong(&self, tracker: &ObjectId, now_ns: u64) -> Vec<u8> {
        let header = self.numbers.get(tracker).map(|sender| Header {
            time_ns: now_ns,
            sender: *sender,
            kind: PONG,
        });
        header.map_or_else(Vec::new, |header| header.message(&[]))
    }
}

#[derive(Debug, Clone, Copy)]
struct Header {
    time_ns: u64,
    sender: i32,
    kind: i32,
}

impl Header {
    fn message(self, payload: &[u8]) -> Vec<u8> {
        let length = (HEADER_BYTES + payload.len()) as u32;
        // Unsigned seconds last until 2106.
        let seconds = (self.time_ns / 1_000_000_000) as u32;
        let micros = (self.time_ns / 1000 % 1_000_000) as u32;
        let mut message = Vec::with_capacity(HEADER_BYTES + padded(payload.len()));
        for field in [length, seconds, micros] {
            message.extend(field.to_be_bytes());
        }
        for field in [self.sender, self.kind, 0] {
            message.extend(field.to_be_bytes());
        }
        message.extend_from_slice(payload);
        message.resize(HEADER_BYTES + padded(payload.len()), 0);
        message
    }
}

/// The length of a payload on the wire.
fn padded(length: usize) -> usize {
    length.next_multiple_of(ALIGNMENT)
}

/// A description: the number described is in the place of the sender; the name ends with a zero, which counts.
fn describe(kind: i32, number: i32, name: &str, time_ns: u64) -> Vec<u8> {
    let length = name.len() as u32 + 1;
    let payload = [&length.to_be_bytes(), name.as_bytes(), &[0]].concat();
    let header = Header {
        time_ns,
        sender: number,
        kind,
    };
    header.message(&payload)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pose and descriptions as the server of VRPN 7.38 (`vrpn_Tracker_Server::report_pose`) has sent them; its
    /// sequence number, which is no part of the protocol, is 0 here.
    #[test]
    fn messages_have_the_bytes_of_the_reference() {
        let mut trackers = VrpnTrackers::new(Axes::ZUp);
        trackers
            .numbers
            .insert(ObjectId::new("first").unwrap(), SENSOR);
        let pose = ObjectPose {
            object: ObjectId::new("cube").unwrap(),
            epoch: 1,
            sequence: 1,
            capture_ns: 1_800_000_000_123_456_789,
            published_ns: 1_800_000_000_123_456_789,
            state: State::Tracking,
            position: [1.5, -2.25, 0.75],
            orientation: [0.5, -0.5, 0.1, 0.7],
            covariance: [0.0; 36],
            twist: [0.0; 6],
            cameras: 2,
            tags: 3,
            rms_px: 0.1,
        };
        let report = trackers.report(&pose).unwrap();
        assert_eq!(
            hex(&report.pose),
            "000000586b49d2000001e240000000010000000000000000\
             0000000000000000\
             3ff8000000000000c0020000000000003fe8000000000000\
             3fe0000000000000bfe00000000000003fb999999999999a3fe6666666666666"
        );
        assert_eq!(
            hex(&report.description.unwrap()),
            "000000216b49d2000001e24000000001ffffffff00000000\
             00000005637562650000000000000000"
        );
        assert_eq!(
            hex(&describe(
                TYPE_DESCRIPTION,
                4,
                "vrpn_Tracker Pos_Quat",
                pose.capture_ns
            )),
            "000000326b49d2000001e24000000004fffffffe00000000\
             000000167672706e5f547261636b657220506f735f5175617400000000000000"
        );
        assert_eq!(trackers.report(&pose).unwrap().description, None);
        let lost = ObjectPose {
            state: State::Lost,
            ..pose
        };
        assert_eq!(trackers.report(&lost), None);
    }

    fn hex(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    #[test]
    fn the_cookie_has_24_bytes_and_no_log_mode() {
        assert_eq!(VrpnTrackers::cookie(), *b"vrpn: ver. 07.35  0\0\0\0\0\0");
    }

    #[test]
    fn a_flood_of_objects_ends_at_the_bound() {
        let mut trackers = VrpnTrackers::new(Axes::ZUp);
        for number in 0..limits::MAX_OBJECTS {
            let id = ObjectId::new(&format!("o{number}")).unwrap();
            trackers.numbers.insert(id, number as i32);
        }
        let pose = ObjectPose {
            object: ObjectId::new("more").unwrap(),
            epoch: 1,
            sequence: 1,
            capture_ns: 1,
            published_ns: 1,
            state: State::Tracking,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            covariance: [0.0; 36],
            twist: [0.0; 6],
            cameras: 1,
            tags: 1,
            rms_px: 0.1,
        };
        assert_eq!(trackers.report(&pose), None);
    }
}
