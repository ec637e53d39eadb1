//! Learning an object whose tags are unknown: tags that move as one body belong to it.
//!
//! A tag that stands still in front of its camera belongs to the room, and one that moves differently to another
//! object. Unknown sizes follow from a known one, since all tags of a body share its motion. A [`DiscoverySession`]
//! finds the tags and learns them with a [`LearnSession`], with the same interface.

mod groups;
mod rigidity;
mod sizes;
mod tracks;

use crate::discovered_tags::DiscoveredTags;
use crate::image_store::ImageStore;
use crate::learn::{
    Gauge, LearnError, LearnPlan, LearnProgress, LearnSession, LearnedObject, SketchedTag,
};
use crate::verdict::{Finding, Grade, listed};
use groups::Groups;
use sextant_site_model::{CameraId, ImageObservation, ObjectId, Rig, TagId};
use sextant_tag_families::Family;
use sizes::Sizes;
use tracks::Tracks;

/// Tags by what they move with.
#[derive(Clone, Debug, Default)]
pub(crate) struct TagGroups {
    /// Tags of each thing that moves as one, two at least, in ascending order.
    pub bodies: Vec<Vec<TagId>>,
    /// Tags that move and are joined with nothing.
    pub loose: Vec<TagId>,
    /// Tags that stand still before every camera.
    pub still: Vec<TagId>,
}

impl TagGroups {
    /// Groups the tags of some families by the images of a rig, whose lenses may be approximate.
    pub(crate) fn from_images<'a>(
        rig: &Rig,
        images: impl Iterator<Item = &'a ImageObservation>,
        families: &[Family],
    ) -> Self {
        let mut tracks = Tracks::default();
        for image in images {
            if let Some(camera) = rig.camera(&image.camera) {
                tracks.add(camera, image, families);
            }
        }
        let groups = Groups::from_tracks(&tracks);
        let mut bodies = groups.moving().to_vec();
        bodies.iter_mut().for_each(|body| body.sort_unstable());
        Self {
            bodies,
            loose: groups.loose().to_vec(),
            still: groups.still().to_vec(),
        }
    }
}

/// What is to be discovered and learned.
#[derive(Clone, Debug)]
pub struct DiscoveryPlan {
    /// The object's name.
    pub object: ObjectId,
    /// The families of tags that count.
    pub families: Vec<Family>,
    /// The edge of the black square that most tags of the object have, metres.
    pub size_m: Option<f64>,
    /// The sizes of single tags, metres. One of them is enough where [`DiscoveryPlan::size_m`] is not known.
    pub sizes: Vec<(TagId, f64)>,
    /// A tag of the object, needed where several things move.
    pub around: Option<TagId>,
    /// Cameras to use; empty for all of the rig.
    pub cameras: Vec<CameraId>,
    /// The frame of the result.
    pub gauge: Gauge,
}

/// Discovers and learns an object from successive images.
#[derive(Clone, Debug)]
pub struct DiscoverySession {
    rig: Rig,
    plan: DiscoveryPlan,
    images: ImageStore,
    tracks: Tracks,
    groups: Groups,
    /// The discovered tags with their sizes, and the session that learns them.
    inner: Option<(Sizes, LearnSession)>,
    /// Number of images at which tags are grouped again.
    next_regrouping: usize,
}

/// Most stored images.
const MOST_IMAGES: usize = 6000;
/// Images before the first grouping, and growth of their number until the next one.
const FIRST_REGROUPING: usize = 8;
const REGROUPING_GROWTH: f64 = 1.15;
/// Most rounds of learning to estimate unknown sizes.
const SIZE_ROUNDS: usize = 3;
/// Relative change of unknown sizes at which the rounds end.
const CONVERGED: f64 = 5e-4;

impl DiscoverySession {
    /// Starts a session without images.
    ///
    /// # Errors
    /// A camera that is not in the rig.
    pub fn new(rig: Rig, plan: DiscoveryPlan) -> Result<Self, LearnError> {
        if let Some(unknown) = plan.cameras.iter().find(|id| rig.camera(id).is_none()) {
            return Err(LearnError::UnknownCamera(unknown.clone()));
        }
        Ok(Self {
            images: ImageStore::at_most(MOST_IMAGES),
            tracks: Tracks::default(),
            groups: Groups::default(),
            inner: None,
            next_regrouping: FIRST_REGROUPING,
            rig,
            plan,
        })
    }

    /// Whether images of a camera are used.
    pub fn counts(&self, camera: &CameraId) -> bool {
        let chosen = self.plan.cameras.is_empty() || self.plan.cameras.contains(camera);
        chosen && self.rig.camera(camera).is_some()
    }

    /// Handles an image. Images of unused cameras are ignored.
    pub fn handle(&mut self, image: &ImageObservation) {
        let Some(camera) = self.rig.camera(&image.camera) else {
            return;
        };
        if !self.counts(&image.camera) {
            return;
        }
        self.tracks.add(camera, image, &self.plan.families);
        self.images.push(image);
        if let Some((_, inner)) = &mut self.inner {
            inner.handle(image);
        }
        if self.images.n_received() >= self.next_regrouping {
            self.next_regrouping =
                (self.images.n_received() as f64 * REGROUPING_GROWTH) as usize + 1;
            self.regroup();
        }
    }

    /// Groups the tags again, and starts a new session if the object's tags have changed.
    fn regroup(&mut self) {
        self.groups = Groups::from_tracks(&self.tracks);
        let object = self.groups.object(self.plan.around);
        let Some(sizes) =
            object.map(|tags| Sizes::from_ratios(&self.plan, tags, self.groups.joints()))
        else {
            self.inner = None;
            return;
        };
        let is_same = |(before, _): &(Sizes, LearnSession)| before.are_nearly(&sizes);
        if !self.inner.as_ref().is_some_and(is_same) {
            self.inner = self.learning(&sizes).ok().map(|inner| (sizes, inner));
        }
    }

    /// A session that learns these tags from all images so far.
    fn learning(&self, sizes: &Sizes) -> Result<LearnSession, LearnError> {
        let gauge = match self.plan.gauge {
            Gauge::Tag(tag) if sizes.contains(tag) => Gauge::Tag(tag),
            _ => Gauge::Centroid,
        };
        let plan = LearnPlan {
            object: self.plan.object.clone(),
            tags: sizes.tags(),
            cameras: self.plan.cameras.clone(),
            gauge,
            from: None,
        };
        let mut session = LearnSession::new(self.rig.clone(), plan)?;
        self.images.iter().for_each(|image| session.handle(image));
        Ok(session)
    }

    /// The groups of tags found so far.
    pub fn found(&self) -> DiscoveredTags {
        self.groups.found(self.plan.around)
    }

    /// Progress so far and what to do next.
    pub fn progress(&self) -> LearnProgress {
        let mut progress = match &self.inner {
            Some((_, inner)) => inner.progress(),
            None => LearnProgress::nothing_yet(),
        };
        progress.images = self.images.n_received();
        if let Some(hint) = self.hint() {
            progress.hint = hint;
            progress.complete = progress.complete.min(0.99);
        }
        progress
    }

    /// Instruction from discovery itself, if any.
    fn hint(&self) -> Option<String> {
        let found = self.found();
        if found.object.is_empty() {
            return Some(match found.others.as_slice() {
                [] if self.tracks.is_empty() => "Show the object to the camera".to_owned(),
                [] => "Take the object into your hand and turn it slowly before the camera, away \
                    from what stands still"
                    .to_owned(),
                _ => found.several(),
            });
        }
        if let Some((sizes, _)) = &self.inner
            && !sizes.are_known()
        {
            return Some(format!(
                "{} move as one, but how large they are is not known: end this and state a size",
                listed(&found.object)
            ));
        }
        found.loose.first().map(|loose| {
            format!(
                "{loose} moves too, joined with nothing yet: show it together with one of {}, or keep it away",
                listed(&found.object)
            )
        })
    }

    /// Approximate poses of the tags found so far.
    pub fn sketch(&self) -> Vec<SketchedTag> {
        let inner = self.inner.as_ref();
        inner.map(|(_, inner)| inner.sketch()).unwrap_or_default()
    }

    /// Determines the tags of the object and their poses.
    ///
    /// # Errors
    /// If nothing moves or several things do, if no size is known, or if the images do not determine every tag.
    pub fn solve(&self) -> Result<LearnedObject, LearnError> {
        let mut last = self.clone();
        last.regroup();
        let found = last.found();
        let Some(tags) = last.groups.object(self.plan.around) else {
            return Err(LearnError::NotDiscovered(
                found.why_none(self.images.n_received(), self.plan.around),
            ));
        };
        let sizes = Sizes::from_ratios(&self.plan, tags, last.groups.joints());
        if let Gauge::Tag(tag) = self.plan.gauge
            && !sizes.contains(tag)
        {
            return Err(LearnError::UnknownOrigin(tag));
        }
        if !sizes.are_known() {
            return Err(LearnError::SizeUnknown(sizes.in_words()));
        }
        let learned = last.solve_with(sizes)?;
        Ok(with_discovery(learned, found))
    }

    /// Learns the tags and corrects unknown sizes by the estimated size ratios until they converge.
    fn solve_with(&self, mut sizes: Sizes) -> Result<LearnedObject, LearnError> {
        let mut learned = self.learning(&sizes)?.solve()?;
        for _ in 0..SIZE_ROUNDS {
            let ratios: Vec<f64> = learned.report.tags.iter().map(|t| t.size_ratio).collect();
            if sizes.correct(&ratios) < CONVERGED {
                break;
            }
            learned = self.learning(&sizes)?.solve()?;
        }
        learned.report.solved_sizes = sizes.solved();
        Ok(learned)
    }
}

/// Adds the discovered tags to the report.
fn with_discovery(mut learned: LearnedObject, found: DiscoveredTags) -> LearnedObject {
    let verdict = &mut learned.report.verdict;
    if !found.loose.is_empty() {
        verdict.add(Grade::Good, Finding::LooseTags(found.loose.clone()));
    }
    learned.report.found = Some(found);
    learned
}
