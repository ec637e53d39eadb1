//! NatNet, the protocol of OptiTrack's Motive, as a server of rigid bodies (NaturalPoint, NatNet SDK 3.1 and 4.1:
//! `NatNetTypes.h`, `PacketClient.cpp`, `NatNetClient.py`): each object is a rigid body whose markers are the centres
//! of its tags.
//!
//! A message is a datagram: its kind and the length of its payload, 16 bits each, then the payload, all little-endian.
//! From 4.1 on, each list in a frame and each description states its length in bytes. Time stamps count nanoseconds
//! since the Unix epoch.

pub(crate) mod bodies;
pub(crate) mod request;

use std::fmt;
use std::str::FromStr;

/// The port for commands that Motive has by default.
pub const NATNET_COMMAND_PORT: u16 = 1510;
/// The port for frames that Motive has by default.
pub const NATNET_DATA_PORT: u16 = 1511;

/// Kinds of messages.
const CONNECT: u16 = 0;
const SERVER_INFO: u16 = 1;
const REQUEST: u16 = 2;
const RESPONSE: u16 = 3;
const REQUEST_MODEL_DEFINITIONS: u16 = 4;
const MODEL_DEFINITIONS: u16 = 5;
const REQUEST_FRAME: u16 = 6;
const FRAME: u16 = 7;
const DISCONNECT: u16 = 9;
const KEEP_ALIVE: u16 = 10;
const ECHO_REQUEST: u16 = 12;
const ECHO_RESPONSE: u16 = 13;
const DISCOVERY: u16 = 14;
const UNRECOGNIZED_REQUEST: u16 = 100;

const HEADER_BYTES: usize = 4;
/// The longest datagram of UDP.
const MAX_DATAGRAM_BYTES: usize = 65_507;
/// A name in the description of a server.
const NAME_BYTES: usize = 256;

/// A version of the protocol that is spoken here: 3.0, 3.1 or 4.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct NatNetVersion {
    major: u8,
    minor: u8,
}

impl NatNetVersion {
    /// The newest one.
    pub const NEWEST: Self = Self { major: 4, minor: 1 };

    fn new(major: u8, minor: u8) -> Option<Self> {
        matches!((major, minor), (3, 0 | 1) | (4, 1)).then_some(Self { major, minor })
    }

    fn states_lengths(self) -> bool {
        self >= Self::NEWEST
    }
}

impl fmt::Display for NatNetVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

impl FromStr for NatNetVersion {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let version = text.trim().split_once('.').and_then(|(major, minor)| {
            // Two parts count of up to four.
            let minor = minor.split('.').next()?;
            Self::new(major.parse().ok()?, minor.parse().ok()?)
        });
        version.ok_or("write 3.0, 3.1 or 4.1")
    }
}

/// A message under construction.
#[derive(Debug)]
struct Message {
    bytes: Vec<u8>,
    version: NatNetVersion,
}

impl Message {
    fn new(kind: u16, version: NatNetVersion) -> Self {
        let mut bytes = kind.to_le_bytes().to_vec();
        bytes.extend([0; 2]);
        Self { bytes, version }
    }

    fn u16(&mut self, value: u16) {
        self.bytes.extend(value.to_le_bytes());
    }

    fn i32(&mut self, value: i32) {
        self.bytes.extend(value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.bytes.extend(value.to_le_bytes());
    }

    fn f32s(&mut self, values: &[f32]) {
        for value in values {
            self.bytes.extend(value.to_le_bytes());
        }
    }

    /// Text with a zero at its end.
    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    /// A number, such as the count of a list, and what belongs to it, whose length stands between from 4.1 on.
    fn with_length(&mut self, number: i32, write: impl FnOnce(&mut Self)) {
        self.i32(number);
        let at = self.bytes.len();
        if self.version.states_lengths() {
            self.i32(0);
        }
        let start = self.bytes.len();
        write(self);
        let length = (self.bytes.len() - start) as i32;
        if self.version.states_lengths() {
            self.bytes[at..start].copy_from_slice(&length.to_le_bytes());
        }
    }

    /// The message with its length, which no caller lets exceed a datagram.
    fn finish(mut self) -> Vec<u8> {
        let length = (self.bytes.len() - HEADER_BYTES) as u16;
        self.bytes[2..HEADER_BYTES].copy_from_slice(&length.to_le_bytes());
        self.bytes
    }
}
