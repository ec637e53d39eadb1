//! Objects: constellations of tags, rigid or on links that joints connect.

use std::collections::{BTreeMap, BTreeSet};

use sextant_geometry::Pose;
use thiserror::Error;

use crate::rig::{is_finite, is_same};
use crate::{Articulation, ArticulationError, LinkId, ObjectId, PoseSigma, TagId};

/// A tag on an object.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectTag {
    /// Which tag.
    pub tag: TagId,
    /// Edge of its black square in metres.
    pub size_m: f64,
    /// Maps points of the tag (x right, y up, z out of its face) into the object, or into its link where the object has
    /// links; `None` until learned.
    pub object_from_tag: Option<Pose>,
}

/// An object with its tags.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectModel {
    id: ObjectId,
    tags: Vec<ObjectTag>,
    articulation: Option<Articulation>,
    /// Index of each tag's link; empty for a rigid object.
    links: Vec<usize>,
    tag_sigmas: BTreeMap<TagId, PoseSigma>,
    size_sigmas_m: BTreeMap<TagId, f64>,
}

/// An invalid object.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ObjectError {
    /// An object without tags.
    #[error("object {0} has no tag")]
    NoTag(ObjectId),
    /// A duplicate tag.
    #[error("object {object}: tag {tag} is there twice")]
    DuplicateTag {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
    /// A size that is not between a millimetre and 100 metres.
    #[error(
        "object {object}: tag {tag} has the size {size_m} m; it must lie between 0.001 and 100"
    )]
    Size {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
        /// The size in metres.
        size_m: f64,
    },
    /// A position or orientation that is not finite.
    #[error("object {object}: object_from_tag of tag {tag} is not finite")]
    Pose {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
    /// An invalid sigma of a tag pose, or one of a missing tag.
    #[error("object {object}: the sigmas of tag {tag} must lie between 0 and 1 (m, rad)")]
    TagSigma {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
    /// An invalid sigma of a size, or one of a missing tag.
    #[error(
        "object {object}: the sigma of the size of tag {tag} must lie between 0 and the size itself"
    )]
    SizeSigma {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
    /// A tag on a link that the object lacks.
    #[error("object {object}: tag {tag} is on link {link}, which the object does not have")]
    UnknownLink {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
        /// The missing link.
        link: LinkId,
    },
    /// Invalid links and joints.
    #[error("object {object}: {error}")]
    Articulation {
        /// The object.
        object: ObjectId,
        /// The fault.
        error: ArticulationError,
    },
}

impl ObjectError {
    /// The tag concerned, if any.
    pub fn tag(&self) -> Option<TagId> {
        match self {
            Self::DuplicateTag { tag, .. }
            | Self::Size { tag, .. }
            | Self::Pose { tag, .. }
            | Self::TagSigma { tag, .. }
            | Self::SizeSigma { tag, .. }
            | Self::UnknownLink { tag, .. } => Some(*tag),
            Self::NoTag(_) | Self::Articulation { .. } => None,
        }
    }
}

impl ObjectModel {
    /// Checks the tags of a rigid object.
    ///
    /// # Errors
    /// Without tags, and for the first tag that is duplicated or whose size or pose is invalid.
    pub fn new(id: ObjectId, tags: Vec<ObjectTag>) -> Result<Self, ObjectError> {
        if tags.is_empty() {
            return Err(ObjectError::NoTag(id));
        }
        let mut seen = BTreeSet::new();
        for tag in &tags {
            check(&id, tag)?;
            if !seen.insert(tag.tag) {
                return Err(ObjectError::DuplicateTag {
                    object: id,
                    tag: tag.tag,
                });
            }
        }
        Ok(Self {
            id,
            tags,
            articulation: None,
            links: Vec::new(),
            tag_sigmas: BTreeMap::new(),
            size_sigmas_m: BTreeMap::new(),
        })
    }

    /// Checks the tags of an articulated object: each with its link; `object_from_tag` is `link_from_tag`.
    ///
    /// # Errors
    /// As [`Self::new`], and for the first tag on a missing link.
    pub fn articulated(
        id: ObjectId,
        articulation: Articulation,
        tags: Vec<(LinkId, ObjectTag)>,
    ) -> Result<Self, ObjectError> {
        let mut links = Vec::with_capacity(tags.len());
        for (link, tag) in &tags {
            links.push(
                articulation
                    .link(link)
                    .ok_or_else(|| ObjectError::UnknownLink {
                        object: id.clone(),
                        tag: tag.tag,
                        link: link.clone(),
                    })?,
            );
        }
        let rigid = Self::new(id, tags.into_iter().map(|(_, tag)| tag).collect())?;
        Ok(Self {
            articulation: Some(articulation),
            links,
            ..rigid
        })
    }

    /// The object with standard deviations of its tag poses, in axes of the object or link about the centre of the tag. Tags without
    /// one count as exact.
    ///
    /// # Errors
    /// For the first tag that the object lacks, and the first invalid sigma.
    pub fn with_tag_sigmas(
        mut self,
        sigmas: impl IntoIterator<Item = (TagId, PoseSigma)>,
    ) -> Result<Self, ObjectError> {
        for (tag, sigma) in sigmas {
            if !sigma.is_sound() || !self.tags.iter().any(|one| one.tag == tag) {
                let object = self.id.clone();
                return Err(ObjectError::TagSigma { object, tag });
            }
            self.tag_sigmas.insert(tag, sigma);
        }
        Ok(self)
    }

    /// The object with standard deviations of its tags' sizes, m.
    ///
    /// # Errors
    /// For the first tag that the object lacks, and the first sigma that is not between 0 and the tag's size.
    pub fn with_size_sigmas(
        mut self,
        sigmas: impl IntoIterator<Item = (TagId, f64)>,
    ) -> Result<Self, ObjectError> {
        for (tag, sigma_m) in sigmas {
            let known = self.tags.iter().find(|one| one.tag == tag);
            if !known.is_some_and(|known| (0.0..=known.size_m).contains(&sigma_m)) {
                let object = self.id.clone();
                return Err(ObjectError::SizeSigma { object, tag });
            }
            self.size_sigmas_m.insert(tag, sigma_m);
        }
        Ok(self)
    }

    /// Standard deviation of a tag's size in m, if given.
    pub fn size_sigma_m(&self, tag: &TagId) -> Option<f64> {
        self.size_sigmas_m.get(tag).copied()
    }

    /// Declares every number without a sigma exact: for simulations.
    #[must_use]
    pub fn exact(mut self) -> Self {
        for tag in &self.tags {
            self.tag_sigmas.entry(tag.tag).or_insert(PoseSigma::NONE);
            self.size_sigmas_m.entry(tag.tag).or_insert(0.0);
        }
        self
    }

    /// The object with another pose and size of a tag, and the sigma of the pose; unchanged if they are invalid.
    #[must_use]
    pub fn with_tag(mut self, corrected: ObjectTag, sigma: PoseSigma) -> Self {
        let mut tags = self.tags.iter_mut();
        let known = tags.find(|tag| tag.tag == corrected.tag);
        if let Some(tag) = known.filter(|_| check(&self.id, &corrected).is_ok()) {
            self.tag_sigmas.insert(corrected.tag, sigma);
            if let Some(size_sigma_m) = self.size_sigmas_m.get_mut(&corrected.tag) {
                let scaled_m = *size_sigma_m * corrected.size_m / tag.size_m;
                *size_sigma_m = scaled_m.min(corrected.size_m);
            }
            *tag = corrected;
        }
        self
    }

    /// Standard deviation of the pose of a tag, if given.
    pub fn tag_sigma(&self, tag: &TagId) -> Option<PoseSigma> {
        self.tag_sigmas.get(tag).copied()
    }

    /// Takes over the sigmas of a former model for tags with unchanged poses, unless this model has sigmas
    /// of its own.
    #[must_use]
    pub fn holding_on_to(mut self, former: &Self) -> Self {
        for (tag, sigma) in &former.tag_sigmas {
            let place = |model: &Self| {
                let mut tags = model.tags.iter();
                tags.find(|one| one.tag == *tag)?.object_from_tag
            };
            if is_same(place(&self), place(former)) {
                self.tag_sigmas.entry(*tag).or_insert(*sigma);
            }
        }
        self
    }

    /// Whether the poses of all tags are known.
    pub fn is_learned(&self) -> bool {
        self.tags.iter().all(|tag| tag.object_from_tag.is_some())
    }

    /// Its links and joints; `None` if it is rigid.
    pub fn articulation(&self) -> Option<&Articulation> {
        self.articulation.as_ref()
    }

    /// Index of the link of a tag, by the tag's index in [`Self::tags`]; `None` if the object is rigid.
    pub fn link_of(&self, tag: usize) -> Option<usize> {
        self.links.get(tag).copied()
    }

    /// Its name.
    pub fn id(&self) -> &ObjectId {
        &self.id
    }

    /// Its tags in the given order.
    pub fn tags(&self) -> &[ObjectTag] {
        &self.tags
    }
}

fn check(object: &ObjectId, tag: &ObjectTag) -> Result<(), ObjectError> {
    if !(0.001..=100.0).contains(&tag.size_m) {
        return Err(ObjectError::Size {
            object: object.clone(),
            tag: tag.tag,
            size_m: tag.size_m,
        });
    }
    match &tag.object_from_tag {
        Some(pose) if !is_finite(pose) => Err(ObjectError::Pose {
            object: object.clone(),
            tag: tag.tag,
        }),
        _ => Ok(()),
    }
}
