//! An object that is carried and not known: its tags are placed before the cameras are.
//!
//! Where images join all tags, each image is used by itself, since nobody knows where the cameras are. A board with two sides
//! has tags that no image joins: then the side that is seen most places the cameras, and those, seeing one side each at the
//! same time, place the other.

use super::{Origin, RigError, RigPlan, RigSession};
use crate::learn::{Gauge, LearnError, LearnPlan, LearnSession};
use sextant_estimator::{Camera, ObjectModel, ObjectTag, Rig, TagId};

impl RigSession {
    /// The object with every tag in its place.
    pub(super) fn learned_object(&self) -> Result<ObjectModel, RigError> {
        match self.learned_with(self.blind()?) {
            Err(LearnError::NotConnected {
                islands,
                groups,
                hint,
            }) => self.joined_across(&islands).ok_or_else(|| {
                let hint = format!(
                    "{hint}; or let two cameras see a side each at the same time, and each of them the same side at other times"
                );
                let apart = LearnError::NotConnected {
                    islands,
                    groups,
                    hint,
                };
                RigError::Object(apart)
            }),
            learned => Ok(learned?),
        }
    }

    /// The poses of the rig may be wrong: without them.
    fn blind(&self) -> Result<Rig, RigError> {
        let blind = self.rig.cameras().iter().map(|camera| Camera {
            world_from_camera: None,
            ..camera.clone()
        });
        Rig::new(blind.collect())
            .map_err(|_| RigError::Undetermined("the rig is not usable".to_owned()))
    }

    fn learned_with(&self, rig: Rig) -> Result<ObjectModel, LearnError> {
        let tags = self.plan.object.tags().iter();
        let plan = LearnPlan {
            object: self.plan.object.id().clone(),
            tags: tags.map(|tag| (tag.tag, tag.size_m)).collect(),
            cameras: Vec::new(),
            gauge: Gauge::Centroid,
            from: None,
        };
        let mut session = LearnSession::new(rig, plan)?;
        self.images.iter().for_each(|image| session.handle(image));
        Ok(session.solve()?.object)
    }

    /// By way of the cameras, once one of the groups has placed those.
    fn joined_across(&self, islands: &[Vec<TagId>]) -> Option<ObjectModel> {
        let seen = |island: &&Vec<TagId>| {
            let tags = self.images.iter().flat_map(|image| &image.tags);
            tags.filter(|seen| island.contains(&seen.tag)).count()
        };
        let most = islands.iter().max_by_key(seen)?;
        let side = self.part_of_object(most)?;
        let plan = RigPlan {
            object: side,
            origin: Origin::FirstCamera,
        };
        let mut session = RigSession::new(self.blind().ok()?, plan).ok()?;
        self.images.iter().for_each(|image| session.handle(image));
        self.learned_with(session.solve().ok()?.rig).ok()
    }

    fn part_of_object(&self, tags: &[TagId]) -> Option<ObjectModel> {
        let own = self.plan.object.tags().iter();
        let unplaced = own
            .filter(|own| tags.contains(&own.tag))
            .map(|own| ObjectTag {
                object_from_tag: None,
                ..own.clone()
            });
        ObjectModel::new(self.plan.object.id().clone(), unplaced.collect()).ok()
    }
}
