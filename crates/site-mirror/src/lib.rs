//! A site as heard from the network: which nodes, cameras and objects there are, their newest statuses, images and
//! poses, and the models in force. Every program that shows or uses a site keeps one [`SiteMirror`].
//!
//! Sans-I/O: payloads, liveliness tokens and the time are arguments. Times are ns by one clock of the caller's choice;
//! unless times of the day are to be shown, choose one that is never set.
//!
//! **Trust.** Any payload may be anything. What breaks the contract, names another id than its key, comes from a
//! replaced publisher or finds no room is refused with a [`Rejection`] and counted. [`limits`] bounds how much is kept
//! and states when something is silent or forgotten.

mod bounded_map;
pub mod limits;
mod mirror;
mod reading;
mod records;
mod rejection;
mod renewal;
mod tag_index;

pub use bounded_map::{BoundedMap, Full};
pub use mirror::{SiteMirror, Update};
pub use records::{Camera, FusionNode, Heard, Liveliness, Node, Object};
pub use rejection::{Rejection, Rejections};
pub use renewal::Renewal;
