//! The harness of the whole-system tests: runs the real `sextant` binary, waits for what it says, and leaves nothing behind.
//!
//! Tests wait for conditions, never for durations; a limit on waiting only keeps a broken system from hanging the run.

#![allow(clippy::expect_used, reason = "a harness ends its test by panicking")]

mod demo;
mod program;
mod traces;

pub use demo::{Demo, Ended, send};
pub use program::{sextant, workspace_root};
pub use traces::Traces;
