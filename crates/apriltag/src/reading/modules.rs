//! What black and white are all over a tag: planes through the greys of its border and of the ring around it, as in
//! AprilTag 2 (Wang & Olson, IROS 2016).

use super::layout::Layout;
use crate::quad::Point;
use sextant_tag_families::BorderColour;
use std::ops::Range;

/// Share of the contrast beyond the threshold that makes black or white of a place.
pub(super) const CLEARLY: f32 = 0.15;

/// Grey between black and white all over the tag, and the means of both.
pub(super) struct Thresholds {
    middle: GreyPlane,
    pub(super) black: f32,
    pub(super) white: f32,
}

impl Thresholds {
    pub(super) fn new(layout: &Layout, greys: &[f32], colour: BorderColour) -> Option<Self> {
        let border = GreyPlane::fit(layout, greys, layout.border.clone())?;
        let ring = GreyPlane::fit(layout, greys, layout.ring.clone())?;
        let (black, white) = match colour {
            BorderColour::Black => (border.mean, ring.mean),
            BorderColour::White => (ring.mean, border.mean),
        };
        Some(Self {
            middle: border.midway(&ring),
            black,
            white,
        })
    }

    pub(super) fn contrast(&self) -> f32 {
        self.white - self.black
    }

    /// Halfway between black and white at a place, in modules from the middle of the tag.
    pub(super) fn at(&self, place: Point) -> f32 {
        self.middle.at(place)
    }

    /// Border and ring must by and large have the colours that they should; an occluded corner is forgiven.
    pub(super) fn rings_agree(&self, layout: &Layout, greys: &[f32], colour: BorderColour) -> bool {
        const LEAST_SHARE: f32 = 0.75;
        let white_share = |modules: &Range<usize>| {
            let (mut white, mut all) = (0, 0);
            let places = &layout.from_middle[modules.clone()];
            for (&place, &grey) in places.iter().zip(&greys[modules.clone()]) {
                white += u32::from(grey > self.at(place));
                all += u32::from(!grey.is_nan());
            }
            white as f32 / all as f32
        };
        let (border, ring) = (white_share(&layout.border), white_share(&layout.ring));
        let (black, white) = match colour {
            BorderColour::Black => (border, ring),
            BorderColour::White => (ring, border),
        };
        black <= 1.0 - LEAST_SHARE && white >= LEAST_SHARE
    }

    /// Border and ring must clearly have their colours all around, as far as they are in the image and but for what is hidden
    /// in one quarter of the tag: a letter's strokes leave gaps, bend or touch what stands beside them.
    pub(super) fn rings_are_whole(
        &self,
        layout: &Layout,
        greys: &[f32],
        colour: BorderColour,
    ) -> bool {
        let clearly = CLEARLY * self.contrast();
        let sign = match colour {
            BorderColour::Black => 1.0,
            BorderColour::White => -1.0,
        };
        let lacks =
            |i: usize, sign: f32| sign * (greys[i] - self.at(layout.from_middle[i])) <= clearly;
        let border = layout.border.clone().filter(|&i| lacks(i, -sign));
        let ring = layout.ring.clone().filter(|&i| lacks(i, sign));
        let lost = border.chain(ring).map(|i| layout.from_middle[i]);
        let [mut left, mut right, mut top, mut bottom] = [false; 4];
        for [x, y] in lost {
            (left, right) = (left || x <= 0.0, right || x >= 0.0);
            (top, bottom) = (top || y <= 0.0, bottom || y >= 0.0);
        }
        !(left && right || top && bottom)
    }
}

/// grey = mean + slope . place
struct GreyPlane {
    mean: f32,
    slope: Point,
}

impl GreyPlane {
    /// Least squares over a square ring, module by module of all four sides, each a quarter turn from the one before: mean and
    /// slopes part. Where some are outside the image, the mean alone.
    fn fit(layout: &Layout, greys: &[f32], modules: Range<usize>) -> Option<Self> {
        let (places, greys) = (&layout.from_middle[modules.clone()], &greys[modules]);
        // By side: the sum of the greys, and of the greys times how far along their side they lie.
        let (mut sums, mut along, mut squares, mut reach) = ([0.0; 4], [0.0; 4], 0.0, 0.0);
        for (places, greys) in places.chunks_exact(4).zip(greys.chunks_exact(4)) {
            let [at, out] = places[0];
            for side in 0..4 {
                sums[side] += greys[side];
                along[side] += at * greys[side];
            }
            squares += at * at + out * out;
            reach = out;
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

    fn midway(&self, other: &Self) -> Self {
        let mean = |a: f32, b: f32| (a + b) / 2.0;
        Self {
            mean: mean(self.mean, other.mean),
            slope: [0, 1].map(|axis| mean(self.slope[axis], other.slope[axis])),
        }
    }

    fn at(&self, place: Point) -> f32 {
        self.mean + self.slope[0] * place[0] + self.slope[1] * place[1]
    }
}
