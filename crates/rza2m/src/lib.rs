//! The Renesas RZ/A2M from user space: its camera path and its accelerator, the DRP.
//!
//! - [`Camera`]: an IMX219 over CSI-2 and VIN, whose raw images arrive in on-chip memory. [`FrameClock`] turns their
//!   arrivals into times.
//! - [`Preprocess`]: from a raw image to the grey one that the detector takes: by the CPU ([`Cpu`], the reference) or
//!   the DRP ([`Accelerated`], with the CPU behind it).
//! - [`drp`]: the driver's requests, a session that keeps clear of its traps, the pipeline of circuits and its
//!   self-test.
//! - [`PhysicalMemory`], [`SensorBus`], [`DrpDevice`]: what the board gives, as traits; [`DevMem`], [`I2cBus`] and
//!   [`DrpFile`] are the real ones.
//!
//! Time is an argument, except for the pauses that registers need. Nothing here has run on silicon: registers, requests
//! and formulas are from Renesas' published sources and manuals, which each file names.

mod camera;
pub mod drp;
mod frame_clock;
mod imx219;
mod on_chip;
mod physical;
mod preprocess;
mod sensor_bus;
mod vin;

pub use camera::{Camera, CameraError, CameraSettings, Frame};
pub use drp::{DrpDevice, DrpFile};
pub use frame_clock::FrameClock;
pub use on_chip::{LayoutError, OnChipLayout};
pub use physical::{DevMem, PhysicalMemory};
pub use preprocess::{Accelerated, Cpu, Preprocess, check_order};
pub use sensor_bus::{I2cBus, SensorBus};
