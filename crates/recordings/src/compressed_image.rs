//! Images and previews as `sensor_msgs/msg/CompressedImage` in CDR, which viewers and ROS tools read without a plug-in.
//!
//! The message: stamp (i32 s, u32 ns), frame (string), format (string), data (list of bytes); little-endian, aligned
//! to 4.

use sextant_ros2::messages::{CompressedImage, Header};
use sextant_site_model::CameraId;

/// CDR, little-endian, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A PNG of one image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedImage {
    /// The camera.
    pub camera: CameraId,
    /// Middle of the exposure by the camera's clock, ns since the Unix epoch.
    pub capture_ns: u64,
    /// 8-bit grey.
    pub png: Vec<u8>,
}

/// Topic of a camera's images.
#[must_use]
pub fn topic(camera: &CameraId) -> String {
    format!("/camera/{camera}/image")
}

/// The camera whose images have this topic.
#[must_use]
pub fn camera_of(topic: &str) -> Option<CameraId> {
    let camera = topic.strip_prefix("/camera/")?.strip_suffix("/image")?;
    CameraId::new(camera).ok()
}

/// Coordinate frame of a camera in viewers.
#[must_use]
pub fn frame_of(camera: &CameraId) -> String {
    format!("camera/{camera}")
}

/// Topic of a camera's previews.
#[must_use]
pub fn preview_topic(camera: &CameraId) -> String {
    format!("/camera/{camera}/preview")
}

/// The message of a picture of a camera, a file of the named format.
#[must_use]
pub(crate) fn message(
    camera: &CameraId,
    capture_ns: u64,
    format: &str,
    file: Vec<u8>,
) -> CompressedImage {
    CompressedImage {
        header: Header::new(capture_ns, &frame_of(camera)),
        format: format.to_owned(),
        data: file,
    }
}

/// The message of an image.
pub(crate) fn image_message(image: &RecordedImage) -> CompressedImage {
    message(&image.camera, image.capture_ns, "png", image.png.clone())
}

/// The image of a message under a camera's topic; `None` for invalid bytes.
#[must_use]
pub fn decode(camera: &CameraId, bytes: &[u8]) -> Option<RecordedImage> {
    let mut rest = Cdr { bytes, at: 4 };
    let header = bytes.get(..4)?;
    let seconds = u64::try_from(i32::from_le_bytes(rest.word()?)).ok()?;
    let nanoseconds = u64::from(u32::from_le_bytes(rest.word()?));
    rest.string()?;
    let format = rest.string()?;
    let n_bytes = u32::from_le_bytes(rest.word()?) as usize;
    let png = rest.take(n_bytes)?;
    (header == HEADER && format == b"png\0" && nanoseconds < 1_000_000_000).then(|| RecordedImage {
        camera: camera.clone(),
        capture_ns: seconds * 1_000_000_000 + nanoseconds,
        png: png.to_vec(),
    })
}

/// CDR that is being read. The header has 4 bytes, so that alignment from the start is alignment behind it.
struct Cdr<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cdr<'a> {
    fn take(&mut self, n_bytes: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(n_bytes)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn word(&mut self) -> Option<[u8; 4]> {
        self.at = self.at.next_multiple_of(4);
        self.take(4)?.try_into().ok()
    }

    fn string(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(self.word()?) as usize;
        self.take(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_ros2::encode;

    fn image() -> RecordedImage {
        RecordedImage {
            camera: CameraId::new("north").unwrap(),
            capture_ns: 1_800_000_000_123_456_789,
            png: vec![1, 2, 3],
        }
    }

    #[test]
    fn an_image_is_the_bytes_that_ros_expects() {
        let bytes = encode(&image_message(&image()));
        assert_eq!(bytes[..4], [0, 1, 0, 0]);
        assert_eq!(bytes[4..8], 1_800_000_000_i32.to_le_bytes());
        assert_eq!(bytes[8..12], 123_456_789_u32.to_le_bytes());
        assert_eq!(bytes[12..16], 13_u32.to_le_bytes());
        assert_eq!(&bytes[16..29], b"camera/north\0");
        assert_eq!(bytes[32..36], 4_u32.to_le_bytes());
        assert_eq!(&bytes[36..40], b"png\0");
        assert_eq!(bytes[40..44], 3_u32.to_le_bytes());
        assert_eq!(bytes[44..], [1, 2, 3]);
    }

    #[test]
    fn an_image_comes_back_and_a_cut_one_does_not() {
        let (image, bytes) = (image(), encode(&image_message(&image())));
        assert_eq!(decode(&image.camera, &bytes), Some(image.clone()));
        for length in 0..bytes.len() {
            assert_eq!(decode(&image.camera, &bytes[..length]), None);
        }
        assert_eq!(camera_of(&topic(&image.camera)), Some(image.camera));
        assert_eq!(camera_of("/camera/../image"), None);
    }
}
