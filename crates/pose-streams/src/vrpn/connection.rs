//! The connection of a client, without its socket: bytes that it has sent become bytes to answer it with.

use super::{
    COOKIE_BYTES, HEADER_BYTES, PROTOCOL, SENDER_DESCRIPTION, TYPE_DESCRIPTION, TYPES,
    VrpnTrackers, padded,
};
use sextant_proto::limits;
use sextant_site_model::ObjectId;
use std::collections::BTreeMap;

/// The longest message that the reference's clients can send.
const MAX_MESSAGE_BYTES: usize = 64_000;
const PING: &str = TYPES[1];

/// What a client has said so far.
#[derive(Debug, Default)]
pub struct VrpnConnection {
    unread: Vec<u8>,
    is_open: bool,
    /// Its number of the type of pings.
    ping: Option<i32>,
    /// The trackers that it wants, by its numbers.
    trackers: BTreeMap<i32, ObjectId>,
}

/// Why a connection ends.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum VrpnError {
    /// Another protocol, or another major version of this one.
    #[error(
        "it begins with {0:?}, where a client of VRPN 7 begins with \"vrpn: ver. 07.\"; use such a client"
    )]
    Cookie(String),
    /// A message of an impossible length.
    #[error("a message of {0} bytes is impossible")]
    Length(u32),
}

impl VrpnConnection {
    /// Whether cookies have been exchanged, so that the client takes messages.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// Takes bytes that have arrived; the answer is descriptions after the cookie, and pongs.
    ///
    /// # Errors
    /// [`VrpnError`], after which the connection is useless.
    pub fn take(
        &mut self,
        bytes: &[u8],
        trackers: &VrpnTrackers,
        now_ns: u64,
    ) -> Result<Vec<u8>, VrpnError> {
        self.unread.extend_from_slice(bytes);
        let mut answer = Vec::new();
        if !self.is_open {
            if self.unread.len() < COOKIE_BYTES {
                return Ok(answer);
            }
            let cookie: Vec<u8> = self.unread.drain(..COOKIE_BYTES).collect();
            check(&cookie)?;
            self.is_open = true;
            answer = trackers.descriptions(now_ns);
        }
        let mut taken = 0;
        while let Some(message) = Message::first_of(&self.unread[taken..])? {
            taken += message.wire_bytes;
            let tracker = self.pinged(&message);
            match tracker {
                Some(tracker) => answer.extend(trackers.pong(tracker, now_ns)),
                None => self.learn(message.header, message.name().map(str::to_owned)),
            }
        }
        self.unread.drain(..taken);
        Ok(answer)
    }

    /// The tracker that a message asks for a sign of life.
    fn pinged(&self, message: &Message<'_>) -> Option<&ObjectId> {
        let is_ping = self.ping == Some(message.header.kind) && message.header.kind >= 0;
        is_ping.then(|| self.trackers.get(&message.header.sender))?
    }

    /// Notes the numbers of trackers and of the one type that is answered.
    fn learn(&mut self, header: MessageHeader, name: Option<String>) {
        let Some(name) = name else { return };
        match header.kind {
            TYPE_DESCRIPTION if name == PING => self.ping = Some(header.sender),
            SENDER_DESCRIPTION if self.trackers.len() < limits::MAX_OBJECTS => {
                if let Ok(object) = ObjectId::new(&name) {
                    self.trackers.insert(header.sender, object);
                }
            }
            _ => {}
        }
    }
}

fn check(cookie: &[u8]) -> Result<(), VrpnError> {
    if cookie.starts_with(PROTOCOL) {
        return Ok(());
    }
    let text = cookie.split(|byte| *byte == 0).next().unwrap_or_default();
    Err(VrpnError::Cookie(
        String::from_utf8_lossy(text).into_owned(),
    ))
}

#[derive(Debug, Clone, Copy)]
struct MessageHeader {
    sender: i32,
    kind: i32,
}

struct Message<'a> {
    header: MessageHeader,
    payload: &'a [u8],
    /// With header and padding.
    wire_bytes: usize,
}

impl<'a> Message<'a> {
    /// The first message, when it is there as a whole.
    fn first_of(bytes: &'a [u8]) -> Result<Option<Self>, VrpnError> {
        let Some((header, rest)) = bytes.split_first_chunk::<HEADER_BYTES>() else {
            return Ok(None);
        };
        let field = |at: usize| [0, 1, 2, 3].map(|byte| header[at + byte]);
        let length = u32::from_be_bytes(field(0));
        let wrong = || VrpnError::Length(length);
        let payload_bytes = (length as usize)
            .checked_sub(HEADER_BYTES)
            .ok_or_else(wrong)?;
        if payload_bytes > MAX_MESSAGE_BYTES {
            return Err(wrong());
        }
        if rest.len() < padded(payload_bytes) {
            return Ok(None);
        }
        Ok(Some(Self {
            header: MessageHeader {
                sender: i32::from_be_bytes(field(12)),
                kind: i32::from_be_bytes(field(16)),
            },
            payload: &rest[..payload_bytes],
            wire_bytes: HEADER_BYTES + padded(payload_bytes),
        }))
    }

    /// The name in a description.
    fn name(&self) -> Option<&'a str> {
        let (_, name) = self.payload.split_first_chunk::<4>()?;
        let end = name.iter().position(|byte| *byte == 0)?;
        std::str::from_utf8(&name[..end]).ok()
    }
}

/// The port in a datagram by which a client asks a server to connect to it, `HOST PORT` with a zero behind. Ports below
/// 1024 are no client's.
#[must_use]
pub fn requested_port(datagram: &[u8]) -> Option<u16> {
    let text = datagram.split(|byte| *byte == 0).next()?;
    let mut words = std::str::from_utf8(text).ok()?.split_ascii_whitespace();
    let (_host, port, end) = (words.next()?, words.next()?, words.next());
    let port: u16 = port.parse().ok()?;
    (end.is_none() && port >= 1024).then_some(port)
}

#[cfg(test)]
mod tests {
    use super::super::{Header, PONG, describe};
    use super::*;
    use crate::axes::Axes;

    const COOKIE: [u8; 24] = *b"vrpn: ver. 07.38  0\0\0\0\0\0";

    fn trackers() -> VrpnTrackers {
        let mut trackers = VrpnTrackers::new(Axes::ZUp);
        let names = ["ball", "cube"].map(|name| ObjectId::new(name).unwrap());
        trackers.numbers.extend(names.into_iter().zip(0..));
        trackers
    }

    /// A client whose numbers are its own: 7 is the cube, 9 is a ping.
    fn words_of_a_client() -> Vec<u8> {
        let ping = Header {
            time_ns: 3,
            sender: 7,
            kind: 9,
        };
        [
            COOKIE.to_vec(),
            describe(SENDER_DESCRIPTION, 7, "cube", 1),
            describe(SENDER_DESCRIPTION, 8, "VRPN Control", 1),
            describe(TYPE_DESCRIPTION, 9, PING, 2),
            ping.message(&[]),
        ]
        .concat()
    }

    #[test]
    fn descriptions_answer_the_cookie_and_a_pong_the_ping() {
        let answer = VrpnConnection::default().take(&words_of_a_client(), &trackers(), 5);
        let pong = Header {
            time_ns: 5,
            sender: 1,
            kind: PONG,
        };
        let expected = [trackers().descriptions(5), pong.message(&[])].concat();
        assert_eq!(answer, Ok(expected));
    }

    #[test]
    fn bytes_may_arrive_one_by_one() {
        let mut connection = VrpnConnection::default();
        let (mut answer, mut opened) = (Vec::new(), 0);
        for (n, byte) in words_of_a_client().iter().enumerate() {
            answer.extend(connection.take(&[*byte], &trackers(), 5).unwrap());
            opened += usize::from(connection.is_open() && n < COOKIE_BYTES - 1);
        }
        assert_eq!(opened, 0);
        let whole = VrpnConnection::default().take(&words_of_a_client(), &trackers(), 5);
        assert_eq!(Ok(answer), whole);
    }

    #[test]
    fn other_protocols_and_impossible_lengths_are_errors() {
        let take = |bytes: &[u8]| VrpnConnection::default().take(bytes, &trackers(), 0);
        let other = take(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap_err();
        assert!(matches!(other, VrpnError::Cookie(text) if text.starts_with("GET / ")));
        assert!(take(b"vrpn: ver. 08.01  0\0\0\0\0\0").is_err());
        for length in [0_u32, 23, u32::MAX] {
            let mut header = [0; HEADER_BYTES];
            header[..4].copy_from_slice(&length.to_be_bytes());
            let sent = [&COOKIE[..], &header[..]].concat();
            assert_eq!(take(&sent), Err(VrpnError::Length(length)));
        }
    }

    #[test]
    fn a_flood_of_names_ends_at_the_bound() {
        let mut connection = VrpnConnection::default();
        connection.take(&COOKIE, &trackers(), 0).unwrap();
        for number in 0..4 * limits::MAX_OBJECTS as i32 {
            let name = describe(SENDER_DESCRIPTION, number, "cube", 0);
            connection.take(&name, &trackers(), 0).unwrap();
        }
        assert_eq!(connection.trackers.len(), limits::MAX_OBJECTS);
        assert!(connection.unread.is_empty());
    }

    #[test]
    fn requests_name_a_port() {
        assert_eq!(requested_port(b"10.0.0.1 34567\0"), Some(34567));
        for wrong in [
            &b"10.0.0.1 80\0"[..],
            b"34567\0",
            b"10.0.0.1 34567 1\0",
            b"10.0.0.1 99999\0",
            b"\xff 34567\0",
            b"",
        ] {
            assert_eq!(requested_port(wrong), None);
        }
    }
}
