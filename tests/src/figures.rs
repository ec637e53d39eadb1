//! Figures of the table of faults in BENCHMARKS.md: `cargo xtask faults` runs the tests that measure them, in full
//! length, and writes them there.

use std::fmt;

/// The variable by which `cargo xtask faults` asks for the full length, on a machine with nothing else to do.
const FULL: &str = "SEXTANT_FAULTS";

/// Whether faults last as long, and come as often, as the table says. Otherwise a test shows in seconds that the
/// promise can be kept, and holds no time against a machine that has other things to do.
#[must_use]
pub fn is_full() -> bool {
    std::env::var_os(FULL).is_some()
}

/// A measured figure of a row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Figure<'a> {
    /// The row: as in the table.
    pub row: &'a str,
    /// What was measured.
    pub what: &'a str,
    /// The figure.
    pub value: f64,
    /// Its unit.
    pub unit: &'a str,
    /// The promise: it is at most this.
    pub at_most: f64,
}

impl fmt::Display for Figure<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, unit, .. } = self;
        let decimals = if self.value.abs() < 10.0 && self.value.fract() != 0.0 {
            2
        } else {
            0
        };
        write!(out, "{what}: {:.decimals$} {unit}", self.value)
    }
}

impl Figure<'_> {
    /// Prints the figure for the table.
    ///
    /// # Panics
    /// When the promise is broken, in full length.
    pub fn keep(&self) {
        let is_kept = self.value <= self.at_most;
        let Self {
            row, at_most, unit, ..
        } = self;
        println!("FIGURE\t{row}\t{self}\tat most {at_most} {unit}");
        assert!(!is_full() || is_kept, "{self}, more than {at_most} {unit}");
    }
}
