//! From tag corners of many cameras to object poses with covariance.
//!
//! Input: a rig (cameras with lens and pose), objects (constellations of tags on rigid or articulated bodies) and the
//! corners of single images, each with its capture time. Output: `world_from_object` with covariance and twist of each
//! object. Metres, radians, pixels with (0, 0) at the centre of the top-left pixel, nanoseconds since the Unix epoch.
//!
//! - [`Fusion`]: the state machine; [`Input`] in, [`Output`] out, every tunable a field of [`FusionOptions`].
//! - `Rig`, `ObjectModel`, `Articulation` and `ImageObservation` of `sextant_site_model`: what it works from.
//! - `ObjectEstimate`, `ClockOffset`, `Fault` and `Imperfection` of `sextant_site_report`, [`Proposal`],
//!   [`Statistics`]: what it reports.
//! - Rooms, each depending on earlier ones only: `measurement` and `kinematics` (residuals of a view, links and
//!   joints), `site` (models in force, data association), `filter` (the state of an object), `tracker` (hypotheses and
//!   the fixed lag), `self_calibration` (errors of the files), `clocks` (far clock offsets), `diagnosis` (faults),
//!   `contradictions` (mistakes), `fusion` (intake and outputs), `localisation` (cameras that objects carry).
//!
//! This crate knows no clock (time is an argument), no image, no network and no file.

mod clocks;
mod contradictions;
mod diagnosis;
mod fading_counter;
mod filter;
mod fusion;
mod kinematics;
mod localisation;
mod measurement;
mod mended;
mod options;
mod proposal;
mod self_calibration;
mod site;
mod statistics;
mod time;
mod tracker;

pub use fusion::task::SolverTask;
pub use fusion::{Input, Output};
pub use localisation::Fusion;
pub use options::{DiagnosisOptions, FusionOptions, OptionsError};
pub use proposal::Proposal;
pub use self_calibration::{AdjustmentTask, HeldBack};
pub use site::ModelError;
pub use statistics::{CameraStatistics, Statistics};
