//! A carried object with unknown tag poses: its tags are placed before the cameras.
//!
//! Where images connect all tags, each image is used separately, since the camera poses are unknown. A two-sided board
//! has tags that no image connects: then the side that is seen most places the cameras, and these, seeing one side each
//! at the same time, place the other.

use super::{Origin, RigError, RigPlan, RigSession};
use crate::learn::{Gauge, LearnError, LearnPlan, LearnSession, LearnedObject};
use sextant_site_model::{Camera, ObjectModel, ObjectTag, Rig, TagId};

impl RigSession {
    /// The object, and the causes why tags of it could not be placed.
    pub(super) fn learned_object(&self) -> Result<(ObjectModel, Vec<String>), RigError> {
        let learned = self.learned_with(self.blind()?)?;
        if learned.report.unsolved.is_empty() {
            return Ok((learned.object, Vec::new()));
        }
        let joined = self.joined_across(&learned.object);
        Ok(joined.unwrap_or_else(|| {
            let hint = "or let two cameras see a side each at the same time, and each of them \
                the same side at other times";
            let unsolved = learned.report.unsolved.iter();
            let words = unsolved.map(|unsolved| format!("{unsolved}; {hint}"));
            (learned.object, words.collect())
        }))
    }

    /// The rig without its camera poses, which may be wrong, and without priors.
    fn blind(&self) -> Result<Rig, RigError> {
        let blind = self.images.rig.cameras().iter();
        let blind = blind
            .map(|camera| Camera::new(camera.id.clone(), camera.resolution, camera.lens, None));
        Rig::new(blind.collect())
            .map_err(|_| RigError::Undetermined("the rig is not usable".to_owned()))
    }

    fn learned_with(&self, rig: Rig) -> Result<LearnedObject, LearnError> {
        let tags = self.plan.object.tags().iter();
        let plan = LearnPlan {
            object: self.plan.object.id().clone(),
            tags: tags.map(|tag| (tag.tag, tag.size_m)).collect(),
            cameras: Vec::new(),
            gauge: Gauge::Centroid,
            from: None,
        };
        let mut session = LearnSession::new(rig, plan)?;
        self.images
            .stored
            .iter()
            .for_each(|image| session.handle(image));
        session.solve()
    }

    /// By way of the cameras, once the connected part of the object has placed those.
    fn joined_across(&self, part: &ObjectModel) -> Option<(ObjectModel, Vec<String>)> {
        let tags: Vec<TagId> = part.tags().iter().map(|tag| tag.tag).collect();
        let plan = RigPlan {
            object: self.part_of_object(&tags)?,
            origin: Origin::FirstCamera,
        };
        let mut session = RigSession::new(self.blind().ok()?, plan).ok()?;
        self.images
            .stored
            .iter()
            .for_each(|image| session.handle(image));
        let joined = self.learned_with(session.solve().ok()?.rig).ok()?;
        let more = joined.object.tags().len() > tags.len();
        more.then_some((joined.object, joined.report.unsolved))
    }

    fn part_of_object(&self, tags: &[TagId]) -> Option<ObjectModel> {
        let own = self.plan.object.tags().iter();
        let unplaced = own
            .filter(|own| tags.contains(&own.tag))
            .map(|own| ObjectTag::new(own.tag, own.size_m, None));
        ObjectModel::new(self.plan.object.id().clone(), unplaced.collect()).ok()
    }
}
