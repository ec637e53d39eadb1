//! The keys of a protected site: its authority, the keys of its members, and their revocation.
//!
//! | in the authority's folder | contents |
//! |---|---|
//! | `authority.pem` | the authority's certificate, which all members trust |
//! | `authority.key` | its private key, which creates members |
//! | `members.toml` | members, their roles and validity, including revoked ones |
//! | `passwords` | the members' passwords of profile lab |
//! | `NAME/` | a member's keys: the folder that is copied to its machine ([`sextant_zenoh_bus::KeyFiles`]) |
//!
//! Time is an argument; random numbers are the system's.

mod authority;
mod certificates;
mod error;
mod folder;
mod secrets;

pub use authority::{Authority, CertificateRequest};
pub use error::KeysError;
