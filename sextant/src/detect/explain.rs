//! `detect --explain`: the stages of one detection as pictures, their counts and times as JSON.
//!
//! Everything comes from the detector itself, through its observer: there is no second pipeline that could differ.

mod close_ups;
mod pictures;
mod record;
mod summary;

use super::sight::DetectedImage;
use anyhow::Context;
use record::{Record, Stopwatch};
use sextant_apriltag::{Detection, Detector, Image, Options, Report};
use sextant_drawing::Canvas;
use sextant_process::{Exit, WithExit};
use sextant_recordings::{GreyImage, read_picture, write_colour_png};
use sextant_replay::image_of;
use sextant_site_files::write_atomically;
use std::fs;
use std::path::Path;
use summary::{Subject, Summary};

/// One image and all that is known of its detection.
struct Explanation {
    picture: GreyImage,
    report: Report,
    record: Record,
    times: Stopwatch,
    detections: Vec<Detection>,
}

/// Explains the detection in a picture's file with files in the folder `out`, which is made if need be. Times are those of the
/// run of median length among `reps`.
///
/// # Errors
/// [`Exit::Input`] for a file that is no picture, a size that the detector does not take, a folder that can't be written.
pub fn explain(
    path: &Path,
    out: &Path,
    options: &Options,
    reps: u32,
) -> anyhow::Result<DetectedImage> {
    let explanation = Explanation::of(path, options, reps).exit_with(Exit::Input)?;
    explanation.write(path, out).exit_with(Exit::Input)?;
    Ok(DetectedImage {
        path: path.to_owned(),
        ms: explanation.times.total_ms(),
        detections: explanation.detections,
        tracking: None,
    })
}

impl Explanation {
    fn of(path: &Path, options: &Options, reps: u32) -> anyhow::Result<Self> {
        let picture = read_picture(path)?;
        let image = image_of(&picture).with_context(|| path.display().to_string())?;
        let mut detector = Detector::new(options.clone())?;
        let mut record = Record::default();
        let detections = detector.detect_observed(&image, &mut record).to_vec();
        record.sort();
        Ok(Self {
            times: timed(&mut detector, &image, reps),
            report: detector.report().clone(),
            record,
            detections,
            picture,
        })
    }

    fn write(&self, path: &Path, out: &Path) -> anyhow::Result<()> {
        fs::create_dir_all(out).with_context(|| {
            format!(
                "{}: no folder can be made there; name another one",
                out.display()
            )
        })?;
        for (name, canvas) in self.pictures() {
            write_colour_png(&out.join(name), canvas.image())?;
        }
        let subject = Subject {
            file: path.display().to_string(),
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
