//! Topics: their messages, and the quality of service that each is published with.

use crate::description::{RosMessage, type_hash};
use crate::messages::{
    AprilTagDetectionArray, CameraInfo, CompressedImage, DiagnosticArray, NamedPoseArray, Odometry,
    PoseWithCovarianceStamped, RigidBodies, TFMessage,
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
        match self {
            Self::Transforms | Self::StaticTransforms => TFMessage::TYPE_NAME,
            Self::Pose => PoseWithCovarianceStamped::TYPE_NAME,
            Self::Odometry => Odometry::TYPE_NAME,
            Self::NamedPoses => NamedPoseArray::TYPE_NAME,
            Self::RigidBodies => RigidBodies::TYPE_NAME,
            Self::Detections => AprilTagDetectionArray::TYPE_NAME,
            Self::CameraInfo | Self::PictureInfo => CameraInfo::TYPE_NAME,
            Self::Picture => CompressedImage::TYPE_NAME,
            Self::Diagnostics => DiagnosticArray::TYPE_NAME,
        }
    }

    /// The hash of that type.
    #[must_use]
    pub fn type_hash(self) -> String {
        match self {
            Self::Transforms | Self::StaticTransforms => type_hash::<TFMessage>(),
            Self::Pose => type_hash::<PoseWithCovarianceStamped>(),
            Self::Odometry => type_hash::<Odometry>(),
            Self::NamedPoses => type_hash::<NamedPoseArray>(),
            Self::RigidBodies => type_hash::<RigidBodies>(),
            Self::Detections => type_hash::<AprilTagDetectionArray>(),
            Self::CameraInfo | Self::PictureInfo => type_hash::<CameraInfo>(),
            Self::Picture => type_hash::<CompressedImage>(),
            Self::Diagnostics => type_hash::<DiagnosticArray>(),
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
            | Self::Odometry
            | Self::NamedPoses
            | Self::RigidBodies
            | Self::Detections
            | Self::Diagnostics => reliable(10),
            Self::Picture | Self::PictureInfo => Qos {
                reliability: Reliability::BestEffort,
                ..reliable(5)
            },
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
    /// `<reliability>:<durability>:<history>,<depth>:<deadline>:<lifespan>:<liveliness>`, a default left empty: reliable, volatile,
    /// the last 42 messages, everything else without limit.
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
