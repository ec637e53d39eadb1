//! Topics: their messages, and the quality of service that each is published with.

use crate::description::{RosMessage, definition, type_hash};
use crate::messages::{
    AprilTagDetectionArray, CameraInfo, CompressedImage, DiagnosticArray, Float64MultiArray,
    NamedPoseArray, Odometry, PoseWithCovarianceStamped, RigidBodies, TFMessage,
};

/// A topic: its absolute name, and what it carries.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Topic {
    /// As in `/tf`.
    pub name: String,
    /// What it carries.
    pub kind: TopicKind,
}

/// What a topic carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TopicKind {
    /// `/tf`: objects and links in the world.
    Transforms,
    /// `/tf_static`: cameras in the world, tags on objects.
    StaticTransforms,
    /// The pose of an object with covariance.
    Pose,
    /// How good the pose of an object is.
    Quality,
    /// The pose and the velocities of an object.
    Odometry,
    /// `/poses`: objects by name, as Crazyswarm2 reads them.
    NamedPoses,
    /// `/rigid_bodies`: objects by name, as MOCAP4ROS2 has them.
    RigidBodies,
    /// The tags of a camera's images.
    Detections,
    /// The lens of a camera.
    CameraInfo,
    /// Whole images of a camera.
    Image,
    /// Pictures of a camera.
    Picture,
    /// The lens of a camera, scaled to its pictures.
    PictureInfo,
    /// `/diagnostics`.
    Diagnostics,
}

impl TopicKind {
    /// The message's type, as in `tf2_msgs/msg/TFMessage`.
    #[must_use]
    pub fn type_name(self) -> &'static str {
        self.message().name
    }

    /// The hash of that type.
    #[must_use]
    pub fn type_hash(self) -> String {
        (self.message().hash)()
    }

    /// The definition of that type: see [`definition`].
    #[must_use]
    pub fn definition(self) -> String {
        (self.message().definition)()
    }

    fn message(self) -> MessageType {
        match self {
            Self::Transforms | Self::StaticTransforms => MessageType::for_message::<TFMessage>(),
            Self::Pose => MessageType::for_message::<PoseWithCovarianceStamped>(),
            Self::Quality => MessageType::for_message::<Float64MultiArray>(),
            Self::Odometry => MessageType::for_message::<Odometry>(),
            Self::NamedPoses => MessageType::for_message::<NamedPoseArray>(),
            Self::RigidBodies => MessageType::for_message::<RigidBodies>(),
            Self::Detections => MessageType::for_message::<AprilTagDetectionArray>(),
            Self::CameraInfo | Self::PictureInfo => MessageType::for_message::<CameraInfo>(),
            Self::Image | Self::Picture => MessageType::for_message::<CompressedImage>(),
            Self::Diagnostics => MessageType::for_message::<DiagnosticArray>(),
        }
    }

    /// As ROS's own publishers of such topics announce it. On rmw_zenoh any publisher goes with any subscriber.
    #[must_use]
    pub fn qos(self) -> Qos {
        let reliable = |depth| Qos {
            reliability: Reliability::Reliable,
            durability: Durability::Volatile,
            depth,
        };
        match self {
            Self::Transforms => reliable(100),
            Self::StaticTransforms | Self::CameraInfo => Qos {
                durability: Durability::TransientLocal,
                ..reliable(1)
            },
            Self::Pose
            | Self::Quality
            | Self::Odometry
            | Self::NamedPoses
            | Self::RigidBodies
            | Self::Detections
            | Self::Diagnostics => reliable(10),
            Self::Image | Self::Picture | Self::PictureInfo => Qos {
                reliability: Reliability::BestEffort,
                ..reliable(5)
            },
        }
    }
}

/// A type of message.
struct MessageType {
    name: &'static str,
    hash: fn() -> String,
    definition: fn() -> String,
}

impl MessageType {
    fn for_message<M: RosMessage>() -> Self {
        Self {
            name: M::TYPE_NAME,
            hash: type_hash::<M>,
            definition: definition::<M>,
        }
    }
}

/// Quality of service: history is always the last `depth` messages, other policies are the defaults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    /// Whether messages may be lost.
    pub reliability: Reliability,
    /// Whether late subscribers get the last messages.
    pub durability: Durability,
    /// How many messages wait for a slow subscriber.
    pub depth: u32,
}

/// Whether messages may be lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reliability {
    /// They should not.
    Reliable,
    /// They may.
    BestEffort,
}

/// Whether late subscribers get the last messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Durability {
    /// They get new ones only.
    Volatile,
    /// They get the last `depth`.
    TransientLocal,
}

impl Qos {
    /// `<reliability>:<durability>:<history>,<depth>:<deadline>:<lifespan>:<liveliness>`, a default left empty:
    /// reliable, volatile, the last 42 messages, everything else without limit.
    pub(crate) fn token(self) -> String {
        let reliability = match self.reliability {
            Reliability::Reliable => "",
            Reliability::BestEffort => "2",
        };
        let durability = match self.durability {
            Durability::Volatile => "",
            Durability::TransientLocal => "1",
        };
        format!("{reliability}:{durability}:,{}:,:,:,,", self.depth)
    }
}
