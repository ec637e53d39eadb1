//! The names of axes on the command line.

use clap::ValueEnum;
use sextant_pose_streams::Axes;

/// Axes of poses in an output, by the values of `--axes`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AxesName {
    /// Right-handed, z up, as in Sextant and ROS.
    ZUp,
    /// Right-handed, y up, as in OpenGL.
    YUp,
    /// Left-handed, y up, z forward.
    Unity,
}

impl From<AxesName> for Axes {
    fn from(name: AxesName) -> Self {
        match name {
            AxesName::ZUp => Self::ZUp,
            AxesName::YUp => Self::YUp,
            AxesName::Unity => Self::Unity,
        }
    }
}
