//! The two processes of a camera node.

use clap::ValueEnum;

/// The two processes of a camera node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Part {
    /// From the camera into shared memory.
    Capture,
    /// From shared memory to the network.
    Detect,
}

impl Part {
    /// Its word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Capture => "capture",
            Self::Detect => "detect",
        }
    }
}
