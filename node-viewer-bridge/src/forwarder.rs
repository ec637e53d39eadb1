//! Payloads of the site's keys into the mirror of the site and the hub. Runs on the network's threads: decodes, writes
//! JSON, never waits.

use crate::changes::Offer;
use crate::changes::edit::version_of;
use crate::frame::{Frame, frame_of};
use crate::hub::Slot;
use crate::link_frames::Part;
use crate::message::{Message, OfferedModels};
use crate::metrics::Moment;
use crate::shared::Shared;
use crate::{link_frames, translate};
use sextant_process::{fail_point, monotonic_ns, now_ns};
use sextant_proto::{AnyMessage, KeyRef, Keys, NodeKind};
use sextant_proto::{
    FusionStatus, NodeId, ObjectConfig, ObjectLinks, ObjectPose, Observations, Proposal,
};
use sextant_site_mirror::{Rejection, Renewal, Update};
use sextant_site_model::ImageObservation;
use sextant_zenoh_bus::{Item, Presence};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Hands messages to the mirror of the site, and what they bring to the hub and the wizards; counts those that it
/// cannot show.
pub(crate) struct Forwarder {
    keys: Keys,
    shared: Arc<Shared>,
    renewal: Mutex<Renewal<Item>>,
}

impl Forwarder {
    pub(crate) fn new(keys: Keys, shared: Arc<Shared>) -> Self {
        Self {
            keys,
            shared,
            renewal: Mutex::default(),
        }
    }

    /// When kept messages are asked for.
    pub(crate) fn renewal(&self) -> MutexGuard<'_, Renewal<Item>> {
        self.renewal.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A message that was published; models wait while kept ones are asked for.
    pub(crate) fn receive(&self, item: Item) {
        let is_model = self
            .keys
            .parse(&item.key)
            .is_some_and(|key| key.is_config());
        let item = match is_model {
            true => self.renewal().hold(item),
            false => Some(item),
        };
        if let Some(item) = item {
            self.take(&item);
        }
    }

    /// The kept messages that were asked for.
    pub(crate) fn answered(&self, items: &[Item]) {
        items.iter().for_each(|item| self.take(item));
        let next_held = || self.renewal().next_held();
        while let Some(item) = next_held() {
            self.take(&item);
        }
    }

    /// A message of the network. Keys below the site that mean nothing to us belong to others and are passed over.
    fn take(&self, item: &Item) {
        fail_point!("intake");
        let Some(key) = self.keys.parse(&item.key) else {
            return;
        };
        self.shared.last_seconds.take(&key, item, now_ns());
        if let Err(why) = self.try_take(&key, item) {
            tracing::debug!(key = item.key, ?why, "payload not shown");
        }
    }

    /// Takes a change of liveliness.
    pub(crate) fn presence(&self, presence: &Presence) {
        let (key, up) = match presence {
            Presence::Joined(key) => (key, true),
            Presence::Left(key) => (key, false),
        };
        let Some(KeyRef::Alive(kind, id)) = self.keys.parse(key) else {
            return;
        };
        if kind == NodeKind::Fusion && up {
            self.renewal().joined();
        }
        let message = Message::Alive {
            kind: kind.as_str(),
            id: &id,
            up,
        };
        if kind == NodeKind::Fusion && !up {
            self.forget_offers(&id);
        }
        let mut site = self.shared.mirror();
        match up {
            // A flood of tokens is bounded like everything else, and no payload is refused.
            true => drop(site.handle_joined(monotonic_ns(), kind, &id)),
            false => site.handle_left(monotonic_ns(), kind, &id),
        }
        drop(site);
        let slot = Slot::Alive(kind.as_str().to_owned(), id.to_string());
        let (hub, frame) = (&self.shared.hub, frame_of(&message));
        let _ = match up {
            true => hub.publish_lasting(&slot, frame),
            false => hub.publish(&slot, frame),
        };
    }

    fn try_take(&self, key: &KeyRef, item: &Item) -> Result<(), Rejection> {
        // Liveliness has its own way in; inputs are for recordings, heartbeats among fusion nodes.
        if matches!(
            key,
            KeyRef::Alive(..) | KeyRef::Inputs(_) | KeyRef::Heartbeat(_)
        ) {
            return Ok(());
        }
        let now = Moment {
            at_ns: monotonic_ns(),
            wall_ns: now_ns(),
        };
        let mut site = self.shared.mirror();
        let update = site.handle(now.at_ns, key, item.sender.as_deref(), item.try_bytes())?;
        self.shared.metrics.count(&update.message, &site, now);
        drop(site);
        let Update { message, gone } = update;
        let shown = self.show_message(key, message);
        if let Err(why) = &shown {
            self.shared.mirror().count(why);
        }
        gone.iter().for_each(|object| self.shared.forget(object));
        shown
    }

    fn show_message(&self, key: &KeyRef, message: AnyMessage) -> Result<(), Rejection> {
        match message {
            AnyMessage::Observations(message) => self.show_image(&message),
            AnyMessage::Preview(message) => {
                let frame = Frame::Binary(translate::preview(&message).into());
                self.publish(Slot::Preview(message.camera.to_string()), frame)
            }
            AnyMessage::CameraStatus(message) => {
                let slot = Slot::CameraStatus(message.camera.to_string());
                self.show(slot, &Message::CameraStatus(&message))
            }
            AnyMessage::DetectionReport(message) => {
                let slot = Slot::DetectionReport(message.camera.to_string());
                self.show(slot, &Message::DetectionReport(&message))
            }
            AnyMessage::ObjectPose(message) => self.show_pose(&message),
            AnyMessage::ObjectTruth(message) => {
                let slot = Slot::Truth(message.object.to_string());
                self.show(slot, &translate::truth(&message))
            }
            AnyMessage::ObjectLinks(message) => self.show_links(&message),
            AnyMessage::FusionStatus(message) => self.show_status(&message),
            AnyMessage::ClockReport(message) => {
                let slot = Slot::Clocks(message.node.to_string());
                self.show(slot, &Message::Clocks(&message))
            }
            AnyMessage::RigConfig(message) if *key == KeyRef::ConfigRig => {
                self.show(Slot::Rig, &translate::rig(&message))
            }
            AnyMessage::ObjectConfig(message) if matches!(key, KeyRef::ConfigObject(_)) => {
                self.show_object(&message)
            }
            AnyMessage::ConfigAnswer(answer) => {
                self.shared.wizard.put_answer(answer);
                Ok(())
            }
            AnyMessage::Proposal(proposal) => match key {
                KeyRef::Proposal(_) => self.take_offer(Offer::Refinement, proposal),
                _ => self.take_offer(Offer::Former, proposal),
            },
            // The page reverts by the proposal under `former`, and the camera's status says what became of its
            // settings.
            AnyMessage::RigConfig(_)
            | AnyMessage::ObjectConfig(_)
            | AnyMessage::CameraSettings(_)
            | AnyMessage::FusionInputs(_)
            | AnyMessage::Heartbeat(_) => Ok(()),
        }
    }

    /// What a fusion node offers to be put in force.
    fn take_offer(&self, offer: Offer, proposal: Proposal) -> Result<(), Rejection> {
        let objects = proposal.object_configs()?;
        let models = OfferedModels {
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
        self.shared.wizard.put_offer(offer, proposal);
        Ok(())
    }

    /// A node that is gone offers nothing.
    fn forget_offers(&self, node: &NodeId) {
        for offer in [Offer::Refinement, Offer::Former] {
            // There was room for it, or it was never shown.
            let _ = self.take_offer(offer, Proposal::none(node.clone(), 0));
        }
        self.shared.wizard.node_left(node.clone());
    }

    fn show_status(&self, status: &FusionStatus) -> Result<(), Rejection> {
        let slot = Slot::FusionStatus(status.node.to_string());
        self.show(slot, &Message::FusionStatus(status))?;
        let objects = status.objects.iter().map(|object| object.object.as_str());
        let objects: BTreeSet<&str> = objects.collect();
        self.shared.hub.confirm_objects(&objects);
        Ok(())
    }

    fn show_pose(&self, pose: &ObjectPose) -> Result<(), Rejection> {
        self.shared.zones.take_pose(pose, &self.shared.hub);
        self.show(Slot::Pose(pose.object.to_string()), &translate::pose(pose))
    }

    fn show_object(&self, object: &ObjectConfig) -> Result<(), Rejection> {
        if object.is_removal() {
            return Ok(());
        }
        if object.links.is_empty() {
            let slot = Slot::Object(object.id.to_string());
            return self.show(slot, &translate::object(object));
        }
        let version = version_of(object);
        let parts = link_frames::parts(object);
        let mut parts = parts.into_iter();
        parts.try_for_each(|part| self.show_part(part, version.clone()))
    }

    fn show_part(&self, part: Part, version: String) -> Result<(), Rejection> {
        let message = Message::Object {
            id: &part.id,
            tags: part.tags,
            world_from_object: None,
            version,
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

    /// To the clients, and to the wizard that may be at work.
    fn show_image(&self, message: &Observations) -> Result<(), Rejection> {
        let service = &self.shared.wizard;
        service.put_image(|| with_real_tags(ImageObservation::from(message)));
        let slot = Slot::Observations(message.camera.to_string());
        self.show(slot, &translate::observations(message))
    }

    fn show(&self, slot: Slot, message: &Message<'_>) -> Result<(), Rejection> {
        self.publish(slot, frame_of(message))
    }

    fn publish(&self, slot: Slot, frame: Frame) -> Result<(), Rejection> {
        Ok(self.shared.hub.publish(&slot, frame)?)
    }
}

/// The image without tags that their families don't have: procedures keep account of every tag that they see.
fn with_real_tags(mut image: ImageObservation) -> ImageObservation {
    image
        .tags
        .retain(|seen| (seen.tag.id as usize) < seen.tag.family.data().codes.len());
    image
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use sextant_proto::{ObjectHealth, ObjectTagConfig, ObjectTruth, Rejections, encode};
    use sextant_site_model::ObjectId;
    use sextant_site_report::State;
    use sextant_zenoh_bus::Payload;

    pub(crate) fn status(node: &str, objects: &[&str]) -> FusionStatus {
        let health = |id: &&str| ObjectHealth {
            object: ObjectId::new(id).unwrap(),
            state: State::Tracking,
            rate_hz: 30.0,
        };
        FusionStatus {
            node: NodeId::new(node).unwrap(),
            version: String::new(),
            uptime_s: 1,
            epoch: Some(1),
            cameras: vec![],
            foreign: Rejections::default(),
            objects: objects.iter().map(health).collect(),
            faults: vec![],
            faults_left_out: 0,
            imperfections: vec![],
            notices: vec![],
        }
    }

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

    /// Texts for clients besides the bridge's own, and counts of rejections, after these payloads under keys of site
    /// `demo`.
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
        let counted = serde_json::to_value(shared.mirror().rejections()).unwrap();
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
            let status = status("f", objects);
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
