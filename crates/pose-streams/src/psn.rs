//! PosiStageNet 2 (VYV and MA Lighting, protocol 2.03), the positions of things on a stage: each object is a tracker.
//!
//! A packet is a tree of chunks: 16 bits of id, 15 of length, one that says whether further chunks are in it, and the
//! content, all little-endian. Packets with data have positions, those with information names; each has at most 1500
//! bytes, so that a frame may have several. Times are in microseconds since the server has started. Axes are x to the
//! right, y up, z into the depth: left-handed, metres. An orientation is the axis of a rotation, as long as its angle
//! in radians.

use crate::axes::Axes;
use crate::narrowed;
use crate::roster::Roster;
use nalgebra::{Quaternion, UnitQuaternion};
use sextant_proto::ObjectPose;
use sextant_site_model::ObjectId;
use sextant_site_report::State;
use std::net::{Ipv4Addr, SocketAddrV4};

/// The multicast group on which receivers listen.
pub const PSN_GROUP: SocketAddrV4 = SocketAddrV4::new(Ipv4Addr::new(236, 10, 10, 10), 56565);

const DATA_PACKET: u16 = 0x6755;
const INFO_PACKET: u16 = 0x6756;
const HEADER: u16 = 0;
const DATA_TRACKERS: u16 = 1;
const INFO_SYSTEM_NAME: u16 = 1;
const INFO_TRACKERS: u16 = 2;
const INFO_TRACKER_NAME: u16 = 0;
const POSITION: u16 = 0;
const SPEED: u16 = 1;
const ORIENTATION: u16 = 2;
const VALIDITY: u16 = 3;
const TIMESTAMP: u16 = 6;

const VERSION: [u8; 2] = [2, 3];
/// Bytes of trackers in a packet; the rest of 1500 is for headers.
const MAX_TRACKER_BYTES: usize = 1400;
/// The marks of a chunk that has further ones in it.
const HAS_CHUNKS: u16 = 1 << 15;

/// The trackers of a server. An object becomes one when it is named or seen first, and keeps its number, which counts
/// from 1.
#[derive(Debug)]
pub struct PsnTrackers {
    axes: Axes,
    roster: Roster,
    start_ns: u64,
    n_data: u8,
    n_info: u8,
}

impl PsnTrackers {
    /// Trackers of objects with these names first, in their order; the server starts now.
    #[must_use]
    pub fn new(axes: Axes, names: &[ObjectId], now_ns: u64) -> Self {
        Self {
            axes,
            roster: Roster::new(names),
            start_ns: now_ns,
            n_data: 0,
            n_info: 0,
        }
    }

    /// Makes an object a tracker.
    pub fn add(&mut self, name: &ObjectId) {
        self.roster.add(name);
    }

    /// Leaves a tracker out until it is added again. The others keep their numbers.
    pub fn remove(&mut self, name: &ObjectId) {
        self.roster.remove(name);
    }

    /// Takes a pose; returns whether there is now a new pose of every object that is tracked.
    pub fn take(&mut self, pose: &ObjectPose) -> bool {
        self.roster.take(pose);
        self.roster.is_complete()
    }

    /// The packets of a frame, with all trackers that have been seen.
    pub fn data(&mut self, now_ns: u64) -> Vec<Vec<u8>> {
        self.n_data = self.n_data.wrapping_add(1);
        let trackers = self.roster.seen();
        let trackers = trackers.map(|(number, _, pose)| self.tracker(number, pose));
        let packets = self.packets(DATA_PACKET, DATA_TRACKERS, trackers.collect(), now_ns);
        self.roster.age();
        packets
    }

    /// The packets with the names of all trackers.
    pub fn info(&mut self, now_ns: u64) -> Vec<Vec<u8>> {
        self.n_info = self.n_info.wrapping_add(1);
        let trackers = self.roster.numbered().map(|(number, member)| {
            let name = chunk(INFO_TRACKER_NAME, member.name.as_str().as_bytes());
            chunk(number, &name).containing_chunks()
        });
        self.packets(INFO_PACKET, INFO_TRACKERS, trackers.collect(), now_ns)
    }

    fn tracker(&self, number: u16, pose: &ObjectPose) -> Vec<u8> {
        let converted = self.axes.convert(&pose.world_from_object());
        let [x, y, z, w] = converted.orientation;
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let [vx, vy, vz, ..] = pose.twist;
        let validity = match pose.state {
            State::Tracking => 1.0_f32,
            State::Coasting => 0.5,
            State::Initialising | State::Lost => 0.0,
        };
        let time_us = pose.capture_ns.saturating_sub(self.start_ns) / 1000;
        let content = [
            chunk(POSITION, &vector(converted.position)),
            chunk(SPEED, &vector(self.axes.direction([vx, vy, vz]))),
            chunk(ORIENTATION, &vector(rotation.scaled_axis().into())),
            chunk(VALIDITY, &validity.to_le_bytes()),
            chunk(TIMESTAMP, &time_us.to_le_bytes()),
        ];
        chunk(number, &content.concat()).containing_chunks()
    }

    fn packets(&self, kind: u16, list: u16, trackers: Vec<Vec<u8>>, now_ns: u64) -> Vec<Vec<u8>> {
        let mut lists = vec![Vec::new()];
        for tracker in trackers {
            match lists.last_mut() {
                Some(last) if last.len() + tracker.len() <= MAX_TRACKER_BYTES => {
                    last.extend(tracker)
                }
                _ => lists.push(tracker),
            }
        }
        let (frame, system) = match kind {
            DATA_PACKET => (self.n_data, Vec::new()),
            _ => (self.n_info, chunk(INFO_SYSTEM_NAME, b"Sextant")),
        };
        let mut header = (now_ns.saturating_sub(self.start_ns) / 1000)
            .to_le_bytes()
            .to_vec();
        header.extend(VERSION);
        header.extend([frame, lists.len() as u8]);
        let header = chunk(HEADER, &header);
        let packet = |trackers: Vec<u8>| {
            let trackers = chunk(list, &trackers).containing_chunks();
            chunk(kind, &[&header[..], &system, &trackers].concat()).containing_chunks()
        };
        lists.into_iter().map(packet).collect()
    }
}

/// A chunk of less than 2¹⁵ bytes.
fn chunk(id: u16, content: &[u8]) -> Vec<u8> {
    let length = content.len() as u16;
    [&id.to_le_bytes(), &length.to_le_bytes(), content].concat()
}

trait ContainingChunks {
    fn containing_chunks(self) -> Self;
}

impl ContainingChunks for Vec<u8> {
    /// Marks a chunk as one that has further ones in it.
    fn containing_chunks(mut self) -> Self {
        self[3] |= (HAS_CHUNKS >> 8) as u8;
        self
    }
}

fn vector(values: [f64; 3]) -> Vec<u8> {
    values
        .iter()
        .flat_map(|value| narrowed(*value).to_le_bytes())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(object: &str) -> ObjectPose {
        ObjectPose {
            object: ObjectId::new(object).unwrap(),
            epoch: 1,
            sequence: 1,
            capture_ns: 3_500_000,
            published_ns: 1,
            state: State::Tracking,
            position: [1.5, -2.25, 0.75],
            // A turn to the left by 90 degrees.
            orientation: [0.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt()],
            covariance: [0.0; 36],
            twist: [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            cameras: 2,
            tags: 3,
            rms_px: 0.1,
        }
    }

    #[test]
    fn packets_are_trees_of_chunks() {
        let mut trackers = PsnTrackers::new(Axes::Unity, &[], 1_000_000);
        assert!(trackers.take(&pose("cube")));
        let packets = trackers.data(4_000_000);
        assert_eq!(packets.len(), 1);
        let floats = |values: [f32; 3]| values.map(f32::to_le_bytes).concat();
        let expected = [
            &b"\x55\x67\x5c\x80"[..],
            b"\0\0\x0c\0\xb8\x0b\0\0\0\0\0\0\x02\x03\x01\x01",
            b"\x01\0\x48\x80",
            b"\x01\0\x44\x80",
            b"\0\0\x0c\0",
            &floats([2.25, 0.75, 1.5]),
            b"\x01\0\x0c\0",
            &floats([0.0, 0.0, 1.0]),
            b"\x02\0\x0c\0",
            &floats([-0.0, -std::f32::consts::FRAC_PI_2, -0.0]),
            b"\x03\0\x04\0\0\0\x80\x3f",
            b"\x06\0\x08\0\xc4\x09\0\0\0\0\0\0",
        ];
        assert_eq!(packets[0], expected.concat());
        let info = trackers.info(4_000_000);
        let expected = [
            &b"\x56\x67\x2b\x80"[..],
            b"\0\0\x0c\0\xb8\x0b\0\0\0\0\0\0\x02\x03\x01\x01",
            b"\x01\0\x07\0Sextant",
            b"\x02\0\x0c\x80\x01\0\x08\x80\0\0\x04\0cube",
        ];
        assert_eq!(info, [expected.concat()]);
    }

    #[test]
    fn a_removed_object_is_no_tracker_and_the_others_keep_their_numbers() {
        let mut trackers = PsnTrackers::new(Axes::Unity, &[], 0);
        for name in ["cube", "ball"] {
            trackers.take(&pose(name));
        }
        let both = trackers.info(1)[0].len();
        let cube = ObjectId::new("cube").unwrap();
        trackers.remove(&cube);
        // A late pose.
        trackers.take(&pose("cube"));
        let info = trackers.info(1);
        assert_eq!(info[0].len(), both - 12);
        assert!(info[0].ends_with(b"\x02\0\x08\x80\0\0\x04\0ball"));
        assert_eq!(trackers.data(1)[0][24..26], [2, 0]);
        trackers.add(&cube);
        assert_eq!(trackers.info(1)[0].len(), both);
    }

    #[test]
    fn many_trackers_take_several_packets() {
        let mut trackers = PsnTrackers::new(Axes::Unity, &[], 0);
        for number in 0..200 {
            trackers.take(&pose(&format!("o{number}")));
        }
        for packets in [trackers.data(1), trackers.info(1)] {
            assert!(packets.len() > 1);
            for packet in &packets {
                assert!(packet.len() <= 1500);
                assert_eq!(usize::from(packet[4 + 4 + 11]), packets.len());
            }
        }
    }
}
