//! `data.csv` of the EuRoC ASL layout: `#timestamp [ns],filename` and an optional third column `arrival [ns]`.

use crate::error::RecordingError;
use crate::lines::{TimeOrder, each_line};
use std::path::{Component, Path, PathBuf};

/// One line: an image and its times, ns since the Unix epoch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ImageLine {
    pub capture_ns: u64,
    pub arrival_ns: Option<u64>,
    pub picture: PathBuf,
}

/// The images of a camera's folder, in the order of time; every picture exists.
pub(crate) fn read_data_csv(folder: &Path) -> Result<Vec<ImageLine>, RecordingError> {
    let csv = folder.join("data.csv");
    let pictures = folder.join("data");
    let mut lines = Vec::new();
    let mut ascending = TimeOrder::default();
    each_line(&csv, |number, line| {
        let is_header = number == 1
            && line
                .trim_start_matches('"')
                .to_lowercase()
                .starts_with("time");
        if is_header {
            return Ok(());
        }
        let image = image_of(line, &pictures)
            .map_err(|(cause, remedy)| RecordingError::wrong(&csv, number, cause, remedy))?;
        ascending.check(&csv, number, image.capture_ns)?;
        if !image.picture.is_file() {
            let cause = format!("the picture {} is missing", image.picture.display());
            let remedy = "copy it there or remove the line";
            return Err(RecordingError::wrong(&csv, number, cause, remedy));
        }
        lines.push(image);
        Ok(())
    })?;
    Ok(lines)
}

/// Times since 1970 up to this one, ns, are durations in truth where others are of today.
const DURATION_NS: u64 = 1_000_000_000_000;
/// Times since 1970 beyond this one, ns, are of today: September 2001.
const TODAY_NS: u64 = 1_000_000_000_000_000_000;

type Flaw = (String, &'static str);

fn image_of(line: &str, pictures: &Path) -> Result<ImageLine, Flaw> {
    let is_separator = |c: char| matches!(c, ',' | ';' | '\t');
    let columns = line.split(is_separator);
    let columns: Vec<&str> = columns
        .map(|column| column.trim().trim_matches('"'))
        .collect();
    let (capture, name, arrival) = match columns.as_slice() {
        [capture, name] | [capture, name, ""] => (capture, name, None),
        [capture, name, arrival] => (capture, name, Some(arrival)),
        _ => {
            let cause = format!("{} columns instead of 2 or 3", columns.len());
            return Err((
                cause,
                "write timestamp [ns],filename and maybe arrival [ns]",
            ));
        }
    };
    let capture_ns = time_of(capture)?;
    let arrival_ns = arrival.copied().map(time_of).transpose()?;
    if let Some(arrival_ns) = arrival_ns.filter(|ns| *ns < DURATION_NS && capture_ns > TODAY_NS) {
        let cause = format!("{arrival_ns} in the third column is no time of arrival");
        let remedy =
            "write arrival [ns] there, or remove the column: exposures and gains are not read";
        return Err((cause, remedy));
    }
    Ok(ImageLine {
        capture_ns,
        arrival_ns,
        picture: pictures.join(file_name_of(name)?),
    })
}

fn time_of(text: &str) -> Result<u64, Flaw> {
    text.parse().map_err(|_| {
        let cause = format!("\"{text}\" is no timestamp");
        (cause, "write whole nanoseconds since the Unix epoch")
    })
}

/// A name below the folder of the pictures: nothing that leads out of it.
fn file_name_of(name: &str) -> Result<&Path, Flaw> {
    let path = Path::new(name);
    let inside = path
        .components()
        .all(|part| matches!(part, Component::Normal(_)));
    if name.is_empty() || !inside {
        let cause = format!("\"{name}\" is no name of a picture");
        return Err((
            cause,
            "write the name of a file in the folder `data` beside data.csv",
        ));
    }
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use tempfile::TempDir;

    fn folder(csv: &str, pictures: &[&str]) -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("data.csv"), csv).unwrap();
        fs::create_dir(folder.path().join("data")).unwrap();
        for name in pictures {
            fs::write(folder.path().join("data").join(name), b"").unwrap();
        }
        folder
    }

    fn complaint_about(csv: &str) -> String {
        let folder = folder(csv, &["a.png", "b.png"]);
        let message = read_data_csv(folder.path()).unwrap_err().to_string();
        let root = format!("{}/", folder.path().display());
        message.replace(&root, "")
    }

    #[test]
    fn lines_with_and_without_arrival_are_read() {
        let csv = "#timestamp [ns],filename,arrival [ns]\r\n5, a.png , 7\r\n\n6,b.png\n";
        let folder = folder(csv, &["a.png", "b.png"]);
        let lines = read_data_csv(folder.path()).unwrap();
        let times: Vec<_> = lines.iter().map(|l| (l.capture_ns, l.arrival_ns)).collect();
        assert_eq!(times, [(5, Some(7)), (6, None)]);
        assert_eq!(lines[0].picture, folder.path().join("data/a.png"));
    }

    #[test]
    fn tables_of_spreadsheets_are_read() {
        for csv in [
            "timestamp [ns],filename\n5,a.png\n6,b.png\n",
            "#timestamp [ns];filename\n5;a.png\n6;b.png\n",
            "Timestamp\tfilename\n5\ta.png\n6\tb.png\n",
            "\"timestamp\",\"filename\"\n\"5\",\"a.png\"\n\"6\",\"b.png\"\n",
        ] {
            let folder = folder(csv, &["a.png", "b.png"]);
            let lines = read_data_csv(folder.path()).unwrap();
            let times: Vec<_> = lines.iter().map(|line| line.capture_ns).collect();
            assert_eq!(times, [5, 6], "{csv}");
        }
    }

    #[test]
    fn an_exposure_is_no_time_of_arrival() {
        let csv = "#timestamp [ns],filename,exposure [us]\n1700000000000000000,a.png,4000\n";
        let message = complaint_about(csv);
        assert!(
            message.contains("4000 in the third column is no time of arrival"),
            "{message}"
        );
    }

    #[test]
    fn wrong_lines_are_refused_with_their_number() {
        for (csv, expected) in [
            (
                "7,a.png\n6,b.png\n",
                "data.csv:2: the timestamp 6 is earlier than 7 on line 1; sort the lines",
            ),
            (
                "#t\n7,a.png\n7,b.png\n",
                "data.csv:3: the timestamp 7 is there already, on line 2; each image",
            ),
            ("7\n", "data.csv:1: 1 columns instead of 2 or 3; write"),
            (
                "7,a.png,8,9\n",
                "data.csv:1: 4 columns instead of 2 or 3; write",
            ),
            ("x,a.png\n", "data.csv:1: \"x\" is no timestamp; write"),
            ("-1,a.png\n", "data.csv:1: \"-1\" is no timestamp; write"),
            ("1.5,a.png\n", "data.csv:1: \"1.5\" is no timestamp; write"),
            ("7,a.png,x\n", "data.csv:1: \"x\" is no timestamp; write"),
            (
                "18446744073709551615,a.png\n",
                "data.csv:1: the timestamp 18446744073709551615 lies beyond",
            ),
            (
                "7,c.png\n",
                "data.csv:1: the picture data/c.png is missing; copy",
            ),
            (
                "7,../a.png\n",
                "data.csv:1: \"../a.png\" is no name of a picture",
            ),
            ("7,\n", "data.csv:1: \"\" is no name of a picture"),
        ] {
            let message = complaint_about(csv);
            assert!(message.starts_with(expected), "{csv}: {message}");
        }
    }
}
