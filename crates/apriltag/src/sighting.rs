//! Decodes the tag in a quad, and turns it into a detection with sub-pixel corners.

use crate::agreement::{self, Agreement};
use crate::board_corners::{self, BoardFit};
use crate::edges::{self, Corners};
use crate::kernels::vectorise;
use crate::match_quality;
use crate::photometric::PatternFitter;
use crate::quad::{Point, Quad, distance, mean_edge, middle};
use crate::reading::{ReadFailure, Reader, Reading};
use crate::view::ImageView;
use crate::{Detection, Image, Options, Pass, Refinement, Rejection};
use sextant_tag_families::{Board, Family};

/// Share of the pattern's edges that agree with the picture, below which corners are doubted: usually all do, and seven
/// in ten where a line of the border is beside its edge.
const LEAST_AGREEMENT: f32 = 0.85;

/// Share of the edges around a corner that may be contradicted where nothing is wrong.
const USUALLY_CONTRADICTED: f32 = 0.1;

/// Variance of corners, in square pixels, of a fit that leaves nothing to be doubted.
const SURE_VARIANCE: f32 = 0.02;

/// Distance of a border from straight sides, root mean square, up to which noise, blur and lens explain it: in pixels,
/// and as a share of the edge.
const USUAL_AWAY_PX: f32 = 0.8;
const USUAL_AWAY: f32 = 0.0125;

/// Sub-pixel corners of a sighting.
struct Located {
    corners: Corners,
    refinement: Refinement,
    /// How many of the pattern's edges the picture shows there.
    agreement: Agreement,
}

/// A decoded tag, with corners accurate to about a pixel in the order of the upright tag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sighting {
    pub(crate) reading: Reading,
    pub(crate) quad: Quad,
}

impl Sighting {
    /// Whether a point is well within the tag.
    pub(crate) fn covers(&self, point: Point) -> bool {
        distance(middle(&self.quad), point) < mean_edge(&self.quad) / 2.0
    }

    /// Whether the picture is what the pattern says: for tags of few bits, with better corners if it was not with those
    /// of the quad. These become the quad.
    pub(crate) fn confirm(
        &mut self,
        image: &Image<'_>,
        patterns: Option<&mut PatternFitter>,
        noise_sigma: f32,
    ) -> bool {
        let Reading { family, found, .. } = self.reading;
        if self.reading.is_evident {
            return true;
        }
        let view = ImageView {
            image,
            border: family.data().border,
            min_contrast: 0.0,
        };
        self.quad = self
            .locate(&view, &self.quad, patterns, noise_sigma)
            .corners
            .quad;
        match_quality::measure(image, &self.quad, family, found.id).is_evident
    }

    /// The detection with corners from the whole pattern where these are more accurate than those from edges, or from
    /// the saddle points of a calibration board.
    pub(crate) fn refine(
        &self,
        image: &Image<'_>,
        mut patterns: Option<&mut PatternFitter>,
        noise_sigma: f32,
    ) -> (Detection, BoardFit) {
        let view = ImageView {
            image,
            border: self.reading.family.data().border,
            min_contrast: 0.0,
        };
        let mut located = self.locate(&view, &self.quad, patterns.as_deref_mut(), noise_sigma);
        if located.agreement.share() < LEAST_AGREEMENT {
            let moved = agreement::improve(image, &self.reading, &located.corners.quad);
            let again = self.locate(&view, &moved, patterns, noise_sigma);
            if again.agreement.share() > located.agreement.share() {
                located = again;
            }
        }
        let Located {
            mut corners,
            refinement,
            agreement,
        } = located;
        self.doubt(&view, &mut corners, agreement);
        let mut tag = Detection {
            family: self.reading.family,
            id: self.reading.found.id,
            hamming: self.reading.found.hamming as u8,
            margin: self.reading.margin,
            corners: corners.quad,
            corner_covariance: corners.covariance,
            corner_cross_covariance: corners.cross_covariance,
            refinement,
        };
        let fit = board_corners::refine(image, &self.reading, &mut tag);
        (tag, fit)
    }

    /// Adds what the picture contradicts to the covariance of each corner: edges of the pattern that it does not show
    /// around there, and a border that is hidden or, as of a bent tag, beside its sides.
    fn doubt(&self, view: &ImageView<'_>, corners: &mut Corners, agreement: Agreement) {
        let module_px = agreement::module_px(&self.reading, &corners.quad);
        let contrast = self.reading.white - self.reading.black;
        let usual_px = USUAL_AWAY_PX.max(USUAL_AWAY * mean_edge(&corners.quad));
        // A bent or hidden border leaves a fit that is less sure than this.
        let support = match corners.mean_variance() > SURE_VARIANCE {
            true => edges::corner_support(view, &corners.quad, contrast),
            false => Default::default(),
        };
        let wrong = agreement.wrong_at_corners();
        let is_wrong = agreement.share() < LEAST_AGREEMENT;
        for (corner, (support, wrong)) in support.into_iter().zip(wrong).enumerate() {
            let contradicted = wrong.max(support.hidden);
            if is_wrong || contradicted > USUALLY_CONTRADICTED {
                corners.widen(
                    corner,
                    contradicted.max(1.0 - agreement.share()) * module_px,
                );
            }
            if support.away_px > usual_px {
                corners.widen(corner, support.away_px);
            }
        }
    }

    /// Corners from a quad, by the whole pattern or by the edges.
    fn locate(
        &self,
        view: &ImageView<'_>,
        quad: &Quad,
        patterns: Option<&mut PatternFitter>,
        noise_sigma: f32,
    ) -> Located {
        let coarse = edges::fit_coarsely(view, quad);
        let pattern = patterns.and_then(|patterns| {
            vectorise!(patterns.fit(view.image, &self.reading, &coarse, noise_sigma))
        });
        let (corners, refinement) = match pattern {
            Some(corners) => (corners, Refinement::Photometric),
            None => {
                let fine = edges::fit_finely(view, &coarse.quad).unwrap_or(coarse);
                (fine, Refinement::Edges)
            }
        };
        let agreement = agreement::measure(view.image, &self.reading, &corners.quad);
        Located {
            corners,
            refinement,
            agreement,
        }
    }
}

/// Decodes tags of all families within quads.
#[derive(Debug)]
pub(crate) struct Decoder {
    readers: Vec<Reader>,
    /// Whether black squares touch the tags of a family.
    pub(crate) are_touched: bool,
}

impl Decoder {
    pub(crate) fn new(options: &Options) -> Self {
        let reader = |&family: &Family| Reader::new(family, options);
        Self {
            readers: options.families.iter().map(reader).collect(),
            are_touched: options
                .families
                .iter()
                .any(|family| family.data().board == Some(Board::Aprilgrid)),
        }
    }

    /// The families of a pass.
    fn readers(&self, pass: Pass) -> impl Iterator<Item = &Reader> {
        let readers = self.readers.iter();
        readers.filter(move |reader| reader.takes_part_in(pass))
    }

    /// Least share of the rows within a border that contain white, over the families of a pass; `None` without
    /// families.
    pub(crate) fn least_open(&self, pass: Pass) -> Option<f32> {
        let open = self.readers(pass).map(|reader| reader.least_open);
        open.reduce(f32::min)
    }

    /// Reads a tag of one of the families of a pass within a quad; if that fails or has bit errors, again with corners
    /// from its edges.
    pub(crate) fn sight(
        &self,
        pass: Pass,
        view: &ImageView<'_>,
        quad: &Quad,
    ) -> Result<Sighting, Rejection> {
        let wrong = |read: &Result<Sighting, _>| match read {
            Ok(Sighting { reading, .. }) if reading.is_evident => reading.found.hamming,
            Ok(_) => u32::MAX - 1,
            Err(_) => u32::MAX,
        };
        let mut read = self.read(pass, view, quad);
        if wrong(&read) > 0
            && !matches!(
                read,
                Err(ReadFailure {
                    can_retry: false,
                    ..
                })
            )
        {
            let again = self.read(pass, view, &edges::fit_coarsely(view, quad).quad);
            if wrong(&again) <= wrong(&read) {
                read = again;
            }
        }
        read.map_err(|failure| failure.reason)
    }

    /// The result of the first family that decodes; otherwise, a retry is worthwhile if it is for any family.
    fn read(&self, pass: Pass, view: &ImageView<'_>, quad: &Quad) -> Result<Sighting, ReadFailure> {
        let (mut reason, mut can_retry) = (Rejection::NoCode, false);
        for reader in self.readers(pass) {
            let read = vectorise!(reader.read(view, quad));
            match read {
                Ok(reading) => {
                    let mut quad = *quad;
                    quad.rotate_left(reading.found.turns as usize);
                    return Ok(Sighting { reading, quad });
                }
                Err(failure) => {
                    reason = failure.reason;
                    can_retry |= failure.can_retry;
                }
            }
        }
        Err(ReadFailure::new(reason, can_retry))
    }
}
