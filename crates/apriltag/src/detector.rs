//! The detection pipeline.

use crate::area::Area;
use crate::bit_plane::BitPlane;
use crate::board_corners::{BoardFit, common_reach, extrapolate, share_corners, touch};
use crate::components::{Component, Components, make_room};
use crate::kernels::vectorise;
use crate::negative::Negative;
use crate::photometric::PatternFitter;
use crate::quad::middle;
use crate::quad_finder::{Outline, QuadFinder};
use crate::sighting::{Decoder, Sighting};
use crate::tiles::Tiles;
use crate::view::ImageView;
use crate::{
    Detection, Image, Observer, Options, OptionsError, Pass, Refinement, Rejection, Report, Stage,
};
use sextant_geometry::Lens;
use std::mem;
use std::ops::Range;

/// Most tags in an image; the report counts what is dropped.
const MAX_SIGHTINGS: usize = 1024;

/// Least contrast in dim images, in standard deviations of the noise. Noise alone rarely reaches it, so that flat dim
/// images cost no more than flat bright ones.
const DIM_IN_SIGMA: f32 = 8.0;

/// Mean distance of the edge of a border from the centres of its outermost pixels, in pixels.
const OVERHANG_PX: f32 = 0.4;

/// Shortest edge of a tag of which erosion leaves a border: with modules of three pixels.
const LEAST_ERODED_PX: f32 = 16.0;

/// An area of an image that is searched in one pass.
struct Part<'a> {
    image: &'a Image<'a>,
    area: &'a Area,
    pass: Pass,
}

/// The smallest range with both.
fn enclosing(a: &Range<u32>, b: &Range<u32>) -> Range<u32> {
    a.start.min(b.start)..a.end.max(b.end)
}

/// Detects tags in images; reuses its memory between images.
#[derive(Debug)]
pub struct Detector {
    options: Options,
    decoder: Decoder,
    negative: Negative,
    tiles: Tiles,
    /// Whether the current area is dim.
    is_dim: bool,
    plane: BitPlane,
    components: Components,
    quads: QuadFinder,
    patterns: PatternFitter,
    sightings: Vec<Sighting>,
    detections: Vec<Detection>,
    /// Of each detection before those that are none are dropped.
    fits: Vec<BoardFit>,
    /// Detections whose squares the others of their board have shown.
    completed: Vec<usize>,
    report: Report,
}

impl Detector {
    /// Checks the options and prepares the families' tables.
    pub fn new(options: Options) -> Result<Self, OptionsError> {
        options.check()?;
        Ok(Self {
            decoder: Decoder::new(&options),
            options,
            negative: Negative::default(),
            tiles: Tiles::default(),
            is_dim: false,
            plane: BitPlane::default(),
            components: Components::default(),
            quads: QuadFinder::default(),
            patterns: PatternFitter::default(),
            sightings: Vec::new(),
            detections: Vec::new(),
            fits: Vec::new(),
            completed: Vec::new(),
            report: Report::default(),
        })
    }

    /// Sets the lens through which tags are fitted from the next image on. Corners remain pixels of the image: with a
    /// lens they are the true corners, without one they have a bias from distortion inside the tag. Messages and
    /// recordings contain corners fitted without a lens, like those of other detectors; the estimator corrects the
    /// distortion bias.
    pub fn set_lens(&mut self, lens: Option<Lens>) {
        self.patterns.lens = lens;
    }

    /// The tags in an image, sorted by family, id and centre.
    pub fn detect(&mut self, image: &Image<'_>) -> &[Detection] {
        self.detect_observed(image, &mut ())
    }

    /// Like [`Self::detect`], with an observer of the stages.
    pub fn detect_observed(
        &mut self,
        image: &Image<'_>,
        observer: &mut impl Observer,
    ) -> &[Detection] {
        self.detect_within(image, &[Area::whole(image)], observer)
    }

    /// Searches areas of the image, one after the other. Each uses the least noise of those before it, since a small
    /// area may contain little but tags.
    pub(crate) fn detect_within(
        &mut self,
        image: &Image<'_>,
        areas: &[Area],
        observer: &mut impl Observer,
    ) -> &[Detection] {
        make_room(&mut self.sightings, MAX_SIGHTINGS);
        make_room(&mut self.detections, MAX_SIGHTINGS);
        make_room(&mut self.fits, MAX_SIGHTINGS);
        make_room(&mut self.completed, MAX_SIGHTINGS);
        self.patterns.make_room(image.width(), image.height());
        self.report = Report {
            noise_sigma: f32::INFINITY,
            ..Report::default()
        };
        let mut negative = mem::take(&mut self.negative);
        let image = match self.options.inverted {
            true => &negative.invert(image),
            false => image,
        };
        for area in areas {
            self.search(image, area, observer);
        }
        self.locate(image, observer);
        self.negative = negative;
        observer.stage_ended(Stage::Refine);
        &self.detections
    }

    fn search(&mut self, image: &Image<'_>, area: &Area, observer: &mut impl Observer) {
        let part = area.crop(image);
        let some_live = self.measure(&part);
        observer.stage_ended(Stage::Tiles);
        if !some_live {
            return;
        }
        let mut touched = match self.decoder.are_touched {
            true => Some([0..part.width() as u32, 0..part.height() as u32]),
            false => None,
        };
        for pass in Pass::ALL {
            if pass == Pass::Eroded {
                let Some([columns, rows]) = &touched else {
                    continue;
                };
                self.plane.keep(columns, rows);
            }
            let Some(least_open) = self.decoder.least_open(pass) else {
                continue;
            };
            let min_edge_px = match pass {
                Pass::Eroded if !self.decoder.are_touched => {
                    self.options.min_edge_px.max(LEAST_ERODED_PX)
                }
                _ => self.options.min_edge_px,
            };
            observer.pass_began(pass);
            vectorise!(self.plane.threshold(&part, &self.tiles, pass));
            observer.stage_ended(Stage::Threshold);
            self.components.label(&self.plane);
            observer.labelled(self.components.labelled_pixels(&self.plane));
            observer.stage_ended(Stage::Components);
            self.report.components += self.components.n_components() as u32;
            self.report.runs += self.components.n_runs() as u32;
            for label in 0..self.components.all().len() {
                let component = self.components.all()[label];
                if component.may_be_border(min_edge_px, least_open) {
                    let rejected = self.examine(&component, &Part { image, area, pass }, observer);
                    if rejected.is_some() && component.may_be_touched(LEAST_ERODED_PX) {
                        let [columns, rows] =
                            touched.get_or_insert_with(|| [component.columns(), component.rows()]);
                        *columns = enclosing(columns, &component.columns());
                        *rows = enclosing(rows, &component.rows());
                    }
                }
            }
        }
    }

    /// Computes the tiles of an area and its contrast threshold; returns whether any tile exceeds it. Allocates only if
    /// no area of this size came before.
    fn measure(&mut self, part: &Image<'_>) -> bool {
        let (width, height) = (part.width(), part.height());
        self.plane.make_room(width, height);
        self.components.make_room(width, height);
        self.quads.make_room(height);
        self.tiles.measure(part);
        let noise_sigma = self.tiles.noise_sigma().min(self.report.noise_sigma);
        let over_noise = |in_sigma: f32| (noise_sigma * in_sigma).min(64.0) as u8;
        let gate = over_noise(self.options.min_contrast_in_sigma).max(self.options.min_contrast);
        let dim_gate = over_noise(DIM_IN_SIGMA).max(self.options.min_dim_contrast);
        // Paper is at least a quarter brighter than what is printed on it, so an image with no bright tile has no tag
        // of high contrast.
        self.is_dim = self.tiles.are_below(gate.saturating_mul(4));
        let contrast_gate = if self.is_dim {
            dim_gate.min(gate)
        } else {
            gate
        };
        (self.report.noise_sigma, self.report.contrast_gate) = (noise_sigma, contrast_gate);
        self.tiles.set_levels(contrast_gate)
    }

    /// Least difference between black and white of a tag, in grey levels; tiles have a separate threshold.
    fn min_contrast(&self) -> u8 {
        let options = &self.options;
        match self.is_dim {
            true => options.min_dim_contrast.min(options.min_contrast),
            false => options.min_contrast,
        }
    }

    /// Reads the tag whose border may be this component, unless it lies within a tag that was already read. Returns
    /// why it is none.
    fn examine(
        &mut self,
        component: &Component,
        &Part { image, area, pass }: &Part<'_>,
        observer: &mut impl Observer,
    ) -> Option<Rejection> {
        if area.cuts(component, image) {
            return None;
        }
        let bounds = area.quad_to_image(component.corners());
        let middle = middle(&bounds);
        if self.sightings.iter().any(|tag| tag.covers(middle)) {
            return None;
        }
        self.report.candidates += 1;
        let outline = Outline {
            min_edge_px: self.options.min_edge_px,
            overhang_px: OVERHANG_PX + f32::from(pass == Pass::Eroded),
        };
        let (components, plane) = (&self.components, &self.plane);
        let quad = vectorise!(self.quads.fit(component, components, plane, outline));
        let quad = quad.map(|quad| area.quad_to_image(quad));
        observer.stage_ended(Stage::Quads);
        if let Ok(quad) = &quad {
            self.report.quads += 1;
            observer.quad_found(quad);
        }
        let view = ImageView {
            image,
            border: pass.border(),
            min_contrast: f32::from(self.min_contrast()),
        };
        let sighted = quad.and_then(|quad| {
            let mut sighting = self.decoder.sight(pass, &view, &quad)?;
            let patterns =
                (self.options.refinement == Refinement::Photometric).then_some(&mut self.patterns);
            match sighting.confirm(image, patterns, self.report.noise_sigma) {
                true => Ok(sighting),
                false => Err(Rejection::NoCode),
            }
        });
        let rejection = sighted.err();
        match sighted {
            Ok(sighting) if self.sightings.len() < MAX_SIGHTINGS => self.sightings.push(sighting),
            Ok(_) => self.report.dropped += 1,
            Err(reason) => {
                self.report.rejected[reason as usize] += 1;
                observer.rejected(reason, &quad.unwrap_or(bounds));
            }
        }
        observer.stage_ended(Stage::Decode);
        rejection
    }

    /// Refines the corners of every sighting and sorts the detections.
    fn locate(&mut self, image: &Image<'_>, observer: &mut impl Observer) {
        self.fits.clear();
        for sighting in &self.sightings {
            let patterns =
                (self.options.refinement == Refinement::Photometric).then_some(&mut self.patterns);
            let (tag, fit) = sighting.refine(image, patterns, self.report.noise_sigma);
            self.detections.push(tag);
            self.fits.push(fit);
        }
        self.complete_squares();
        let fits = mem::take(&mut self.fits);
        let mut each = self.sightings.iter().zip(&fits);
        self.detections.retain(|tag| {
            let Some((sighting, fit)) = each.next() else {
                return true;
            };
            let is_tag = matches!(
                fit,
                BoardFit::Found | BoardFit::Square { n_saddles: 1.., .. }
            );
            if is_tag {
                observer.refined(&sighting.quad, tag);
            } else {
                self.report.rejected[Rejection::FaintBorder as usize] += 1;
                observer.rejected(Rejection::FaintBorder, &sighting.quad);
            }
            is_tag
        });
        self.fits = fits;
        share_corners(&mut self.detections);
        self.detections.sort_unstable_by(|a, b| {
            let ([ax, ay], [bx, by]) = (a.centre(), b.centre());
            (a.family, a.id)
                .cmp(&(b.family, b.id))
                .then(ay.total_cmp(&by))
                .then(ax.total_cmp(&bx))
        });
        self.report.detections = self.detections.len() as u32;
    }

    /// Gives markers of a ChArUco board without saddle points the squares that the others of their board have.
    fn complete_squares(&mut self) {
        for i in 0..self.fits.len() {
            let family = self.detections[i].family;
            if !matches!(
                self.fits[i],
                BoardFit::Marker | BoardFit::Square { n_saddles: 0, .. }
            ) {
                continue;
            }
            let fits = self.fits.iter().zip(&self.detections);
            let of_family = fits.filter(|(_, tag)| tag.family == family);
            if let Some(reach) = common_reach(of_family.map(|(fit, _)| *fit)) {
                extrapolate(&mut self.detections[i], reach);
                self.completed.push(i);
            }
        }
        for &i in &self.completed {
            let square = &self.detections[i];
            let others = self.detections.iter().enumerate();
            let mut squares = others.filter(|(j, tag)| *j != i && tag.family == square.family);
            if squares.any(|(_, tag)| touch(&square.corners, &tag.corners)) {
                self.fits[i] = BoardFit::Found;
            }
        }
        self.completed.clear();
    }

    /// Counts of the last image.
    pub fn report(&self) -> &Report {
        &self.report
    }
}
