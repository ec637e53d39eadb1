//! Whether a JPEG has its end: the decoder fills what is missing with grey and says nothing.

/// What the markers of a JPEG tell.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Survey {
    /// The end of the picture is there.
    pub(super) whole: bool,
    /// Decoding needs all coefficients in memory at once.
    pub(super) progressive: bool,
}

/// Walks through the segments up to the end of the first picture.
pub(super) fn survey(bytes: &[u8]) -> Survey {
    let mut found = Survey::default();
    let mut at = 2;
    while let Some((code, after)) = next_marker(bytes, at) {
        at = after;
        match code {
            0xd9 => {
                found.whole = true;
                return found;
            }
            // These have no length: the byte stuffed into pixels, restarts and beginnings.
            0x00 | 0x01 | 0xd0..=0xd8 => continue,
            0xc2 | 0xc6 | 0xca | 0xce => found.progressive = true,
            _ => {}
        }
        let Some(&[high, low]) = bytes.get(at..at + 2) else {
            break;
        };
        at += usize::from(u16::from_be_bytes([high, low]));
    }
    found
}

/// The next marker from there, and where its segment starts. Pixels between segments are skipped.
fn next_marker(bytes: &[u8], from: usize) -> Option<(u8, usize)> {
    let rest = bytes.get(from..)?;
    let start = from + rest.iter().position(|byte| *byte == 0xff)?;
    let filling = bytes[start..].iter().take_while(|byte| **byte == 0xff);
    let at = start + filling.count();
    bytes.get(at).map(|code| (*code, at + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_within_a_segment_is_none() {
        let start = b"\xff\xd8\xff\xe1\x00\x06\xff\xd9\xff\xd9\xff\xda\x00\x02\x01\xff\x00\xff\xd0";
        assert!(!survey(start).whole);
        let whole = [start, &b"\xff\xff\xd9 and more"[..]].concat();
        assert!(survey(&whole).whole);
        assert!(!survey(b"\xff\xd8\xff").whole);
        assert!(survey(b"\xff\xd8\xff\xc2\x00\x02").progressive);
    }
}
