//! Names of the kept parameters.

/// A free parameter that remains when the instants are eliminated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum KeptParameter {
    /// A camera's position along a world axis, 0 to 2.
    CameraPosition {
        /// Index of the camera.
        camera: usize,
        /// 0, 1, 2: x, y, z of the world.
        axis: usize,
    },
    /// A camera's attitude about a world axis.
    CameraRotation {
        /// Index of the camera.
        camera: usize,
        /// 0, 1, 2: x, y, z of the world.
        axis: usize,
    },
    /// A lens parameter.
    Lens {
        /// Index of the camera.
        camera: usize,
        /// Index into `Lens::parameters`.
        parameter: usize,
    },
    /// A camera's clock offset.
    Clock {
        /// Index of the camera.
        camera: usize,
    },
    /// A camera's line delay.
    LineDelay {
        /// Index of the camera.
        camera: usize,
    },
    /// A tag's position along an axis of the object.
    TagPosition {
        /// Index of the tag.
        tag: usize,
        /// 0, 1, 2: x, y, z of the object.
        axis: usize,
    },
    /// A tag's attitude about an axis of the object.
    TagRotation {
        /// Index of the tag.
        tag: usize,
        /// 0, 1, 2: x, y, z of the object.
        axis: usize,
    },
    /// Logarithm of a tag's size: a relative change.
    TagSize {
        /// Index of the tag.
        tag: usize,
    },
    /// A common scale of tags, as its logarithm.
    Scale {
        /// Index of the scale.
        scale: usize,
    },
    /// A position of the robot.
    ArmPosition {
        /// Which of the robot's two poses.
        pose: ArmPose,
        /// 0, 1, 2: x, y, z of the outer frame.
        axis: usize,
    },
    /// An attitude of the robot.
    ArmRotation {
        /// Which of the robot's two poses.
        pose: ArmPose,
        /// 0, 1, 2: x, y, z of the outer frame.
        axis: usize,
    },
    /// The delay between images and the robot's poses.
    ArmDelay,
}

/// One of the two transforms of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ArmPose {
    /// [`Arm::base_from_site`](crate::Arm::base_from_site).
    Base,
    /// [`Arm::hand_from_carried`](crate::Arm::hand_from_carried).
    Hand,
}
