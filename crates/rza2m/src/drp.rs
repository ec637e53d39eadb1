//! The DRP, the RZ/A2M's reconfigurable processor, through its Linux driver.
//!
//! - [`DrpDevice`]: one request with one record of bytes; [`DrpFile`] is the real one, `/dev/drp`.
//! - [`Session`]: the requests, in the only order and with the only values that keep clear of the driver's traps.
//! - [`Pipeline`]: circuits one after the other on all tiles, with spot checks of what they wrote.
//! - [`SelfTest`]: what the comparison of circuits and models gave.
//!
//! Source of requests, records and traps: renesas-rz/rza2m_drp, `driver/drp/{drp_linux.c,drp_linux.h,r_dk2_if.c}`, read
//! at d03929aa. Circuit data is not part of this project, since its licence forbids passing it on: users name their own
//! files.

mod device;
mod pipeline;
pub mod requests;
mod self_test;
mod session;

pub use device::{DrpDevice, DrpFile};
pub use pipeline::{CircuitData, Pipeline, PipelineError};
pub use self_test::{Difference, SelfTest, Trial};
pub use session::{DrpError, Session};
pub use sextant_drp_circuits::Circuit;
