//! What a pixel should show, and how that changes with everything that is fitted.

use super::equations::{Equations, GROUP, RESIDUAL, Row, UNIT};
use super::pattern::{Coverage, Optics, Pattern, Places};
use super::pixels::Group;
use super::state::State;
use crate::quad::{Point, Quad};

/// Residuals beyond this many scales count nothing at all (Tukey's biweight).
pub(super) const TUKEY: f32 = 4.7;

/// Standard deviations of the blur beyond which an edge does not show.
const SEEN: f32 = 3.2;

/// Modules beyond which edges show no farther than to the middle between two.
pub(super) const FAR_APART: f32 = 0.5;

/// The state and what follows from it for all pixels.
pub(super) struct Model<'a> {
    pattern: &'a Pattern,
    state: &'a State,
    optics: Optics,
    inverse: [[f32; 3]; 3],
    /// Standard deviations of the blur across the edges of either axis.
    sigmas_px: [f32; 2],
    /// Pixels nearer to the ring's outer edges, across those of either axis, count nothing.
    least_inside_px: [f32; 2],
    /// Pixels per unit of u, over the denominator: at the middle, and its change along u; and those of v.
    units_px: [[f32; 2]; 2],
    /// Over the product of the map's denominator and that of its inverse, the same everywhere; negative.
    per_scale: f32,
    per_contrast: f32,
    per_size: f32,
    /// Grey levels beyond which residuals count nothing.
    per_limit: f32,
}

impl<'a> Model<'a> {
    /// With residuals that are about this share of the contrast.
    pub(super) fn new(pattern: &'a Pattern, state: &'a State, scale: f32) -> Option<Self> {
        let contrast = state.contrast().max(1.0);
        let inverse = state.inverse()?;
        Some(Self {
            units_px: [0, 1].map(|axis| units_px(&inverse[axis], &inverse[2])),
            per_scale: per_scale(state, &inverse),
            pattern,
            state,
            optics: state.optics()?,
            inverse,
            sigmas_px: [state.blur[0].sqrt(), state.blur[1].sqrt()],
            least_inside_px: least_inside_px(pattern, state),
            per_contrast: 1.0 / contrast,
            per_size: 1.0 / state.size_px(),
            per_limit: 1.0 / (TUKEY * scale * contrast),
        })
    }

    /// Modules beyond which an edge does not show.
    pub(super) fn seen_modules(&self) -> f32 {
        seen_modules(self.pattern, self.state)
    }

    /// Adds the rows of a group of pixels.
    #[inline(always)]
    pub(super) fn linearise<const EDGES: usize, const SHARP: bool>(
        &self,
        group: &Group<'_>,
        equations: &mut Equations,
    ) {
        let places = self.places([group.x, group.y]);
        let crossings = self.pattern.cross::<EDGES, SHARP>(&places, &self.optics);
        let rim = (EDGES > 1).then(
            #[inline(always)]
            || self.pattern.rim::<SHARP>(&places, &self.optics),
        );
        equations.add(
            #[inline(always)]
            |i| {
                let mut coverage = crossings.coverage(i, self.optics.covariance);
                if let Some(rim) = &rim {
                    let outwards = self.outwards(&places, i);
                    let light = self.light(outwards);
                    let more = (group.beyond[i] / light - self.state.white) * self.per_contrast;
                    rim.mix(i, outwards, more, self.state.ground, &mut coverage);
                }
                self.row(group, &places, i, &coverage)
            },
        );
    }

    #[inline(always)]
    fn light(&self, [u, v]: [f32; 2]) -> f32 {
        1.0 + self.state.light[0] * u + self.state.light[1] * v
    }

    /// Where the ground beyond the ring's outer edge shows, from pixels that feel it; elsewhere the pixels themselves.
    pub(super) fn beyond(&self, pixels: [&[f32; GROUP]; 2]) -> [Point; GROUP] {
        let places = self.places(pixels);
        std::array::from_fn(|i| {
            let [u, v] = self.outwards(&places, i);
            self.state.homography.apply(u, v)
        })
    }

    /// The same on the square.
    #[inline(always)]
    fn outwards(&self, places: &Places, i: usize) -> [f32; 2] {
        const FELT: f32 = 4.0;
        const BEYOND: f32 = 2.0;
        std::array::from_fn(|axis| {
            let (place, unit_px) = (places.on_square[axis][i], places.unit_px[axis][i]);
            let sigma = self.sigmas_px[axis] / unit_px;
            if self.pattern.ring - place.abs() < FELT * sigma {
                (self.pattern.ring + BEYOND * sigma).copysign(place)
            } else {
                place
            }
        })
    }

    #[inline(always)]
    fn places(&self, [x_px, y_px]: [&[f32; GROUP]; 2]) -> Places {
        let [ox, oy] = self.state.homography.origin;
        let [m_u, m_v, m_w] = &self.inverse;
        let [u_px, v_px] = self.units_px;
        let mut places = Places {
            on_square: [[0.0; GROUP]; 2],
            unit_px: [[0.0; GROUP]; 2],
        };
        for i in 0..GROUP {
            let (x, y) = (x_px[i] - ox, y_px[i] - oy);
            let along = |m: &[f32; 3]| m[0] * x + m[1] * y + m[2];
            let w = along(m_w);
            let (u, v) = (along(m_u) / w, along(m_v) / w);
            places.on_square[0][i] = u;
            places.on_square[1][i] = v;
            places.unit_px[0][i] = w * (u_px[0] + u_px[1] * u);
            places.unit_px[1][i] = w * (v_px[0] + v_px[1] * v);
        }
        places
    }

    /// A pixel's derivatives in parts of the contrast and its residual in parts of the limit, times the root of its weight,
    /// and that root, in the units of the columns.
    #[inline(always)]
    fn row(&self, group: &Group<'_>, places: &Places, i: usize, coverage: &Coverage) -> Row {
        let State {
            homography,
            black,
            white,
            gain,
            ..
        } = self.state;
        let (x, y, grey) = (group.x[i], group.y[i], group.grey[i]);
        let [u, v] = [places.on_square[0][i], places.on_square[1][i]];
        let units_px = [places.unit_px[0][i], places.unit_px[1][i]];
        let (x, y) = (x - homography.origin[0], y - homography.origin[1]);
        let [m_u, m_v, m_w] = &self.inverse;
        let share = coverage.value;
        let mixed = share * (1.0 - share);
        let cover = share + gain * mixed;
        let light = self.light([u, v]);
        let contrast = (white - black) * light;
        let expected = black * light + contrast * cover;

        let strays = (grey - expected) * self.per_limit;
        let clipped = (grey >= 254.0) & (expected > grey) | (grey <= 1.0) & (expected < grey);
        let beyond = 1.0 - strays * strays;
        let inside_px = |place: f32, unit_px: f32| (self.pattern.ring - place.abs()) * unit_px;
        let within = (inside_px(u, units_px[0]) > self.least_inside_px[0])
            & (inside_px(v, units_px[1]) > self.least_inside_px[1]);
        let root = if within & !clipped & (beyond > 0.0) {
            beyond
        } else {
            0.0
        };

        let unit = root * UNIT;
        let lit = light * unit;
        let bright = expected * self.per_contrast * unit;
        let response = lit * (1.0 + gain - 2.0 * gain * share);
        // When the square's image moves by d, the grey at a fixed pixel changes by -gradient . d; over the denominator.
        let moves = response * self.per_scale;
        let along_u = moves * coverage.across[0] * units_px[0];
        let along_v = moves * coverage.across[1] * units_px[1];
        let along_w = along_u * u + along_v * v;
        let gradient =
            |axis: usize| along_u * m_u[axis] + along_v * m_v[axis] - along_w * m_w[axis];
        let (gx, gy) = (gradient(0), gradient(1));
        let towards = -(gx * x + gy * y) * self.per_size;
        [
            gx * u,
            gx * v,
            gx,
            gy * u,
            gy * v,
            gy,
            towards * u,
            towards * v,
            lit - lit * cover,
            lit * cover,
            bright * u,
            bright * v,
            response * coverage.with_blur[0],
            response * coverage.with_blur[1],
            response * coverage.with_blur[2],
            response * coverage.with_halo,
            lit * mixed,
            response * coverage.with_ground,
            root * strays * RESIDUAL,
            unit,
        ]
    }
}

/// The length of 1 / (m - u w), over w, near the square's middle.
fn units_px(m: &[f32; 3], w: &[f32; 3]) -> [f32; 2] {
    let square = m[0] * m[0] + m[1] * m[1];
    let middle = 1.0 / square.sqrt();
    [middle, middle * (m[0] * w[0] + m[1] * w[1]) / square]
}

fn per_scale(state: &State, [.., w]: &[[f32; 3]; 3]) -> f32 {
    let [_, _, c, _, _, f, ..] = state.homography.m;
    -1.0 / (w[0] * c + w[1] * f + w[2])
}

/// Modules beyond which an edge does not show.
fn seen_modules(pattern: &Pattern, state: &State) -> f32 {
    /// How many more a unit of the halo shows an edge, which reaches twice as far.
    const MORE_WITH_HALO: f32 = 3.5;
    const MOST_MORE: f32 = 1.2;
    let seen = SEEN + (MORE_WITH_HALO * state.halo.abs()).min(MOST_MORE);
    let [uu, vv, _] = state.blur;
    seen * uu.max(vv).sqrt() / pattern.module_px(state.size_px())
}

/// How near to the ring's outer edge pixels are looked at, across the edges of either axis: where the ground is not mixed in,
/// only where it does not show.
fn least_inside_px(pattern: &Pattern, state: &State) -> [f32; 2] {
    const MIXED: f32 = 1.0;
    let sigmas = if seen_modules(pattern, state) < FAR_APART {
        SEEN
    } else {
        MIXED
    };
    [state.blur[0], state.blur[1]].map(|variance| sigmas * variance.sqrt())
}

/// Of all that shows the pattern.
pub(super) fn outline(pattern: &Pattern, state: &State) -> Quad {
    let [inside_px, _] = least_inside_px(pattern, state);
    let r = pattern.ring - 2.0 * inside_px / state.size_px();
    [[-r, -r], [r, -r], [r, r], [-r, r]].map(|[u, v]| state.homography.apply(u, v))
}
