//! The publishers on the router of ROS: each declared with its first message, with its liveliness token, numbered
//! messages and attachments.

use super::{OnTopic, Ros2Error};
use crate::report::Notice;
use sextant_ros2::{Attachment, Durability, Gid, Graph, Outgoing, Topic, TopicKind};
use sextant_zenoh_bus::{AliveToken, AttachedPublisher, Audience, Bus, BusError, Qos};
use std::collections::BTreeMap;

/// All publishers of the node.
pub(super) struct Publishers<'a> {
    ros: Bus,
    graph: Graph,
    on_topic: OnTopic<'a>,
    publishers: BTreeMap<Topic, TopicPublisher>,
    counts: Counts,
    is_router_gone: bool,
    _node: AliveToken,
}

/// Messages since the start.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    /// Handed to the network.
    pub(super) published: u64,
    /// Refused by it.
    pub(super) failed: u64,
}

struct TopicPublisher {
    publisher: AttachedPublisher,
    gid: Gid,
    sequence: i64,
    _token: AliveToken,
}

impl<'a> Publishers<'a> {
    /// The node appears in the graph of ROS.
    pub(super) fn new(ros: Bus, graph: Graph, on_topic: OnTopic<'a>) -> Result<Self, BusError> {
        let node = ros.alive(&graph.node_token())?;
        Ok(Self {
            ros,
            graph,
            on_topic,
            publishers: BTreeMap::new(),
            counts: Counts::default(),
            is_router_gone: false,
            _node: node,
        })
    }

    pub(super) fn counts(&self) -> Counts {
        self.counts
    }

    /// Publishes a message at `now_ns`.
    ///
    /// # Errors
    /// The publisher cannot be declared, or its topic not be announced.
    pub(super) fn put(&mut self, now_ns: u64, message: Outgoing) -> Result<(), Ros2Error> {
        if !self.publishers.contains_key(&message.topic) {
            self.declare(&message.topic)?;
        }
        let Some(topic) = self.publishers.get_mut(&message.topic) else {
            return Ok(());
        };
        topic.sequence += 1;
        let attachment = Attachment {
            sequence: topic.sequence,
            source_ns: i64::try_from(now_ns).unwrap_or(i64::MAX),
            gid: topic.gid,
        };
        match topic.publisher.put(message.payload, &attachment.to_bytes()) {
            Ok(()) => self.counts.published += 1,
            Err(_) => self.counts.failed += 1,
        }
        Ok(())
    }

    fn declare(&mut self, topic: &Topic) -> Result<(), Ros2Error> {
        let number = self.publishers.len() as u32 + 1;
        let endpoint = self.graph.publisher(number, topic);
        let audience = match topic.kind.qos().durability {
            Durability::Volatile => Audience::Present,
            Durability::TransientLocal => Audience::PresentAndLate,
        };
        let publisher = TopicPublisher {
            publisher: self
                .ros
                .attached_publisher(&endpoint.key, class(topic.kind), audience)?,
            gid: endpoint.gid,
            sequence: 0,
            _token: self.ros.alive(&endpoint.token)?,
        };
        self.publishers.insert(topic.clone(), publisher);
        (self.on_topic)(topic).map_err(Ros2Error::Announcement)
    }

    /// A notice when the router of ROS is gone, and when it is back.
    pub(super) fn router_notice(&mut self) -> Option<Notice> {
        let is_gone = !self.ros.is_connected();
        let was_gone = std::mem::replace(&mut self.is_router_gone, is_gone);
        match (was_gone, is_gone) {
            (false, true) => Some(Notice::RosRouterGone),
            (true, false) => Some(Notice::RosRouterBack),
            _ => None,
        }
    }

    /// Ends the session.
    pub(super) fn close(self) {
        let Self {
            ros, publishers, ..
        } = self;
        drop(publishers);
        ros.close();
    }
}

/// How each topic is treated when the network is slow.
fn class(kind: TopicKind) -> Qos {
    match kind {
        TopicKind::Transforms
        | TopicKind::Pose
        | TopicKind::Quality
        | TopicKind::Odometry
        | TopicKind::NamedPoses
        | TopicKind::RigidBodies
        | TopicKind::Detections => Qos::Pose,
        TopicKind::StaticTransforms | TopicKind::CameraInfo => Qos::Config,
        TopicKind::Image | TopicKind::Picture | TopicKind::PictureInfo => Qos::Preview,
        TopicKind::Diagnostics => Qos::Status,
    }
}
