//! Harness of the whole-system tests: runs the real `sextant` binary, waits for its output, and cleans up.
//!
//! Tests wait for conditions, never for durations; a limit on waiting only keeps a broken system from hanging the run.

#![allow(clippy::expect_used, reason = "a harness ends its test by panicking")]

mod board;
mod demo;
mod fault_proxy;
mod figures;
mod fused_site;
mod guide;
mod house;
mod killed_writes;
mod locked_site;
mod name_spaces;
mod page_checks;
mod preloaded;
mod program;
mod raw_images;
mod scene;
mod slow_disk;
mod status;
mod stepped_clock;
mod studio;
mod traces;
mod unit_view;
mod witness;
mod workshop;

pub use board::{Board, HOST};
pub use demo::{Demo, DemoOutcome, send};
pub use fault_proxy::{FaultProxy, Faults};
pub use figures::{Figure, is_full};
pub use fused_site::{FusedSite, free_port};
pub use guide::commands;
pub use house::{CameraFeed, Cameras, House};
pub use killed_writes::KilledWrites;
pub use locked_site::{LockedSite, keys};
pub use name_spaces::run_in_name_spaces;
pub use page_checks::run_page_checks;
pub use program::{client_example, node_camera, sextant, workspace_root};
pub use raw_images::{RAW_FORMATS, raw_image};
pub use scene::{Scene, changed, place, tag_of};
pub use slow_disk::SlowDisk;
pub use status::PATIENCE;
pub use stepped_clock::SteppedClock;
pub use studio::{Shots, Studio, looking_at};
pub use traces::Traces;
pub use unit_view::{Unit, prepare_machine};
pub use witness::{Sight, Witness};
pub use workshop::{BOARD, FIRST_OF_CUBE, Workshop};
