//! Bounds of everything that crosses the network. A message beyond them is refused by sender and receiver alike.

/// Tags in one image.
pub const MAX_TAGS: usize = 256;
/// Branches of the planar ambiguity of one tag.
pub const MAX_TAG_POSES: usize = 2;
/// Candidates that a detection report shows.
pub const MAX_REJECTED: usize = 64;
/// Cameras of one rig or one fusion node.
pub const MAX_CAMERAS: usize = 256;
/// Objects of one fusion node.
pub const MAX_OBJECTS: usize = 1024;
/// Tags of one object.
pub const MAX_OBJECT_TAGS: usize = 1024;
/// Links of one object, and joints between them.
pub const MAX_LINKS: usize = sextant_site_model::MOST_LINKS;
/// Joints of one object that move.
pub const MAX_JOINTS: usize = sextant_site_model::MOST_JOINTS;
/// Faults of the site in one status.
pub const MAX_FAULTS: usize = 64;
/// Imperfections of the site's files in one status.
pub const MAX_IMPERFECTIONS: usize = 16;
/// Notices in one status of a fusion node.
pub const MAX_NOTICES: usize = 32;
/// Inputs of the estimator in one message.
pub const MAX_INPUTS: usize = 256;
/// Other fusion nodes of a site that a heartbeat names.
pub const MAX_PEERS: usize = 64;
/// Notices in one status of a camera node.
pub const MAX_CAMERA_NOTICES: usize = 32;
/// Bytes (UTF-8) of one text for people, and of a key.
pub const MAX_DETAIL_BYTES: usize = 240;
/// Bytes of a version or host name.
pub const MAX_NAME_BYTES: usize = 64;
/// Bytes of a preview's JPEG.
pub const MAX_JPEG_BYTES: usize = 100_000;
/// Bytes of any payload, header included; [`crate::MessageKind::max_bytes`] is narrower for most kinds.
pub const MAX_PAYLOAD_BYTES: usize = 128 * 1024;
/// Memory that decoding one payload may hold at any moment, for any bytes.
pub const MAX_DECODED_BYTES: usize = 256 * 1024;
/// Latest time that a message may state, ns since the Unix epoch (year 2262): differences fit an `i64`.
pub const MAX_TIME_NS: u64 = i64::MAX as u64;
/// Corners lie within this many pixels of the image's first pixel, on either side.
pub const MAX_PIXEL: f32 = 65_536.0;
/// Positions of objects and links lie within this distance of the world's origin along each axis, metres.
pub const MAX_DISTANCE_M: f64 = 1.0e6;
/// Positions in rigs and objects (cameras, tags, joints) lie within this distance of their frame's origin along each
/// axis, metres: a tenth of [`MAX_DISTANCE_M`], so that what an accepted camera sees can be published.
pub const MAX_PLACEMENT_M: f64 = 1.0e5;
/// A quaternion's length differs from 1 by at most this.
pub const QUATERNION_TOLERANCE: f64 = 1.0e-3;

/// The text cut to at most `max_bytes` at a character's border: for names and sentences that come from elsewhere.
#[must_use]
pub fn clipped(text: &str, max_bytes: usize) -> String {
    let mut end = text.len().min(max_bytes);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    text[..end].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipping_keeps_characters_whole() {
        assert_eq!(clipped("naïve", 3), "na");
        assert_eq!(clipped("naïve", 4), "naï");
        assert_eq!(clipped("naïve", 99), "naïve");
        assert_eq!(clipped("", 0), "");
    }
}
