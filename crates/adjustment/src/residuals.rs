//! Terms of the cost beside the motion between instants: corners, a robot's poses, priors.

pub mod corners;
pub mod hand_pose;
pub mod prior;
