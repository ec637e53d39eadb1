//! Sextant on the command line.
fn main() {}
