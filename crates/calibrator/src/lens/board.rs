//! The board: its tags with sizes and poses.

use super::refusal::LensRefusal;
use crate::bundle::{BundleTag, Freedom};
use nalgebra::Point3;
use sextant_geometry::{Pose, tag_corners_in_tag};
use sextant_site_model::{ObjectModel, TagId};

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
    pub(super) fn of(object: &ObjectModel) -> Result<Self, LensRefusal> {
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

    /// Fixed bundle tags, as printed.
    pub(super) fn bundle_tags(&self) -> Vec<BundleTag> {
        let tags = self.tags.iter().map(|tag| BundleTag {
            object_from_tag: tag.board_from_tag,
            size_m: tag.size_m,
            pose: Freedom::Fixed,
            size: Freedom::Fixed,
        });
        tags.collect()
    }
}
