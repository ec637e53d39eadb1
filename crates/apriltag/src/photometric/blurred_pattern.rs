//! How white a blurred tag is at a place, and how that changes.
//!
//! The square -1..1 carries `border_width` modules; the ring around it belongs to the pattern, and beyond that ring the
//! paper is taken to go on. Blur is Gaussian, followed by the pixel's own square: across an edge the square is a trapezoid,
//! here a box as wide as the trapezoid's middle and a Gaussian with the rest of its variance (1/12 px^2 in all). Where
//! edges cross, the two shares are multiplied and corrected for their covariance c by c f_uv + c^2/2 f_uuvv, the first
//! terms of the bivariate normal distribution's tetrachoric series (Pearson, Phil. Trans. R. Soc. A 195, 1900).

use super::{Place, State};
use crate::Family;
use sextant_tag_families::module_is_white;

const MAX_MODULES: usize = 12;

/// Modules that are added around the printed tag, continuing its outermost ring.
const PADDING: usize = 2;

const SIZE: usize = MAX_MODULES + 2 * PADDING;

/// Crossings of module edges, at most.
pub(super) const CROSSINGS: usize = SIZE * SIZE;

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
    /// First and half the second derivative of the share with the distance, per pixel.
    density: [f32; EDGES],
    spread: [f32; EDGES],
    /// Pixels in a module, and the axis' direction in the image.
    module_px: f32,
    normal: [f32; 2],
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
        const BLURS: f32 = 2.5;
        let [a, b, _, d, e, ..] = state.homography.m;
        let edge_px = (a.hypot(d) + b.hypot(e)).max(f32::MIN_POSITIVE);
        let module_px = edge_px / (2.0 * self.half_border);
        let blur_px = ((state.blur[0] + state.blur[2]) / 2.0 + PIXEL).sqrt();
        1.0 + (1.0 - BLURS * blur_px / module_px).clamp(0.0, 0.8) / self.half_border
    }

    /// Number of the crossing of module edges nearest to a place, below [`CROSSINGS`].
    #[inline]
    pub(super) fn nearest_crossing(&self, place: &Place) -> usize {
        let nearest =
            |along: f32| ((along * self.half_border + self.middle + 0.5) as usize).min(SIZE - 1);
        nearest(place.v) * SIZE + nearest(place.u)
    }

    #[inline]
    pub(super) fn at(&self, place: &Place, blur: &[f32; 3]) -> Coverage {
        let half = self.half_border;
        let columns = Crossings::of(
            place.u * half + self.middle,
            place.u_gradient.map(|g| g * half),
            blur,
        );
        let rows = Crossings::of(
            place.v * half + self.middle,
            place.v_gradient.map(|g| g * half),
            blur,
        );
        let ([ux, uy], [vx, vy]) = (columns.normal, rows.normal);
        let covariance = (blur[0] + PIXEL) * ux * vx
            + blur[1] * (ux * vy + uy * vx)
            + (blur[2] + PIXEL) * uy * vy;

        let mut along = [Sums::default(); EDGES + 1];
        for (i, sums) in along.iter_mut().enumerate() {
            *sums = columns.sum(&self.modules[rows.first + i]);
        }
        let mut value = along[0].share;
        let mut with_covariance = 0.0;
        let (mut density, mut spread) = ([along[0].density, 0.0], [along[0].spread, 0.0]);
        for k in 0..EDGES {
            let change = along[k + 1].minus(&along[k]);
            let mixed = change.density * rows.density[k];
            let mixed_twice = 4.0 * change.spread * rows.spread[k];
            value += change.share * rows.share[k]
                + covariance * (mixed + covariance / 2.0 * mixed_twice);
            with_covariance += mixed + covariance * mixed_twice;
            density[0] += change.density * rows.share[k];
            density[1] += change.share * rows.density[k];
            spread[0] += change.spread * rows.share[k];
            spread[1] += change.share * rows.spread[k];
        }
        Coverage {
            value,
            along_u: density[0] * columns.module_px * half,
            along_v: density[1] * rows.module_px * half,
            with_blur: [
                spread[0] * ux * ux + spread[1] * vx * vx + with_covariance * ux * vx,
                2.0 * (spread[0] * ux * uy + spread[1] * vx * vy)
                    + with_covariance * (ux * vy + uy * vx),
                spread[0] * uy * uy + spread[1] * vy * vy + with_covariance * uy * vy,
            ],
        }
    }
}

/// Variance of a pixel's square along either axis, in square pixels.
const PIXEL: f32 = 1.0 / 12.0;

/// A row of modules, blurred along it.
#[derive(Clone, Copy, Default)]
struct Sums {
    share: f32,
    density: f32,
    spread: f32,
}

impl Sums {
    #[inline]
    fn minus(&self, other: &Self) -> Self {
        Self {
            share: self.share - other.share,
            density: self.density - other.density,
            spread: self.spread - other.spread,
        }
    }
}

impl Crossings {
    /// `place` in modules from the first one; `gradient` its change over the image.
    #[inline]
    fn of(place: f32, gradient: [f32; 2], blur: &[f32; 3]) -> Self {
        const LEAST_VARIANCE: f32 = 0.01;
        let first_edge = (place as usize)
            .saturating_sub(EDGES / 2 - 1)
            .clamp(1, SIZE - EDGES);
        let module_px = 1.0 / gradient[0].hypot(gradient[1]);
        let [nx, ny] = gradient.map(|g| g * module_px);
        let width = nx.abs().max(ny.abs());
        let gaussian = blur[0] * nx * nx + 2.0 * blur[1] * nx * ny + blur[2] * ny * ny;
        let sigma = (gaussian + (1.0 - width * width) * PIXEL)
            .max(LEAST_VARIANCE)
            .sqrt();
        let mut crossings = Self {
            first: first_edge - 1,
            share: [0.0; EDGES],
            density: [0.0; EDGES],
            spread: [0.0; EDGES],
            module_px,
            normal: [nx, ny],
        };
        for k in 0..EDGES {
            let distance = (place - (first_edge + k) as f32) * module_px;
            let (far, near) = (distance + width / 2.0, distance - width / 2.0);
            let ((far_share, far_density), (near_share, near_density)) =
                (normal(far / sigma), normal(near / sigma));
            let integral =
                far * far_share - near * near_share + sigma * (far_density - near_density);
            crossings.share[k] = integral / width;
            crossings.density[k] = (far_share - near_share) / width;
            crossings.spread[k] = (far_density - near_density) / (2.0 * sigma * width);
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
    let density = 0.398_942_3 * (-0.5 * x * x).exp();
    let t = 1.0 / (1.0 + 0.231_641_9 * x);
    let poly = t
        * (0.319_381_53
            + t * (-0.356_563_78 + t * (1.781_477_9 + t * (-1.821_256 + t * 1.330_274_4))));
    let tail = density * poly;
    (if z < 0.0 { tail } else { 1.0 - tail }, density)
}
