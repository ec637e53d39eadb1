//! Messages of a site as ROS messages.
//!
//! Positions, attitudes and covariances are those of the site: metres, radians, 6x6 row-major over x, y, z and
//! rotations about the world's axes, which is what ROS's PoseWithCovariance asks for. Pixels count from the centre of
//! the first, as ROS's camera models do. Two things differ from what apriltag_ros publishes:
//!
//! - Tag frames have x right, y up and z out of the face towards the viewer; apriltag_ros's are turned by 180 degrees
//!   about x.
//! - Pixels of detections are 0.5 smaller than the AprilTag library's, which counts from the corner of the first pixel.

mod camera;
mod detections;
pub(crate) mod diagnostics;
mod frames;
mod pose;

pub use camera::{camera_info, image, picture, picture_info};
pub use detections::detections;
pub use diagnostics::{camera_status, fusion_status};
pub use frames::{link_frame, optical_frame, tag_frame};
pub use pose::{
    link_transform, named_pose, object_pose, object_transform, odometry, quality, rigid_body,
    static_transforms,
};
