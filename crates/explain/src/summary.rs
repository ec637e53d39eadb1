//! `report.json`: counts and times of the stages.

use crate::TagLine;
use crate::record::{PassRecord, Record, Stopwatch};
use serde::Serialize;
use sextant_apriltag::{Detection, Rejection, Report, Stage};
use std::collections::BTreeMap;

/// Contents of `report.json`: stages, candidates and tags of one picture.
#[derive(Serialize)]
pub struct Summary {
    file: String,
    width: usize,
    height: usize,
    ms: f64,
    stages: Vec<StageTime>,
    noise_sigma: f32,
    contrast_gate: u8,
    counts: Counts,
    rejected: BTreeMap<&'static str, u32>,
    passes: Vec<PassCounts>,
    detections: Vec<TagLine>,
}

#[derive(Serialize)]
struct StageTime {
    stage: &'static str,
    ms: f64,
}

#[derive(Serialize)]
struct Counts {
    runs: u32,
    components: u32,
    candidates: u32,
    quads: u32,
    dropped: u32,
    detections: u32,
}

#[derive(Serialize)]
struct PassCounts {
    name: &'static str,
    pixels: usize,
    quads: usize,
    rejected: usize,
}

/// An image by name and size.
pub struct Subject {
    /// Its file.
    pub file: String,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Summary {
    /// Summary of one image.
    pub fn new(
        subject: Subject,
        report: &Report,
        record: &Record,
        times: &Stopwatch,
        detections: &[Detection],
    ) -> Self {
        let ms = |ms: f64| (ms * 1e4).round() / 1e4;
        let stage_time = |(stage, time): (&Stage, f64)| StageTime {
            stage: stage_name(*stage),
            ms: ms(time),
        };
        let stages = Stage::ALL.iter().zip(times.stage_ms).map(stage_time);
        let rejected = |reason: &Rejection| (reason_name(*reason), report.rejected_for(*reason));
        Self {
            file: subject.file,
            width: subject.width,
            height: subject.height,
            ms: ms(times.total_ms()),
            stages: stages.collect(),
            noise_sigma: report.noise_sigma,
            contrast_gate: report.contrast_gate,
            counts: Counts::from(report),
            rejected: Rejection::ALL.iter().map(rejected).collect(),
            passes: record.passes.iter().map(PassCounts::from).collect(),
            detections: detections.iter().map(TagLine::from).collect(),
        }
    }
}

impl From<&Report> for Counts {
    fn from(report: &Report) -> Self {
        Self {
            runs: report.runs,
            components: report.components,
            candidates: report.candidates,
            quads: report.quads,
            dropped: report.dropped,
            detections: report.detections,
        }
    }
}

impl From<&PassRecord> for PassCounts {
    fn from(pass: &PassRecord) -> Self {
        Self {
            name: pass.name(),
            pixels: pass.pixels.len(),
            quads: pass.quads.len(),
            rejected: pass.rejected.len(),
        }
    }
}

fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Tiles => "tiles",
        Stage::Threshold => "threshold",
        Stage::Components => "components",
        Stage::Quads => "quads",
        Stage::Decode => "decode",
        Stage::Refine => "refine",
    }
}

fn reason_name(reason: Rejection) -> &'static str {
    match reason {
        Rejection::NotAQuad => "not-a-quad",
        Rejection::Shape => "shape",
        Rejection::FaintBorder => "faint-border",
        Rejection::NoCode => "no-code",
        Rejection::SmallMargin => "small-margin",
    }
}
