//! Services of the operating system for a process: clocks and their errors, shutdown requests, logging, children,
//! memory, exit codes. Linux only; independent of images, network and file formats.

pub mod background;
pub mod children;
pub mod clock;
pub mod exit;
pub mod host;
pub mod logging;
pub mod memory;
pub mod panics;
mod rate_limit;
pub mod shutdown;
pub mod terminal;
pub mod watchdog;
pub mod whole_lines;

pub use clock::{ClockQuality, Reading, SteadyClock, monotonic_ns, now_ns};
pub use exit::{Exit, Failure, WithExit, report};
pub use shutdown::Shutdown;
