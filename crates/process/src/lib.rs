//! What a process of Sextant needs of its operating system, and nothing of what it does: the clock and how far to trust
//! it, the wish to stop, logging, children, memory, the exit code. Linux only; knows no image, no network, no file format.

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

pub use clock::{ClockQuality, Reading, SteadyClock, now_ns};
pub use exit::{Exit, Failure, WithExit, report};
pub use shutdown::Shutdown;
