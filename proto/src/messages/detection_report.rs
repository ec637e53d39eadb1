//! How a camera's detector processed one image, a few times a second while somebody subscribes: durations of its
//! stages, candidates, and why candidates were rejected.

use crate::check::{self, OutOfRange, holds};
use crate::envelope::{Message, MessageKind};
use crate::limits::{MAX_PIXEL, MAX_REJECTED};
use crate::wire;
use serde::{Deserialize, Serialize};
use sextant_site_model::CameraId;

/// The report on one image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DetectionReport {
    /// The camera; the same as in the key.
    pub camera: CameraId,
    /// Number of the image, as in its observations.
    pub sequence: u64,
    /// Middle of the exposure, ns since the Unix epoch by the board's clock.
    pub capture_ns: u64,
    /// Width and height of the image, pixels.
    pub resolution: [u16; 2],
    /// Share of the image that was searched, 0 to 1; less than 1 only where the node follows tags.
    pub searched: f32,
    /// Durations of the stages.
    pub stage_ms: StageTimes,
    /// Standard deviation of the pixel noise, grey levels, as estimated from the image.
    pub noise_sigma: f32,
    /// Least contrast of a candidate, grey levels.
    pub contrast_gate: u8,
    /// Connected areas of the border's colour.
    pub components: u32,
    /// Those that could be a tag's border by their size.
    pub candidates: u32,
    /// Candidates passed over because a bound of the detector's memory was reached.
    pub dropped: u32,
    /// Tags found.
    pub tags: u32,
    /// Candidates rejected, by cause.
    pub rejected: RejectionCounts,
    /// Some of them, those that came furthest first.
    #[serde(deserialize_with = "wire::list::at_most::<_, _, MAX_REJECTED>")]
    pub examples: Vec<RejectedCandidate>,
}

/// Milliseconds of the detector's stages, all their passes together.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StageTimes {
    /// Contrast and noise of small tiles.
    pub tiles: f32,
    /// Separation of black and white.
    pub threshold: f32,
    /// Connected areas.
    pub components: f32,
    /// Quadrilaterals around them.
    pub quads: f32,
    /// Decoding.
    pub decode: f32,
    /// Corners below the pixel.
    pub refine: f32,
}

/// Why a candidate is rejected, in the order of the tests. On the wire the number of the variant, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RejectionCause {
    /// Its outline is not a quadrilateral.
    NotAQuad,
    /// Too small, too narrow or too skewed.
    Shape,
    /// Inside and outside of its edges lack contrast.
    FaintBorder,
    /// No code word of any family is near enough.
    NoCode,
    /// A code word with too small a decision margin.
    SmallMargin,
}

/// Rejected candidates by [`RejectionCause`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "each field is the cause of its name")]
pub struct RejectionCounts {
    pub not_a_quad: u32,
    pub shape: u32,
    pub faint_border: u32,
    pub no_code: u32,
    pub small_margin: u32,
}

/// A candidate that is no tag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RejectedCandidate {
    /// Why.
    pub cause: RejectionCause,
    /// Corners of its quadrilateral, or of its box where it has none; pixels, clockwise from any.
    pub corners: [[f32; 2]; 4],
}

impl Message for DetectionReport {
    const KIND: MessageKind = MessageKind::DetectionReport;

    fn check(&self) -> Result<(), OutOfRange> {
        check::time(self.capture_ns, "capture_ns")?;
        holds(!self.resolution.contains(&0), "resolution")?;
        holds((0.0..=1.0).contains(&self.searched), "searched")?;
        self.stage_ms.check()?;
        check::amount(f64::from(self.noise_sigma), "noise_sigma")?;
        holds(self.examples.len() <= MAX_REJECTED, "examples")?;
        self.examples.iter().try_for_each(RejectedCandidate::check)
    }
}

impl StageTimes {
    fn check(&self) -> Result<(), OutOfRange> {
        let Self {
            tiles,
            threshold,
            components,
            quads,
            decode,
            refine,
        } = *self;
        [tiles, threshold, components, quads, decode, refine]
            .into_iter()
            .try_for_each(|ms| check::amount(f64::from(ms), "stage_ms"))
    }
}

impl RejectedCandidate {
    fn check(&self) -> Result<(), OutOfRange> {
        let within = |pixel: &f32| pixel.abs() <= MAX_PIXEL;
        holds(
            self.corners.as_flattened().iter().all(within),
            "examples[].corners",
        )
    }
}
