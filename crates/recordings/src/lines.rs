//! A text file line by line, and the rule of every recording that time moves on from line to line.

use crate::error::RecordingError;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Latest time that a recording may state: differences fit an `i64`.
const MAX_TIME_NS: u64 = i64::MAX as u64;

/// Longest line of a text file, bytes.
pub const MOST_LINE_BYTES: usize = 16 << 20;

/// The lines of a text. One that is longer than [`MOST_LINE_BYTES`] is an error: an endless file must not fill the
/// memory.
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

/// Hands each line that is neither empty nor a `#` comment to `take`, with its number from 1 and without a byte order
/// mark.
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

/// What makes times of images doubtful, and the remedy: they are too close together for nanoseconds, so that they are
/// in another unit or count the images.
pub(crate) fn doubt(times_ns: impl Iterator<Item = u64>) -> Option<(String, &'static str)> {
    let times_ns: Vec<u64> = times_ns.collect();
    if times_ns.len() < ENOUGH_IMAGES {
        return None;
    }
    let pairs = times_ns.windows(2);
    let mut spacings_ns: Vec<u64> = pairs.map(|pair| pair[1].saturating_sub(pair[0])).collect();
    let middle = spacings_ns.len() / 2;
    let (_, median, _) = spacings_ns.select_nth_unstable(middle);
    let (median, rate) = (*median, 1_000_000_000 / (*median).max(1));
    let (question, remedy) = match median {
        SHORTEST_NS.. => return None,
        500.. => (
            "are they microseconds?",
            "write nanoseconds: multiply all times by 1000",
        ),
        2.. => (
            "are they milliseconds?",
            "write nanoseconds: multiply all times by 1000000",
        ),
        _ => (
            "do they count the images?",
            "write when each image was taken, in nanoseconds",
        ),
    };
    let cause = format!(
        "the timestamps are {median} apart; in nanoseconds these are {rate} images a second: {question}"
    );
    Some((cause, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doubted(spacing: u64, n: u64) -> Option<String> {
        // One long break.
        let times = (0..n).map(|k| 1_700_000_000_000_000 + spacing * (k + 1_000_000 * (k / 5)));
        doubt(times).map(|(cause, _)| cause)
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
        assert_eq!(
            doubted(33_333, 20).unwrap(),
            "the timestamps are 33333 apart; in nanoseconds these are 30000 images a second: are they microseconds?"
        );
        assert!(doubted(33, 20).unwrap().contains("are they milliseconds?"));
        assert!(
            doubted(1, 20)
                .unwrap()
                .contains("do they count the images?")
        );
        assert_eq!(doubted(33_333_333, 20), None);
        assert_eq!(doubted(1, 5), None);
    }
}
