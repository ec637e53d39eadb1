//! The camera node: a board's two processes.
//!
//! *Capture* owns the camera and lends each image in shared memory; it knows no network. *Detect* borrows the images,
//! finds the tags, solves their poses and publishes; beside it, in a thread of low priority with a borrow of its own,
//! runs the preview. The two are joined by shared memory only, so either may die and come back without the other.
//! Without a part named, [`run`] starts both as children and supervises them.
//!
//! - [`CameraNodeConfig`] is `camera.toml`.
//! - `source`: where images come from (V4L2, RZ/A2M, another program, a video, a recording, the simulator), one trait.
//! - `capture`, `detect`, `preview`: the loops. `supervise`: the parent of both.

mod capture;
mod config;
mod detect;
#[cfg(test)]
mod panic_tests;
mod part;
mod preview;
mod run;
mod settings_files;
mod site_models;
mod source;
mod supervise;

pub use config::{
    CameraNodeConfig, CommandConfig, CommandLine, DetectionConfig, DrpCircuit, DrpCircuitConfig,
    Pace, PreviewConfig, Rza2mConfig, SourceConfig, StreamFormat, V4l2Config, VideoConfig,
};
pub use part::Part;
pub use preview::JpegMaker;
pub use run::{CameraArguments, ProgramArguments, run};
pub use site_models::SiteModels;
pub use source::examine::examine;
pub use source::v4l2::probe;
pub use source::{Capture, ImageSource, Next, Reconfigured, SourceError};
