//! The pipeline.

use crate::bit_plane::BitPlane;
use crate::components::{Components, make_room};
use crate::edges::{self, EdgeFit};
use crate::kernels::Kernels;
use crate::outlines::Outlines;
use crate::photometric;
use crate::quad::{Quad, QuadFinder, mean_edge};
use crate::reading::{Reader, Reading, check_sides};
use crate::tiles::{Level, Tiles};
use crate::{
    Detection, Image, Observer, Options, OptionsError, Refinement, Rejection, Report, Stage,
};
use sextant_tag_families::BorderColour;

/// Tags in an image before those found twice are sorted out, at most; the report counts what is dropped.
const MAX_DETECTIONS: usize = 1024;

/// Finds tags, image after image; keeps its memory between images.
#[derive(Debug)]
pub struct Detector {
    options: Options,
    readers: Vec<Reader>,
    kernels: Kernels,
    /// Width and height of the last image.
    size: (usize, usize),
    tiles: Tiles,
    plane: BitPlane,
    components: Components,
    outlines: Outlines,
    quads: QuadFinder,
    detections: Vec<Detection>,
    report: Report,
}

impl Detector {
    /// Checks the options and prepares the families' tables.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        options.check()?;
        Ok(Self {
            readers: options
                .families
                .iter()
                .map(|&family| Reader::new(family, &options))
                .collect(),
            options,
            kernels: Kernels::fastest(),
            size: (0, 0),
            tiles: Tiles::default(),
            plane: BitPlane::default(),
            components: Components::default(),
            outlines: Outlines::default(),
            quads: QuadFinder::default(),
            detections: Vec::new(),
            report: Report::default(),
        })
    }

    /// The tags in an image, sorted by family, id and centre.
    pub fn detect(&mut self, image: &Image<'_>) -> &[Detection] {
        self.detect_observed(image, &mut ())
    }

    /// Like [`Self::detect`], telling an observer what happens.
    pub fn detect_observed(
        &mut self,
        image: &Image<'_>,
        observer: &mut impl Observer,
    ) -> &[Detection] {
        self.begin(image);
        observer.stage_ended(Stage::Tiles);
        for level in [Level::Middle, Level::Shaded] {
            self.plane.threshold(
                image,
                &self.tiles,
                self.report.contrast_gate,
                level,
                &self.kernels,
            );
            observer.stage_ended(Stage::Threshold);
            self.components.label(&self.plane);
            observer.stage_ended(Stage::Components);
            self.outlines
                .trace(&mut self.components, self.options.min_edge_px);
            observer.stage_ended(Stage::Quads);
            self.read_outlines(image, observer);
            observer.stage_ended(Stage::Decode);
        }
        self.sort();
        observer.stage_ended(Stage::Refine);
        &self.detections
    }

    fn begin(&mut self, image: &Image<'_>) {
        self.make_room(image.width(), image.height());
        self.detections.clear();
        self.tiles.measure(image, &self.kernels);
        let noise_sigma = self.tiles.noise_sigma();
        let gate = (noise_sigma * self.options.min_contrast_in_sigma).min(64.0) as u8;
        let contrast_gate = gate.max(self.options.min_contrast);
        self.report = Report {
            noise_sigma,
            contrast_gate,
            ..Report::default()
        };
    }

    /// All memory that an image of this size can ask for, when the size is new.
    fn make_room(&mut self, width: usize, height: usize) {
        if self.size == (width, height) {
            return;
        }
        self.size = (width, height);
        self.tiles.make_room(width, height);
        self.plane.make_room(width, height);
        self.components.make_room(width, height);
        self.outlines
            .make_room(self.components.max_labels(), height);
        self.quads.make_room(height);
        make_room(&mut self.detections, MAX_DETECTIONS);
    }

    fn read_outlines(&mut self, image: &Image<'_>, observer: &mut impl Observer) {
        self.report.components += self.components.whole().count() as u32;
        self.report.runs += self.components.n_runs() as u32;
        self.report.dropped += self.outlines.n_dropped();
        for (outline, extents) in self.outlines.iter() {
            self.report.candidates += 1;
            let quad = self
                .quads
                .around(outline, extents, self.options.min_edge_px);
            let read = quad.and_then(|quad| read_tag(image, &quad, &self.readers, &self.options));
            match read {
                Ok(detection) if self.detections.len() < MAX_DETECTIONS => {
                    self.detections.push(detection)
                }
                Ok(_) => self.report.dropped += 1,
                Err(reason) => {
                    self.report.rejected[reason as usize] += 1;
                    if let Ok(quad) = quad {
                        observer.rejected(reason, &quad);
                    }
                }
            }
        }
    }

    /// In order, and each tag once: the reading with fewer wrong bits, then the larger margin, stands.
    fn sort(&mut self) {
        let key = |d: &Detection| (d.family, d.id);
        self.detections.sort_unstable_by(|a, b| {
            key(a)
                .cmp(&key(b))
                .then(a.hamming.cmp(&b.hamming))
                .then(b.margin.total_cmp(&a.margin))
        });
        let mut kept = 0;
        for i in 0..self.detections.len() {
            let detection = self.detections[i];
            if !self.detections[..kept]
                .iter()
                .any(|other| is_same_tag(other, &detection))
            {
                self.detections[kept] = detection;
                kept += 1;
            }
        }
        self.detections.truncate(kept);
        self.detections.sort_unstable_by(|a, b| {
            let ([ax, ay], [bx, by]) = (a.centre(), b.centre());
            key(a)
                .cmp(&key(b))
                .then(ay.total_cmp(&by))
                .then(ax.total_cmp(&bx))
        });
        self.report.detections = kept as u32;
    }

    /// What happened to the last image.
    pub fn report(&self) -> &Report {
        &self.report
    }
}

fn is_same_tag(a: &Detection, b: &Detection) -> bool {
    let ([ax, ay], [bx, by]) = (a.centre(), b.centre());
    a.family == b.family && a.id == b.id && (ax - bx).hypot(ay - by) < mean_edge(&a.corners) / 2.0
}

fn read_tag(
    image: &Image<'_>,
    quad: &Quad,
    readers: &[Reader],
    options: &Options,
) -> Result<Detection, Rejection> {
    check_sides(image, quad, BorderColour::Black, options.min_contrast)?;
    let fit = refine_edges(image, quad).ok_or(Rejection::Shape)?;
    let mut reason = Rejection::NoCode;
    for reader in readers {
        for quad in [&fit.quad, quad] {
            match reader.read(image, quad) {
                Ok(reading) => return Ok(locate(image, &reading, &fit, options)),
                Err(why) => reason = why,
            }
        }
    }
    Err(reason)
}

fn refine_edges(image: &Image<'_>, quad: &Quad) -> Option<EdgeFit> {
    let module_px = mean_edge(quad) / 8.0;
    let coarse = edges::fit(
        image,
        quad,
        BorderColour::Black,
        (0.75 * module_px).clamp(1.5, 4.0),
    )?;
    let fine = edges::fit(image, &coarse.quad, BorderColour::Black, 2.0)?;
    Some(fine)
}

/// The tag as the edges show it, then as its whole pattern does where that fits.
fn locate(image: &Image<'_>, reading: &Reading, fit: &EdgeFit, options: &Options) -> Detection {
    let mut edges = *fit;
    edges.quad.rotate_left(reading.found.turns as usize);
    edges.covariance.rotate_left(reading.found.turns as usize);
    let pattern = match options.refinement {
        Refinement::Edges => None,
        Refinement::Photometric => photometric::fit(image, reading, &edges),
    };
    let (corners, corner_covariance, refinement) = match pattern {
        Some(fit) => (fit.corners, fit.covariance, Refinement::Photometric),
        None => (edges.quad, edges.covariance, Refinement::Edges),
    };
    Detection {
        family: reading.family,
        id: reading.found.id,
        hamming: reading.found.hamming as u8,
        margin: reading.margin,
        corners,
        corner_covariance,
        refinement,
    }
}
