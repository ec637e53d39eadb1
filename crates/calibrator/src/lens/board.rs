//! The board: its tags with sizes and poses.

use super::refusal::LensRefusal;
use nalgebra::Point3;
use sextant_adjustment::{Anchor, BundleTag, Freedom};
use sextant_geometry::{Pose, tag_corners_in_tag};
use sextant_site_model::{BEND_SIGMA, ObjectModel, PoseSigma, TagId};

/// A tag of the board.
#[derive(Clone, Debug)]
pub(super) struct BoardTag {
    pub tag: TagId,
    pub size_m: f64,
    pub board_from_tag: Pose,
    /// In the board's frame.
    pub corners: [Point3<f64>; 4],
}

/// All tags of the board.
#[derive(Clone, Debug)]
pub(super) struct Board {
    pub tags: Vec<BoardTag>,
}

impl Board {
    pub(super) fn from_object(object: &ObjectModel) -> Result<Self, LensRefusal> {
        let tags = object.tags().iter().map(|tag| {
            let unplaced = LensRefusal::Unplaced { tag: tag.tag };
            let board_from_tag = tag.object_from_tag.ok_or(unplaced)?;
            Ok(BoardTag {
                tag: tag.tag,
                size_m: tag.size_m,
                board_from_tag,
                corners: tag_corners_in_tag(tag.size_m).map(|corner| board_from_tag * corner),
            })
        });
        Ok(Self {
            tags: tags.collect::<Result<_, _>>()?,
        })
    }

    pub(super) fn position(&self, tag: TagId) -> Option<usize> {
        self.tags.iter().position(|known| known.tag == tag)
    }

    /// The same with its tags at these places.
    pub(super) fn bent(&self, places: &[Pose]) -> Self {
        let tags = self.tags.iter().zip(places);
        let tags = tags.map(|(tag, place)| BoardTag {
            board_from_tag: *place,
            corners: tag_corners_in_tag(tag.size_m).map(|corner| place * corner),
            ..tag.clone()
        });
        Self {
            tags: tags.collect(),
        }
    }

    pub(super) fn places(&self) -> Vec<Pose> {
        self.tags.iter().map(|tag| tag.board_from_tag).collect()
    }

    /// The tags as they are, fixed or sought.
    pub(super) fn bundle_tags(&self, pose: Freedom) -> Vec<BundleTag> {
        let tags = self.tags.iter().map(|tag| BundleTag {
            object_from_tag: tag.board_from_tag,
            size_m: tag.size_m,
            pose,
            size: Freedom::Fixed,
            scale: None,
        });
        tags.collect()
    }

    /// Where the tags of a board of paper may be: printed well, and bent.
    pub(super) fn anchors(&self) -> Vec<Anchor> {
        let corners = || self.tags.iter().flat_map(|tag| tag.corners);
        let length = |axis: usize| {
            let ends = corners().map(|corner| corner[axis]);
            let (least, most) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |ends, at| {
                (ends.0.min(at), ends.1.max(at))
            });
            most - least
        };
        // A target that is no plane of its x and y is no paper that bends.
        let is_flat = corners().all(|corner| corner.z.abs() < PoseSigma::OF_PRINT.position_m);
        let bend = if is_flat { BEND_SIGMA } else { 0.0 };
        let across = (bend * length(0).max(length(1)) / PoseSigma::OF_PRINT.position_m).max(1.0);
        let tags = self.tags.iter().enumerate();
        let anchors = tags.map(|(tag, printed)| Anchor::Tag {
            tag,
            object_from_tag: printed.board_from_tag,
            sigma: PoseSigma::OF_PRINT,
            across,
        });
        anchors.collect()
    }
}
