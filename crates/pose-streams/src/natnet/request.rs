//! What clients ask for, and the answers that need no poses.

use super::{
    CONNECT, DISCONNECT, DISCOVERY, ECHO_REQUEST, ECHO_RESPONSE, HEADER_BYTES, KEEP_ALIVE, Message,
    NAME_BYTES, NatNetVersion, REQUEST, REQUEST_FRAME, REQUEST_MODEL_DEFINITIONS, RESPONSE,
    SERVER_INFO, UNRECOGNIZED_REQUEST,
};
use crate::axes::Axes;
use std::net::SocketAddrV4;

/// The place of the version that a client wants in its greeting: after the description of a sender and a byte.
const WANTED_VERSION_AT: usize = NAME_BYTES + 4 + 4 + 1;
/// The version of Motive that speaks the protocol of the same generation: clients that look at it know this one.
const APPLICATION_VERSION: [u8; 4] = [3, 1, 0, 0];
const TICKS_PER_SECOND: u64 = 1_000_000_000;

/// A message of a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NatNetRequest<'a> {
    /// It asks what the server is, and may want a version.
    Connect(Option<NatNetVersion>),
    /// It asks for the rigid bodies.
    ModelDefinitions,
    /// It asks for the newest frame.
    Frame,
    /// A command of Motive, as text.
    Command(&'a str),
    /// It wants frames at its own address.
    KeepAlive,
    /// It wants no frames any more.
    Disconnect,
    /// It compares clocks: the time of its own.
    Echo([u8; 8]),
    /// Something else.
    Unrecognized,
}

impl<'a> NatNetRequest<'a> {
    /// Reads a datagram; none where it is too short for a message. The stated length is left unread: clients fill it in
    /// differently.
    #[must_use]
    pub fn read(datagram: &'a [u8]) -> Option<Self> {
        let (header, payload) = datagram.split_first_chunk::<HEADER_BYTES>()?;
        Some(match u16::from_le_bytes([header[0], header[1]]) {
            CONNECT | DISCOVERY => {
                let wanted = payload.get(WANTED_VERSION_AT..WANTED_VERSION_AT + 2);
                Self::Connect(wanted.and_then(|v| NatNetVersion::new(v[0], v[1])))
            }
            REQUEST => Self::command(payload),
            REQUEST_MODEL_DEFINITIONS => Self::ModelDefinitions,
            REQUEST_FRAME => Self::Frame,
            DISCONNECT => Self::Disconnect,
            KEEP_ALIVE => Self::KeepAlive,
            ECHO_REQUEST => payload
                .first_chunk()
                .map_or(Self::Unrecognized, |time| Self::Echo(*time)),
            _ => Self::Unrecognized,
        })
    }

    fn command(payload: &'a [u8]) -> Self {
        let text = payload.split(|byte| *byte == 0).next().unwrap_or_default();
        std::str::from_utf8(text).map_or(Self::Unrecognized, |text| Self::Command(text.trim()))
    }
}

/// What a server says of itself.
#[derive(Debug, Clone, Copy)]
pub struct NatNetServer {
    /// Axes of its poses.
    pub axes: Axes,
    /// Frames a second at most.
    pub rate_hz: f64,
    /// Where all clients can hear its frames; `None` where it sends to single clients only.
    pub multicast: Option<SocketAddrV4>,
    /// The port where clients expect frames.
    pub data_port: u16,
}

impl NatNetServer {
    /// The answer to a greeting.
    #[must_use]
    pub fn info(&self, version: NatNetVersion) -> Vec<u8> {
        let mut message = Message::new(SERVER_INFO, version);
        message.text("Sextant");
        message.bytes.resize(HEADER_BYTES + NAME_BYTES, 0);
        message.bytes.extend(APPLICATION_VERSION);
        message.bytes.extend([version.major, version.minor, 0, 0]);
        message.u64(TICKS_PER_SECOND);
        message.u16(self.data_port);
        message.bytes.push(u8::from(self.multicast.is_some()));
        let group = self.multicast.map_or([0; 4], |group| group.ip().octets());
        message.bytes.extend(group);
        message.finish()
    }

    /// The answer to a command for which Motive has a number; else that it is not recognised.
    #[must_use]
    pub fn answer(&self, command: &str, version: NatNetVersion) -> Vec<u8> {
        let up_axis = match self.axes {
            Axes::ZUp => 2_i32,
            Axes::YUp | Axes::Unity => 1,
        };
        let number = match command {
            "FrameRate" => (self.rate_hz as f32).to_le_bytes(),
            "UnitsToMillimeters" => 1000_f32.to_le_bytes(),
            "UpAxis" => up_axis.to_le_bytes(),
            // Live, without analogue devices and without a take; `LiveMode` asks for what is so already.
            "CurrentMode" | "AnalogSamplesPerMocapFrame" | "CurrentTakeLength" | "LiveMode" => {
                0_i32.to_le_bytes()
            }
            _ => return Message::new(UNRECOGNIZED_REQUEST, version).finish(),
        };
        let mut message = Message::new(RESPONSE, version);
        message.bytes.extend(number);
        message.finish()
    }
}

/// The answer to `Bitstream`, with or without a version.
#[must_use]
pub fn natnet_bitstream(version: NatNetVersion) -> Vec<u8> {
    let mut message = Message::new(RESPONSE, version);
    message.text(&format!("Bitstream,{version}"));
    message.finish()
}

/// The answer to a comparison of clocks.
#[must_use]
pub fn natnet_echo(theirs: [u8; 8], now_ns: u64) -> Vec<u8> {
    let mut message = Message::new(ECHO_RESPONSE, NatNetVersion::NEWEST);
    message.bytes.extend(theirs);
    message.u64(now_ns);
    message.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    const V3: NatNetVersion = NatNetVersion { major: 3, minor: 0 };

    fn server() -> NatNetServer {
        NatNetServer {
            axes: Axes::YUp,
            rate_hz: 120.0,
            multicast: Some("239.255.42.99:1511".parse().unwrap()),
            data_port: 1511,
        }
    }

    /// The layout is that of an answer recorded of Motive 2.0: 283 bytes, the clock's rate at 268, then
    /// `e705 01 efff2a63`.
    #[test]
    fn the_server_is_described_as_motive_describes_itself() {
        let info = server().info(V3);
        assert_eq!(info.len(), 283);
        assert_eq!(info[..12], *b"\x01\0\x17\x01Sextant\0");
        assert_eq!(info[264..268], [3, 0, 0, 0]);
        assert_eq!(info[268..276], 1_000_000_000_u64.to_le_bytes());
        assert_eq!(info[276..], [0xe7, 0x05, 0x01, 0xef, 0xff, 0x2a, 0x63]);
    }

    /// The greetings of NatNetLib 3.0, of the Python client of the SDK 4.1, and of libmotioncapture, which has no
    /// payload.
    #[test]
    fn greetings_may_want_a_version() {
        let mut greeting = vec![0; 4 + 271];
        assert_eq!(
            NatNetRequest::read(&greeting[..4]),
            Some(NatNetRequest::Connect(None))
        );
        greeting[2..4].copy_from_slice(&271_u16.to_le_bytes());
        greeting[4..8].copy_from_slice(b"Ping");
        greeting[4 + 265..4 + 267].copy_from_slice(&[4, 1]);
        let wanted = Some(NatNetVersion::NEWEST);
        assert_eq!(
            NatNetRequest::read(&greeting),
            Some(NatNetRequest::Connect(wanted))
        );
        let mut discovery = [&[0x0e, 0, 8, 1][..], b"NatNetLib"].concat();
        discovery.resize(268, 0);
        assert_eq!(
            NatNetRequest::read(&discovery),
            Some(NatNetRequest::Connect(None))
        );
    }

    /// Bytes as recorded of NatNetLib 3.0 and Motive 2.0.
    #[test]
    fn an_echo_has_both_times() {
        let request = b"\x0c\0\x08\0\x4e\x66\x9a\x10\0\0\0\0";
        let Some(NatNetRequest::Echo(theirs)) = NatNetRequest::read(request) else {
            panic!("no echo");
        };
        assert_eq!(
            natnet_echo(theirs, 0x149_cde4_8504),
            b"\x0d\0\x10\0\x4e\x66\x9a\x10\0\0\0\0\x04\x85\xe4\xcd\x49\x01\0\0"
        );
    }

    #[test]
    fn commands_are_answered_by_numbers_or_not_recognised() {
        let answer = |command: &str| server().answer(command, V3);
        assert_eq!(answer("FrameRate"), b"\x03\0\x04\0\0\0\xf0\x42");
        assert_eq!(answer("UpAxis"), b"\x03\0\x04\0\x01\0\0\0");
        assert_eq!(answer("UnitsToMillimeters"), b"\x03\0\x04\0\0\0\x7a\x44");
        assert_eq!(answer("StartRecording"), b"\x64\0\0\0");
        assert_eq!(natnet_bitstream(V3), b"\x03\0\x0e\0Bitstream,3.0\0");
    }

    #[test]
    fn any_bytes_are_a_request_or_none() {
        for kind in 0..=300_u16 {
            for length in 0..40 {
                let mut bytes = kind.to_le_bytes().to_vec();
                bytes.resize(length, 0xff);
                let read = NatNetRequest::read(&bytes);
                assert_eq!(read.is_some(), length >= HEADER_BYTES);
            }
        }
    }

    #[test]
    fn versions_are_those_spoken() {
        assert_eq!("4.1.0.0".parse(), Ok(NatNetVersion::NEWEST));
        for wrong in ["", "4", "4.0", "2.9", "a.b", "300.1"] {
            assert!(wrong.parse::<NatNetVersion>().is_err(), "{wrong}");
        }
    }
}
