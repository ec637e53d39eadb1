//! NetworkTables 4 (WPILib, "NetworkTables Protocol Specification, Version 4.0"), the values of robots of the FIRST
//! Robotics Competition, as a client that publishes poses.
//!
//! Over a WebSocket: what is published as JSON texts, values as MessagePack arrays of a publisher's number, the
//! server's time in microseconds, a type and the value. A pose is a `Pose3d` as WPILib's structs have it: seven 64-bit
//! floats, little-endian, x y z and the quaternion w x y z.

use sextant_proto::ObjectPose;

/// The port of a server.
pub const NT4_PORT: u16 = 5810;
/// The WebSocket's subprotocol by which NetworkTables 4 is spoken.
pub const NT4_PROTOCOL: &str = "networktables.first.wpi.edu";

/// Numbers of types.
const INTEGER: u8 = 2;
const RAW: u8 = 5;
/// The number that stands for the time.
const TIME: i8 = -1;

/// The schemas that `Pose3d` rests on: names and fields.
pub const NT4_SCHEMAS: [(&str, &str); 4] = [
    ("Translation3d", "double x;double y;double z"),
    ("Quaternion", "double w;double x;double y;double z"),
    ("Rotation3d", "Quaternion q"),
    ("Pose3d", "Translation3d translation;Rotation3d rotation"),
];

/// The text that announces a topic of a type under a number of the publisher's.
#[must_use]
pub fn nt4_publish(topic: &str, kind: &str, number: u32) -> String {
    let topic = topic.replace('\\', "\\\\").replace('"', "\\\"");
    format!(
        r#"[{{"method":"publish","params":{{"name":"{topic}","pubuid":{number},"type":"{kind}","properties":{{"retained":true}}}}}}]"#
    )
}

/// Bytes as the value of a topic, at the server's time.
#[must_use]
pub fn nt4_raw(number: u32, server_us: i64, value: &[u8]) -> Vec<u8> {
    let mut message = vec![0x94, 0xce];
    message.extend(number.to_be_bytes());
    message.push(0xd3);
    message.extend(server_us.to_be_bytes());
    // The length of what is sent here fits 16 bits.
    message.extend([RAW, 0xc5]);
    message.extend((value.len() as u16).to_be_bytes());
    message.extend(value);
    message
}

/// A pose as `Pose3d`.
#[must_use]
pub fn nt4_pose(pose: &ObjectPose) -> Vec<u8> {
    let ([x, y, z], [i, j, k, w]) = (pose.position, pose.orientation);
    [x, y, z, w, i, j, k]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect()
}

/// The question for the server's time, which comes back with the answer.
#[must_use]
pub fn nt4_time_request(our_us: i64) -> Vec<u8> {
    let mut message = vec![0x94, TIME as u8, 0, INTEGER, 0xd3];
    message.extend(our_us.to_be_bytes());
    message
}

/// The server's time and ours when it was asked for, of an answer; none of other messages.
#[must_use]
pub fn nt4_time_answer(message: &[u8]) -> Option<(i64, i64)> {
    let mut rest = message.strip_prefix(&[0x94, TIME as u8])?;
    let server_us = integer(&mut rest)?;
    (integer(&mut rest)? == i64::from(INTEGER)).then_some(())?;
    Some((server_us, integer(&mut rest)?))
}

/// The integer that MessagePack begins with.
fn integer(bytes: &mut &[u8]) -> Option<i64> {
    let (&format, rest) = bytes.split_first()?;
    let (length, is_signed) = match format {
        0..=0x7f | 0xe0..=0xff => {
            *bytes = rest;
            return Some(i64::from(format as i8));
        }
        0xcc => (1, false),
        0xcd => (2, false),
        0xce => (4, false),
        0xcf => (8, false),
        0xd0 => (1, true),
        0xd1 => (2, true),
        0xd2 => (4, true),
        0xd3 => (8, true),
        _ => return None,
    };
    let (number, rest) = rest.split_at_checked(length)?;
    *bytes = rest;
    let fill = match is_signed && number[0] >= 0x80 {
        true => [0xff; 8],
        false => [0; 8],
    };
    let whole = [&fill[length..], number].concat();
    let value = u64::from_be_bytes(whole.try_into().ok()?);
    // Times beyond the range of 63 bits are none.
    (is_signed || value <= i64::MAX as u64).then_some(value as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_bytes_of_messagepack() {
        assert_eq!(
            nt4_raw(3, -2, b"ab"),
            b"\x94\xce\0\0\0\x03\xd3\xff\xff\xff\xff\xff\xff\xff\xfe\x05\xc5\0\x02ab"
        );
        assert_eq!(nt4_time_request(5), b"\x94\xff\0\x02\xd3\0\0\0\0\0\0\0\x05");
        assert_eq!(
            nt4_publish("/a\"b", "raw", 7),
            r#"[{"method":"publish","params":{"name":"/a\"b","pubuid":7,"type":"raw","properties":{"retained":true}}}]"#
        );
    }

    #[test]
    fn times_are_read_in_every_width() {
        for (bytes, times) in [
            (&b"\x94\xff\x07\x02\x7f"[..], Some((7, 127))),
            (
                b"\x94\xff\xcf\0\0\0\0\0\0\x01\0\x02\xd3\xff\xff\xff\xff\xff\xff\xff\xfe",
                Some((256, -2)),
            ),
            (
                b"\x94\xff\xce\x01\0\0\0\x02\xcd\x01\x02",
                Some((1 << 24, 258)),
            ),
            (b"\x94\xff\xd1\xff\0\x02\xcc\xff", Some((-256, 255))),
            (b"\x94\xff\xcf\xff\0\0\0\0\0\0\0\x02\0", None),
            (b"\x94\xff\x07\x05\x7f", None),
            (b"\x94\x01\x07\x02\x7f", None),
            (b"\x94\xff\xd3\0", None),
            (b"", None),
        ] {
            assert_eq!(nt4_time_answer(bytes), times, "{bytes:?}");
        }
    }
}
