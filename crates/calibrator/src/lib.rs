//! Calibration: from the tag corners of recorded images to lenses, camera poses and constellations.
//!
//! Metres, radians, pixels, seconds and the frames of `crates/geometry/FRAMES.md`. Procedures that a person runs now
//! and then; nothing of the live path depends on this crate. It knows no image, file, clock or network.
//!
//! - [`RigSession`]: where every camera is, from an object carried through what they see.
//! - [`LearnSession`]: where each tag of an object sits, from images of the object being turned.
//! - [`DiscoverySession`]: the same where the tags of the object are unknown.
//! - [`SiteSession`]: lenses, rig, objects and clocks at once, from nothing but sizes.
//! - [`RobotSession`]: where a robot's base is, and what its hand carries, from its poses and images.
//! - [`Verdict`]: grade and findings of every procedure.
//! - [`PrintedGrid`]: a flat board as it is printed.
//! - [`lens`]: the calibration of a lens with a board of tags.
//! - [`procedure`]: the three behind one face, as terminal and page run them.

mod adjustment;
mod board_layout;
mod constellation;
mod discovered_tags;
mod discovery;
mod graph;
mod held_out;
mod image_store;
mod learn;
pub mod lens;
mod printed_grid;
mod priors;
pub mod procedure;
mod resection;
mod rig;
mod robot;
mod session_images;
mod site;
mod verdict;

pub use board_layout::{LayoutCheck, OtherLayout};
pub use discovered_tags::DiscoveredTags;
pub use discovery::{DiscoveryPlan, DiscoverySession};
pub use held_out::HeldOutImages;
pub use learn::{
    Gauge, LearnError, LearnPlan, LearnProgress, LearnReport, LearnSession, LearnedObject,
    LearnedTag, SketchedTag, TagProgress,
};
pub use printed_grid::{GridError, PrintedGrid, STRIP_MM};
pub use rig::{
    CalibratedCamera, CalibratedRig, CameraProgress, Origin, RigError, RigPlan, RigProgress,
    RigReport, RigSession, Up,
};
pub use robot::{
    CalibratedRobot, HeldOut, PoseReading, RobotError, RobotPlan, RobotPoses, RobotReport,
    RobotSession,
};
pub use site::{
    CalibratedSite, MeasuredDistance, SiteCameraReport, SiteError, SiteObjectReport, SitePlan,
    SiteReport, SiteSession,
};
pub use verdict::{Finding, Grade, PosePart, ScaleSource, Verdict, WeakMotion};
