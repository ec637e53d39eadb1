//! Clocks that are off by more than the filter can estimate: tenths of a second to years.
//!
//! - [`offset_search`]: when to search, which clocks to correct, and by how much.
//! - [`offset_query`]: one search under way; [`motion_matching`] compares the motion that two cameras see,
//!   [`single_camera_track`] is that motion, and [`consensus`] decides which clock is wrong.
//! - [`arrival_delays`]: what the arrival times of images tell about clocks.

pub(crate) mod arrival_delays;
pub(crate) mod consensus;
pub(crate) mod motion_matching;
pub(crate) mod offset_query;
pub(crate) mod offset_search;
pub(crate) mod single_camera_track;
