//! Objects: rigid constellations of tags.

use std::collections::BTreeSet;
use std::fmt;

use serde::{Deserialize, Serialize};
use sextant_geometry::Pose;
use sextant_tag_families::Family;
use thiserror::Error;

use crate::ObjectId;
use crate::rig::is_finite;

/// Which tag it is: its family and its number in the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct TagId {
    /// The family of code words.
    pub family: Family,
    /// The number of the code word.
    pub id: u32,
}

impl fmt::Display for TagId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.family, self.id)
    }
}

/// A tag on an object.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectTag {
    /// Which tag.
    pub tag: TagId,
    /// Edge of its black square in metres.
    pub size_m: f64,
    /// Maps points of the tag (x right, y up, z out of its face) into the object; `None` until learned.
    pub object_from_tag: Option<Pose>,
}

/// A rigid object with its tags.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectModel {
    id: ObjectId,
    tags: Vec<ObjectTag>,
}

/// Why tags make no object.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ObjectError {
    /// An object needs a tag.
    #[error("object {0} has no tag")]
    NoTag(ObjectId),
    /// The same tag twice on one object.
    #[error("object {object}: tag {tag} is there twice")]
    DuplicateTag {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
    /// A size that is no length, or not between a millimetre and 100 metres.
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
}

impl ObjectModel {
    /// Checks the tags and takes them over.
    ///
    /// # Errors
    /// Without tags, and for the first tag that is there twice or whose size or pose is unusable.
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
        Ok(Self { id, tags })
    }

    /// Its name.
    pub fn id(&self) -> &ObjectId {
        &self.id
    }

    /// Its tags in the order given.
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
