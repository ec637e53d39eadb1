//! A text file line by line, and the rule of every recording that time moves on from line to line.

use crate::error::RecordingError;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Latest time that a recording may state: differences fit an `i64`.
const MAX_TIME_NS: u64 = i64::MAX as u64;

/// Hands each line that is neither empty nor a `#` comment to `take`, with its number from 1.
pub(crate) fn each_line(
    path: &Path,
    mut take: impl FnMut(usize, &str) -> Result<(), RecordingError>,
) -> Result<(), RecordingError> {
    let remedy = "check the path and what wrote the file";
    let file = File::open(path).map_err(RecordingError::unreadable(path, remedy))?;
    for (index, line) in BufReader::new(file).lines().enumerate() {
        let line = line.map_err(RecordingError::unreadable(path, remedy))?;
        let line = line.trim();
        if !line.is_empty() && !line.starts_with('#') {
            take(index + 1, line)?;
        }
    }
    Ok(())
}

/// The time of the last line, to hold the next one against.
#[derive(Default)]
pub(crate) struct TimeOrder {
    last: Option<(u64, usize)>,
}

impl TimeOrder {
    /// Refuses a time that is not after the one before.
    pub(crate) fn check(
        &mut self,
        path: &Path,
        line: usize,
        time_ns: u64,
    ) -> Result<(), RecordingError> {
        if time_ns > MAX_TIME_NS {
            let cause = format!("the timestamp {time_ns} lies beyond the year 2262");
            return Err(RecordingError::wrong(
                path,
                line,
                cause,
                "write nanoseconds",
            ));
        }
        if let Some((before, at)) = self.last.replace((time_ns, line)) {
            if time_ns == before {
                let cause = format!("the timestamp {time_ns} is there already, on line {at}");
                let remedy = "each image has its own timestamp: remove one of the lines";
                return Err(RecordingError::wrong(path, line, cause, remedy));
            }
            if time_ns < before {
                let cause =
                    format!("the timestamp {time_ns} is earlier than {before} on line {at}");
                let remedy = "sort the lines by timestamp";
                return Err(RecordingError::wrong(path, line, cause, remedy));
            }
        }
        Ok(())
    }
}
