//! Tags in pictures: those with codes by the detector, the squares of a plain chessboard by a search for the whole
//! board.

use sextant_apriltag::{
    BoardShape, ChessboardView, Detection, Detector, Extent, Image, ImageError, Options,
    find_chessboard,
};
use sextant_recordings::{DetectedTag, GreyImage};
use sextant_site_files::Chessboard;
use sextant_site_model::ObjectModel;
use sextant_tag_families::Family;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// A plain chessboard to look for, and what the images show of it.
pub struct ChessboardSearch {
    shape: BoardShape,
    partial: PartialViews,
    seen: Mutex<Views>,
}

/// What becomes of images that show a chessboard in part. It has no ids, so that such an image does not tell which
/// part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartialViews {
    /// They serve: a lens does not depend on it.
    Used,
    /// They are left out.
    LeftOut,
}

/// Number of images by what they show.
#[derive(Default)]
struct Views {
    whole: usize,
    part: usize,
    /// By columns and rows.
    larger: BTreeMap<[u16; 2], usize>,
}

impl ChessboardSearch {
    /// The chessboard among some objects.
    pub fn among<'a>(
        objects: impl IntoIterator<Item = &'a ObjectModel>,
        partial: PartialViews,
    ) -> Option<Self> {
        let board = objects.into_iter().find_map(Chessboard::from_object)?;
        let Chessboard { columns, rows, .. } = board;
        Some(Self {
            shape: BoardShape { columns, rows },
            partial,
            seen: Mutex::default(),
        })
    }

    /// The squares of the board in an image.
    fn find(&self, image: &Image<'_>) -> Vec<Detection> {
        let Some(ChessboardView {
            size,
            extent,
            squares,
        }) = find_chessboard(image, self.shape)
        else {
            return Vec::new();
        };
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        match extent {
            Extent::Whole => seen.whole += 1,
            Extent::Part => seen.part += 1,
            Extent::Larger => *seen.larger.entry(size).or_default() += 1,
        }
        let is_left_out = extent == Extent::Part && self.partial == PartialViews::LeftOut;
        if is_left_out { Vec::new() } else { squares }
    }

    /// What a person should know about the images of the board, a line each.
    pub fn remarks(&self) -> Vec<String> {
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let BoardShape { columns, rows } = self.shape;
        let mut remarks = Vec::new();
        if let Some(([seen_columns, seen_rows], _)) = seen.larger.iter().max_by_key(|(_, n)| **n) {
            let n: usize = seen.larger.values().sum();
            remarks.push(format!(
                "{n} images show a chessboard of other size, most often {seen_columns} x \
                 {seen_rows} inner corners instead of {columns} x {rows}, and are left out; \
                 correct the board file: it counts inner corners, one fewer than squares"
            ));
        }
        if self.partial == PartialViews::LeftOut && seen.part > 0 {
            remarks.push(format!(
                "{} images show a part of the chessboard and are left out, since a plain \
                 chessboard does not tell which part; keep all {columns} x {rows} inner corners \
                 in view, or use a board with tags (`sextant print charuco`)",
                seen.part
            ));
        }
        remarks
    }
}

/// There is neither a detector nor a chessboard to look for.
#[derive(Debug, thiserror::Error)]
#[error("there is no detector")]
pub struct NothingSought;

/// Finds tags in images; one a thread.
pub struct TagFinder<'a> {
    detector: Option<Detector>,
    /// For images without tags otherwise.
    inverted: Option<Detector>,
    chessboard: Option<&'a ChessboardSearch>,
}

/// Least inverted tags of a board: one alone may be anything.
const LEAST_INVERTED: usize = 2;

impl<'a> TagFinder<'a> {
    /// Finds the tags of the options' families, and a chessboard.
    pub fn new(options: &Options, chessboard: Option<&'a ChessboardSearch>) -> Self {
        let mut options = options.clone();
        options
            .families
            .retain(|family| *family != Family::Chessboard);
        Self {
            detector: Detector::new(options).ok(),
            inverted: None,
            chessboard,
        }
    }

    /// Also finds a board of tags that are printed inverted, in images without any other tag.
    #[must_use]
    pub fn or_inverted(self, options: &Options) -> Self {
        let inverted = Options {
            inverted: !options.inverted,
            ..options.clone()
        };
        Self {
            inverted: Self::new(&inverted, None).detector,
            ..self
        }
    }

    /// The tags in an image.
    ///
    /// # Errors
    /// Without anything to look for, and after options that the detector refuses.
    pub fn find(&mut self, image: &Image<'_>) -> Result<Vec<Detection>, NothingSought> {
        let mut found = match (&mut self.detector, self.chessboard) {
            (Some(detector), _) => detector.detect(image).to_vec(),
            (None, Some(_)) => Vec::new(),
            (None, None) => return Err(NothingSought),
        };
        if let (true, Some(inverted)) = (found.is_empty(), &mut self.inverted) {
            let tags = inverted.detect(image);
            if tags.len() >= LEAST_INVERTED {
                found.extend_from_slice(tags);
            }
        }
        found.extend(
            self.chessboard
                .into_iter()
                .flat_map(|board| board.find(image)),
        );
        Ok(found)
    }
}

/// A picture as the detector takes it.
///
/// # Errors
/// A size that the detector does not take.
pub fn image_of(picture: &GreyImage) -> Result<Image<'_>, ImageError> {
    Image::new(
        &picture.pixels,
        picture.width,
        picture.height,
        picture.width,
    )
}

/// What is recorded of detections. A replay takes pictures through the same form, so that pictures and what is recorded
/// of them give the same poses, bit for bit.
pub fn detected_tags(detections: &[Detection]) -> Vec<DetectedTag> {
    let tags = detections.iter().map(|detection| DetectedTag {
        family: detection.family,
        id: detection.id,
        corners: detection.corners,
        sigma_px: None,
        corner_covariance: Some(detection.corner_covariance),
        corner_cross_covariance: Some(detection.corner_cross_covariance),
    });
    tags.collect()
}
