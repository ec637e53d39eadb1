//! What rmw_zenoh expects beside each message: number, time and sender, as zenoh-ext serialises a tuple.

use crate::Gid;

/// Length of an attachment: 8 + 8 + 1 + 16.
pub const ATTACHMENT_BYTES: usize = 33;

/// The attachment of one message. A receiver that finds none, or another length, drops the message or ends: these bytes
/// are fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attachment {
    /// Number of the message on its topic, from 1.
    pub sequence: i64,
    /// When it was published, ns since the Unix epoch.
    pub source_ns: i64,
    /// Its publisher.
    pub gid: Gid,
}

impl Attachment {
    /// Sequence and time little-endian, then the GID with its length in front.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; ATTACHMENT_BYTES] {
        let mut bytes = [0; ATTACHMENT_BYTES];
        bytes[..8].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.source_ns.to_le_bytes());
        // A LEB128 number below 128 is one byte.
        bytes[16] = self.gid.0.len() as u8;
        bytes[17..].copy_from_slice(&self.gid.0);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_are_those_of_zenoh_ext() {
        let attachment = Attachment {
            sequence: 1,
            source_ns: 0x0102_0304_0506_0708,
            gid: Gid(*b"0123456789abcdef"),
        };
        let expected = [
            &[1, 0, 0, 0, 0, 0, 0, 0][..],
            &[8, 7, 6, 5, 4, 3, 2, 1],
            &[16],
            b"0123456789abcdef",
        ];
        assert_eq!(attachment.to_bytes()[..], expected.concat());
    }
}
