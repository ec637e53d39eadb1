//! The stages of one detection as pictures, their counts and times as JSON.
//!
//! Everything comes from the detector itself, through its observer: there is no second pipeline that could differ.

mod close_ups;
mod pictures;
mod record;
mod summary;
mod tag_line;

pub use tag_line::TagLine;

use record::{Record, Stopwatch};
use sextant_apriltag::{Detection, Detector, Image, ImageError, Options, OptionsError, Report};
use sextant_drawing::Canvas;
use sextant_recordings::{GreyImage, RecordingError, read_picture, write_colour_png};
use sextant_replay::image_of;
use sextant_site_files::{FileError, write_atomically};
use std::path::{Path, PathBuf};
use std::{fs, io};
use summary::{Subject, Summary};

/// Why a detection is not explained.
#[derive(Debug, thiserror::Error)]
pub enum ExplainError {
    /// The file is no picture, or one of the pictures cannot be written.
    #[error(transparent)]
    Picture(#[from] RecordingError),
    /// The detector does not take images of this size.
    #[error("{}: {cause}", path.display())]
    Image {
        /// The picture.
        path: PathBuf,
        /// The detector's reason.
        cause: ImageError,
    },
    /// The detector refuses the options.
    #[error(transparent)]
    Options(#[from] OptionsError),
    /// The folder cannot be made.
    #[error("{}: no folder can be made there; name another one", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The report cannot be written.
    #[error(transparent)]
    Report(#[from] FileError),
    /// The report has numbers that JSON lacks.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

/// One image and all that is known of its detection.
#[derive(Debug)]
pub struct Explanation {
    path: PathBuf,
    picture: GreyImage,
    report: Report,
    record: Record,
    times: Stopwatch,
    detections: Vec<Detection>,
}

impl Explanation {
    /// Detects the tags in a picture's file. Times are those of the run of median length among `reps`, which is at
    /// least 1.
    ///
    /// # Errors
    /// A file that is no picture, a size or options that the detector does not take.
    pub fn explain(path: &Path, options: &Options, reps: u32) -> Result<Self, ExplainError> {
        let picture = read_picture(path)?;
        let image = image_of(&picture).map_err(|cause| ExplainError::Image {
            path: path.to_owned(),
            cause,
        })?;
        let mut detector = Detector::new(options.clone())?;
        let mut record = Record::default();
        let detections = detector.detect_observed(&image, &mut record).to_vec();
        record.sort();
        Ok(Self {
            path: path.to_owned(),
            times: timed(&mut detector, &image, reps.max(1)),
            report: detector.report().clone(),
            record,
            detections,
            picture,
        })
    }

    /// Tags that the detector found in the picture.
    pub fn detections(&self) -> &[Detection] {
        &self.detections
    }

    /// Time of all stages, ms.
    pub fn total_ms(&self) -> f64 {
        self.times.total_ms()
    }

    /// Writes the pictures and `report.json` into a folder, which is made if need be.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn write(&self, out: &Path) -> Result<(), ExplainError> {
        fs::create_dir_all(out).map_err(|source| ExplainError::Folder {
            path: out.to_owned(),
            source,
        })?;
        for (name, canvas) in self.pictures() {
            write_colour_png(&out.join(name), canvas.image())?;
        }
        let subject = Subject {
            file: self.path.display().to_string(),
            width: self.picture.width,
            height: self.picture.height,
        };
        let summary = Summary::new(
            subject,
            &self.report,
            &self.record,
            &self.times,
            &self.detections,
        );
        let text = serde_json::to_string_pretty(&summary)? + "\n";
        write_atomically(&out.join("report.json"), text.as_bytes())?;
        Ok(())
    }

    /// By file name, in the order of the stages.
    fn pictures(&self) -> Vec<(String, Canvas)> {
        let (picture, record) = (&pictures::brightened(&self.picture), &self.record);
        let mut pictures = Vec::new();
        for pass in &record.passes {
            let name = |stage: &str| format!("{stage}-{}.png", pass.name());
            pictures.push((name("1-threshold"), pictures::threshold(picture, pass)));
            pictures.push((name("2-components"), pictures::components(picture, pass)));
        }
        let whole = [
            ("3-quads.png", pictures::quads(picture, record)),
            ("4-rejected.png", pictures::rejected(picture, record)),
            ("5-corners.png", close_ups::corners(picture, record)),
            ("6-tags.png", pictures::tags(picture, &self.detections)),
        ];
        pictures.extend(whole.map(|(name, canvas)| (name.to_owned(), canvas)));
        pictures
    }
}

/// The run of median length.
fn timed(detector: &mut Detector, image: &Image<'_>, reps: u32) -> Stopwatch {
    let run = |_| {
        let mut stopwatch = Stopwatch::start();
        detector.detect_observed(image, &mut stopwatch);
        stopwatch
    };
    let mut runs: Vec<Stopwatch> = (0..reps).map(run).collect();
    runs.sort_by(|a, b| a.total_ms().total_cmp(&b.total_ms()));
    runs.swap_remove(runs.len() / 2)
}
