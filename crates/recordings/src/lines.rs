//! A text file line by line, and the rule of every recording that time moves on from line to line.

use crate::error::RecordingError;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Latest time that a recording may state: differences fit an `i64`.
const MAX_TIME_NS: u64 = i64::MAX as u64;

/// Longest line of a text file, bytes.
pub const MOST_LINE_BYTES: usize = 16 << 20;

/// The lines of a text. One that is longer than [`MOST_LINE_BYTES`] is an error: an endless file must not fill the memory.
pub fn bounded_lines(mut text: impl BufRead) -> impl Iterator<Item = io::Result<String>> {
    std::iter::from_fn(move || {
        let mut line = Vec::new();
        let bounded = (&mut text).take(MOST_LINE_BYTES as u64 + 1);
        match { bounded }.read_until(b'\n', &mut line) {
            Ok(0) => None,
            Ok(_) if line.len() > MOST_LINE_BYTES => {
                let cause = format!("a line of more than {} MiB", MOST_LINE_BYTES >> 20);
                Some(Err(io::Error::other(cause)))
            }
            Ok(_) => Some(String::from_utf8(line).map_err(|_| io::ErrorKind::InvalidData.into())),
            Err(error) => Some(Err(error)),
        }
    })
}

/// Hands each line that is neither empty nor a `#` comment to `take`, with its number from 1 and without a byte order mark.
pub(crate) fn each_line(
    path: &Path,
    mut take: impl FnMut(usize, &str) -> Result<(), RecordingError>,
) -> Result<(), RecordingError> {
    let remedy = "check the path and what wrote the file";
    let file = File::open(path).map_err(RecordingError::unreadable(path, remedy))?;
    for (index, line) in bounded_lines(BufReader::new(file)).enumerate() {
        let line = line.map_err(RecordingError::unreadable(path, remedy))?;
        let line = line.trim_start_matches('\u{feff}').trim();
        if !line.is_empty() && !line.starts_with('#') {
            take(index + 1, line)?;
        }
    }
    Ok(())
}

/// Shortest plausible time between images, ns: 20 000 a second.
const SHORTEST_NS: u64 = 50_000;
/// Images from which their spacing is judged.
const ENOUGH_IMAGES: usize = 8;

/// The times of the lines so far, with which the next one is compared.
#[derive(Default)]
pub(crate) struct TimeOrder {
    last: Option<(u64, usize)>,
    spacings_ns: Vec<u64>,
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
            self.spacings_ns.push(time_ns.saturating_sub(before));
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

    /// Refuses times that are too close together for nanoseconds: those of another unit.
    pub(crate) fn finish(mut self, path: &Path) -> Result<(), RecordingError> {
        let n = self.spacings_ns.len();
        if n + 1 < ENOUGH_IMAGES {
            return Ok(());
        }
        let (_, median, _) = self.spacings_ns.select_nth_unstable(n / 2);
        let (median, rate) = (*median, 1_000_000_000 / (*median).max(1));
        let (unit, remedy) = match median {
            SHORTEST_NS.. => return Ok(()),
            500.. => (
                "microseconds",
                "write nanoseconds: multiply all times by 1000",
            ),
            _ => (
                "milliseconds",
                "write nanoseconds: multiply all times by 1000000",
            ),
        };
        let cause = format!(
            "the timestamps are {median} apart; in nanoseconds these are {rate} images a second: are they {unit}?"
        );
        Err(RecordingError::wrong(path, None, cause, remedy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finished(spacing: u64, n: u64) -> Result<(), String> {
        let mut order = TimeOrder::default();
        for number in 0..n {
            // One long break.
            let time = 1_700_000_000_000_000 + spacing * (number + 1_000_000 * (number / 5));
            order
                .check(Path::new("a"), number as usize + 1, time)
                .unwrap();
        }
        order
            .finish(Path::new("a"))
            .map_err(|error| error.to_string())
    }

    #[test]
    fn an_endless_line_is_an_error() {
        let endless = BufReader::new(io::repeat(b'x'));
        let error = bounded_lines(endless).next().unwrap().unwrap_err();
        assert_eq!(error.to_string(), "a line of more than 16 MiB");
        let lines: Result<Vec<String>, _> = bounded_lines(&b"a\nb"[..]).collect();
        assert_eq!(lines.unwrap(), ["a\n", "b"]);
    }

    #[test]
    fn times_in_another_unit_are_a_question() {
        let refused = |spacing| finished(spacing, 20).unwrap_err();
        assert_eq!(
            refused(33_333),
            "a: the timestamps are 33333 apart; in nanoseconds these are 30000 images a second: are they microseconds?; write nanoseconds: multiply all times by 1000"
        );
        assert!(refused(33).contains("are they milliseconds?"));
        assert_eq!(finished(33_333_333, 20), Ok(()));
        assert_eq!(finished(1, 5), Ok(()));
    }
}
