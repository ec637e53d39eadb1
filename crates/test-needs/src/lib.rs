//! What tests and chores need of a machine beside Rust and a C compiler, whether it is there, and what to do where it
//! is not.
//!
//! `cargo xtask` checks all of it before anything runs. A test with needs of its own ([`Guarded`]) checks them again,
//! so that a plain `cargo test` skips what cannot run. In continuous integration (the environment variable `CI`) a skip
//! is a failure.
//!
//! No dependency but the standard library: the chores begin with it on a fresh machine.

#[allow(missing_docs, reason = "each is described by its fields")]
mod guarded;
#[allow(missing_docs, reason = "each is described by its fields")]
mod list;
mod need;
mod skips;

pub use guarded::*;
pub use list::*;
pub use need::{Need, locate};
pub use skips::{SKIPS, is_ci, note_skip};
