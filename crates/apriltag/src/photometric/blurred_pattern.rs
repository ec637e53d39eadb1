//! How white a blurred tag is at a place, and how that changes.
//!
//! The square -1..1 carries `border_width` modules; the ring around it belongs to the pattern, and beyond that ring the
//! paper is taken to go on. Blur is Gaussian. Across one straight edge that is exact; where an edge along u crosses one
//! along v, the two are taken as independent, which is exact where they cross at right angles in the image and slightly
//! off where they don't.

use super::{Place, State};
use crate::Family;
use sextant_tag_families::module_is_white;

const MAX_MODULES: usize = 12;

/// Modules that are added around the printed tag, continuing its outermost ring.
const PADDING: usize = 2;

const SIZE: usize = MAX_MODULES + 2 * PADDING;

/// Edges between modules that reach a place: within three modules' width of it at either side there are no others that
/// blur of up to half a module carries over.
const EDGES: usize = 4;

pub(super) struct BlurredPattern {
    /// 1 is white; row after row, padded.
    modules: [[f32; SIZE]; SIZE],
    /// Modules from the square's middle to its edge.
    half_border: f32,
    /// Column of the padded pattern in which the square's middle lies.
    middle: f32,
}

/// White's share at a place and its derivatives along u, v and with the blur's covariance (xx, xy, yy).
pub(super) struct Coverage {
    pub(super) value: f32,
    pub(super) along_u: f32,
    pub(super) along_v: f32,
    pub(super) with_blur: [f32; 3],
}

/// The nearest edges along one axis: how far each has been crossed and how steeply.
struct Crossings {
    /// Module before the first edge.
    first: usize,
    /// Share of the blur that lies beyond the edge.
    share: [f32; EDGES],
    /// Change of the share with the place, in modules.
    density: [f32; EDGES],
    /// Change of the share with the variance across the edge.
    spread: [f32; EDGES],
}

impl BlurredPattern {
    pub(super) fn new(family: Family, id: u32) -> Self {
        let data = family.data();
        let total = usize::from(data.total_width);
        let printed = |i: usize| i.saturating_sub(PADDING).min(total - 1);
        let modules = std::array::from_fn(|y| {
            std::array::from_fn(|x| {
                f32::from(u8::from(module_is_white(
                    family,
                    id,
                    printed(x),
                    printed(y),
                )))
            })
        });
        Self {
            modules,
            half_border: f32::from(data.border_width) / 2.0,
            middle: total as f32 / 2.0 + PADDING as f32,
        }
    }

    /// How far from the middle pixels are still the pattern's own: what lies beyond the ring around the square blurs
    /// into its outer part. In half edges of the square.
    pub(super) fn reach(&self, state: &State) -> f32 {
        const BLURS: f32 = 1.5;
        let [a, b, _, d, e, ..] = state.homography.m;
        let edge_px = (a.hypot(d) + b.hypot(e)).max(f32::MIN_POSITIVE);
        let module_px = edge_px / (2.0 * self.half_border);
        let blur_px = ((state.blur[0] + state.blur[2]) / 2.0).sqrt();
        1.0 + (1.0 - BLURS * blur_px / module_px).clamp(0.1, 0.8) / self.half_border
    }

    #[inline]
    pub(super) fn at(&self, place: &Place, blur: &[f32; 3]) -> Coverage {
        let half = self.half_border;
        let scaled = |gradient: [f32; 2]| [gradient[0] * half, gradient[1] * half];
        let (u_gradient, v_gradient) = (scaled(place.u_gradient), scaled(place.v_gradient));
        let columns = Crossings::of(place.u * half + self.middle, variance(u_gradient, blur));
        let rows = Crossings::of(place.v * half + self.middle, variance(v_gradient, blur));

        let mut along = [Sums::default(); EDGES + 1];
        for (i, sums) in along.iter_mut().enumerate() {
            *sums = columns.sum(&self.modules[(rows.first + i).min(SIZE - 1)]);
        }
        let mut coverage = Coverage {
            value: along[0].share,
            along_u: along[0].density,
            along_v: 0.0,
            with_blur: [0.0; 3],
        };
        let mut spread = [along[0].spread, 0.0];
        for k in 0..EDGES {
            let change = along[k + 1].share - along[k].share;
            coverage.value += change * rows.share[k];
            coverage.along_u += (along[k + 1].density - along[k].density) * rows.share[k];
            coverage.along_v += change * rows.density[k];
            spread[0] += (along[k + 1].spread - along[k].spread) * rows.share[k];
            spread[1] += change * rows.spread[k];
        }
        coverage.along_u *= half;
        coverage.along_v *= half;
        let ([ux, uy], [vx, vy]) = (u_gradient, v_gradient);
        coverage.with_blur = [
            spread[0] * ux * ux + spread[1] * vx * vx,
            2.0 * (spread[0] * ux * uy + spread[1] * vx * vy),
            spread[0] * uy * uy + spread[1] * vy * vy,
        ];
        coverage
    }
}

/// Variance of the blur along an axis of the pattern, in square modules.
fn variance([x, y]: [f32; 2], blur: &[f32; 3]) -> f32 {
    const LEAST: f32 = 1e-4;
    (blur[0] * x * x + 2.0 * blur[1] * x * y + blur[2] * y * y).max(LEAST)
}

/// A row of modules, blurred along it.
#[derive(Clone, Copy, Default)]
struct Sums {
    share: f32,
    density: f32,
    spread: f32,
}

impl Crossings {
    #[inline]
    fn of(place: f32, variance: f32) -> Self {
        let first_edge =
            (place.floor() as isize - (EDGES / 2 - 1) as isize).clamp(1, (SIZE - EDGES) as isize);
        let inverse = 1.0 / variance.sqrt();
        let mut crossings = Self {
            first: first_edge as usize - 1,
            share: [0.0; EDGES],
            density: [0.0; EDGES],
            spread: [0.0; EDGES],
        };
        for k in 0..EDGES {
            let z = (place - (first_edge + k as isize) as f32) * inverse;
            let (share, density) = normal(z);
            crossings.share[k] = share;
            crossings.density[k] = density * inverse;
            crossings.spread[k] = -0.5 * density * z * inverse * inverse;
        }
        crossings
    }

    #[inline]
    fn sum(&self, modules: &[f32; SIZE]) -> Sums {
        let mut sums = Sums {
            share: modules[self.first],
            ..Sums::default()
        };
        for k in 0..EDGES {
            let change = modules[self.first + k + 1] - modules[self.first + k];
            sums.share += change * self.share[k];
            sums.density += change * self.density[k];
            sums.spread += change * self.spread[k];
        }
        sums
    }
}

/// The normal distribution function and its density (Abramowitz & Stegun, Handbook of Mathematical Functions, 26.2.17,
/// |error| < 1e-7).
#[inline]
fn normal(z: f32) -> (f32, f32) {
    let x = z.abs().min(6.0);
    let density = 0.398_942_28 * (-0.5 * x * x).exp();
    let t = 1.0 / (1.0 + 0.231_641_9 * x);
    let poly = t
        * (0.319_381_53
            + t * (-0.356_563_78 + t * (1.781_477_9 + t * (-1.821_256 + t * 1.330_274_4))));
    let tail = density * poly;
    (if z < 0.0 { tail } else { 1.0 - tail }, density)
}
