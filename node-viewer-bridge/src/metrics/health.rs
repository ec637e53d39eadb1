//! Whether the site works: a fusion node that reports, every camera of the rig with new images, and a pose of every object whose tags are
//! visible.

use super::Figures;
use serde::Serialize;
use sextant_proto::{NodeId, NodeKind};
use sextant_site_model::CameraId;
use std::time::{Duration, Instant};

/// What is silent for longer is lost.
pub(crate) const SILENCE: Duration = Duration::from_secs(5);

/// Something that keeps the site from working.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct Ailment {
    /// What it is about, such as `camera north`.
    pub(crate) about: String,
    pub(crate) cause: String,
    pub(crate) remedy: &'static str,
}

impl Ailment {
    fn new(about: String, cause: String, remedy: &'static str) -> Self {
        Self {
            about,
            cause,
            remedy,
        }
    }

    /// The bridge itself hears nothing.
    pub(crate) fn no_network() -> Self {
        let cause = "the bridge is not connected to the site's router".to_owned();
        let remedy =
            "start the fusion node that is the router, or correct `connect` in viewer.toml";
        Self::new("network".to_owned(), cause, remedy)
    }
}

impl Figures {
    pub(super) fn ailments(&self, now: Instant) -> Vec<Ailment> {
        let fusion = self.fusion_ailments(now);
        let cameras = self.camera_ailments(now);
        // Without a fusion node there are no poses, and no other cause is needed.
        let poses = match fusion.is_empty() {
            true => self.pose_ailments(now),
            false => Vec::new(),
        };
        [fusion, cameras, poses].concat()
    }

    fn fusion_ailments(&self, now: Instant) -> Vec<Ailment> {
        let mut living = self.living(NodeKind::Fusion).peekable();
        if living.peek().is_none() {
            return vec![Ailment::new(
                "fusion".to_owned(),
                "no fusion node is running".to_owned(),
                "start `sextant fusion`, and look at its log if it ends",
            )];
        }
        let is_silent = |(node, since): &(&NodeId, Instant)| {
            let status = self.fusion.get(node).and_then(|node| node.status.as_ref());
            let heard = status.map_or(*since, |(_, heard)| *heard);
            now.saturating_duration_since(heard) > SILENCE
        };
        let silent = living.filter(is_silent).map(|(node, _)| {
            Ailment::new(
                format!("fusion {node}"),
                "it has sent no status for more than 5 s".to_owned(),
                "look at its log and at the load of its machine",
            )
        });
        silent.collect()
    }

    fn camera_ailments(&self, now: Instant) -> Vec<Ailment> {
        let state = |camera: &CameraId| self.camera_ailment(camera, now);
        self.rig.iter().filter_map(state).collect()
    }

    fn camera_ailment(&self, camera: &CameraId, now: Instant) -> Option<Ailment> {
        let about = format!("camera {camera}");
        let node = NodeId::new(camera.as_str()).ok()?;
        let Some(since) = self.alive.get(&(NodeKind::Camera, node)) else {
            return Some(Ailment::new(
                about,
                "it is in the rig, but its node is not running".to_owned(),
                "check its power and network, start its node, or take it out of the rig",
            ));
        };
        let record = self.cameras.get(camera);
        let last = record.and_then(|record| record.last_image);
        let last = last.unwrap_or(*since);
        (now.saturating_duration_since(last) > SILENCE).then(|| {
            Ailment::new(
                about,
                "its node runs, but sends no images".to_owned(),
                "look at its log: the device may be unplugged or held by another program",
            )
        })
    }

    fn pose_ailments(&self, now: Instant) -> Vec<Ailment> {
        let age = |at: Instant| now.saturating_duration_since(at);
        let ailing = self.objects.iter().filter(|(_, object)| {
            let is_visible = object
                .seen
                .is_some_and(|(first, last)| age(first) > SILENCE && age(last) <= SILENCE);
            let has_pose = object
                .pose
                .as_ref()
                .is_some_and(|(_, at)| age(*at) <= SILENCE);
            is_visible && !has_pose
        });
        let ailing = ailing.map(|(object, _)| {
            Ailment::new(
                format!("object {object}"),
                "its tags are visible, but it has no pose".to_owned(),
                "`sextant top` shows the faults of the site; check tag ids, tag sizes and camera poses",
            )
        });
        ailing.collect()
    }

    pub(super) fn living(&self, kind: NodeKind) -> impl Iterator<Item = (&NodeId, Instant)> {
        let nodes = self.alive.iter();
        nodes.filter_map(move |((other, node), since)| (*other == kind).then_some((node, *since)))
    }
}
