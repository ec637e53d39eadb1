//! MAVLink 2 frames (mavlink.io, "Serialization"): header, payload without its trailing zeros, CRC-16/MCRF4XX. Fields
//! are little-endian, the widest first, extensions last.

pub(crate) mod odometry;
pub(crate) mod reset_counter;

use odometry::LocalFrame;
use sextant_proto::ObjectPose;

const MAGIC: u8 = 0xfd;
/// Version of the protocol in heartbeats.
const MAVLINK_VERSION: u8 = 3;

/// A kind of message.
struct MavlinkKind {
    id: u32,
    /// Enters the CRC, so that other definitions of the message are refused.
    crc_extra: u8,
}

const HEARTBEAT: MavlinkKind = MavlinkKind {
    id: 0,
    crc_extra: 50,
};
const ODOMETRY: MavlinkKind = MavlinkKind {
    id: 331,
    crc_extra: 91,
};

const TIMESYNC: MavlinkKind = MavlinkKind {
    id: 111,
    crc_extra: 34,
};
/// Bytes of a frame beside its payload, and where its fields begin.
const FRAME_BYTES: usize = 12;
const HEADER_BYTES: usize = 10;
/// A frame with a signature is longer.
const SIGNED: u8 = 1;
const SIGNATURE_BYTES: usize = 13;

/// Who sends: ids of the vehicle's network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sender {
    /// The vehicle.
    pub system: u8,
    /// The component; MAVLink's `MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY` is 197.
    pub component: u8,
}

/// Makes frames and numbers them.
#[derive(Debug)]
pub struct MavlinkSender {
    sender: Sender,
    sequence: u8,
}

impl MavlinkSender {
    /// A sender whose first frame has number 0.
    #[must_use]
    pub fn new(sender: Sender) -> Self {
        Self {
            sender,
            sequence: 0,
        }
    }

    /// A `HEARTBEAT` of an active onboard controller, expected once a second of every component.
    pub fn heartbeat(&mut self) -> Vec<u8> {
        const CUSTOM_MODE: [u8; 4] = [0; 4];
        const ONBOARD_CONTROLLER: u8 = 18;
        const NO_AUTOPILOT: u8 = 8;
        const BASE_MODE: u8 = 0;
        const ACTIVE: u8 = 4;
        let mut payload = CUSTOM_MODE.to_vec();
        payload.extend([
            ONBOARD_CONTROLLER,
            NO_AUTOPILOT,
            BASE_MODE,
            ACTIVE,
            MAVLINK_VERSION,
        ]);
        self.frame(&HEARTBEAT, &payload)
    }

    /// An `ODOMETRY` of a pose.
    pub fn odometry(
        &mut self,
        pose: &ObjectPose,
        frame: &LocalFrame,
        reset_counter: u8,
    ) -> Vec<u8> {
        self.frame(&ODOMETRY, &odometry::payload(pose, frame, reset_counter))
    }

    /// The answer to a `TIMESYNC` that asks for our time: ours in ns, and theirs as they sent it. Ours is that of
    /// `time_usec` in `ODOMETRY`.
    pub fn timesync(&mut self, now_ns: u64, theirs: i64) -> Vec<u8> {
        let ours = i64::try_from(now_ns).unwrap_or(i64::MAX);
        let payload = [ours.to_le_bytes(), theirs.to_le_bytes()].concat();
        self.frame(&TIMESYNC, &payload)
    }

    fn frame(&mut self, kind: &MavlinkKind, payload: &[u8]) -> Vec<u8> {
        let zeros = payload.iter().rev().take_while(|byte| **byte == 0).count();
        // One byte stays, also of a payload of zeros.
        let payload = &payload[..(payload.len() - zeros).max(1)];
        let [low, middle, high, _] = kind.id.to_le_bytes();
        let Sender { system, component } = self.sender;
        // No payload is longer than 255 bytes.
        let length = payload.len() as u8;
        let (incompatible, compatible) = (0, 0);
        let mut frame = vec![
            MAGIC,
            length,
            incompatible,
            compatible,
            self.sequence,
            system,
            component,
            low,
            middle,
            high,
        ];
        self.sequence = self.sequence.wrapping_add(1);
        frame.extend_from_slice(payload);
        let checksum = crc(frame[1..].iter().chain([&kind.crc_extra]));
        frame.extend(checksum.to_le_bytes());
        frame
    }
}

/// Their times in the `TIMESYNC` requests of a datagram with frames of MAVLink 2; anything else is passed over.
#[must_use]
pub fn timesync_requests(datagram: &[u8]) -> Vec<i64> {
    let mut requests = Vec::new();
    let mut rest = datagram;
    while let [MAGIC, length, incompatible, ..] = *rest {
        let signature = usize::from(incompatible & SIGNED) * SIGNATURE_BYTES;
        let bytes = FRAME_BYTES + usize::from(length) + signature;
        let Some((frame, after)) = rest.split_at_checked(bytes) else {
            break;
        };
        requests.extend(request_of(&frame[..bytes - signature]));
        rest = after;
    }
    requests
}

/// Their time, of a frame without its signature.
fn request_of(frame: &[u8]) -> Option<i64> {
    let (body, checksum) = frame.split_last_chunk()?;
    let (header, payload) = body.split_at_checked(HEADER_BYTES)?;
    let [low, middle, high, _] = TIMESYNC.id.to_le_bytes();
    let is_timesync = header.ends_with(&[low, middle, high]);
    let expected = crc(body[1..].iter().chain([&TIMESYNC.crc_extra]));
    if !is_timesync || u16::from_le_bytes(*checksum) != expected {
        return None;
    }
    // Zeros at the end are left out.
    let mut fields = [0; 16];
    let n_bytes = payload.len().min(fields.len());
    fields[..n_bytes].copy_from_slice(&payload[..n_bytes]);
    let (ours, theirs) = fields.split_first_chunk::<8>()?;
    let theirs = theirs.first_chunk::<8>()?;
    (i64::from_le_bytes(*ours) == 0).then(|| i64::from_le_bytes(*theirs))
}

/// CRC-16/MCRF4XX: polynomial 0x1021 reflected, initial value 0xffff.
fn crc<'a>(bytes: impl Iterator<Item = &'a u8>) -> u16 {
    bytes.fold(0xffff, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte), |crc, _| {
            let is_odd = crc & 1 == 1;
            (crc >> 1) ^ if is_odd { 0x8408 } else { 0 }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of pymavlink's `timesync_send(0, 123456789012)`, MAVLink 2, system 1, component 1, first frame.
    #[test]
    fn a_request_for_our_time_is_answered() {
        let sender = Sender {
            system: 1,
            component: 1,
        };
        let request = MavlinkSender::new(sender).frame(
            &TIMESYNC,
            &[0_i64.to_le_bytes(), 123_456_789_012_i64.to_le_bytes()].concat(),
        );
        assert_eq!(timesync_requests(&request), [123_456_789_012]);
        let heartbeat = MavlinkSender::new(sender).heartbeat();
        let several = [&heartbeat[..], &request, &request].concat();
        assert_eq!(timesync_requests(&several).len(), 2);
        let mut answers = MavlinkSender::new(sender);
        let answer = answers.timesync(1_800_000_000_000_000_000, 123_456_789_012);
        assert_eq!(answer[10..18], 1_800_000_000_000_000_000_i64.to_le_bytes());
        assert_eq!(answer[18..23], 123_456_789_012_i64.to_le_bytes()[..5]);
        // An answer is no request.
        assert!(timesync_requests(&answer).is_empty());
        let mut damaged = request.clone();
        damaged[12] ^= 1;
        for bytes in [
            &damaged[..],
            &request[..request.len() - 1],
            b"",
            b"\xfd",
            &[0xfd; 300],
        ] {
            assert!(timesync_requests(bytes).is_empty());
        }
    }

    /// Check value of the catalogue of parametrised CRC algorithms (Cook).
    #[test]
    fn the_checksum_is_mcrf4xx() {
        assert_eq!(crc(b"123456789".iter()), 0x6f91);
    }
}
