//! What is seen of a tag's modules, and what black and white are all over the tag: planes through the greys of its
//! border and of the ring around it, as in AprilTag 2 (Wang & Olson, IROS 2016).

use super::layout::{MAX_MODULES, ModuleLayout, Rim, RimBit, Ring, SPREAD};
use crate::Rejection;
use crate::homography::{Homography, POINTS, Points};
use crate::kernels::sample;
use crate::quad::{Point, Quad, widths};
use crate::view::ImageView;
use std::ops::Range;

/// Share of the contrast beyond the threshold that makes black or white of a place.
const CLEARLY: f32 = 0.15;

/// Blur that most images have, as a standard deviation in pixels.
pub(super) const USUAL_BLUR_PX: f32 = 0.75;

/// Width of a module from which on corners a pixel off leave its middle within it, and blur leaves it its grey.
const ROOMY_PX: f32 = 4.0;

/// How wide the ring around a border is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RimWidth {
    /// A module, as the family has it.
    Module,
    /// Half a module or less: something else is close.
    Narrow,
}

/// The modules of a family as they lie within a quad.
pub(super) struct Modules<'a> {
    view: &'a ImageView<'a>,
    layout: &'a ModuleLayout,
    map: Homography,
    /// Width and height of a module, each at right angles to its sides.
    size_px: [f32; 2],
    /// Mean greys.
    border: f32,
    ring: f32,
    /// Halfway between black and white.
    threshold: GreyPlane,
    /// How far the greys of the modules, in the order of the layout, are above the threshold; NaN outside the image.
    above: [f32; MAX_MODULES],
}

impl<'a> Modules<'a> {
    /// Border and ring.
    #[inline(always)]
    pub(super) fn new(
        view: &'a ImageView<'a>,
        layout: &'a ModuleLayout,
        quad: &Quad,
        rim: RimWidth,
    ) -> Result<Self, Rejection> {
        let map = Homography::square_to_quad(quad).ok_or(Rejection::Shape)?;
        let mut above = [0.0; MAX_MODULES];
        let places = match rim {
            RimWidth::Module => &layout.places[..layout.ring_blocks()],
            RimWidth::Narrow => &layout.narrow_rim,
        };
        sample(view.image, &map, places, &mut above);
        let plane = |ring: &Ring| {
            let plane = GreyPlane::fit(&above[ring.modules.clone()], ring);
            plane.ok_or(Rejection::FaintBorder)
        };
        let (border, ring) = (plane(&layout.border)?, plane(&layout.ring)?);
        let threshold = GreyPlane {
            mean: (border.mean + ring.mean) / 2.0,
            slope: [0, 1].map(|axis| (border.slope[axis] + ring.slope[axis]) / 2.0),
        };
        threshold.take_from(&mut above, &layout.places[..layout.ring_blocks()]);
        Ok(Self {
            view,
            layout,
            map,
            size_px: widths(quad).map(|width| width * layout.border.step / 2.0),
            border: border.mean,
            ring: ring.mean,
            threshold,
            above,
        })
    }

    /// Mean greys of black and white.
    pub(super) fn black_and_white(&self) -> [f32; 2] {
        let (border, ring) = (self.border, self.ring);
        [border.min(ring), border.max(ring)]
    }

    /// From the border outwards, negative where that goes the wrong way.
    pub(super) fn contrast(&self) -> f32 {
        self.view.sign() * (self.ring - self.border)
    }

    /// The modules of border and ring, and the sign of what they should be above the threshold.
    fn rings(&self) -> [(&Range<usize>, f32); 2] {
        let sign = self.view.sign();
        [
            (&self.layout.whole_border, -sign),
            (&self.layout.ring.modules, sign),
        ]
    }

    /// Share of the modules of border and of ring, as far as they are in the image, that have the colour that they
    /// should.
    #[inline(always)]
    pub(super) fn right_in_rings(&self) -> [f32; 2] {
        let mut shares = [0.0; 2];
        for (share, (modules, sign)) in shares.iter_mut().zip(self.rings()) {
            let (mut right, mut all) = (0, 0);
            for above in &self.above[modules.clone()] {
                right += u32::from(sign * above > 0.0);
                all += u32::from(!above.is_nan());
            }
            *share = right as f32 / all as f32;
        }
        shares
    }

    /// Border and ring must clearly have their colours all around, as far as they are in the image and but for what is
    /// hidden in one quarter of the tag: a letter's strokes leave gaps, bend or touch what stands beside them.
    pub(super) fn rings_are_whole(&self) -> bool {
        let clearly = CLEARLY * self.contrast();
        let [mut left, mut right, mut top, mut bottom] = [false; 4];
        for (modules, sign) in self.rings() {
            for i in modules.clone().filter(|i| sign * self.above[*i] <= clearly) {
                let [u, v] = self.layout.places[i / POINTS].map(|at| at[i % POINTS]);
                (left, right) = (left || u <= 0.0, right || u >= 0.0);
                (top, bottom) = (top || v <= 0.0, bottom || v >= 0.0);
            }
        }
        !(left && right || top && bottom)
    }

    /// Width of a module across its narrower side, in pixels.
    pub(super) fn narrowest_px(&self) -> f32 {
        self.size_px[0].min(self.size_px[1])
    }

    /// Whether corners a pixel off can spoil what is read.
    pub(super) fn are_small(&self) -> bool {
        self.narrowest_px() < ROOMY_PX
    }

    /// The middles of the modules that carry bits. Says whether all lie in the image.
    #[inline(always)]
    pub(super) fn sample_bits(&mut self) -> bool {
        let bits = &self.layout.bits;
        let above = &mut self.above[bits.start..];
        let places = &self.layout.places[self.layout.ring_blocks()..];
        sample(self.view.image, &self.map, places, above);
        self.threshold.take_from(above, places);
        !above[..bits.len()].iter().any(|above| above.is_nan())
    }

    /// The bits by the mean over each, without what a line or a spot on it makes darkest or brightest: of the points
    /// over it, the middle half.
    pub(super) fn spread_bits(&mut self) {
        let mut greys = [[0.0; MAX_MODULES]; SPREAD];
        for (greys, places) in greys.iter_mut().zip(&self.layout.spread) {
            sample(self.view.image, &self.map, places, greys);
            self.threshold.take_from(greys, places);
        }
        for (i, above) in self.above[self.layout.bits.clone()].iter_mut().enumerate() {
            let mut of_bit = greys.map(|greys| greys[i]);
            of_bit.sort_unstable_by(f32::total_cmp);
            let middle = &of_bit[SPREAD / 4..SPREAD - SPREAD / 4];
            *above = middle.iter().sum::<f32>() / middle.len() as f32;
        }
    }

    /// The observed code word and its margin: the mean distance from the threshold of the weaker colour.
    #[inline(always)]
    pub(super) fn word(&self, blur_px: f32) -> (u64, f32) {
        let (mut code, mut sum, mut distances) = (0_u64, 0.0, 0.0);
        for value in self.bits(blur_px) {
            code = code << 1 | u64::from(value > 0.0);
            sum += value;
            distances += value.abs();
        }
        let white = code.count_ones();
        let black = self.layout.bits.len() as u32 - white;
        let mean = |twice: f32, count: u32| twice / (2 * count.max(1)) as f32;
        let (of_white, of_black) = (mean(distances + sum, white), mean(distances - sum, black));
        (code, of_white.min(of_black))
    }

    /// How far each bit's grey is above the threshold.
    ///
    /// What blur carries over from the neighbours, which matters where a module is hardly wider than the blur, is taken
    /// out: the inverse of a blur by modules of that width, fitted by a power law. A tag seen from the side is narrow
    /// one way only.
    #[inline(always)]
    fn bits(&self, blur_px: f32) -> impl Iterator<Item = f32> {
        let shares = self.size_px.map(|width| 3.3 * (blur_px / width).powi(3));
        let [across, down] = shares.map(|share| share.min(0.5));
        let bits = self.above[self.layout.bits.clone()].iter();
        bits.zip(&self.layout.beside).map(move |(bit, beside)| {
            let [left, right, top, bottom] = beside.map(|at| self.above[usize::from(at)]);
            let twice = 2.0 * bit;
            let edge = across * (twice - left - right) + down * (twice - top - bottom);
            bit + if edge.is_nan() { 0.0 } else { edge }
        })
    }

    /// Whether white reaches as far from the middle as the family's bits do, in the mean of a word's outermost white
    /// ones.
    #[inline(always)]
    pub(super) fn white_ends_at_the_border(&self, code: u64) -> bool {
        /// Grey at a sample point that is white under one border width and black under the other, between 0 (black) and
        /// 1 (white). Two thousand tags gave 0.6 and more where it is white, 0.45 and less where it is black. The
        /// smallest tags may have 0.45, since no smaller tag of the other border width can be read.
        const LEAST_WHITE: [f32; 2] = [0.6, 0.45];
        const MOST_BLACK: f32 = 0.45;
        /// As large a share of the bits that were read leaves no doubt.
        const SURELY_WHITE: f32 = 0.8;
        /// Width of a module below which tags are among the least.
        const LEAST_PX: f32 = 1.7;
        let rim = &self.layout.rim;
        let bits = &self.above[self.layout.bits.clone()];
        let own = self.above_black(code, |_, bit| bits[bit.place]);
        let [of_other, between] = &rim.places;
        let between = self.seen_above_black(code, between);
        if between.is_nan() || rim.shows_white && between >= SURELY_WHITE * own {
            // At the edge of the image it is not known.
            return true;
        }
        let white = own.max(self.seen_above_black(code, of_other));
        let is_least = self.narrowest_px() < LEAST_PX;
        match rim.shows_white {
            true => between >= LEAST_WHITE[usize::from(is_least)] * white,
            false => between <= MOST_BLACK * white,
        }
    }

    /// How far the greys at places on the rim are above black, in sum over the word's white bits.
    #[inline(always)]
    fn seen_above_black(&self, code: u64, places: &[[Points; 2]]) -> f32 {
        let mut above = [0.0; Rim::MOST];
        sample(self.view.image, &self.map, places, &mut above);
        self.threshold.take_from(&mut above, places);
        self.above_black(code, |at, _| above[at])
    }

    #[inline(always)]
    fn above_black(&self, code: u64, above: impl Fn(usize, RimBit) -> f32) -> f32 {
        let (black, mut sums) = (self.contrast() / 2.0, [0.0; POINTS]);
        for (block, bits) in self.layout.rim.bits.iter().enumerate() {
            for (i, bit) in bits.iter().enumerate() {
                // Those that pad the last block are beyond the word, and not white.
                let is_white = code >> bit.significance & 1 == 1;
                let above = above(block * POINTS + i, *bit) + black;
                sums[i] += if is_white { above } else { 0.0 };
            }
        }
        sums.iter().sum()
    }

    /// Modules with a bit that are not clearly black or clearly white, or not throughout. Those of a tag with more and
    /// smaller modules, which now and then show a code word of a family of few bits, are not, or are grey where that
    /// tag is blurred.
    pub(super) fn n_in_doubt(&self) -> usize {
        let mut around = [[0.0; MAX_MODULES]; 4];
        for (above, places) in around.iter_mut().zip(&self.layout.around) {
            sample(self.view.image, &self.map, places, above);
            self.threshold.take_from(above, places);
        }
        let clearly = CLEARLY * self.contrast();
        let is_in_doubt = |(i, middle): &(usize, f32)| {
            let other = |above: &[f32; MAX_MODULES]| middle.signum() * above[*i] < -clearly;
            middle.abs() < clearly || around.iter().any(other)
        };
        let middles = self.bits(USUAL_BLUR_PX).enumerate();
        middles.filter(is_in_doubt).count()
    }
}

/// grey = mean + slope . place on the square -1..1
struct GreyPlane {
    mean: f32,
    slope: Point,
}

impl GreyPlane {
    /// Least squares over a square ring, module by module of all four sides, each a quarter turn from the one before:
    /// mean and slopes part. Where some are outside the image, the mean alone.
    #[inline(always)]
    fn fit(greys: &[f32], ring: &Ring) -> Option<Self> {
        let fours = greys.as_chunks::<4>().0;
        let [start, reach] = ring.begins;
        // By side: the sum of the greys, and of the greys times how far along their side they lie.
        let (mut sums, mut along, mut at, mut squares) = ([0.0; 4], [0.0; 4], start, 0.0);
        for greys in fours {
            for side in 0..4 {
                sums[side] += greys[side];
                along[side] += at * greys[side];
            }
            squares += at * at + reach * reach;
            at += ring.step;
        }
        let [top, right, bottom, left] = sums;
        let sum = top + right + bottom + left;
        if !f32::is_nan(sum) {
            let moments = [
                along[0] - along[2] + reach * (left - right),
                along[1] - along[3] + reach * (top - bottom),
            ];
            return Some(Self {
                mean: sum / greys.len() as f32,
                slope: moments.map(|moment| moment / (2.0 * squares)),
            });
        }
        let (mut n, mut sum) = (0.0, 0.0);
        for grey in greys.iter().filter(|grey| !grey.is_nan()) {
            (n, sum) = (n + 1.0, sum + grey);
        }
        let (mean, slope) = (sum / n, [0.0; 2]);
        (n > 0.0).then_some(Self { mean, slope })
    }

    /// Makes the greys at places what they are above the plane.
    #[inline(always)]
    fn take_from(&self, greys: &mut [f32], places: &[[Points; 2]]) {
        let (mean, [right, down]) = (self.mean, self.slope);
        let greys: &mut [Points] = greys.as_chunks_mut().0;
        for (greys, [u, v]) in greys.iter_mut().zip(places) {
            *greys = std::array::from_fn(|i| greys[i] - (mean + right * u[i] + down * v[i]));
        }
    }
}
