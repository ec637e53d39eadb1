//! MQTT 5 (OASIS standard, 2019) as a client that only publishes, without acknowledgement (QoS 0).
//!
//! A packet is its type and flags in a byte, the length of the rest in up to four bytes of seven bits each, and the
//! rest. Texts begin with their length in 16 bits; everything is big-endian. No properties are sent: each list of them
//! is empty.

/// The usual port without TLS.
pub const MQTT_PORT: u16 = 1883;
/// The usual port under TLS.
pub const MQTT_TLS_PORT: u16 = 8883;

const CONNECT: u8 = 0x10;
const CONNECT_ANSWER: u8 = 0x20;
const PUBLISH: u8 = 0x30;
const RETAIN: u8 = 0x01;
const PING_ANSWER: u8 = 0xd0;
const DISCONNECT: u8 = 0xe0;
const NO_PROPERTIES: u8 = 0;
const VERSION: u8 = 5;

/// Flags of a greeting.
const USERNAME: u8 = 0x80;
const PASSWORD: u8 = 0x40;
const RETAINED_WILL: u8 = 0x24;
const CLEAN_START: u8 = 0x02;

/// The longest packet that is read: a client that subscribes to nothing gets short ones.
const MAX_READ_BYTES: usize = 64 << 10;

/// CONNECT packet: who the client is, and what is published when it is gone.
#[derive(Debug, Clone)]
pub struct MqttGreeting {
    /// Name of the client, which the broker knows no other client by.
    pub client: String,
    /// Seconds without a packet after which the broker takes the client for gone.
    pub keep_alive_s: u16,
    /// Topic and payload that the broker publishes, retained, when the client is gone.
    pub will: (String, String),
    /// Name and password of a user.
    pub user: Option<(String, String)>,
}

impl MqttGreeting {
    /// The bytes of the CONNECT packet.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let user = match self.user {
            Some(_) => USERNAME | PASSWORD,
            None => 0,
        };
        let mut rest = text("MQTT");
        rest.extend([VERSION, CLEAN_START | RETAINED_WILL | user]);
        rest.extend(self.keep_alive_s.to_be_bytes());
        rest.push(NO_PROPERTIES);
        rest.extend(text(&self.client));
        rest.push(NO_PROPERTIES);
        rest.extend([text(&self.will.0), text(&self.will.1)].concat());
        if let Some((name, password)) = &self.user {
            rest.extend([text(name), text(password)].concat());
        }
        packet(CONNECT, &rest)
    }
}

/// Whether a broker keeps a message for later subscribers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Retention {
    /// It does, until the next one of the topic.
    Retained,
    /// It does not.
    Passing,
}

/// A message under a topic.
#[must_use]
pub fn mqtt_publish(topic: &str, payload: &[u8], retention: Retention) -> Vec<u8> {
    let mut rest = text(topic);
    rest.push(NO_PROPERTIES);
    rest.extend(payload);
    let flags = match retention {
        Retention::Retained => RETAIN,
        Retention::Passing => 0,
    };
    packet(PUBLISH | flags, &rest)
}

/// A sign of life.
pub const MQTT_PING: [u8; 2] = [0xc0, 0];
/// The orderly end, after which the broker forgets the will.
pub const MQTT_END: [u8; 2] = [DISCONNECT, 0];

/// What a broker has sent.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MqttAnswer {
    /// The client is welcome.
    Accepted,
    /// The client is not welcome, and why.
    Refused(String),
    /// The broker ends the connection, and why.
    Ended(String),
    /// The broker is alive.
    Alive,
}

/// Bytes of a broker, cut into packets.
#[derive(Debug, Default)]
pub struct MqttReader {
    unread: Vec<u8>,
}

/// What is no MQTT.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("it does not speak MQTT")]
pub struct NoMqtt;

impl MqttReader {
    /// Takes bytes that have arrived.
    pub fn take(&mut self, bytes: &[u8]) {
        self.unread.extend_from_slice(bytes);
    }

    /// The next packet, when it is there as a whole.
    ///
    /// # Errors
    /// Bytes of another protocol, or a packet that no broker sends to a client without subscriptions.
    pub fn next_answer(&mut self) -> Result<Option<MqttAnswer>, NoMqtt> {
        let Some(&kind) = self.unread.first() else {
            return Ok(None);
        };
        // A client that neither subscribes nor asks for acknowledgements gets nothing else.
        if !matches!(kind, CONNECT_ANSWER | PING_ANSWER | DISCONNECT) {
            return Err(NoMqtt);
        }
        let Some((start, length)) = length(&self.unread)? else {
            return Ok(None);
        };
        let Some(rest) = self.unread.get(start..start + length) else {
            return Ok(None);
        };
        let answer = match kind {
            CONNECT_ANSWER => match rest.get(1).ok_or(NoMqtt)? {
                0 => MqttAnswer::Accepted,
                reason => MqttAnswer::Refused(in_words(*reason)),
            },
            DISCONNECT => MqttAnswer::Ended(in_words(rest.first().copied().unwrap_or(0))),
            _ => MqttAnswer::Alive,
        };
        self.unread.drain(..start + length);
        Ok(Some(answer))
    }
}

/// Where the rest of a packet begins, and its length.
fn length(packet: &[u8]) -> Result<Option<(usize, usize)>, NoMqtt> {
    let mut length = 0;
    for place in 0..4 {
        let Some(byte) = packet.get(1 + place) else {
            return Ok(None);
        };
        length |= usize::from(byte & 0x7f) << (7 * place);
        if byte & 0x80 == 0 {
            return match length <= MAX_READ_BYTES {
                true => Ok(Some((2 + place, length))),
                false => Err(NoMqtt),
            };
        }
    }
    Err(NoMqtt)
}

/// Reasons of refusals and ends, table 2-6 of the standard; small numbers are those of MQTT 3.
fn in_words(reason: u8) -> String {
    let words = match reason {
        0x00 => "it has ended",
        0x01 | 0x84 => "it speaks no MQTT 5",
        0x04 | 0x86 => "wrong user name or password",
        0x05 | 0x87 => "not authorised",
        0x88 | 0x03 => "the server is unavailable",
        0x89 => "the server is busy",
        0x8a => "banned",
        0x8b => "the server is shutting down",
        0x8d => "the server has missed signs of life",
        0x8e => "another client has the same name",
        0x95 => "a packet was too large",
        0x97 => "the quota is exceeded",
        _ => return format!("reason code 0x{reason:02x}"),
    };
    words.to_owned()
}

/// Text of at most 65,535 bytes, as names and topics are.
fn text(text: &str) -> Vec<u8> {
    let bytes = &text.as_bytes()[..text.len().min(usize::from(u16::MAX))];
    let length = bytes.len() as u16;
    [&length.to_be_bytes(), bytes].concat()
}

fn packet(kind: u8, rest: &[u8]) -> Vec<u8> {
    let mut packet = vec![kind];
    let mut length = rest.len();
    loop {
        let more = u8::from(length > 0x7f) << 7;
        packet.push((length & 0x7f) as u8 | more);
        length >>= 7;
        if length == 0 {
            break;
        }
    }
    packet.extend(rest);
    packet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_have_the_bytes_of_the_standard() {
        let greeting = MqttGreeting {
            client: "c".to_owned(),
            keep_alive_s: 10,
            will: ("w".to_owned(), "off".to_owned()),
            user: Some(("u".to_owned(), "pw".to_owned())),
        };
        let bytes = b"\x10\x1e\0\x04MQTT\x05\xe6\0\x0a\0\0\x01c\0\0\x01w\0\x03off\0\x01u\0\x02pw";
        assert_eq!(greeting.to_bytes(), bytes);
        let message = mqtt_publish("a/b", b"{}", Retention::Retained);
        assert_eq!(message, b"\x31\x08\0\x03a/b\0{}");
        let long = mqtt_publish("t", &[7; 300], Retention::Passing);
        assert_eq!(long[..6], [0x30, 0xb0, 0x02, 0, 1, b't']);
        assert_eq!(long.len(), 3 + 304);
    }

    #[test]
    fn answers_are_read_in_pieces_of_any_size() {
        let bytes = b"\x20\x03\0\0\0\xd0\0\x20\x03\0\x87\0\xe0\x01\x8b";
        let mut reader = MqttReader::default();
        let mut answers = Vec::new();
        for byte in bytes {
            reader.take(&[*byte]);
            answers.extend(reader.next_answer().unwrap());
        }
        let expected = [
            MqttAnswer::Accepted,
            MqttAnswer::Alive,
            MqttAnswer::Refused("not authorised".to_owned()),
            MqttAnswer::Ended("the server is shutting down".to_owned()),
        ];
        assert_eq!(answers, expected);
    }

    #[test]
    fn other_protocols_and_impossible_lengths_are_errors() {
        for bytes in [
            &b"HTTP/1.1 400 Bad Request"[..],
            b"\x20\xff\xff\xff\xff",
            b"\x20\xff\xff\x7f",
            b"\x20\0",
            b"\0\0",
        ] {
            let mut reader = MqttReader::default();
            reader.take(bytes);
            assert_eq!(reader.next_answer(), Err(NoMqtt), "{bytes:?}");
        }
    }
}
