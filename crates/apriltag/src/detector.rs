//! The pipeline.

use crate::bit_plane::BitPlane;
use crate::components::{Components, make_room};
use crate::kernels::Kernels;
use crate::outlines::Outlines;
use crate::photometric::PatternFitter;
use crate::quad::QuadFinder;
use crate::reading::Reader;
use crate::sighting::{Sighting, sight};
use crate::tiles::{Level, Pass, Tiles};
use crate::{Detection, Image, Observer, Options, OptionsError, Refinement, Report, Stage};
use sextant_tag_families::BorderColour;

/// Tags in an image before those seen twice are sorted out, at most; the report counts what is dropped.
const MAX_SIGHTINGS: usize = 1024;

/// How black and white are told apart, one after the other.
const PASSES: [Pass; 3] = [
    Pass {
        border: BorderColour::Black,
        level: Level::Middle,
    },
    Pass {
        border: BorderColour::Black,
        level: Level::Shaded,
    },
    Pass {
        border: BorderColour::White,
        level: Level::Middle,
    },
];

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
    patterns: PatternFitter,
    sightings: Vec<Sighting>,
    detections: Vec<Detection>,
    report: Report,
}

impl Detector {
    /// Checks the options and prepares the families' tables.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        options.check()?;
        let kernels = Kernels::fastest();
        Ok(Self {
            readers: options
                .families
                .iter()
                .map(|&family| Reader::new(family, &options))
                .collect(),
            options,
            kernels,
            size: (0, 0),
            tiles: Tiles::default(),
            plane: BitPlane::default(),
            components: Components::default(),
            outlines: Outlines::default(),
            quads: QuadFinder::default(),
            patterns: PatternFitter::new(kernels),
            sightings: Vec::new(),
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
        for pass in PASSES {
            if !self.is_worth_while(pass) {
                continue;
            }
            observer.pass_began(pass);
            self.plane
                .threshold(image, &self.tiles, pass, &self.kernels);
            observer.stage_ended(Stage::Threshold);
            self.components.label(&self.plane);
            observer.stage_ended(Stage::Components);
            self.outlines
                .trace(&mut self.components, self.options.min_edge_px);
            observer.labelled(self.components.labelled_runs());
            observer.stage_ended(Stage::Quads);
            self.read_outlines(image, pass.border, observer);
            observer.stage_ended(Stage::Decode);
        }
        self.drop_doubles();
        self.locate(image, observer);
        observer.stage_ended(Stage::Refine);
        &self.detections
    }

    /// Whether a pass can show a tag of the families that are looked for.
    fn is_worth_while(&mut self, pass: Pass) -> bool {
        let wanted = self
            .readers
            .iter()
            .any(|reader| reader.border() == pass.border);
        wanted && (pass.level == Level::Middle || self.tiles.find_shade())
    }

    fn begin(&mut self, image: &Image<'_>) {
        self.make_room(image.width(), image.height());
        self.sightings.clear();
        self.detections.clear();
        self.tiles.measure(image, &self.kernels);
        let noise_sigma = self.tiles.noise_sigma();
        let gate = (noise_sigma * self.options.min_contrast_in_sigma).min(64.0) as u8;
        let contrast_gate = gate.max(self.options.min_contrast);
        self.tiles.set_gate(contrast_gate);
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
        make_room(&mut self.sightings, MAX_SIGHTINGS);
        make_room(&mut self.detections, MAX_SIGHTINGS);
    }

    fn read_outlines(
        &mut self,
        image: &Image<'_>,
        border: BorderColour,
        observer: &mut impl Observer,
    ) {
        self.report.components += self.outlines.n_components();
        self.report.runs += self.components.n_runs() as u32;
        self.report.dropped += self.outlines.n_dropped();
        let n_known = self.sightings.len();
        for (outline, extents) in self.outlines.iter() {
            let middle = outline.component.middle();
            if self.sightings[..n_known]
                .iter()
                .any(|known| known.covers(middle))
            {
                continue;
            }
            self.report.candidates += 1;
            let quad = self
                .quads
                .around(outline, extents, self.options.min_edge_px);
            if let Ok(quad) = &quad {
                self.report.quads += 1;
                observer.quad_found(quad);
            }
            match quad.and_then(|quad| sight(image, &quad, border, &self.readers, &self.options)) {
                Ok(sighting) if self.sightings.len() < MAX_SIGHTINGS => {
                    self.sightings.push(sighting)
                }
                Ok(_) => self.report.dropped += 1,
                Err(reason) => {
                    self.report.rejected[reason as usize] += 1;
                    observer.rejected(reason, &quad.unwrap_or(outline.component.corners()));
                }
            }
        }
    }

    /// Of the same tag seen twice, the sighting with fewer wrong bits, then the larger margin, stands.
    fn drop_doubles(&mut self) {
        self.sightings.sort_unstable_by(|a, b| {
            let (a, b) = (&a.reading, &b.reading);
            a.found
                .hamming
                .cmp(&b.found.hamming)
                .then(b.margin.total_cmp(&a.margin))
        });
        let mut kept = 0;
        for i in 0..self.sightings.len() {
            let sighting = self.sightings[i];
            if !self.sightings[..kept]
                .iter()
                .any(|other| other.is_same_tag(&sighting))
            {
                self.sightings[kept] = sighting;
                kept += 1;
            }
        }
        self.sightings.truncate(kept);
    }

    /// Corners below the pixel for every sighting; detections in order.
    fn locate(&mut self, image: &Image<'_>, observer: &mut impl Observer) {
        for sighting in &self.sightings {
            let patterns =
                (self.options.refinement == Refinement::Photometric).then_some(&mut self.patterns);
            let detection = sighting.refine(image, patterns);
            observer.refined(&sighting.quad, &detection);
            self.detections.push(detection);
        }
        self.detections.sort_unstable_by(|a, b| {
            let ([ax, ay], [bx, by]) = (a.centre(), b.centre());
            (a.family, a.id)
                .cmp(&(b.family, b.id))
                .then(ay.total_cmp(&by))
                .then(ax.total_cmp(&bx))
        });
        self.report.detections = self.detections.len() as u32;
    }

    /// What happened to the last image.
    pub fn report(&self) -> &Report {
        &self.report
    }
}
