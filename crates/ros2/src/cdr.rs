//! CDR: how ROS 2 writes a message as bytes (OMG, Common Object Request Broker Architecture 3.3, 9.3; as "plain CDR" of
//! DDS-XTypes 1.3, 7.4). Numbers are little-endian and aligned to their own size, counted from the end of the four-byte
//! header.

/// Encapsulation identifier of little-endian plain CDR, and no options.
const HEADER: [u8; 4] = [0x00, 0x01, 0x00, 0x00];

/// Writes one message as CDR bytes.
#[derive(Debug)]
pub struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    pub(crate) fn new() -> Self {
        Self {
            bytes: HEADER.to_vec(),
        }
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    /// A number of N bytes.
    pub(crate) fn number<const N: usize>(&mut self, little_endian: [u8; N]) {
        let body = self.bytes.len() - HEADER.len();
        self.bytes
            .resize(HEADER.len() + body.next_multiple_of(N), 0);
        self.bytes.extend_from_slice(&little_endian);
    }

    /// The number of elements of a sequence, or of bytes of a string.
    pub(crate) fn length(&mut self, length: usize) {
        // A message of this crate is bounded far below 4 GiB by the site's own limits.
        self.number(u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
    }

    /// UTF-8 with a length in front that counts the zero byte behind. CDR cannot carry a zero byte within.
    pub(crate) fn text(&mut self, text: &str) {
        let text = text.split('\0').next().unwrap_or_default();
        self.length(text.len() + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
    }

    /// Bytes without a length.
    pub(crate) fn raw(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_behind_the_header() {
        let mut writer = Writer::new();
        writer.number([7]);
        writer.number(1_u32.to_le_bytes());
        writer.number([9]);
        writer.number(1.0_f64.to_le_bytes());
        let expected = [
            &HEADER[..],
            &[7, 0, 0, 0, 1, 0, 0, 0],
            &[9, 0, 0, 0, 0, 0, 0, 0],
            &1.0_f64.to_le_bytes(),
        ];
        assert_eq!(writer.into_bytes(), expected.concat());
    }

    #[test]
    fn a_text_ends_at_its_first_zero_byte() {
        let mut writer = Writer::new();
        writer.text("");
        writer.text("ab\0c");
        assert_eq!(
            writer.into_bytes()[4..],
            [1, 0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0]
        );
    }
}
