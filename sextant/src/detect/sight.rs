//! One picture and what the detector sees in it.

use anyhow::{Context, ensure};
use sextant_apriltag::{Detection, Detector, Tracker, TrackingReport};
use sextant_geometry::Lens;
use sextant_recordings::{GreyImage, read_picture};
use sextant_replay::image_of;
use sextant_site_model::Camera;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The detections of one image.
pub struct DetectedImage {
    /// Its file.
    pub path: PathBuf,
    /// Time of the detection alone, milliseconds.
    pub ms: f64,
    /// The tags.
    pub detections: Vec<Detection>,
    /// Searched areas, for an image of a sequence.
    pub tracking: Option<TrackingReport>,
}

/// Detects the tags in an image file, `reps` times.
///
/// # Errors
/// A file that is no picture, and a picture of a size that the detector does not take.
pub fn detect(
    detector: &mut Option<Detector>,
    path: &Path,
    reps: u32,
    camera: Option<&Camera>,
) -> anyhow::Result<DetectedImage> {
    let picture = read_picture(path)?;
    let image = image_of(&picture).with_context(|| path.display().to_string())?;
    let detector = detector.as_mut().context("there is no detector")?;
    detector.set_lens(lens_of(camera, &picture, path)?);
    if reps > 1 {
        detector.detect(&image);
    }
    let mut detections = Vec::new();
    let mut times = Vec::new();
    for _ in 0..reps {
        let start = Instant::now();
        let found = detector.detect(&image);
        times.push(start.elapsed().as_secs_f64() * 1e3);
        detections.clear();
        detections.extend_from_slice(found);
    }
    times.sort_by(f64::total_cmp);
    Ok(DetectedImage {
        path: path.to_owned(),
        ms: times[times.len() / 2],
        detections,
        tracking: None,
    })
}

/// Detects the tags in an image file, the next one of a sequence.
///
/// # Errors
/// As [`detect`].
pub fn follow(
    tracker: &mut Option<Tracker>,
    path: &Path,
    camera: Option<&Camera>,
) -> anyhow::Result<DetectedImage> {
    let picture = read_picture(path)?;
    let image = image_of(&picture).with_context(|| path.display().to_string())?;
    let tracker = tracker.as_mut().context("there is no tracker")?;
    tracker.set_lens(lens_of(camera, &picture, path)?);
    let start = Instant::now();
    let detections = tracker.detect(&image).to_vec();
    Ok(DetectedImage {
        path: path.to_owned(),
        ms: start.elapsed().as_secs_f64() * 1e3,
        detections,
        tracking: Some(*tracker.tracking_report()),
    })
}

/// The lens through which a camera saw the picture.
fn lens_of(
    camera: Option<&Camera>,
    picture: &GreyImage,
    path: &Path,
) -> anyhow::Result<Option<Lens>> {
    let Some(camera) = camera else {
        return Ok(None);
    };
    let [width, height] = camera.resolution.map(|pixels| pixels as usize);
    ensure!(
        (picture.width, picture.height) == (width, height),
        "{}: {}x{} pixels, but the rig says {width}x{height} of camera \"{}\"",
        path.display(),
        picture.width,
        picture.height,
        camera.id
    );
    Ok(Some(camera.lens))
}
