//! OpenTrackIO 1.0 (SMPTE RIS OSVP), the pose of a camera for virtual studios: samples in JSON, each in one datagram
//! behind a header of 16 bytes.
//!
//! x is to the right, y forward, z up: right-handed, metres. Rotations are intrinsic about z, x, y: pan grows to the
//! left, tilt upwards, roll clockwise as the camera sees it; degrees. Of an object Sextant's x is the optical axis, y
//! is left and z up; of the world likewise.

use crate::freed::camera_angles_deg;
use sextant_proto::ObjectPose;
use sextant_site_report::State;
use std::net::{Ipv4Addr, SocketAddrV4};

/// The port of receivers.
const PORT: u16 = 55_555;
const JSON: u8 = 1;
/// The mark of a sample's last segment.
const LAST: u16 = 1 << 15;

/// A camera with its sequence of samples.
#[derive(Debug)]
pub struct OpenTrackIoCamera {
    source: u8,
    start_ns: u64,
    sequence: u64,
}

/// The group in which receivers listen to a source, 1 to 200.
#[must_use]
pub fn opentrackio_group(source: u8) -> SocketAddrV4 {
    SocketAddrV4::new(Ipv4Addr::new(239, 135, 1, source), PORT)
}

impl OpenTrackIoCamera {
    /// A source that begins at this time, which keeps its samples apart from those of another run.
    #[must_use]
    pub fn new(source: u8, now_ns: u64) -> Self {
        Self {
            source,
            start_ns: now_ns,
            sequence: 0,
        }
    }

    /// The datagram of the next sample.
    pub fn sample(&mut self, pose: &ObjectPose) -> Vec<u8> {
        self.sequence += 1;
        let payload = self.json(pose);
        let mut datagram = b"OTrk\0".to_vec();
        datagram.push(JSON);
        datagram.extend((self.sequence as u16).to_be_bytes());
        // One segment, at the beginning.
        datagram.extend([0; 4]);
        datagram.extend((LAST | payload.len() as u16).to_be_bytes());
        let checksum = fletcher_16(datagram.iter().chain(payload.as_bytes()));
        datagram.extend(checksum.to_be_bytes());
        datagram.extend(payload.as_bytes());
        datagram
    }

    fn json(&self, pose: &ObjectPose) -> String {
        let [right, tilt, roll] = camera_angles_deg(pose);
        let [forward, left, up] = pose.position;
        let (seconds, nanos) = (
            pose.capture_ns / 1_000_000_000,
            pose.capture_ns % 1_000_000_000,
        );
        let status = match pose.state {
            State::Tracking => "Optical Good",
            _ => "Predicted",
        };
        let (object, source) = (&pose.object, self.source);
        let sample_id = uuid(self.start_ns, self.sequence);
        let source_id = uuid(fnv_1a(object.as_str()), u64::from(source));
        format!(
            r#"{{"protocol":{{"name":"OpenTrackIO","version":[1,0,1]}},"sampleId":"{sample_id}","sourceId":"{source_id}","sourceNumber":{source},"timing":{{"mode":"internal","sampleTimestamp":{{"seconds":{seconds},"nanoseconds":{nanos}}},"sequenceNumber":{sequence}}},"tracker":{{"status":"{status}"}},"transforms":[{{"translation":{{"x":{x},"y":{forward},"z":{up}}},"rotation":{{"pan":{pan},"tilt":{tilt},"roll":{roll}}},"id":"{object}"}}]}}"#,
            sequence = self.sequence as u16,
            x = -left,
            pan = -right,
        )
    }
}

/// An identifier of the form of RFC 9562, version 8: 122 bits of these numbers.
fn uuid(high: u64, low: u64) -> String {
    let bits = (u128::from(high) << 64) | u128::from(low);
    let (a, b, c) = (bits >> 96, (bits >> 80) & 0xffff, (bits >> 64) & 0xfff);
    let (d, e) = ((bits >> 48) & 0x3fff, bits & 0xffff_ffff_ffff);
    format!(
        "urn:uuid:{a:08x}-{b:04x}-8{c:03x}-{:04x}-{e:012x}",
        0x8000 | d
    )
}

/// A number of a name (Fowler, Noll and Vo).
fn fnv_1a(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Fletcher's sum as OpenTrackIO has it, by 256.
fn fletcher_16<'a>(bytes: impl Iterator<Item = &'a u8>) -> u16 {
    let (first, second) = bytes.fold((0_u8, 0_u8), |(first, second), byte| {
        let first = first.wrapping_add(*byte);
        (first, second.wrapping_add(first))
    });
    u16::from_be_bytes([second, first])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, UnitQuaternion, Vector3};
    use sextant_site_model::ObjectId;

    fn pose(rotation: Rotation3<f64>) -> ObjectPose {
        let q = UnitQuaternion::from_rotation_matrix(&rotation);
        ObjectPose {
            object: ObjectId::new("camera").unwrap(),
            epoch: 1,
            sequence: 1,
            capture_ns: 1_800_000_000_123_456_789,
            published_ns: 1,
            state: State::Tracking,
            position: [2.0, -1.5, 0.25],
            orientation: [q.i, q.j, q.k, q.w],
            covariance: [0.0; 36],
            twist: [0.0; 6],
            cameras: 2,
            tags: 3,
            rms_px: 0.1,
        }
    }

    /// The axes of OpenTrackIO in those of Sextant: right, forward, up.
    fn about(right_forward_up: [f64; 3], degrees: f64) -> Rotation3<f64> {
        let [x, y, z] = right_forward_up;
        Rotation3::new(Vector3::new(y, -x, z) * degrees.to_radians())
    }

    #[test]
    fn a_sample_is_json_behind_a_header_with_its_sum() {
        let (pan, tilt, roll) = (
            about([0.0, 0.0, 1.0], 30.0),
            about([1.0, 0.0, 0.0], 20.0),
            about([0.0, 1.0, 0.0], 10.0),
        );
        let mut camera = OpenTrackIoCamera::new(7, 0x0123_4567_89ab_cdef);
        let datagram = camera.sample(&pose(pan * tilt * roll));
        let (header, payload) = datagram.split_at(16);
        let length = u16::from_be_bytes([header[12], header[13]]);
        assert_eq!(header[..8], *b"OTrk\0\x01\0\x01");
        assert_eq!(length, LAST | payload.len() as u16);
        // The sum of the reference, `fletcher16` of camdkit, worked out for this sample.
        assert_eq!(fletcher_16(b"abcde".iter()), 0xc3ef);
        let sum = fletcher_16(header[..14].iter().chain(payload));
        assert_eq!(header[14..], sum.to_be_bytes());
        let text = std::str::from_utf8(payload).unwrap();
        for part in [
            r#""sourceNumber":7,"#,
            r#""sampleId":"urn:uuid:01234567-89ab-8def-8000-000000000001""#,
            r#""sampleTimestamp":{"seconds":1800000000,"nanoseconds":123456789}"#,
            r#""translation":{"x":1.5,"y":2,"z":0.25}"#,
            r#""id":"camera""#,
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        for (name, degrees) in [("pan", 30.0), ("tilt", 20.0), ("roll", 10.0)] {
            let (_, rest) = text.split_once(&format!(r#""{name}":"#)).unwrap();
            let number: f64 = rest[..rest.find([',', '}']).unwrap()].parse().unwrap();
            assert!((number - degrees).abs() < 1e-9, "{name}: {number}");
        }
        assert!(datagram.len() < 1484);
    }
}
