//! From tag corners of many cameras to object poses with covariance.
//!
//! What comes in: a rig (cameras with lens and pose), objects (constellations of tags, on links or on one body) and the corners that single
//! images show, each with its capture time. What goes out: `world_from_object` with covariance and twist per object.
//! Metres, radians, pixels with (0, 0) at the centre of the top-left pixel, nanoseconds since the Unix epoch.
//!
//! - [`Fusion`]: the machine; [`Input`] in, [`Output`] out, every tunable a field of [`FusionOptions`].
//! - [`Rig`], [`ObjectModel`], [`Articulation`], [`ImageObservation`]: what it works from.
//! - [`ObjectEstimate`], [`ClockOffset`], [`Fault`], [`Imperfection`], [`Proposal`], [`Statistics`]: what it reports.
//! - Inside: `fusion` (intake, outputs), `timeline` (the window into which late images are put), `track` (one object at
//!   one instant: rival attitudes and clocks), `filter` (the mathematics of one update), `clock_search` (clocks that are far
//!   off), `self_calibration` (how wrong the files are), `health` (what is wrong, by name).
//!
//! This crate knows no clock (time is an argument), no image, no network and no file.

mod clocks;
mod diagnosis;
mod estimate;
mod fault;
mod filter;
mod fusion;
mod imperfection;
mod kinematics;
mod measurement;
mod options;
mod proposal;
mod self_calibration;
mod site;
mod statistics;
mod tag_poses;
mod time;
mod tracker;

pub use estimate::{ClockOffset, JointEstimate, LinkEstimate, ObjectEstimate, Posture, State};
pub use fault::Fault;
pub use fusion::{Fusion, Input, Output};
pub use imperfection::Imperfection;
pub use options::{FusionOptions, OptionsError};
pub use proposal::Proposal;
pub use self_calibration::HeldBack;
pub use sextant_site_model::{
    Articulation, ArticulationError, Camera, CameraId, Exposure, IdError, ImageObservation, Joint,
    JointId, JointKind, LensSigma, LinkId, MOST_JOINTS, MOST_LINKS, ObjectError, ObjectId,
    ObjectModel, ObjectTag, PoseSigma, Rig, RigError, Stamp, TagCorners, TagId,
};
pub use site::ModelError;
pub use statistics::{CameraStatistics, Statistics};
pub use tag_poses::tag_poses;
