//! What is told of a lens's calibration: to people and as JSON.

use serde::Serialize;
use sextant_calibrator::Verdict;
use sextant_calibrator::lens::{LensCalibration, LensMaps};
use sextant_estimator::{CameraId, TagId};
use sextant_geometry::Lens;
use std::path::Path;

/// As `--json` prints it.
#[derive(Serialize)]
pub struct Report {
    camera: CameraId,
    resolution: [u32; 2],
    lens: Lens,
    /// One standard deviation each of fx, fy, cx, cy and the distortion's coefficients.
    sigmas: Vec<f64>,
    rms_px: f64,
    noise_px: f64,
    images: usize,
    views: usize,
    tags: usize,
    wrong_tags: usize,
    suspicious: Vec<TagId>,
    models: Vec<Model>,
    coverage: f64,
    uncertainty_px: Uncertainty,
    cells: Vec<Vec<Cell>>,
    verdict: Verdict,
}

#[derive(Serialize)]
struct Model {
    model: &'static str,
    held_out_rms_px: f64,
}

#[derive(Serialize)]
struct Uncertainty {
    mean: f64,
    largest: f64,
}

#[derive(Serialize)]
struct Cell {
    corners: u32,
    mean_px: [f64; 2],
    rms_px: f64,
    sigma_px: Option<f64>,
}

impl Report {
    /// Of a calibration.
    pub fn of(camera: &CameraId, calibration: &LensCalibration) -> Self {
        let (mean, largest, _) = calibration.maps.uncertainty();
        let models = calibration.scores.iter().map(|score| Model {
            model: score.model.name(),
            held_out_rms_px: score.held_out_rms_px,
        });
        Self {
            camera: camera.clone(),
            resolution: calibration.resolution,
            lens: calibration.lens,
            sigmas: calibration.sigmas.clone(),
            rms_px: calibration.rms_px,
            noise_px: calibration.noise_px,
            images: calibration.images,
            views: calibration.views,
            tags: calibration.tags,
            wrong_tags: calibration.wrong_tags,
            suspicious: calibration.suspicious.clone(),
            models: models.collect(),
            coverage: calibration.maps.coverage(),
            uncertainty_px: Uncertainty { mean, largest },
            cells: cells(&calibration.maps),
            verdict: calibration.verdict.clone(),
        }
    }

    /// For people.
    pub fn text(&self, rig: &Path) -> String {
        let mut lines = Vec::new();
        let names = ["fx", "fy", "cx", "cy"];
        let values = self.lens.parameters();
        for (at, (value, sigma)) in values.iter().zip(&self.sigmas).enumerate() {
            lines.push(match names.get(at) {
                Some(name) => format!("{name:<4} {value:>10.3} +- {sigma:.3} px"),
                None => format!(
                    "{:<4} {value:>10.6} +- {sigma:.6}",
                    self.coefficient(at - 4)
                ),
            });
        }
        if self.models.len() > 1 {
            let models = self.models.iter();
            let models = models.map(|m| format!("{} {:.3} px", m.model, m.held_out_rms_px));
            let models: Vec<String> = models.collect();
            lines.push(format!(
                "images not fitted to are off by: {}",
                models.join(", ")
            ));
        }
        if !self.suspicious.is_empty() {
            let tags: Vec<String> = self.suspicious.iter().map(ToString::to_string).collect();
            lines.push(format!(
                "{}: seen elsewhere than the board says, or twice; is there a second one in the room?",
                tags.join(", ")
            ));
        }
        lines.push(format!(
            "{}: camera {}, {}, {} of {} images, {} tags ({} left out), {:.3} px rms, uncertain by {:.3} px; {}",
            rig.display(),
            self.camera,
            self.lens.model(),
            self.views,
            self.images,
            self.tags,
            self.wrong_tags,
            self.rms_px,
            self.uncertainty_px.mean,
            self.verdict
        ));
        lines.join("\n")
    }

    fn coefficient(&self, at: usize) -> &'static str {
        let names: &[&str] = match self.lens.distortion().len() {
            5 => &["k1", "k2", "p1", "p2", "k3"],
            _ => &["k1", "k2", "k3", "k4"],
        };
        names.get(at).copied().unwrap_or_default()
    }
}

fn cells(maps: &LensMaps) -> Vec<Vec<Cell>> {
    let row = |row: &Vec<sextant_calibrator::lens::MapCell>| {
        let cells = row.iter().map(|cell| Cell {
            corners: cell.corners,
            mean_px: cell.mean_px,
            rms_px: cell.rms_px,
            sigma_px: cell.sigma_px,
        });
        cells.collect()
    };
    maps.cells.iter().map(row).collect()
}
