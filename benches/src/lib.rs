//! What benches measure and what they measure against.
//!
//! - [`pictures`]: 640x480 images of the simulator's, one a kind, the same on every machine.
//! - [`StageClock`]: times of a detection's stages.
//! - `Peer` (feature `peer`): AprilTag's own detector in C.

#[cfg(feature = "peer")]
mod peer;
mod pictures;
mod stage_clock;

#[cfg(feature = "peer")]
pub use peer::Peer;
pub use pictures::{HEIGHT, Picture, WIDTH, pictures};
pub use stage_clock::StageClock;
