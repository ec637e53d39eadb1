//! Camera nodes on boards, over the system's ssh: a host gets its package, configuration and keys, and is new or as it
//! was.
//!
//! | module | what |
//! |---|---|
//! | `target` | hosts and cameras as typed |
//! | `desired` | configuration and keys of a camera |
//! | `packages` | the package for a host |
//! | `facts`, `digest`, `plan` | what a host is and has; what it lacks |
//! | `host`, `host.sh` | one host, here and there |
//! | `health` | which cameras the site sees |
//! | `ssh` | the connection |
//! | `run` | many hosts at a time |

mod desired;
mod digest;
mod error;
mod facts;
mod health;
mod host;
mod packages;
mod plan;
mod run;
mod ssh;
mod target;

pub use desired::{Desired, Sources};
pub use error::FleetError;
pub use health::Health;
pub use host::{DeployOutcome, Deployment, HostJob, OnStep, Report};
pub use packages::PackageFolder;
pub use run::{RunError, deploy};
pub use ssh::{Ssh, SshError};
pub use target::Target;
