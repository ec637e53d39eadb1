//! The messages, one file a subject: fields, units, frames and ranges.

pub(crate) mod articulated_config;
pub(crate) mod camera_status;
pub(crate) mod clock_report;
pub(crate) mod config;
pub(crate) mod config_answer;
pub(crate) mod detection_report;
pub(crate) mod full_config;
pub(crate) mod fusion_status;
pub(crate) mod object_links;
pub(crate) mod object_pose;
pub(crate) mod observations;
pub(crate) mod preview;
pub(crate) mod proposal;
