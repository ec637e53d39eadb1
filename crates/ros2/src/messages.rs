//! The ROS messages that are published. A message is one list of fields, of which struct, CDR and type hash are made.

use crate::cdr::Writer;
pub use crate::description::Byte;
use crate::description::{Field, FieldType, RosMessage, TypeTable};

macro_rules! messages {
    ($($(#[$doc:meta])* $ros:literal $name:ident { $($field:ident: $type:ty,)* })*) => {$(
        $(#[$doc])*
        #[doc = concat!("\n\n`", $ros, "`")]
        #[derive(Debug, Clone, PartialEq)]
        #[allow(missing_docs, reason = "the fields are those of the ROS message")]
        pub struct $name {
            $(pub $field: $type,)*
        }

        impl RosMessage for $name {
            const TYPE_NAME: &'static str = $ros;
        }

        impl Field for $name {
            fn describe(types: &mut TypeTable) -> FieldType {
                types.nested($ros, |types| {
                    vec![$((stringify!($field), <$type>::describe(types))),*]
                })
            }

            fn write(&self, cdr: &mut Writer) {
                $(self.$field.write(cdr);)*
            }
        }
    )*};
}

messages! {
    /// Time since the Unix epoch.
    "builtin_interfaces/msg/Time" Time { sec: i32, nanosec: u32, }

    /// Time and coordinate frame.
    "std_msgs/msg/Header" Header { stamp: Time, frame_id: String, }

    /// Metres per axis.
    "geometry_msgs/msg/Vector3" Vector3 { x: f64, y: f64, z: f64, }

    /// A place, metres.
    "geometry_msgs/msg/Point" Point { x: f64, y: f64, z: f64, }

    /// A unit quaternion.
    "geometry_msgs/msg/Quaternion" Quaternion { x: f64, y: f64, z: f64, w: f64, }

    /// Place and attitude.
    "geometry_msgs/msg/Pose" Pose { position: Point, orientation: Quaternion, }

    /// With a 6x6 row-major covariance over x, y, z and the rotations about the fixed axes x, y, z.
    "geometry_msgs/msg/PoseWithCovariance" PoseWithCovariance { pose: Pose, covariance: [f64; 36], }

    /// The pose of an object.
    "geometry_msgs/msg/PoseWithCovarianceStamped" PoseWithCovarianceStamped {
        header: Header,
        pose: PoseWithCovariance,
    }

    /// What an axis of an array of numbers means.
    "std_msgs/msg/MultiArrayDimension" MultiArrayDimension { label: String, size: u32, stride: u32, }

    /// The axes of an array of numbers.
    "std_msgs/msg/MultiArrayLayout" MultiArrayLayout { dim: Vec<MultiArrayDimension>, data_offset: u32, }

    /// Numbers.
    "std_msgs/msg/Float64MultiArray" Float64MultiArray { layout: MultiArrayLayout, data: Vec<f64>, }

    /// Velocities, m/s and rad/s.
    "geometry_msgs/msg/Twist" Twist { linear: Vector3, angular: Vector3, }

    /// With a 6x6 row-major covariance.
    "geometry_msgs/msg/TwistWithCovariance" TwistWithCovariance { twist: Twist, covariance: [f64; 36], }

    /// Pose in `frame_id`, velocities in `child_frame_id`.
    "nav_msgs/msg/Odometry" Odometry {
        header: Header,
        child_frame_id: String,
        pose: PoseWithCovariance,
        twist: TwistWithCovariance,
    }

    /// A pose of Crazyswarm2.
    "motion_capture_tracking_interfaces/msg/NamedPose" NamedPose { name: String, pose: Pose, }

    /// What `motion_capture_tracking` publishes under `/poses`.
    "motion_capture_tracking_interfaces/msg/NamedPoseArray" NamedPoseArray { header: Header, poses: Vec<NamedPose>, }

    /// A marker of MOCAP4ROS2.
    "mocap4r2_msgs/msg/Marker" MocapMarker {
        id_type: i8,
        marker_index: i32,
        marker_name: String,
        translation: Point,
    }

    /// A rigid body of MOCAP4ROS2.
    "mocap4r2_msgs/msg/RigidBody" RigidBody { rigid_body_name: String, markers: Vec<MocapMarker>, pose: Pose, }

    /// What MOCAP4ROS2's drivers publish under `/rigid_bodies`.
    "mocap4r2_msgs/msg/RigidBodies" RigidBodies { header: Header, frame_number: u32, rigidbodies: Vec<RigidBody>, }

    /// A rigid motion.
    "geometry_msgs/msg/Transform" Transform { translation: Vector3, rotation: Quaternion, }

    /// `frame_id` from `child_frame_id`.
    "geometry_msgs/msg/TransformStamped" TransformStamped {
        header: Header,
        child_frame_id: String,
        transform: Transform,
    }

    /// Of `/tf` and `/tf_static`.
    "tf2_msgs/msg/TFMessage" TFMessage { transforms: Vec<TransformStamped>, }

    /// A part of an image; all zero for the whole.
    "sensor_msgs/msg/RegionOfInterest" RegionOfInterest {
        x_offset: u32,
        y_offset: u32,
        height: u32,
        width: u32,
        do_rectify: bool,
    }

    /// The lens of a camera.
    "sensor_msgs/msg/CameraInfo" CameraInfo {
        header: Header,
        height: u32,
        width: u32,
        distortion_model: String,
        d: Vec<f64>,
        k: [f64; 9],
        r: [f64; 9],
        p: [f64; 12],
        binning_x: u32,
        binning_y: u32,
        roi: RegionOfInterest,
    }

    /// An image as a file of the named format.
    "sensor_msgs/msg/CompressedImage" CompressedImage { header: Header, format: String, data: Vec<u8>, }

    /// A point of an image, pixels.
    "apriltag_msgs/msg/Point" PixelPoint { x: f64, y: f64, }

    /// A tag in an image, as of apriltag_msgs 2.0.
    "apriltag_msgs/msg/AprilTagDetection" AprilTagDetection {
        family: String,
        id: i32,
        hamming: i32,
        goodness: f32,
        decision_margin: f32,
        centre: PixelPoint,
        corners: [PixelPoint; 4],
        homography: [f64; 9],
    }

    /// The tags of an image.
    "apriltag_msgs/msg/AprilTagDetectionArray" AprilTagDetectionArray {
        header: Header,
        detections: Vec<AprilTagDetection>,
    }

    /// A named value.
    "diagnostic_msgs/msg/KeyValue" KeyValue { key: String, value: String, }

    /// The state of one part; level 0 is well, 1 a warning, 2 an error, 3 stale.
    "diagnostic_msgs/msg/DiagnosticStatus" DiagnosticStatus {
        level: Byte,
        name: String,
        message: String,
        hardware_id: String,
        values: Vec<KeyValue>,
    }

    /// Of `/diagnostics`.
    "diagnostic_msgs/msg/DiagnosticArray" DiagnosticArray { header: Header, status: Vec<DiagnosticStatus>, }
}

impl Time {
    /// Of nanoseconds since the Unix epoch; later than 2038 it stays at the last second that the message can carry.
    #[must_use]
    pub fn from_ns(ns: u64) -> Self {
        Self {
            sec: i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX),
            nanosec: (ns % 1_000_000_000) as u32,
        }
    }
}

impl Header {
    /// Of an instant, ns since the Unix epoch, in a frame.
    #[must_use]
    pub fn new(ns: u64, frame: &str) -> Self {
        Self {
            stamp: Time::from_ns(ns),
            frame_id: frame.to_owned(),
        }
    }
}
