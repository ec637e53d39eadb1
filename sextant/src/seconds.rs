//! Durations on the command line, in seconds.

use std::time::Duration;

/// A duration above 0.
///
/// # Errors
/// What is no such number.
pub fn parse(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text
        .parse()
        .map_err(|_| format!("'{text}' is not a number of seconds"))?;
    match Duration::try_from_secs_f64(seconds) {
        Ok(duration) if !duration.is_zero() => Ok(duration),
        _ => Err("must be above 0".into()),
    }
}
