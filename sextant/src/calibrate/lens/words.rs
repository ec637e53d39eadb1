//! Text report of a lens calibration.

use crate::words;
use sextant_calibrator::procedure::LensReport;
use std::path::Path;

/// Of a calibration whose lens went into this file.
pub fn text(report: &LensReport, rig: &Path) -> String {
    let mut lines = Vec::new();
    let names = ["fx", "fy", "cx", "cy"];
    let values = report.lens.parameters();
    for (at, (value, sigma)) in values.iter().zip(&report.sigmas).enumerate() {
        lines.push(match names.get(at) {
            Some(name) => format!("{name:<4} {value:>10.3} +- {sigma:.3} px"),
            None => format!(
                "{:<4} {value:>10.6} +- {sigma:.6}",
                coefficient(report, at - 4)
            ),
        });
    }
    if report.models.len() > 1 {
        let models = report.models.iter();
        let models = models.map(|m| format!("{} {:.3} px", m.model, m.held_out_rms_px));
        let models: Vec<String> = models.collect();
        lines.push(format!(
            "images not fitted to are off by: {}",
            models.join(", ")
        ));
    }
    if !report.suspicious.is_empty() {
        let tags: Vec<String> = report.suspicious.iter().map(ToString::to_string).collect();
        lines.push(format!(
            "{}: seen elsewhere than the board says, or twice; is there a second one in the room?",
            tags.join(", ")
        ));
    }
    if report.alike > 0 {
        lines.push(format!(
            "{} were left out, since they show the board much as others do (of {} images or \
             fewer all are used); {} show too little of it",
            words::count(report.alike, "image"),
            super::MANY,
            report.without_board
        ));
    }
    lines.push(format!(
        "{}: camera {}, {}, {} of {} images, {} tags ({} left out), {:.3} px rms, uncertain by {:.3} px; {}",
        rig.display(),
        report.camera,
        report.lens.model(),
        report.views,
        report.images,
        report.tags,
        report.wrong_tags,
        report.rms_px,
        report.uncertainty_px.mean,
        report.verdict
    ));
    lines.join("\n")
}

fn coefficient(report: &LensReport, at: usize) -> &'static str {
    let names: &[&str] = match report.lens.distortion().len() {
        5 => &["k1", "k2", "p1", "p2", "k3"],
        _ => &["k1", "k2", "k3", "k4"],
    };
    names.get(at).copied().unwrap_or_default()
}
