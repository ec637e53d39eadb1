//! Diagnostics of one detection: counts in the [`Report`], events through an [`Observer`].
//!
//! The detector reads no clock. An observer measures stage times by reading a clock at the end of each stage.

use crate::Detection;
use sextant_tag_families::BorderColour;

/// The stages of detection in order; those from `Threshold` to `Decode` are repeated in every [`Pass`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Minima and maxima of tiles, noise, contrast gate.
    Tiles,
    /// Thresholds: one bit per pixel.
    Threshold,
    /// Runs merged into components.
    Components,
    /// Outlines of components, and quads around them.
    Quads,
    /// Border, ring and code words.
    Decode,
    /// Sub-pixel corners.
    Refine,
}

impl Stage {
    /// Every stage in order.
    pub const ALL: [Self; 6] = [
        Self::Tiles,
        Self::Threshold,
        Self::Components,
        Self::Quads,
        Self::Decode,
        Self::Refine,
    ];
}

/// The classifications of border pixels, each a pass over the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Black borders: pixels darker than the middle between the darkest and the brightest level nearby. Texture,
    /// undershoot of sharpening and blur leave them on that side of the middle.
    Middle,
    /// Black borders that touch something black at their corners, as on an AprilGrid, if there is something that may be
    /// such: pixels darker than the middle level whose neighbours are too.
    Eroded,
    /// Black borders that the middle level joins with something else: pixels close to the darkest level nearby, which
    /// separates a tag in shadow from bright surroundings, and dark lines.
    Black,
    /// White borders: pixels brighter than the middle level.
    White,
}

impl Pass {
    /// Every pass in order.
    pub const ALL: [Self; 4] = [Self::Middle, Self::Eroded, Self::Black, Self::White];

    /// Colour of the borders of this pass.
    pub fn border(self) -> BorderColour {
        match self {
            Self::Black | Self::Middle | Self::Eroded => BorderColour::Black,
            Self::White => BorderColour::White,
        }
    }
}

/// Why a component was not a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rejection {
    /// Its outline is not a quadrilateral.
    NotAQuad,
    /// The quad is too small, too narrow or too skewed.
    Shape,
    /// Inside and outside of the quad's edges lack contrast; or a ChArUco marker has no chessboard corner where its
    /// family defines one.
    FaintBorder,
    /// No code word of any family is near enough.
    NoCode,
    /// The decision margin is too small.
    SmallMargin,
}

impl Rejection {
    /// Every reason.
    pub const ALL: [Self; 5] = [
        Self::NotAQuad,
        Self::Shape,
        Self::FaintBorder,
        Self::NoCode,
        Self::SmallMargin,
    ];
}

/// Counts of the last image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Standard deviation of the pixel noise, in grey levels, as measured in tiles.
    pub noise_sigma: f32,
    /// Least contrast that makes a tile live, in grey levels.
    pub contrast_gate: u8,
    /// Runs of black pixels, each of two rows.
    pub runs: u32,
    /// Connected components of black pixels.
    pub components: u32,
    /// Components that could be a tag's border by size and area.
    pub candidates: u32,
    /// Candidates dropped because a bound of the detector's memory was reached.
    pub dropped: u32,
    /// Quads around candidates.
    pub quads: u32,
    /// Rejected candidates, by [`Rejection`].
    pub rejected: [u32; Rejection::ALL.len()],
    /// Tags.
    pub detections: u32,
}

impl Report {
    /// Number of candidates rejected for a reason.
    pub fn rejected_for(&self, reason: Rejection) -> u32 {
        self.rejected[reason as usize]
    }
}

/// Observes a detection without influencing it.
///
/// A pass over the image begins with [`Self::pass_began`]; events up to the next one belong to it.
pub trait Observer {
    /// A stage has just ended.
    fn stage_ended(&mut self, _stage: Stage) {}

    /// A pass begins; the next one uses another threshold.
    fn pass_began(&mut self, _pass: Pass) {}

    /// All pixels of the border's colour: column and row of each, and its component, a number that is unique within the
    /// pass.
    fn labelled(&mut self, _pixels: impl Iterator<Item = ([u16; 2], u32)>) {}

    /// A quad was found around a candidate; corners in pixels, clockwise from any.
    fn quad_found(&mut self, _corners: &[[f32; 2]; 4]) {}

    /// A candidate was rejected; corners of its quad, or of its bounding box if it has none, in pixels, clockwise from
    /// any.
    fn rejected(&mut self, _reason: Rejection, _corners: &[[f32; 2]; 4]) {}

    /// The sub-pixel corners of a tag were found; `before` are those with which it was decoded, in the same order.
    fn refined(&mut self, _before: &[[f32; 2]; 4], _tag: &Detection) {}
}

impl Observer for () {}
