//! A folder of recordings: every line, and every picture in full.

use super::Found;
use super::cross_checks::CrossChecks;
use crate::progress;
use anyhow::bail;
use sextant_recordings::mcap::reader::Ending;
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_recordings::{Dataset, Frame, Row, read_picture};
use sextant_replay::in_order;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Threads that decode pictures.
const THREADS: usize = 2;

/// Checks a recording.
///
/// # Errors
/// The first flaw.
pub fn check(path: &Path, together: &mut CrossChecks) -> Found {
    let dataset = Dataset::open(path)?;
    dataset.check_times()?;
    let rows = dataset.rows_by_arrival();
    let images = rows.len();
    in_order(
        THREADS,
        progress::over(rows.into_iter(), "images"),
        || (),
        |(), row| size_of(row).map(|size| (row, size)),
        |seen| {
            let (row, size) = seen?;
            if let (Frame::Picture(file), Some(size)) = (&row.frame, size) {
                together.picture(&row.camera, size, file);
            }
            anyhow::Ok(())
        },
    )?;
    let mut cameras = BTreeMap::new();
    for camera in dataset.cameras() {
        together.recorded(path, &camera.camera);
        cameras.insert(camera.camera.as_str().to_owned(), camera.rows.len());
    }
    let cameras: Vec<String> = cameras.into_keys().collect();
    let summary = format!(
        "{images} images of {} cameras ({})",
        cameras.len(),
        cameras.join(", ")
    );
    Ok(("recording", summary))
}

/// Checks a recording in one MCAP file, pictures apart.
///
/// # Errors
/// A file that cannot be read or is no recording of a site.
pub fn check_mcap(path: &Path, together: &mut CrossChecks) -> Found {
    let recording = SiteRecording::read(path)?;
    if recording.ending != Ending::Closed {
        bail!("{}: {}", path.display(), recording.ending);
    }
    let seen = recording
        .observations
        .iter()
        .map(|timed| &timed.item.camera);
    let cameras: BTreeSet<_> = recording.images.keys().chain(seen).collect();
    for camera in &cameras {
        together.recorded(path, camera);
    }
    let names: Vec<&str> = cameras.iter().map(|camera| camera.as_str()).collect();
    let images: u64 = recording.images.values().sum();
    let summary = format!(
        "{images} images and detections of {} images of {} cameras ({}), {} poses",
        recording.observations.len(),
        names.len(),
        names.join(", "),
        recording.poses.len()
    );
    Ok(("recording", summary))
}

/// Width and height of a picture that is sound; none of detections.
fn size_of(row: &Row) -> anyhow::Result<Option<[u32; 2]>> {
    let Frame::Picture(path) = &row.frame else {
        return Ok(None);
    };
    let picture = read_picture(path)?;
    let pixels = |length: usize| u32::try_from(length).unwrap_or(u32::MAX);
    Ok(Some([pixels(picture.width), pixels(picture.height)]))
}
