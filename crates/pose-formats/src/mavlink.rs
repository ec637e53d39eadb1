//! MAVLink 2 frames (mavlink.io, "Serialization"): header, payload without its trailing zeros, CRC-16/MCRF4XX. Fields are little-endian,
//! the widest first, extensions last.

pub(crate) mod odometry;
pub(crate) mod reset_counter;

use odometry::LocalFrame;
use sextant_proto::ObjectPose;

const MAGIC: u8 = 0xfd;
/// Version of the protocol in heartbeats.
const MAVLINK_VERSION: u8 = 3;

/// A kind of message.
struct Kind {
    id: u32,
    /// Enters the CRC, so that other definitions of the message are refused.
    crc_extra: u8,
}

const HEARTBEAT: Kind = Kind {
    id: 0,
    crc_extra: 50,
};
const ODOMETRY: Kind = Kind {
    id: 331,
    crc_extra: 91,
};

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

    fn frame(&mut self, kind: &Kind, payload: &[u8]) -> Vec<u8> {
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

    /// Check value of the catalogue of parametrised CRC algorithms (Cook).
    #[test]
    fn the_checksum_is_mcrf4xx() {
        assert_eq!(crc(b"123456789".iter()), 0x6f91);
    }
}
