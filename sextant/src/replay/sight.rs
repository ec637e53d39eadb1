//! A recorded image as the estimator takes it: detections as they are, pictures through the detector first.

use crate::detect::{TagFinder, detected_tags, image_of};
use anyhow::{Context, ensure};
use nalgebra::{Matrix2, Point2};
use sextant_recordings::{DetectedTag, Frame, Row, read_picture};
use sextant_site_model::{Camera, ImageObservation, Rig, TagCorners, TagId};
use std::path::Path;

/// Recordings say nothing of their images' exposures.
pub(super) const EXPOSURE_UNKNOWN_NS: u64 = 0;

/// What the image of a row shows, with its stamp as capture time.
///
/// # Errors
/// A picture that cannot be read or has not the size that the rig states.
pub fn observation(
    finder: &mut TagFinder<'_>,
    row: &Row,
    rig: &Rig,
) -> anyhow::Result<ImageObservation> {
    let detected;
    let tags = match &row.frame {
        Frame::Detections(tags) => tags,
        Frame::Picture(path) => {
            let camera = rig.camera(&row.camera).context("an unknown camera")?;
            detected = detect(finder, path, camera)?;
            &detected
        }
    };
    Ok(ImageObservation {
        camera: row.camera.clone(),
        capture_ns: row.capture_ns,
        clock_error_ns: ImageObservation::CLOCK_ERROR_UNKNOWN,
        exposure_ns: EXPOSURE_UNKNOWN_NS,
        tags: tags.iter().map(corners_of).collect(),
    })
}

fn detect(
    finder: &mut TagFinder<'_>,
    path: &Path,
    camera: &Camera,
) -> anyhow::Result<Vec<DetectedTag>> {
    let picture = read_picture(path)?;
    let [width, height] = camera.resolution.map(|pixels| pixels as usize);
    ensure!(
        (picture.width, picture.height) == (width, height),
        "{}: {}x{} pixels, but {width}x{height} are those of camera \"{}\"; give the rig of these images, or take this one away",
        path.display(),
        picture.width,
        picture.height,
        camera.id
    );
    let image = image_of(&picture).with_context(|| path.display().to_string())?;
    Ok(detected_tags(&finder.find(&image)?))
}

fn corners_of(tag: &DetectedTag) -> TagCorners {
    let point = |[x, y]: [f32; 2]| Point2::new(f64::from(x), f64::from(y));
    // Zero means unknown noise.
    let variance = tag.sigma_px.map_or(0.0, |sigma| f64::from(sigma).powi(2));
    let round = Matrix2::from_diagonal_element(variance);
    let stated = tag.corner_covariance.map(|corners| {
        corners.map(|stated| {
            let [xx, xy, yy] = stated.map(f64::from);
            Matrix2::new(xx, xy, xy, yy)
        })
    });
    TagCorners {
        tag: TagId {
            family: tag.family,
            id: tag.id,
        },
        corners: tag.corners.map(point),
        corner_covariance: stated.unwrap_or([round; 4]),
        corner_cross_covariance: tag
            .corner_cross_covariance
            .unwrap_or_default()
            .map(|cross| Matrix2::from_row_slice(&cross.map(f64::from))),
    }
}
