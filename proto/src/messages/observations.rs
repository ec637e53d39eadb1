//! What one image of one camera showed: corners, and the tag poses solved from them.

use crate::check::{self, OutOfRange, holds, widened};
use crate::envelope::{Message, MessageKind};
use crate::limits::{MAX_PIXEL, MAX_TAG_POSES, MAX_TAGS, MAX_TIME_NS};
use crate::messages::camera_status::ClockQuality;
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_geometry::wrong_corner_pair;
use sextant_site_model::CameraId;
use sextant_tag_families::Family;

/// One image's tags. Sent for every image, also for one without a tag: "nothing seen" is news.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observations {
    /// The camera; the same as in the key.
    pub camera: CameraId,
    /// Number of the image since the capture process started; gaps are images that were skipped.
    pub sequence: u64,
    /// Middle of the exposure, ns since the Unix epoch by the board's clock.
    pub capture_ns: u64,
    /// Length of the exposure, ns; 0 when unknown.
    pub exposure_ns: u32,
    /// How far the board's clock can be trusted.
    pub clock: ClockQuality,
    /// Width and height of the image, pixels.
    pub resolution: [u16; 2],
    /// When the image passed the stages of the board.
    pub timing: Timing,
    /// The tags, ordered by family, id and place; at most [`MAX_TAGS`].
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_TAGS>")]
    pub tags: Vec<TagObservation>,
}

/// When an image passed the stages of its board: ns since the Unix epoch, same clock as the capture time; 0 when
/// unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Timing {
    /// The detecting process got hold of the image.
    pub received_ns: u64,
    /// Its tags were found and their poses solved.
    pub detected_ns: u64,
    /// The message was handed to the network.
    pub published_ns: u64,
}

/// One tag in one image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TagObservation {
    /// Its family; on the wire the number of the variant, from 0.
    pub family: Family,
    /// Its number within the family.
    pub id: u32,
    /// Bits that were corrected.
    pub hamming: u8,
    /// Decision margin: grey levels between the modules and the threshold, 0 to 255.
    pub margin: f32,
    /// Top left, top right, bottom right, bottom left of the black square; pixels, (0, 0) at the first pixel's centre.
    pub corners: [[f32; 2]; 4],
    /// Covariance of each corner as xx, xy, yy; square pixels.
    pub corner_covariance: [[f32; 3]; 4],
    /// Covariance between the corners of each of [`sextant_geometry::CORNER_PAIRS`]: x of the one with x and with y of
    /// the other, then y of the one with both; square pixels. All zero where their errors are independent, or nobody
    /// knows.
    pub corner_cross_covariance: [[f32; 4]; 6],
    /// `camera_from_tag` in both branches of the planar ambiguity, the better first; empty without a known size or
    /// lens.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_TAG_POSES>")]
    pub poses: Vec<TagPose>,
}

/// One branch of a tag's pose from its four corners alone: `camera_from_tag`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TagPose {
    /// The tag's centre in the camera's frame, metres.
    pub position: [f32; 3],
    /// The tag's axes in the camera's frame, x, y, z, w.
    pub orientation: [f32; 4],
    /// Root mean square reprojection error of the corners, pixels.
    pub rms_px: f32,
}

impl Message for Observations {
    const KIND: MessageKind = MessageKind::Observations;

    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.capture_ns, "capture_ns")?;
        self.clock.check()?;
        self.timing.check()?;
        holds(!self.resolution.contains(&0), "resolution")?;
        holds(self.tags.len() <= MAX_TAGS, "tags")?;
        self.tags.iter().try_for_each(TagObservation::check)
    }
}

impl Timing {
    fn check(&self) -> Result<(), OutOfRange> {
        let latest = self
            .received_ns
            .max(self.detected_ns)
            .max(self.published_ns);
        holds(latest <= MAX_TIME_NS, "timing")
    }
}

impl TagObservation {
    fn check(&self) -> Result<(), OutOfRange> {
        check::amount(f64::from(self.margin), "tags[].margin")?;
        let inside = self
            .corners
            .iter()
            .flatten()
            .all(|pixel| pixel.abs() <= MAX_PIXEL);
        holds(inside, "tags[].corners")?;
        for covariance in self.corner_covariance {
            check::covariance_2x2(covariance, "tags[].corner_covariance")?;
        }
        let wrong = wrong_corner_pair(&self.corner_covariance, &self.corner_cross_covariance);
        holds(wrong.is_none(), "tags[].corner_cross_covariance")?;
        holds(self.poses.len() <= MAX_TAG_POSES, "tags[].poses")?;
        self.poses.iter().try_for_each(TagPose::check)
    }
}

impl TagPose {
    fn check(&self) -> Result<(), OutOfRange> {
        check::position(widened(self.position), "tags[].poses[].position")?;
        check::orientation(widened(self.orientation), "tags[].poses[].orientation")?;
        check::amount(f64::from(self.rms_px), "tags[].poses[].rms_px")
    }
}
