//! Which tags belong to what, and the images of each body by itself.

use super::{SitePlan, SiteSession};
use crate::discovery::TagGroups;
use crate::image_store::{ImageView, TagSpec, take_in};
use sextant_site_model::{Rig, TagId};

/// Tags of all bodies in turn, then those that stand still.
#[derive(Clone, Debug)]
pub(super) struct Members {
    pub wanted: Vec<TagSpec>,
    /// Of each wanted tag its body; `None` for one that stands still.
    pub body_of: Vec<Option<usize>>,
    pub n_bodies: usize,
    /// Tags that move, but were never seen with another one while they did.
    pub loose: Vec<TagId>,
}

/// Images with the tags of one body each.
#[derive(Clone, Debug, Default)]
pub(super) struct BodyViews {
    pub views: Vec<ImageView>,
    /// Of each view; `None` for the tags that stand still.
    pub body_of: Vec<Option<usize>>,
}

impl Members {
    pub fn from_groups(plan: &SitePlan, mut groups: TagGroups) -> Self {
        // A thing with a single tag is an object where there is no other.
        if groups.bodies.is_empty() {
            groups.bodies = groups.loose.drain(..).map(|tag| vec![tag]).collect();
        }
        groups.bodies.sort();
        let spec = |tag: TagId| TagSpec {
            tag,
            size_m: plan.size_of(tag),
        };
        let (mut wanted, mut body_of) = (Vec::new(), Vec::new());
        for (body, tags) in groups.bodies.iter().enumerate() {
            wanted.extend(tags.iter().map(|tag| spec(*tag)));
            body_of.resize(wanted.len(), Some(body));
        }
        wanted.extend(groups.still.iter().map(|tag| spec(*tag)));
        body_of.resize(wanted.len(), None);
        Self {
            wanted,
            body_of,
            n_bodies: groups.bodies.len(),
            loose: groups.loose,
        }
    }

    /// Indices of the tags of a body.
    pub fn tags_of(&self, body: usize) -> impl Iterator<Item = usize> {
        let tags = self.body_of.iter().enumerate();
        tags.filter(move |(_, of)| **of == Some(body))
            .map(|(tag, _)| tag)
    }

    /// Takes the tags of a body for larger by a factor.
    pub fn rescale(&mut self, body: usize, factor: f64) {
        let tags = self.wanted.iter_mut().zip(&self.body_of);
        let own = tags.filter(|(_, of)| **of == Some(body));
        own.for_each(|(tag, _)| tag.size_m *= factor);
    }

    /// How many tags move; those that stand still follow.
    pub fn n_carried(&self) -> usize {
        self.body_of.iter().flatten().count()
    }
}

impl SitePlan {
    pub(super) fn size_of(&self, tag: TagId) -> f64 {
        let mut sizes = self.sizes.iter();
        let own = sizes.find(|(of, _)| *of == tag);
        own.map_or(self.size_m, |(_, size_m)| *size_m)
    }
}

impl SiteSession {
    /// The images by body, with both poses of every tag by the lenses of the rig.
    pub(super) fn body_views(&self, rig: &Rig, members: &Members) -> BodyViews {
        let mut found = BodyViews::default();
        for image in self.images.iter() {
            let mut cameras = rig.cameras().iter();
            let Some(camera) = cameras.position(|camera| camera.id == image.camera) else {
                continue;
            };
            let (view, _) = take_in(camera, &rig.cameras()[camera], &members.wanted, image);
            let bodies = (0..members.n_bodies).map(Some).chain([None]);
            for body in bodies {
                let own = view.tags.iter();
                let own = own.filter(|seen| members.body_of[seen.tag] == body);
                let tags: Vec<_> = own.cloned().collect();
                if !tags.is_empty() {
                    found.body_of.push(body);
                    found.views.push(ImageView {
                        tags,
                        ..view.clone()
                    });
                }
            }
        }
        found
    }
}

impl BodyViews {
    /// Indices of the views of a body.
    pub fn of_body(&self, body: Option<usize>) -> impl Iterator<Item = usize> {
        let bodies = self.body_of.iter().enumerate();
        bodies
            .filter(move |(_, of)| **of == body)
            .map(|(view, _)| view)
    }
}
