//! Output of `detect` for one image.

use super::sight::DetectedImage;
use crate::output::Format;
use crate::words;
use serde::Serialize;
use sextant_apriltag::{Detection, TrackingReport};
use sextant_explain::TagLine;
use std::fmt::Write;

#[derive(Serialize)]
struct Line<'a> {
    file: &'a str,
    ms: f64,
    detections: Vec<TagLine>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tracking: Option<TrackingLine>,
}

/// Searched areas of an image.
#[derive(Serialize)]
struct TrackingLine {
    areas: u32,
    share: f32,
    followed: u32,
    discovered: u32,
    awaited: u32,
}

impl From<TrackingReport> for TrackingLine {
    fn from(report: TrackingReport) -> Self {
        let TrackingReport {
            areas,
            share,
            followed,
            discovered,
            awaited,
        } = report;
        Self {
            areas,
            share,
            followed,
            discovered,
            awaited,
        }
    }
}

/// The line, or in text the lines, of a picture.
pub fn line(sight: &DetectedImage, format: Format) -> String {
    match format {
        Format::Json => json(sight),
        Format::Text => text(sight),
    }
}

fn json(sight: &DetectedImage) -> String {
    let line = Line {
        file: &sight.path.to_string_lossy(),
        ms: (sight.ms * 1e4).round() / 1e4,
        detections: sight.detections.iter().map(TagLine::from).collect(),
        tracking: sight.tracking.map(TrackingLine::from),
    };
    // Numbers and names: there is nothing that JSON could refuse.
    serde_json::to_string(&line).unwrap_or_default()
}

fn text(sight: &DetectedImage) -> String {
    let tags = words::count(sight.detections.len(), "tag");
    let mut text = format!("{}: {tags}, {:.2} ms", sight.path.display(), sight.ms);
    if let Some(report) = &sight.tracking {
        let _ = write!(
            text,
            ", {:.0} % of the picture searched, {} followed, {} discovered, {} awaited",
            report.share * 100.0,
            report.followed,
            report.discovered,
            report.awaited
        );
    }
    for detection in &sight.detections {
        let [x, y] = detection.centre();
        // Writing to a String cannot fail.
        let _ = write!(
            text,
            "\n  {} {:>4}  at {x:7.1} {y:7.1}  edge {:6.1} px  hamming {}  margin {:5.1}",
            detection.family,
            detection.id,
            edge(detection),
            detection.hamming,
            detection.margin
        );
    }
    text
}

/// Mean length of the four edges, pixels.
fn edge(detection: &Detection) -> f32 {
    let corners = &detection.corners;
    let length = |k: usize| {
        let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % 4]);
        (x1 - x0).hypot(y1 - y0)
    };
    (0..4).map(length).sum::<f32>() / 4.0
}
