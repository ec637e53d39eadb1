//! What an operator watches: counts, rates, latencies and states of the whole site, from the mirror of the site and
//! what is counted here; as metrics of Prometheus ([`text`]) and as a verdict on the site's health ([`health`]).

mod figures;
mod health;
mod histogram;
mod samples;
mod text;

pub(crate) use health::Ailment;
pub(crate) use samples::{BridgeFigures, CONTENT_TYPE};

use figures::{CameraFigures, ObjectFigures};
use sextant_proto::{AnyMessage, Observations};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{CameraId, ObjectId, TagId};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// When something happened, by both clocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// For periods on this machine: ns of the monotonic clock.
    pub(crate) at_ns: u64,
    /// For latencies: ns since the Unix epoch.
    pub(crate) wall_ns: u64,
}

/// The figures of the site.
#[derive(Debug, Default)]
pub(crate) struct Metrics {
    figures: Mutex<Figures>,
}

/// What is counted of cameras and objects. There are only those that the mirror keeps, or kept until
/// [`Metrics::keep_known`].
#[derive(Debug, Default)]
struct Figures {
    cameras: BTreeMap<CameraId, CameraFigures>,
    objects: BTreeMap<ObjectId, ObjectFigures>,
}

/// Everything that metrics are made of.
struct MetricsView<'a> {
    site: &'a SiteMirror,
    figures: &'a Figures,
}

impl Metrics {
    /// Counts a message that the mirror of the site has taken in.
    pub(crate) fn count(&self, message: &AnyMessage, site: &SiteMirror, now: Moment) {
        match message {
            AnyMessage::Observations(image) => self.lock().count_image(image, site, now),
            AnyMessage::ObjectPose(pose) => {
                let mut figures = self.lock();
                let object = figures.objects.entry(pose.object.clone()).or_default();
                object.count_pose(pose, now);
            }
            _ => {}
        }
    }

    /// Forgets what the site has no more.
    pub(crate) fn keep_known(&self, site: &SiteMirror) {
        let mut figures = self.lock();
        figures.cameras.retain(|id, _| site.camera(id).is_some());
        let is_there = |id: &ObjectId| site.object(id).is_some_and(|o| o.gone_ns.is_none());
        figures.objects.retain(|id, _| is_there(id));
    }

    /// What keeps the site from working; nothing if it works.
    pub(crate) fn ailments(&self, site: &SiteMirror, now_ns: u64) -> Vec<Ailment> {
        let figures = &self.lock();
        MetricsView { site, figures }.ailments(now_ns)
    }

    /// All metrics, in the text format of Prometheus.
    pub(crate) fn text(&self, site: &SiteMirror, bridge: &BridgeFigures, now_ns: u64) -> String {
        let figures = &self.lock();
        MetricsView { site, figures }.text(bridge, now_ns)
    }

    fn lock(&self) -> MutexGuard<'_, Figures> {
        // Nothing under the lock panics half way, so poisoned figures are whole ones.
        self.figures.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Figures {
    fn count_image(&mut self, image: &Observations, site: &SiteMirror, now: Moment) {
        let camera = self.cameras.entry(image.camera.clone()).or_default();
        camera.count_image(image, now);
        let objects = image.tags.iter().filter_map(|seen| {
            let (family, id) = (seen.family, seen.id);
            Some(site.tag(TagId { family, id })?.0)
        });
        for object in objects.collect::<BTreeSet<&ObjectId>>() {
            let object = self.objects.entry(object.clone()).or_default();
            object.is_seen(now.at_ns);
        }
    }
}

#[cfg(test)]
mod tests;
