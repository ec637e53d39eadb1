//! A recorded image as the estimator takes it: detections as they are, pictures through the detector first.

use crate::finder::{NothingSought, TagFinder, detected_tags, image_of};
use nalgebra::{Matrix2, Point2};
use sextant_apriltag::ImageError;
use sextant_recordings::{DetectedTag, Frame, RecordingError, Row, read_picture};
use sextant_site_model::{Camera, CameraId, ImageObservation, Rig, TagCorners, TagId};
use std::path::{Path, PathBuf};

/// Recordings say nothing of their images' exposures.
pub(crate) const EXPOSURE_UNKNOWN_NS: u64 = 0;

/// Why a recorded image cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ObservationError {
    /// The rig has no such camera.
    #[error("an unknown camera")]
    UnknownCamera,
    /// The picture cannot be read.
    #[error(transparent)]
    Picture(#[from] RecordingError),
    /// The picture has another size than the camera's.
    #[error(
        "{}: {}x{} pixels, but {}x{} are those of camera \"{camera}\"; {}",
        path.display(), size[0], size[1], expected[0], expected[1], remedy(*size, *expected)
    )]
    Size {
        /// The picture.
        path: PathBuf,
        /// Its width and height, px.
        size: [usize; 2],
        /// Width and height of the camera's images, px.
        expected: [usize; 2],
        /// The camera.
        camera: CameraId,
    },
    /// The detector does not take images of this size.
    #[error("{}: {cause}", path.display())]
    Image {
        /// The picture.
        path: PathBuf,
        /// The detector's reason.
        cause: ImageError,
    },
    /// There is nothing to look for.
    #[error(transparent)]
    NothingSought(#[from] NothingSought),
}

/// What the image of a row shows, with its stamp as capture time.
///
/// # Errors
/// A picture that cannot be read or has not the size that the rig states.
pub fn observation(
    finder: &mut TagFinder<'_>,
    row: &Row,
    rig: &Rig,
) -> Result<ImageObservation, ObservationError> {
    let detected;
    let tags = match &row.frame {
        Frame::Detections(tags) => tags,
        Frame::Picture(path) => {
            let camera = rig
                .camera(&row.camera)
                .ok_or(ObservationError::UnknownCamera)?;
            detected = detect(finder, path, camera)?;
            &detected
        }
    };
    Ok(ImageObservation {
        camera: row.camera.clone(),
        capture_ns: row.capture_ns,
        clock_error_ns: ImageObservation::CLOCK_ERROR_UNKNOWN,
        exposure_ns: EXPOSURE_UNKNOWN_NS,
        resolution: None,
        tags: tags.iter().map(corners_of).collect(),
    })
}

/// What to do about a picture of another size.
fn remedy([width, height]: [usize; 2], expected: [usize; 2]) -> &'static str {
    match [height, width] == expected {
        true => {
            "it was taken upright and others across: hold the camera one way for all, or take this one away"
        }
        false => "give the rig of these images, or take this one away",
    }
}

fn detect(
    finder: &mut TagFinder<'_>,
    path: &Path,
    camera: &Camera,
) -> Result<Vec<DetectedTag>, ObservationError> {
    let picture = read_picture(path)?;
    let expected = camera.resolution.map(|pixels| pixels as usize);
    if [picture.width, picture.height] != expected {
        return Err(ObservationError::Size {
            path: path.to_owned(),
            size: [picture.width, picture.height],
            expected,
            camera: camera.id.clone(),
        });
    }
    let image = image_of(&picture).map_err(|cause| ObservationError::Image {
        path: path.to_owned(),
        cause,
    })?;
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
