//! Objects: constellations of tags, rigid or on links that joints connect.

use std::collections::BTreeSet;

use sextant_geometry::Pose;
use thiserror::Error;

use crate::rig::{is_finite, is_same};
use crate::{Articulation, ArticulationError, LinkId, ObjectId, PoseSigma, Prior, Rig, TagId};

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
    /// Prior of `object_from_tag`, in axes of the object or link about the centre of the tag. Fusion and calibration
    /// default to [`PoseSigma::OF_TAG`]; by default the only placed tag of an object is exact to fusion, since it is
    /// the frame.
    pub pose_prior: Prior<PoseSigma>,
    /// Prior of `size_m`, m. Fusion and calibration default to half a per cent of the size.
    pub size_prior: Prior<f64>,
    /// Its link; `None` if the object is rigid.
    pub link: Option<LinkId>,
}

impl ObjectTag {
    /// A tag of a rigid object with default priors.
    pub fn new(tag: TagId, size_m: f64, object_from_tag: Option<Pose>) -> Self {
        Self {
            tag,
            size_m,
            object_from_tag,
            pose_prior: Prior::Default,
            size_prior: Prior::Default,
            link: None,
        }
    }
}

/// An object with its tags.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectModel {
    id: ObjectId,
    tags: Vec<ObjectTag>,
    articulation: Option<Articulation>,
    frame_sigma: Option<PoseSigma>,
    scale_sigma: Option<f64>,
    world_from_object: Option<Pose>,
}

/// What is invalid in a model of an object.
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
    /// An invalid sigma of a tag pose.
    #[error("object {object}: the sigmas of tag {tag} must lie between 0 and 1 (m, rad)")]
    TagSigma {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
    },
    /// An invalid sigma of the object's frame.
    #[error("object {0}: the sigmas of its frame must lie between 0 and 1 (m, rad)")]
    FrameSigma(ObjectId),
    /// An invalid sigma of the common scale.
    #[error("object {0}: the sigma of its scale must lie between 0 and 1")]
    ScaleSigma(ObjectId),
    /// A place in the world that is not finite.
    #[error("object {0}: world_from_object is not finite")]
    Place(ObjectId),
    /// A place in the world of an object with links.
    #[error("object {0} has links, and a place in the world: only rigid objects are landmarks")]
    MovingLandmark(ObjectId),
    /// An invalid sigma of a size.
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
    /// A tag on no link of an object that has links.
    #[error("object {object}: tag {tag} is on no link, though the object has links")]
    NoLink {
        /// The object.
        object: ObjectId,
        /// The tag.
        tag: TagId,
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
            | Self::UnknownLink { tag, .. }
            | Self::NoLink { tag, .. } => Some(*tag),
            Self::NoTag(_)
            | Self::FrameSigma(_)
            | Self::ScaleSigma(_)
            | Self::Place(_)
            | Self::MovingLandmark(_)
            | Self::Articulation { .. } => None,
        }
    }
}

impl ObjectModel {
    /// Checks the tags of a rigid object. Standard deviations of zero become [`Prior::Exact`].
    ///
    /// # Errors
    /// Without tags, and for the first tag with an invalid size, pose or standard deviation, that names a link, or that
    /// is duplicated.
    pub fn new(id: ObjectId, tags: Vec<ObjectTag>) -> Result<Self, ObjectError> {
        Self::checked(id, None, tags)
    }

    /// Checks the tags of an articulated object, each with its link; `object_from_tag` is `link_from_tag`.
    ///
    /// # Errors
    /// As [`Self::new`], and for the first tag without a link of the articulation.
    pub fn articulated(
        id: ObjectId,
        articulation: Articulation,
        tags: Vec<ObjectTag>,
    ) -> Result<Self, ObjectError> {
        Self::checked(id, Some(articulation), tags)
    }

    fn checked(
        id: ObjectId,
        articulation: Option<Articulation>,
        tags: Vec<ObjectTag>,
    ) -> Result<Self, ObjectError> {
        if tags.is_empty() {
            return Err(ObjectError::NoTag(id));
        }
        let mut object = Self {
            id,
            tags: Vec::new(),
            articulation,
            frame_sigma: None,
            scale_sigma: None,
            world_from_object: None,
        };
        let mut seen = BTreeSet::new();
        for tag in tags {
            let tag = object.checked_tag(tag)?;
            if !seen.insert(tag.tag) {
                let (object, tag) = (object.id, tag.tag);
                return Err(ObjectError::DuplicateTag { object, tag });
            }
            object.tags.push(tag);
        }
        Ok(object)
    }

    /// The tag with exact priors where its standard deviations are zero.
    fn checked_tag(&self, mut checked: ObjectTag) -> Result<ObjectTag, ObjectError> {
        let (object, tag, size_m) = (self.id.clone(), checked.tag, checked.size_m);
        if !(0.001..=100.0).contains(&size_m) {
            return Err(ObjectError::Size {
                object,
                tag,
                size_m,
            });
        }
        if !checked.object_from_tag.as_ref().is_none_or(is_finite) {
            return Err(ObjectError::Pose { object, tag });
        }
        let (pose_sigma, size_sigma_m) = (checked.pose_prior.given(), checked.size_prior.given());
        if !size_sigma_m.is_none_or(|sigma_m| (0.0..=size_m).contains(&sigma_m)) {
            return Err(ObjectError::SizeSigma { object, tag });
        }
        if !pose_sigma.is_none_or(|sigma| sigma.is_sound()) {
            return Err(ObjectError::TagSigma { object, tag });
        }
        match (&checked.link, self.link_of(&checked)) {
            (Some(link), None) => {
                let link = link.clone();
                return Err(ObjectError::UnknownLink { object, tag, link });
            }
            (None, _) if self.articulation.is_some() => {
                return Err(ObjectError::NoLink { object, tag });
            }
            _ => {}
        }
        checked.pose_prior = pose_sigma.into();
        checked.size_prior = size_sigma_m.into();
        Ok(checked)
    }

    /// Makes every default prior exact: for simulations.
    #[must_use]
    pub fn exact(mut self) -> Self {
        for tag in &mut self.tags {
            tag.pose_prior = tag.pose_prior.or(Prior::Exact);
            tag.size_prior = tag.size_prior.or(Prior::Exact);
        }
        self
    }

    /// The object with standard deviations of its frame in its tags, in axes of the object about its origin; zero is
    /// `None`.
    ///
    /// # Errors
    /// Where they do not lie between 0 and 1 (m, rad).
    pub fn with_frame_sigma(mut self, sigma: Option<PoseSigma>) -> Result<Self, ObjectError> {
        if !sigma.is_none_or(|sigma| sigma.is_sound()) {
            return Err(ObjectError::FrameSigma(self.id));
        }
        self.frame_sigma = sigma.filter(PoseSigma::is_some);
        Ok(self)
    }

    /// Standard deviations of its frame in its tags, which no image shows: the tags' sigmas are without them, since
    /// they displace all of them alike. `None` if the file does not state them.
    pub fn frame_sigma(&self) -> Option<PoseSigma> {
        self.frame_sigma
    }

    /// The object with a standard deviation of the scale that the sizes and places of its tags share, as a share of it;
    /// zero is exact.
    ///
    /// # Errors
    /// Where it does not lie between 0 and 1.
    pub fn with_scale_sigma(mut self, sigma: Option<f64>) -> Result<Self, ObjectError> {
        if !sigma.is_none_or(|sigma| (0.0..=1.0).contains(&sigma)) {
            return Err(ObjectError::ScaleSigma(self.id));
        }
        self.scale_sigma = sigma;
        Ok(self)
    }

    /// Standard deviation of the scale that the sizes and places of its tags share, as a share of it, as the file
    /// states it: the tags' sigmas are without it.
    pub fn scale_sigma(&self) -> Option<f64> {
        self.scale_sigma
    }

    /// The object as a landmark, which stands still in the world: carried cameras are localised by its tags.
    ///
    /// # Errors
    /// Where the pose is not finite, or the object has links.
    pub fn with_world_from_object(mut self, pose: Option<Pose>) -> Result<Self, ObjectError> {
        if !pose.as_ref().is_none_or(is_finite) {
            return Err(ObjectError::Place(self.id));
        }
        if pose.is_some() && self.articulation.is_some() {
            return Err(ObjectError::MovingLandmark(self.id));
        }
        self.world_from_object = pose;
        Ok(self)
    }

    /// Maps points of the object into the world; `None` unless it is a landmark.
    pub fn world_from_object(&self) -> Option<&Pose> {
        self.world_from_object.as_ref()
    }

    /// As [`Self::scale_sigma`], by default that of a printer; zero if all sizes are exact.
    pub fn scale_sigma_or_usual(&self) -> f64 {
        let is_exact = |tag: &ObjectTag| tag.size_prior == Prior::Exact;
        let usual = if self.tags.iter().all(is_exact) {
            0.0
        } else {
            crate::SIZE_SIGMA
        };
        self.scale_sigma.unwrap_or(usual)
    }

    /// The object with this tag in place of the one with its name; unchanged if it is invalid or the object has no such
    /// tag. The standard deviation of the former size scales with the size.
    #[must_use]
    pub fn with_tag(mut self, mut corrected: ObjectTag) -> Self {
        let Some(at) = self.tags.iter().position(|tag| tag.tag == corrected.tag) else {
            return self;
        };
        let former = &self.tags[at];
        let scaled = |sigma_m: f64| {
            let scaled_m = sigma_m * corrected.size_m / former.size_m;
            scaled_m.min(corrected.size_m)
        };
        corrected.size_prior = former.size_prior.given().map(scaled).into();
        if let Ok(corrected) = self.checked_tag(corrected) {
            self.tags[at] = corrected;
        }
        self
    }

    /// Takes over the pose priors of a former model for tags with unchanged poses, and the sigmas of its frame and
    /// scale and its place in the world where some pose is unchanged, unless this model has its own.
    #[must_use]
    pub fn holding_on_to(mut self, former: &Self) -> Self {
        let mut is_placed_alike = false;
        for tag in &mut self.tags {
            let before = former.tags.iter().find(|before| before.tag == tag.tag);
            if let Some(before) = before
                && is_same(before.object_from_tag, tag.object_from_tag)
            {
                tag.pose_prior = tag.pose_prior.or(before.pose_prior);
                is_placed_alike = true;
            }
        }
        if is_placed_alike {
            self.frame_sigma = self.frame_sigma.or(former.frame_sigma);
            self.scale_sigma = self.scale_sigma.or(former.scale_sigma);
            self.world_from_object = self.world_from_object.or(former.world_from_object);
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

    /// Index of the link of a tag in [`Articulation::links`]; `None` if the object is rigid.
    pub fn link_of(&self, tag: &ObjectTag) -> Option<usize> {
        self.articulation.as_ref()?.link(tag.link.as_ref()?)
    }

    /// The name by which the site knows the object.
    pub fn id(&self) -> &ObjectId {
        &self.id
    }

    /// Its tags in the given order.
    pub fn tags(&self) -> &[ObjectTag] {
        &self.tags
    }
}

/// The objects whose poses are to be expected: all of these, but landmarks only where some camera stands still; then
/// carriers of cameras that have no model.
pub fn posed_objects(rig: &Rig, objects: &[ObjectModel]) -> Vec<ObjectId> {
    let mut cameras = rig.cameras().iter();
    let some_stand_still = cameras.any(|camera| camera.mount.is_none());
    let is_posed = |object: &&ObjectModel| some_stand_still || object.world_from_object().is_none();
    let modelled = objects.iter().filter(is_posed).map(ObjectModel::id);
    let mut posed: Vec<ObjectId> = modelled.cloned().collect();
    for carrier in rig.carriers() {
        if !posed.contains(carrier) {
            posed.push(carrier.clone());
        }
    }
    posed
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_tag_families::Family;

    fn tag(link: Option<&str>) -> ObjectTag {
        let family = Family::Tag36h11;
        ObjectTag {
            size_prior: Prior::Sigma(0.001),
            link: link.map(|link| LinkId::new(link).unwrap()),
            ..ObjectTag::new(TagId { family, id: 3 }, 0.04, None)
        }
    }

    fn arm() -> ObjectId {
        ObjectId::new("arm").unwrap()
    }

    #[test]
    fn a_tag_is_on_a_link_of_its_object_or_the_object_is_rigid() {
        let tree = Articulation::new(vec![LinkId::new("base").unwrap()], Vec::new()).unwrap();
        let on = |link| ObjectModel::articulated(arm(), tree.clone(), vec![tag(link)]);
        let arm_with_tag = on(Some("base")).unwrap();
        assert_eq!(arm_with_tag.link_of(&arm_with_tag.tags()[0]), Some(0));
        assert!(matches!(on(None), Err(ObjectError::NoLink { .. })));
        let unknown = [
            on(Some("hand")),
            ObjectModel::new(arm(), vec![tag(Some("base"))]),
        ];
        for refused in unknown {
            assert!(matches!(refused, Err(ObjectError::UnknownLink { .. })));
        }
    }

    #[test]
    fn a_corrected_size_scales_its_sigma_and_an_invalid_one_changes_nothing() {
        let object = ObjectModel::new(arm(), vec![tag(None)]).unwrap();
        let sized = |size_m| {
            let corrected = object.clone().with_tag(ObjectTag {
                size_m,
                ..tag(None)
            });
            corrected.tags()[0].clone()
        };
        assert_eq!(sized(0.08).size_prior, Prior::Sigma(0.002));
        assert_eq!(sized(-0.08), object.tags()[0]);
    }
}
