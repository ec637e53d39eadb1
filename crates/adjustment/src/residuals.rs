//! The terms of the cost: corners, motion between instants, a robot's poses, priors.

pub mod corners;
pub mod hand_pose;
pub mod prior;
pub mod shutter;
pub mod tie;
