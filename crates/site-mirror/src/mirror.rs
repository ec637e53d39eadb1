//! The state of a site, from its messages and tokens.

use crate::bounded_map::{BoundedMap, Full};
use crate::limits::{CAMERAS, FORGOTTEN_NS, FUSION_NODES, NODES, OBJECTS, SILENCE_NS};
use crate::reading::read;
use crate::records::{Camera, FusionNode, Heard, Liveliness, Node, Object};
use crate::rejection::{Rejection, Rejections};
use crate::tag_index::TagIndex;
use sextant_proto::{
    ANNOUNCED, AnyMessage, CameraClock, CameraConfig, CameraIntake, DecodeError, EpochFilter,
    FusionStatus, KeyRef, NodeId, NodeKind, ObjectConfig, ObjectHealth, RigConfig,
};
use sextant_site_model::{CameraId, ObjectId, ObjectModel, Rig, TagId};
use std::collections::{BTreeMap, BTreeSet};

/// A site as heard. Drop rule: beyond the [`limits`](crate::limits) a new id takes the place of the one that was silent
/// longest, if that is [`FORGOTTEN_NS`] or more, and is refused otherwise.
#[derive(Debug, Clone)]
pub struct SiteMirror {
    cameras: BoundedMap<CameraId, Camera>,
    objects: BoundedMap<ObjectId, Object>,
    fusion_nodes: BoundedMap<NodeId, FusionNode>,
    nodes: BoundedMap<(NodeKind, NodeId), Node>,
    rig: Option<RigConfig>,
    tags: TagIndex,
    /// Of poses and links, which have the same epochs.
    epochs: EpochFilter,
    rejections: Rejections,
    /// Objects that no fusion node lists and that were announced lately.
    unlisted: BTreeSet<ObjectId>,
}

/// What a payload brought.
#[derive(Debug, Clone, PartialEq)]
pub struct Update {
    /// The message: valid, under its own key, and of the fusion node that publishes now.
    pub message: AnyMessage,
    /// Objects that the site has no more.
    pub gone: Vec<ObjectId>,
}

impl Default for SiteMirror {
    fn default() -> Self {
        Self {
            cameras: BoundedMap::new(CAMERAS, FORGOTTEN_NS),
            objects: BoundedMap::new(OBJECTS, FORGOTTEN_NS),
            fusion_nodes: BoundedMap::new(FUSION_NODES, FORGOTTEN_NS),
            nodes: BoundedMap::new(NODES, FORGOTTEN_NS),
            rig: None,
            tags: TagIndex::default(),
            epochs: EpochFilter::default(),
            rejections: Rejections::default(),
            unlisted: BTreeSet::new(),
        }
    }
}

impl SiteMirror {
    /// Handles a payload that arrived at `now_ns` with its sender's signature; a payload too long to be copied is an
    /// error.
    ///
    /// # Errors
    /// A payload that is refused; it has been counted and changes nothing.
    pub fn handle(
        &mut self,
        now_ns: u64,
        key: &KeyRef,
        sender: Option<&str>,
        payload: Result<&[u8], DecodeError>,
    ) -> Result<Update, Rejection> {
        let update = self.update(now_ns, key, sender, payload);
        if let Err(why) = &update {
            self.rejections.count(why);
        }
        update
    }

    fn update(
        &mut self,
        now_ns: u64,
        key: &KeyRef,
        sender: Option<&str>,
        payload: Result<&[u8], DecodeError>,
    ) -> Result<Update, Rejection> {
        let message = read(key, payload)?;
        let mut gone = Vec::new();
        match (key, &message) {
            (KeyRef::Observations(id), AnyMessage::Observations(image)) => {
                let camera = self.cameras.entry(now_ns, id.clone())?;
                camera.handle_image(image, now_ns);
            }
            (KeyRef::CameraStatus(id), AnyMessage::CameraStatus(status)) => {
                let message = status.clone();
                let at_ns = now_ns;
                self.cameras.entry(now_ns, id.clone())?.status = Some(Heard { message, at_ns });
                self.node_is_heard(now_ns, NodeKind::Camera, id.as_str());
            }
            (KeyRef::ConfigCamera(id), AnyMessage::CameraSettings(settings)) => {
                let camera = self.cameras.entry(now_ns, id.clone())?;
                camera.settings = Some(settings.clone());
            }
            (KeyRef::Pose(id), AnyMessage::ObjectPose(pose)) => {
                self.check_epoch(now_ns, id, pose.epoch)?;
                let message = pose.as_ref().clone();
                let at_ns = now_ns;
                self.object_entry(now_ns, id)?.pose = Some(Heard { message, at_ns });
            }
            (KeyRef::Links(id), AnyMessage::ObjectLinks(links)) => {
                self.check_epoch(now_ns, id, links.epoch)?;
            }
            (KeyRef::FusionStatus(id), AnyMessage::FusionStatus(status)) => {
                gone = self.handle_status(now_ns, status)?;
                self.node_is_heard(now_ns, NodeKind::Fusion, id.as_str());
            }
            (KeyRef::Clocks(id), AnyMessage::ClockReport(report)) => {
                let node = self.fusion_nodes.entry(now_ns, id.clone())?;
                node.clocks = report.cameras.clone();
            }
            (KeyRef::ConfigRig, AnyMessage::RigConfig(rig)) => {
                Rig::try_from(rig).map_err(|cause| Rejection::InvalidModel(cause.to_string()))?;
                self.rig = Some(rig.clone());
            }
            (KeyRef::ConfigObject(_), AnyMessage::ObjectConfig(config)) => {
                gone = self.handle_object(now_ns, config, sender.unwrap_or_default())?;
            }
            // Passed on to those who use them.
            _ => {}
        }
        Ok(Update { message, gone })
    }

    /// A node's token appeared.
    ///
    /// # Errors
    /// There is no room for another node.
    pub fn handle_joined(&mut self, now_ns: u64, kind: NodeKind, id: &NodeId) -> Result<(), Full> {
        let node = Node {
            liveliness: Liveliness::Alive(now_ns),
            heard_ns: Some(now_ns),
        };
        let key = (kind, id.clone());
        self.nodes.insert_lasting(now_ns, key, node).map(drop)
    }

    /// A node's token is gone: its process has ended, or its link is broken.
    pub fn handle_left(&mut self, now_ns: u64, kind: NodeKind, id: &NodeId) {
        let key = (kind, id.clone());
        if let Some(before) = self.nodes.remove(&key) {
            let node = Node {
                liveliness: Liveliness::Gone,
                ..before
            };
            // It takes the room that it had.
            let _ = self.nodes.insert(now_ns, key, node);
        }
    }

    /// Forgets what nothing was heard of for [`FORGOTTEN_NS`]; returns the objects that are gone with it.
    pub fn expire(&mut self, now_ns: u64) -> Vec<ObjectId> {
        self.cameras.expire(now_ns);
        self.nodes.expire(now_ns);
        let former = self.fusion_nodes.expire(now_ns).into_iter();
        let former = former.flat_map(|(_, node)| node.objects);
        let former: BTreeSet<ObjectId> = former.chain(std::mem::take(&mut self.unlisted)).collect();
        let gone = self.without_owner(now_ns, former);
        for (_, object) in self.objects.expire(now_ns) {
            if let Some(config) = object.config {
                self.tags.remove(&config);
            }
        }
        gone
    }

    /// Counts a payload that was taken in and then had no effect for this cause.
    pub fn count(&mut self, why: &Rejection) {
        self.rejections.count(why);
    }

    /// Counts of refused payloads.
    #[must_use]
    pub fn rejections(&self) -> &Rejections {
        &self.rejections
    }

    /// What is known of a camera.
    #[must_use]
    pub fn camera(&self, id: &CameraId) -> Option<&Camera> {
        self.cameras.get(id)
    }

    /// The cameras that were heard of or that a fusion node lists, by name.
    pub fn cameras(&self) -> impl Iterator<Item = (&CameraId, &Camera)> {
        self.cameras.iter()
    }

    /// What is known of an object.
    #[must_use]
    pub fn object(&self, id: &ObjectId) -> Option<&Object> {
        self.objects.get(id)
    }

    /// The objects that were heard of, by name; also those that are gone, until they are forgotten.
    pub fn objects(&self) -> impl Iterator<Item = (&ObjectId, &Object)> {
        self.objects.iter()
    }

    /// What was announced of the objects that the site has.
    pub fn configs(&self) -> impl Iterator<Item = &ObjectConfig> {
        self.objects()
            .filter_map(|(_, object)| object.config.as_ref())
    }

    /// What a fusion node reports.
    #[must_use]
    pub fn fusion_node(&self, id: &NodeId) -> Option<&FusionNode> {
        self.fusion_nodes.get(id)
    }

    /// What the fusion nodes report, by name.
    pub fn fusion_nodes(&self) -> impl Iterator<Item = (&NodeId, &FusionNode)> {
        self.fusion_nodes.iter()
    }

    /// The newest status of each fusion node, by name.
    pub fn statuses(&self) -> impl Iterator<Item = &FusionStatus> {
        let statuses = self.fusion_nodes().map(|(_, node)| node.status.as_ref());
        statuses.flatten().map(|status| &status.message)
    }

    /// What is known of a process.
    #[must_use]
    pub fn node(&self, kind: NodeKind, id: &NodeId) -> Option<&Node> {
        self.nodes.get(&(kind, id.clone()))
    }

    /// The processes, by kind and name; also those that are gone, until they are forgotten.
    pub fn nodes(&self) -> impl Iterator<Item = (NodeKind, &NodeId, &Node)> {
        let nodes = self.nodes.iter();
        nodes.map(|((kind, id), node)| (*kind, id, node))
    }

    /// The nodes of a kind that have a token, and since when, ns.
    pub fn alive(&self, of_kind: NodeKind) -> impl Iterator<Item = (&NodeId, u64)> {
        self.nodes().filter_map(move |(kind, id, node)| {
            let Liveliness::Alive(since_ns) = node.liveliness else {
                return None;
            };
            (kind == of_kind).then_some((id, since_ns))
        })
    }

    /// The rig in force.
    #[must_use]
    pub fn rig(&self) -> Option<&RigConfig> {
        self.rig.as_ref()
    }

    /// A camera of the rig.
    #[must_use]
    pub fn camera_config(&self, id: &CameraId) -> Option<&CameraConfig> {
        self.rig()?.cameras.iter().find(|camera| camera.id == *id)
    }

    /// Width and height of a camera's images, pixels: of the newest one, else as in the rig.
    #[must_use]
    pub fn resolution(&self, camera: &CameraId) -> Option<[u32; 2]> {
        let newest = self.camera(camera).and_then(|known| known.resolution);
        newest.or_else(|| Some(self.camera_config(camera)?.resolution))
    }

    /// The model of an object that the site has.
    #[must_use]
    pub fn object_model(&self, id: &ObjectId) -> Option<ObjectModel> {
        let config = self.object(id)?.config.as_ref()?;
        // It was checked when it was taken in.
        ObjectModel::try_from(config).ok()
    }

    /// The object that has a tag and the edge of its black square, m. Of two objects that claim a tag the first by name
    /// has it.
    #[must_use]
    pub fn tag(&self, tag: TagId) -> Option<(&ObjectId, f64)> {
        self.tags.get(tag)
    }

    /// State and rate of each object by the fusion node that publishes it, as it reports the highest rate.
    #[must_use]
    pub fn healths(&self) -> BTreeMap<&ObjectId, &ObjectHealth> {
        let mut healths: Vec<&ObjectHealth> = self.by_rank().flat_map(|s| &s.objects).collect();
        healths.sort_by(|one, other| one.rate_hz.total_cmp(&other.rate_hz));
        healths.into_iter().map(|one| (&one.object, one)).collect()
    }

    /// How the images of each camera fare at the fusion node that publishes.
    #[must_use]
    pub fn intakes(&self) -> BTreeMap<&CameraId, &CameraIntake> {
        let intakes = self.by_rank().flat_map(|status| &status.cameras);
        intakes.map(|intake| (&intake.camera, intake)).collect()
    }

    /// The clock of each camera as the fusion node that publishes estimates it.
    #[must_use]
    pub fn clocks(&self) -> BTreeMap<&CameraId, &CameraClock> {
        let mut nodes: Vec<&FusionNode> = self.fusion_nodes().map(|(_, node)| node).collect();
        nodes.sort_by_key(|node| node.status.as_ref().map(|status| status.message.epoch));
        let clocks = nodes.into_iter().flat_map(|node| &node.clocks);
        clocks.map(|clock| (&clock.camera, clock)).collect()
    }

    /// Statuses from those who stand by to the newest publisher.
    fn by_rank(&self) -> impl Iterator<Item = &FusionStatus> {
        let mut statuses: Vec<&FusionStatus> = self.statuses().collect();
        statuses.sort_by_key(|status| status.epoch);
        statuses.into_iter()
    }

    fn check_epoch(&mut self, now_ns: u64, id: &ObjectId, epoch: u64) -> Result<(), Rejection> {
        match self.epochs.admits(id, epoch, now_ns) {
            true => Ok(()),
            false => Err(Rejection::Superseded),
        }
    }

    /// A status shows that its node works.
    fn node_is_heard(&mut self, now_ns: u64, kind: NodeKind, id: &str) {
        if let Ok(id) = NodeId::new(id)
            && let Ok(node) = self.nodes.entry(now_ns, (kind, id))
        {
            node.heard_ns = Some(now_ns);
        }
    }

    /// Keeps a status and what it lists; returns the objects that its node had and that no node has any more.
    fn handle_status(&mut self, now_ns: u64, status: &FusionStatus) -> Result<Vec<ObjectId>, Full> {
        let node = self.fusion_nodes.entry(now_ns, status.node.clone())?;
        let listed = status.objects.iter().map(|object| object.object.clone());
        let before = std::mem::replace(&mut node.objects, listed.collect());
        node.status = Some(Heard {
            message: status.clone(),
            at_ns: now_ns,
        });
        for intake in &status.cameras {
            if let Ok(camera) = self.cameras.entry(now_ns, intake.camera.clone()) {
                let newest_ns = Some(intake.last_capture_ns).filter(|at_ns| *at_ns > 0);
                camera.last_capture_ns = camera.last_capture_ns.max(newest_ns);
            }
        }
        for health in &status.objects {
            if let Ok(object) = self.object_entry(now_ns, &health.object) {
                object.gone_ns = None;
            }
        }
        let waiting = std::mem::take(&mut self.unlisted);
        Ok(self.without_owner(now_ns, before.into_iter().chain(waiting).collect()))
    }

    /// Those objects that no fusion node has; they are gone. One that was announced lately is looked at again with the
    /// next status: a node that does not list it may have sent its own before it had the object.
    fn without_owner(&mut self, now_ns: u64, objects: BTreeSet<ObjectId>) -> Vec<ObjectId> {
        let nodes = &self.fusion_nodes;
        let has_none = |id: &ObjectId| !nodes.iter().any(|(_, node)| node.objects.contains(id));
        let is_new = |id: &ObjectId| {
            let announced_ns = self.objects.get(id).and_then(|object| object.announced_ns);
            announced_ns.is_some_and(|at_ns| now_ns.saturating_sub(at_ns) < SILENCE_NS)
        };
        let without: Vec<ObjectId> = objects.into_iter().filter(has_none).collect();
        let (new, gone): (Vec<_>, Vec<_>) = without.into_iter().partition(is_new);
        self.unlisted.extend(new);
        gone.iter().for_each(|id| self.forget(now_ns, id));
        gone
    }

    /// A model of an object, or its removal, which counts when a fusion node announces it. Where somebody else asks for
    /// one, the statuses show whether the object is gone.
    fn handle_object(
        &mut self,
        now_ns: u64,
        config: &ObjectConfig,
        sender: &str,
    ) -> Result<Vec<ObjectId>, Rejection> {
        if config.is_removal() {
            let is_gone = sender.starts_with(ANNOUNCED);
            let gone: Vec<ObjectId> = is_gone.then(|| config.id.clone()).into_iter().collect();
            gone.iter().for_each(|id| self.forget(now_ns, id));
            return Ok(gone);
        }
        ObjectModel::try_from(config)
            .map_err(|cause| Rejection::InvalidModel(cause.to_string()))?;
        self.make_room(now_ns, &config.id)?;
        let before = self.objects.get(&config.id);
        let before = before.and_then(|object| object.config.as_ref());
        self.tags.replace(before, config)?;
        let object = self.objects.entry(now_ns, config.id.clone())?;
        object.config = Some(config.clone());
        object.announced_ns = Some(now_ns);
        object.gone_ns = None;
        Ok(Vec::new())
    }

    fn object_entry(&mut self, now_ns: u64, id: &ObjectId) -> Result<&mut Object, Full> {
        self.make_room(now_ns, id)?;
        self.objects.entry(now_ns, id.clone())
    }

    /// An object that gives way takes its tags along.
    fn make_room(&mut self, now_ns: u64, id: &ObjectId) -> Result<(), Full> {
        let evicted = self.objects.make_room(now_ns, id)?;
        if let Some(config) = evicted.and_then(|object| object.config) {
            self.tags.remove(&config);
        }
        Ok(())
    }

    fn forget(&mut self, now_ns: u64, id: &ObjectId) {
        if let Some(object) = self.objects.get_mut(id) {
            object.gone_ns = object.gone_ns.or(Some(now_ns));
            object.announced_ns = None;
            if let Some(config) = object.config.take() {
                self.tags.remove(&config);
            }
        }
    }
}

#[cfg(test)]
mod tests;
