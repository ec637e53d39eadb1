//! A small picture of what a camera sees, for people's eyes.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::limits::MAX_JPEG_BYTES;
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::CameraId;

/// One picture as JPEG; it may be smaller than the image that it shows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Preview {
    /// The camera; the same as in the key.
    pub camera: CameraId,
    /// Number of the image, as in its observations.
    pub sequence: u64,
    /// Middle of the exposure, ns since the Unix epoch by the board's clock.
    pub capture_ns: u64,
    /// Width and height of the image that was taken (not of the JPEG), pixels: corners are in these.
    pub resolution: [u16; 2],
    /// The JPEG file, at most [`MAX_JPEG_BYTES`].
    #[serde(serialize_with = "wire::bytes::serialize")]
    #[serde(deserialize_with = "wire::bytes::at_most::<_, MAX_JPEG_BYTES>")]
    pub jpeg: Vec<u8>,
}

impl Message for Preview {
    const KIND: MessageKind = MessageKind::Preview;

    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.capture_ns, "capture_ns")?;
        holds(!self.resolution.contains(&0), "resolution")?;
        holds(self.jpeg.len() <= MAX_JPEG_BYTES, "jpeg")
    }
}
