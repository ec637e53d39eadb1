//! A recording's pictures turned into `detections.jsonl`, which replay takes in their place.

use super::detector;
use crate::progress;
use crate::recorded::{Preferred, Recorded};
use anyhow::Context;
use sextant_apriltag::{Detector, Options};
use sextant_process::{Exit, WithExit};
use sextant_recordings::{CameraRecording, DetectionsLine, Frame, Row, read_picture};
use sextant_replay::{detected_tags, image_of, in_order};
use sextant_site_files::write_atomically;
use std::fs;
use std::path::Path;

/// Writes `OUT/<camera>/detections.jsonl` for every camera of a recording that has pictures.
///
/// # Errors
/// [`Exit::Input`] for a recording that cannot be used; then nothing is written for its camera.
pub fn write_detections(
    dataset: &Path,
    out: &Path,
    threads: usize,
    options: &Options,
) -> anyhow::Result<()> {
    let recorded = Recorded::open(dataset, Preferred::Pictures, None)?;
    for recording in recorded.dataset.cameras() {
        let text = lines_of(recording, threads, options).exit_with(Exit::Input)?;
        let folder = out.join(recording.camera.as_str());
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let path = folder.join("detections.jsonl");
        write_atomically(&path, text.as_bytes())?;
        eprintln!("{}: {} images", path.display(), recording.rows.len());
    }
    Ok(())
}

fn lines_of(
    recording: &CameraRecording,
    threads: usize,
    options: &Options,
) -> anyhow::Result<String> {
    let mut text = String::new();
    let take = |line: anyhow::Result<DetectionsLine>| {
        text.push_str(&serde_json::to_string(&line?)?);
        text.push('\n');
        anyhow::Ok(())
    };
    in_order(
        threads,
        progress::over(recording.rows.iter(), "images"),
        || detector(options),
        line_of,
        take,
    )?;
    Ok(text)
}

fn line_of(detector: &mut Option<Detector>, row: &Row) -> anyhow::Result<DetectionsLine> {
    let detections = match &row.frame {
        Frame::Detections(detections) => detections.clone(),
        Frame::Picture(path) => {
            let picture = read_picture(path)?;
            let image = image_of(&picture).with_context(|| path.display().to_string())?;
            let detector = detector.as_mut().context("there is no detector")?;
            detected_tags(detector.detect(&image))
        }
    };
    Ok(DetectionsLine {
        t_ns: row.capture_ns,
        arrival_ns: row.arrival_stated.then_some(row.arrival_ns),
        detections,
    })
}
