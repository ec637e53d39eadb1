//! The messages, one file a subject: fields, units, frames and ranges.

pub(crate) mod camera_notice;
pub(crate) mod camera_settings;
pub(crate) mod camera_status;
pub(crate) mod clock_report;
pub(crate) mod config_answer;
pub(crate) mod detection_report;
pub(crate) mod fusion_inputs;
pub(crate) mod fusion_status;
pub(crate) mod heartbeat;
pub(crate) mod notice;
pub(crate) mod object_config;
pub(crate) mod object_links;
pub(crate) mod object_pose;
pub(crate) mod observations;
pub(crate) mod pose_config;
pub(crate) mod preview;
pub(crate) mod proposal;
pub(crate) mod refusal;
pub(crate) mod rig_config;
