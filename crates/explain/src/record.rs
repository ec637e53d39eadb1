//! Events and stage times of one detection.

use sextant_apriltag::{Detection, Observer, Pass, Rejection, Stage};
use std::time::Instant;

/// Four points of the picture, pixels.
pub type Quad = [[f32; 2]; 4];

/// Events of all passes.
#[derive(Debug, Default)]
pub struct Record {
    /// One after the other.
    pub passes: Vec<PassRecord>,
    /// Corners before the fit, and the tag with those after it, by family and id.
    pub refined: Vec<(Quad, Detection)>,
}

/// Events of one pass.
#[derive(Debug)]
pub struct PassRecord {
    /// What it looked for.
    pub pass: Pass,
    /// Pixels of the border's colour: column and row, component.
    pub pixels: Vec<([u16; 2], u32)>,
    /// Quads around candidates.
    pub quads: Vec<Quad>,
    /// Candidates that were no tag.
    pub rejected: Vec<(Rejection, Quad)>,
}

impl PassRecord {
    /// Name of the pass in file names and reports.
    pub fn name(&self) -> &'static str {
        match self.pass {
            Pass::Black => "black",
            Pass::Middle => "black-middle",
            Pass::Eroded => "black-eroded",
            Pass::White => "white",
        }
    }
}

impl Record {
    /// In the order of the detections.
    pub fn sort(&mut self) {
        self.refined.sort_by_key(|(_, tag)| (tag.family, tag.id));
    }

    /// Candidates of all passes that were no tag, with the reasons.
    pub fn rejected(&self) -> impl Iterator<Item = &(Rejection, Quad)> {
        self.passes.iter().flat_map(|pass| &pass.rejected)
    }
}

impl Observer for Record {
    fn pass_began(&mut self, pass: Pass) {
        self.passes.push(PassRecord {
            pass,
            pixels: Vec::new(),
            quads: Vec::new(),
            rejected: Vec::new(),
        });
    }

    fn labelled(&mut self, pixels: impl Iterator<Item = ([u16; 2], u32)>) {
        if let Some(pass) = self.passes.last_mut() {
            pass.pixels.extend(pixels);
        }
    }

    fn quad_found(&mut self, corners: &Quad) {
        if let Some(pass) = self.passes.last_mut() {
            pass.quads.push(*corners);
        }
    }

    fn rejected(&mut self, reason: Rejection, corners: &Quad) {
        if let Some(pass) = self.passes.last_mut() {
            pass.rejected.push((reason, *corners));
        }
    }

    fn refined(&mut self, before: &Quad, tag: &Detection) {
        self.refined.push((*before, *tag));
    }
}

/// Takes the time at the end of each stage.
#[derive(Debug)]
pub struct Stopwatch {
    last: Instant,
    /// Milliseconds of each stage over all passes, in the order of [`Stage::ALL`].
    pub stage_ms: [f64; Stage::ALL.len()],
}

impl Stopwatch {
    /// Begins the first stage.
    pub fn start() -> Self {
        Self {
            last: Instant::now(),
            stage_ms: [0.0; Stage::ALL.len()],
        }
    }

    /// Of all stages together, milliseconds.
    pub fn total_ms(&self) -> f64 {
        self.stage_ms.iter().sum()
    }
}

impl Observer for Stopwatch {
    fn stage_ended(&mut self, stage: Stage) {
        let now = Instant::now();
        self.stage_ms[stage as usize] += (now - self.last).as_secs_f64() * 1e3;
        self.last = now;
    }
}
