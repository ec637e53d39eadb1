//! The publishers on the router of ROS: each declared with its first message, with its liveliness token, numbered messages and attachments.

use crate::output::{Format, print_line};
use serde_json::json;
use sextant_ros2::{Attachment, Durability, Gid, Graph, Outgoing, Topic, TopicKind};
use sextant_zenoh_bus::{AliveToken, AttachedPublisher, Audience, Bus, Qos};
use std::collections::BTreeMap;

/// All publishers of the node.
pub(super) struct Publishers {
    ros: Bus,
    graph: Graph,
    format: Format,
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

impl Publishers {
    /// The node appears in the graph of ROS.
    pub(super) fn new(ros: Bus, graph: Graph, format: Format) -> anyhow::Result<Self> {
        let node = ros.alive(&graph.node_token())?;
        Ok(Self {
            ros,
            graph,
            format,
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
    /// The publisher cannot be declared, or nobody reads what this program prints.
    pub(super) fn put(&mut self, now_ns: u64, message: Outgoing) -> anyhow::Result<()> {
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

    fn declare(&mut self, topic: &Topic) -> anyhow::Result<()> {
        let number = u32::try_from(self.publishers.len() + 1)?;
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
        print_line(&match self.format {
            Format::Json => {
                json!({"event": "topic", "name": topic.name, "type": topic.kind.type_name()})
                    .to_string()
            }
            Format::Text => format!("{} ({})", topic.name, topic.kind.type_name()),
        })?;
        Ok(())
    }

    /// Says when the router of ROS is gone, and when it is back.
    pub(super) fn watch_router(&mut self) {
        let is_gone = !self.ros.is_connected();
        if is_gone != self.is_router_gone {
            self.is_router_gone = is_gone;
            eprintln!(
                "{}",
                if is_gone {
                    "the ROS router is gone; waiting for it"
                } else {
                    "the ROS router is back"
                }
            );
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
        TopicKind::Transforms | TopicKind::Pose | TopicKind::Detections => Qos::Pose,
        TopicKind::StaticTransforms | TopicKind::CameraInfo => Qos::Config,
        TopicKind::Picture | TopicKind::PictureInfo => Qos::Preview,
        TopicKind::Diagnostics => Qos::Status,
    }
}
