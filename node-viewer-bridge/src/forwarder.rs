//! Payloads of the site's keys into the hub. Runs on the network's threads: decodes, writes JSON, never waits.

use crate::bridge::Shared;
use crate::hub::{Frame, Slot};
use crate::inventory::Inventory;
use crate::link_frames::Part;
use crate::message::{Message, Models};
use crate::metrics::Moment;
use crate::rejections::Rejection;
use crate::wizard::Offer;
use crate::{link_frames, translate};
use sextant_process::{fail_point, now_ns};
use sextant_proto::{ANNOUNCED, DecodeError, EpochFilter, KeyRef, Keys, NodeKind};
use sextant_proto::{
    CameraStatus, ClockReport, ConfigAnswer, DetectionReport, FusionStatus, NodeId, ObjectConfig,
    ObjectLinks, ObjectPose, ObjectTruth, Observations, Preview, Proposal, RigConfig, decode,
};
use sextant_site_model::{ImageObservation, ObjectId, ObjectModel, Rig};
use sextant_zenoh_bus::{Item, Payload, Presence};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Decodes messages and forwards them to the hub and the wizards; counts those that it cannot show.
pub(crate) struct Forwarder {
    keys: Keys,
    shared: Arc<Shared>,
    inventory: Mutex<Inventory>,
    /// Of poses and links, which have the same epochs.
    epochs: Mutex<EpochFilter>,
}

impl Forwarder {
    pub(crate) fn new(keys: Keys, shared: Arc<Shared>) -> Self {
        Self {
            keys,
            shared,
            inventory: Mutex::default(),
            epochs: Mutex::default(),
        }
    }

    /// A message of the network. Keys below the site that mean nothing to us belong to others and are passed over.
    pub(crate) fn take(&self, item: &Item) {
        fail_point!("intake");
        let Some(key) = self.keys.parse(&item.key) else {
            return;
        };
        self.shared.last_seconds.take(&key, item, now_ns());
        if let Err(why) = self.try_take(&key, item) {
            tracing::debug!(key = item.key, ?why, "payload not shown");
            self.shared.count(&why);
        }
    }

    /// Takes a change of liveliness; returns the kind of a node that appeared.
    pub(crate) fn presence(&self, presence: &Presence) -> Option<NodeKind> {
        let (key, up) = match presence {
            Presence::Joined(key) => (key, true),
            Presence::Left(key) => (key, false),
        };
        let KeyRef::Alive(kind, id) = self.keys.parse(key)? else {
            return None;
        };
        let message = Message::Alive {
            kind: kind.as_str(),
            id: &id,
            up,
        };
        if kind == NodeKind::Fusion {
            if !up {
                self.forget_offers(&id);
            }
            self.shared.wizard.fusion_node(&id, up);
        }
        self.shared.metrics.presence(kind, &id, up, moment());
        let slot = Slot::Alive(kind.as_str().to_owned(), id.to_string());
        let (hub, frame) = (&self.shared.hub, frame_of(&message));
        // A flood of tokens is bounded like everything else, and there is no payload to blame.
        let _ = match up {
            true => hub.publish_lasting(&slot, frame),
            false => hub.publish(&slot, frame),
        };
        up.then_some(kind)
    }

    fn try_take(&self, key: &KeyRef, item: &Item) -> Result<(), Rejection> {
        let bytes = match &item.payload {
            Payload::Bytes(bytes) => bytes,
            Payload::TooLong(length) => {
                return Err(Rejection::Undecodable(DecodeError::TooLong(*length)));
            }
        };
        match key {
            KeyRef::Observations(camera) => {
                let message: Observations = read(bytes, camera, |m: &Observations| &m.camera)?;
                self.offer(&message);
                self.shared.metrics.observations(&message, moment());
                let slot = Slot::Observations(camera.to_string());
                self.show(slot, &translate::observations(&message))
            }
            KeyRef::Preview(camera) => {
                let message: Preview = read(bytes, camera, |m: &Preview| &m.camera)?;
                let frame = Frame::Binary(translate::preview(&message).into());
                self.publish(Slot::Preview(camera.to_string()), frame)
            }
            KeyRef::CameraStatus(camera) => {
                let message: CameraStatus = read(bytes, camera, |m: &CameraStatus| &m.camera)?;
                self.shared.metrics.camera_status(&message, moment());
                let slot = Slot::CameraStatus(camera.to_string());
                self.show(slot, &Message::CameraStatus(&message))
            }
            KeyRef::DetectionReport(camera) => {
                let message = read(bytes, camera, |m: &DetectionReport| &m.camera)?;
                let slot = Slot::DetectionReport(camera.to_string());
                self.show(slot, &Message::DetectionReport(&message))
            }
            KeyRef::Pose(object) => {
                let message: ObjectPose = read(bytes, object, |m: &ObjectPose| &m.object)?;
                if !self.is_current(object, message.epoch) {
                    return Ok(());
                }
                self.shared.metrics.pose(&message, moment());
                self.shared.zones.take_pose(&message, &self.shared.hub);
                self.show(Slot::Pose(object.to_string()), &translate::pose(&message))
            }
            KeyRef::Truth(object) => {
                let message: ObjectTruth = read(bytes, object, |m: &ObjectTruth| &m.object)?;
                self.show(Slot::Truth(object.to_string()), &translate::truth(&message))
            }
            KeyRef::FusionStatus(node) => {
                self.take_status(&read(bytes, node, |m: &FusionStatus| &m.node)?)
            }
            KeyRef::Clocks(node) => {
                let message: ClockReport = read(bytes, node, |m: &ClockReport| &m.node)?;
                self.shared.metrics.clocks(&message, moment());
                self.show(Slot::Clocks(node.to_string()), &Message::Clocks(&message))
            }
            KeyRef::ConfigRig => {
                let message: RigConfig = decode(bytes).map_err(Rejection::Undecodable)?;
                self.shared.metrics.rig(&message);
                if let Ok(rig) = Rig::try_from(&message) {
                    self.shared.wizard.take_rig(rig);
                }
                self.show(Slot::Rig, &translate::rig(&message))
            }
            KeyRef::ConfigObject(object) => {
                let message: ObjectConfig = read(bytes, object, |m: &ObjectConfig| &m.id)?;
                self.shared.metrics.object(&message);
                self.take_object(&message, item.sender.as_deref().unwrap_or_default())
            }
            KeyRef::Links(object) => {
                let message: ObjectLinks = read(bytes, object, |m: &ObjectLinks| &m.object)?;
                match self.is_current(object, message.epoch) {
                    true => self.show_links(&message),
                    false => Ok(()),
                }
            }
            // The camera's status says what became of them.
            KeyRef::ConfigCamera(_) => Ok(()),
            // Liveliness has its own way in; a payload there is somebody's mistake, without effect.
            KeyRef::Alive(..) => Ok(()),
            KeyRef::ConfigAnswer(node) => {
                let answer = read(bytes, node, |m: &ConfigAnswer| &m.node)?;
                self.shared.wizard.take_answer(&answer);
                Ok(())
            }
            KeyRef::Proposal(node) => {
                let proposal = read(bytes, node, |m: &Proposal| &m.node)?;
                self.take_offer(Offer::Refinement, proposal)
            }
            KeyRef::Former(node) => {
                let proposal = read(bytes, node, |m: &Proposal| &m.node)?;
                self.take_offer(Offer::Former, proposal)
            }
            // The page reverts by the proposal under `former`.
            KeyRef::FormerRig(_) | KeyRef::FormerObject(..) => Ok(()),
            // For recordings.
            KeyRef::Inputs(_) => Ok(()),
            // Among fusion nodes.
            KeyRef::Heartbeat(_) => Ok(()),
        }
    }

    /// What a fusion node offers to be put in force.
    fn take_offer(&self, offer: Offer, proposal: Proposal) -> Result<(), Rejection> {
        let objects = proposal.object_configs().map_err(Rejection::Undecodable)?;
        let models = Models {
            node: &proposal.node,
            t_ns: proposal.t_ns,
            rig: proposal.rig.is_some(),
            objects: objects.into_iter().map(|object| object.id).collect(),
            n_images: proposal.n_images,
            before_px: proposal.before_px,
            after_px: proposal.after_px,
        };
        let node = proposal.node.to_string();
        match offer {
            Offer::Refinement => self.show(Slot::Proposal(node), &Message::Proposal(models)),
            Offer::Former => self.show(Slot::Former(node), &Message::Former(models)),
        }?;
        self.shared.wizard.take_offer(offer, proposal);
        Ok(())
    }

    /// A node that is gone offers nothing.
    fn forget_offers(&self, node: &NodeId) {
        for offer in [Offer::Refinement, Offer::Former] {
            // There was room for it, or it was never shown.
            let _ = self.take_offer(offer, Proposal::none(node.clone(), 0));
        }
    }

    /// Objects that a fusion node has no more leave the page.
    fn take_status(&self, status: &FusionStatus) -> Result<(), Rejection> {
        self.shared.metrics.fusion_status(status, moment());
        let slot = Slot::FusionStatus(status.node.to_string());
        self.show(slot, &Message::FusionStatus(status))?;
        let objects = status.objects.iter().map(|object| object.object.as_str());
        let objects: BTreeSet<&str> = objects.collect();
        self.shared.hub.confirm_objects(&objects);
        self.shared.wizard.confirm_objects(&objects);
        let gone = self.inventory().take(Instant::now(), status);
        gone.iter().for_each(|object| self.forget(object));
        Ok(())
    }

    /// Whether a pose is of the fusion node that publishes now; late messages of a former one are dropped.
    fn is_current(&self, object: &ObjectId, epoch: u64) -> bool {
        let mut epochs = self.epochs.lock().unwrap_or_else(PoisonError::into_inner);
        epochs.admits(object, epoch, now_ns())
    }

    fn inventory(&self) -> MutexGuard<'_, Inventory> {
        self.inventory
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// A removal counts when a fusion node announces it. Where somebody else asks for one, the fusion nodes' statuses show whether the
    /// object is gone.
    fn take_object(&self, object: &ObjectConfig, sender: &str) -> Result<(), Rejection> {
        if object.is_removal() {
            if sender.starts_with(ANNOUNCED) {
                self.forget(&object.id);
            }
            return Ok(());
        }
        if let Ok(model) = ObjectModel::try_from(object) {
            self.shared.wizard.take_object(model);
        }
        if object.links.is_empty() {
            let slot = Slot::Object(object.id.to_string());
            return self.show(slot, &translate::object(object));
        }
        let parts = link_frames::parts(object);
        parts.into_iter().try_for_each(|part| self.show_part(part))
    }

    fn show_part(&self, part: Part) -> Result<(), Rejection> {
        let message = Message::Object {
            id: &part.id,
            tags: part.tags,
        };
        let slot = Slot::Object(part.id.clone());
        self.show(slot, &message)
    }

    fn show_links(&self, links: &ObjectLinks) -> Result<(), Rejection> {
        let joints = Message::Joints {
            object: &links.object,
            t_ns: links.capture_ns,
            joints: links.joints.iter().map(link_frames::joint).collect(),
        };
        self.show(Slot::Joints(links.object.to_string()), &joints)?;
        links.links.iter().try_for_each(|link| {
            let id = link_frames::id_of(links, link);
            let pose = Message::Pose(link_frames::pose(&id, links, link));
            self.show(Slot::Pose(id.clone()), &pose)
        })
    }

    /// The object and its links.
    fn forget(&self, object: &ObjectId) {
        self.shared.wizard.forget_object(object);
        self.shared.zones.forget_object(object, &self.shared.hub);
        for id in self.shared.hub.parts_of(object.as_str()) {
            let farewell = frame_of(&Message::ObjectGone { id: &id });
            self.shared.hub.forget_object(&id, &farewell);
        }
    }

    /// To the wizard that may be at work.
    fn offer(&self, message: &Observations) {
        let resolution = message.resolution.map(u32::from);
        let service = &self.shared.wizard;
        service.take_resolution(&message.camera, resolution);
        service.offer(|| with_real_tags(ImageObservation::from(message)));
    }

    fn show(&self, slot: Slot, message: &Message<'_>) -> Result<(), Rejection> {
        self.publish(slot, frame_of(message))
    }

    fn publish(&self, slot: Slot, frame: Frame) -> Result<(), Rejection> {
        self.shared
            .hub
            .publish(&slot, frame)
            .map_err(|_| Rejection::TooMany)
    }
}

/// The image without tags that their families don't have: procedures keep account of every tag that they see.
fn with_real_tags(mut image: ImageObservation) -> ImageObservation {
    image
        .tags
        .retain(|seen| (seen.tag.id as usize) < seen.tag.family.data().codes.len());
    image
}

/// Now.
fn moment() -> Moment {
    Moment {
        at: Instant::now(),
        ns: now_ns(),
    }
}

/// A message as a text frame.
pub(crate) fn frame_of(message: &Message<'_>) -> Frame {
    // Plain data with string keys: writing it into memory cannot fail.
    Frame::Text(serde_json::to_string(message).unwrap_or_default().into())
}

/// Decodes a message that must name the id of its key.
fn read<M: sextant_proto::Message, Id: PartialEq>(
    bytes: &[u8],
    expected: &Id,
    id_of: impl Fn(&M) -> &Id,
) -> Result<M, Rejection> {
    let message: M = decode(bytes).map_err(Rejection::Undecodable)?;
    if id_of(&message) == expected {
        Ok(message)
    } else {
        Err(Rejection::WrongId)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ObjectTagConfig, encode};

    fn truth() -> ObjectTruth {
        ObjectTruth {
            object: ObjectId::new("cube").unwrap(),
            capture_ns: 1,
            position: [0.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            position_error_m: 0.001,
            attitude_error_rad: 0.0,
        }
    }

    /// Texts for clients besides the bridge's own, and counts of rejections, after these payloads under keys of site `demo`.
    fn after(payloads: &[(&str, Payload)]) -> (Vec<String>, serde_json::Value) {
        let shared = Arc::new(Shared::for_tests());
        let forwarder = Forwarder::new(Keys::new("demo").unwrap(), Arc::clone(&shared));
        let own = shared.hub.newest_texts();
        for (key, payload) in payloads {
            forwarder.take(&Item {
                key: format!("sextant/v1/demo/{key}"),
                payload: payload.clone(),
                sender: None,
            });
        }
        let texts = shared.hub.newest_texts();
        let others = texts.iter().filter(|text| !own.contains(text));
        let texts = others.map(ToString::to_string).collect();
        let counted = serde_json::to_value(shared.rejections()).unwrap();
        (texts, counted)
    }

    #[test]
    fn a_message_reaches_the_clients_as_json() {
        let payload = Payload::Bytes(encode(&truth()).unwrap());
        let (texts, _) = after(&[("object/cube/truth", payload)]);
        let json: serde_json::Value = serde_json::from_str(&texts[0]).unwrap();
        assert_eq!(
            (&json["type"], &json["error_mm"]),
            (&"truth".into(), &1.0.into())
        );
    }

    #[test]
    fn an_object_is_gone_when_its_fusion_node_lacks_it() {
        let status = |objects: &[&str]| {
            let status = crate::inventory::samples::status("f", objects);
            Payload::Bytes(encode(&status).unwrap())
        };
        let key = "fusion/f/status";
        let truth = (
            "object/cube/truth",
            Payload::Bytes(encode(&truth()).unwrap()),
        );
        assert_eq!(after(&[(key, status(&["cube"])), truth.clone()]).0.len(), 2);
        let (texts, _) = after(&[(key, status(&["cube"])), truth, (key, status(&[]))]);
        assert_eq!(texts.len(), 1);
        assert!(texts[0].contains("fusion_status"));
    }

    #[test]
    fn an_object_that_its_fusion_node_denies_is_gone() {
        let shared = Arc::new(Shared::for_tests());
        let forwarder = Forwarder::new(Keys::new("demo").unwrap(), Arc::clone(&shared));
        let cube = ObjectConfig::from(&crate::wizard::samples::cube());
        let n_own = shared.hub.newest_texts().len();
        let heard_after = |tags: &[ObjectTagConfig], sender: Option<&str>| {
            let config = ObjectConfig {
                tags: tags.to_vec(),
                ..cube.clone()
            };
            forwarder.take(&Item {
                key: "sextant/v1/demo/config/object/cube".to_owned(),
                payload: Payload::Bytes(encode(&config).unwrap()),
                sender: sender.map(str::to_owned),
            });
            shared.hub.newest_texts().len() - n_own
        };
        assert_eq!(heard_after(&cube.tags, None), 1);
        assert_eq!(heard_after(&[], Some("somebody")), 1);
        assert_eq!(heard_after(&[], Some("fusion/main")), 0);
    }

    #[test]
    fn what_cannot_be_shown_is_counted_by_cause() {
        let mut foreign = encode(&truth()).unwrap();
        foreign[1] = 9;
        let (texts, counted) = after(&[
            ("object/cube/truth", Payload::Bytes(b"garbage".to_vec())),
            ("object/cube/truth", Payload::Bytes(foreign)),
            ("object/cube/truth", Payload::TooLong(1 << 20)),
            (
                "object/ball/truth",
                Payload::Bytes(encode(&truth()).unwrap()),
            ),
            (
                "object/cube/pose",
                Payload::Bytes(encode(&truth()).unwrap()),
            ),
        ]);
        assert!(texts.is_empty());
        for cause in [
            "bad_magic",
            "foreign_version",
            "too_long",
            "wrong_id",
            "wrong_kind",
        ] {
            assert_eq!(counted[cause], 1, "{cause}: {counted}");
        }
    }

    #[test]
    fn keys_of_others_are_passed_over() {
        let (texts, counted) = after(&[("somebody/elses", Payload::Bytes(b"x".to_vec()))]);
        assert!(texts.is_empty());
        assert!(
            counted
                .as_object()
                .unwrap()
                .values()
                .all(|count| count == 0)
        );
    }
}
