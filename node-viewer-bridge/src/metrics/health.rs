//! Whether the site works: a fusion node that reports, every camera of the rig with new images, and a pose of every
//! object whose tags are visible.

use super::MetricsView;
use serde::Serialize;
use sextant_proto::{NodeId, NodeKind};
use sextant_site_mirror::limits::SILENCE_NS;
use sextant_site_mirror::{Liveliness, Object};
use sextant_site_model::CameraId;

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

impl MetricsView<'_> {
    pub(super) fn ailments(&self, now_ns: u64) -> Vec<Ailment> {
        let fusion = self.fusion_ailments(now_ns);
        let cameras = self.camera_ailments(now_ns);
        // Without a fusion node there are no poses, and no other cause is needed.
        let poses = match fusion.is_empty() {
            true => self.pose_ailments(now_ns),
            false => Vec::new(),
        };
        [fusion, cameras, poses].concat()
    }

    fn fusion_ailments(&self, now_ns: u64) -> Vec<Ailment> {
        let mut alive = self.site.alive(NodeKind::Fusion).peekable();
        if alive.peek().is_none() {
            return vec![Ailment::new(
                "fusion".to_owned(),
                "no fusion node is running".to_owned(),
                "start `sextant fusion`, and look at its log if it ends",
            )];
        }
        let is_silent = |id: &NodeId| {
            let node = self.site.node(NodeKind::Fusion, id);
            node.is_some_and(|node| node.is_silent(now_ns))
        };
        let silent = alive.filter(|(id, _)| is_silent(id)).map(|(node, _)| {
            let seconds = SILENCE_NS / 1_000_000_000;
            Ailment::new(
                format!("fusion {node}"),
                format!("it has sent no status for more than {seconds} s"),
                "look at its log and at the load of its machine",
            )
        });
        silent.collect()
    }

    fn camera_ailments(&self, now_ns: u64) -> Vec<Ailment> {
        let rig = self.site.rig().into_iter().flat_map(|rig| &rig.cameras);
        let ailments = rig.filter_map(|camera| self.camera_ailment(&camera.id, now_ns));
        ailments.collect()
    }

    fn camera_ailment(&self, camera: &CameraId, now_ns: u64) -> Option<Ailment> {
        let about = format!("camera {camera}");
        let id = NodeId::new(camera.as_str()).ok()?;
        let node = self.site.node(NodeKind::Camera, &id);
        let Some(Liveliness::Alive(since_ns)) = node.map(|node| node.liveliness) else {
            return Some(Ailment::new(
                about,
                "it is in the rig, but its node is not running".to_owned(),
                "check its power and network, start its node, or take it out of the rig",
            ));
        };
        let camera = self.site.camera(camera).cloned().unwrap_or_default();
        camera.lacks_images(since_ns, now_ns).then(|| {
            Ailment::new(
                about,
                "its node runs, but sends no images".to_owned(),
                "look at its log: the device may be unplugged or held by another program",
            )
        })
    }

    fn pose_ailments(&self, now_ns: u64) -> Vec<Ailment> {
        let is_recent = |at_ns: u64| now_ns.saturating_sub(at_ns) <= SILENCE_NS;
        let ailing = self.figures.objects.iter().filter(|(id, object)| {
            let is_visible = object
                .seen_ns
                .is_some_and(|(first_ns, last_ns)| !is_recent(first_ns) && is_recent(last_ns));
            let known = self.site.object(id);
            // Landmarks have poses only where some camera stands still.
            let lacks_pose = |known: &Object| {
                let config = known.config.as_ref();
                let is_landmark = config.is_some_and(|config| config.world_from_object.is_some());
                !is_landmark && known.recent_pose(now_ns).is_none()
            };
            is_visible && known.is_some_and(lacks_pose)
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
}
