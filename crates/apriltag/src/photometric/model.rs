//! Predicted grey value of a pixel, and its derivatives with respect to all fitted parameters.

use super::equations::{PixelEquations, RESIDUAL, Row, UNIT};
use super::pattern::{Coverage, Crossings, GROUP, MOST_EDGES, Optics, Pattern, Places};
use super::pixels::Group;
use super::state::PatternState;
use crate::quad::Quad;

/// Residuals beyond this many scales have no weight (Tukey's biweight).
pub(super) const TUKEY: f32 = 5.5;

/// Extent of an edge in standard deviations of the blur.
const SEEN: f32 = 3.2;

/// Distance from the ring's outer edge, in standard deviations of the blur, within which pixels have no weight: half of
/// their light is from the background, which is hardly uniform.
const RIM: f32 = 1.25;

/// The state, and what is derived from it for all pixels.
pub(super) struct Model<'a> {
    pattern: &'a Pattern,
    pub(super) state: &'a PatternState,
    optics: Optics,
    /// Most edges of either axis that affect a pixel.
    pub(super) n_edges: usize,
    inverse: [[f32; 3]; 3],
    /// Pixels closer to the ring's outer edges of either axis have no weight.
    rim_px: [f32; 2],
    /// Initial contrast in grey levels.
    levels: f32,
    /// Residuals beyond this have no weight.
    limit: f32,
}

impl<'a> Model<'a> {
    /// A model for residuals of about this share of the contrast, which is `levels` grey levels.
    pub(super) fn new(
        pattern: &'a Pattern,
        state: &'a PatternState,
        scale: f32,
        levels: f32,
    ) -> Option<Self> {
        Some(Self {
            pattern,
            state,
            optics: state.optics()?,
            n_edges: n_edges(pattern, state),
            inverse: state.inverse()?,
            rim_px: rim_px(pattern, state),
            levels,
            limit: TUKEY * scale,
        })
    }

    /// Adds the equations of groups of pixels.
    #[inline(always)]
    pub(super) fn linearise<'g, const EDGES: usize, const SHARP: bool>(
        &self,
        groups: impl Iterator<Item = &'g Group>,
        equations: &mut PixelEquations,
    ) {
        let mut crossings = Crossings::<EDGES>::default();
        for group in groups {
            let places = self.places(group);
            crossings.find::<SHARP>(self.pattern, &places, &self.optics);
            equations.add(
                #[inline(always)]
                |i| self.row(group, &places, i, &crossings.coverage(i, &self.optics)),
            );
        }
    }

    #[inline(always)]
    fn places(&self, group: &Group) -> Places {
        let [ox, oy] = self.state.origin;
        let [m_u, m_v, m_w] = &self.inverse;
        let mut places = Places {
            on_square: [[0.0; GROUP]; 2],
            unit_px: [[0.0; GROUP]; 2],
        };
        for i in 0..GROUP {
            let (x, y) = (group.x[i] - ox, group.y[i] - oy);
            let along = |m: &[f32; 3]| m[0] * x + m[1] * y + m[2];
            let w = along(m_w);
            for (axis, m) in [m_u, m_v].into_iter().enumerate() {
                let place = along(m) / w;
                let (gx, gy) = (m[0] - place * m_w[0], m[1] - place * m_w[1]);
                places.on_square[axis][i] = place;
                places.unit_px[axis][i] = w / (gx * gx + gy * gy).sqrt();
            }
        }
        places
    }

    /// A pixel's derivatives in shares of the contrast and its residual in shares of the limit, times the root of its
    /// weight, in the fixed-point units of the columns.
    #[inline(always)]
    fn row(&self, group: &Group, places: &Places, i: usize, coverage: &Coverage) -> Row {
        let PatternState {
            values,
            origin,
            size_px,
            ..
        } = self.state;
        let [.., black, white, light_u, light_v, _, _, _, _, gain, _] = values;
        let (x, y, level) = (
            group.x[i] - origin[0],
            group.y[i] - origin[1],
            group.grey[i],
        );
        let [u, v] = [places.on_square[0][i], places.on_square[1][i]];
        let units_px = [places.unit_px[0][i], places.unit_px[1][i]];
        let share = coverage.value;
        let mixed = share * (1.0 - share);
        let cover = share + gain * mixed;
        let light = 1.0 + light_u * u + light_v * v;
        let unlit = black + (white - black) * cover;
        let residual = level / self.levels - light * unlit;

        let strays = residual / self.limit;
        let clipped = (level >= 254.0) & (residual < 0.0) | (level <= 1.0) & (residual > 0.0);
        let counts = self.is_within([u, v], units_px) & !clipped & (strays.abs() < 1.0);
        let root = if counts { 1.0 - strays * strays } else { 0.0 };

        let unit = root * UNIT;
        let lit = light * unit;
        let bright = unlit * unit;
        let contrast = lit * (white - black);
        let response = contrast * (1.0 + gain - 2.0 * gain * share);
        let along = [0, 1].map(|axis| -response * coverage.across[axis] * units_px[axis]);
        let [gx, gy] = self.gradient(along, [u, v]);
        let towards = -(gx * x + gy * y) / size_px;
        [
            root * strays * RESIDUAL,
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
            contrast * mixed,
            response * coverage.with_ground,
            self.pattern.line([u, v], coverage.across),
        ]
    }

    /// Whether a pixel is inside of the ring by more than the rim.
    #[inline(always)]
    fn is_within(&self, [u, v]: [f32; 2], units_px: [f32; 2]) -> bool {
        let inside_px = |place: f32, unit_px: f32| (self.pattern.ring - place.abs()) * unit_px;
        (inside_px(u, units_px[0]) > self.rim_px[0]) & (inside_px(v, units_px[1]) > self.rim_px[1])
    }

    /// When the image of the square moves by d, the grey at a fixed pixel changes by -gradient . d; divided by the
    /// denominator.
    #[inline(always)]
    fn gradient(&self, [along_u, along_v]: [f32; 2], [u, v]: [f32; 2]) -> [f32; 2] {
        let [m_u, m_v, m_w] = &self.inverse;
        let along_w = along_u * u + along_v * v;
        [0, 1].map(|axis| along_u * m_u[axis] + along_v * m_v[axis] - along_w * m_w[axis])
    }
}

/// Most edges of either axis that affect a pixel: one if their extent is at most half the distance of two.
fn n_edges(pattern: &Pattern, state: &PatternState) -> usize {
    let [u, v] = state.spread_px();
    let modules = SEEN * u.max(v) / pattern.module_px(state.size_px);
    (1 + (2.0 * modules) as usize).min(MOST_EDGES)
}

/// Where a pixel is affected by one edge only, the background is excluded and its parameter not needed.
fn rim_px(pattern: &Pattern, state: &PatternState) -> [f32; 2] {
    let sigmas = if n_edges(pattern, state) == 1 {
        SEEN
    } else {
        RIM
    };
    state.spread_px().map(|sigma| sigmas * sigma)
}

/// Outline of everything that shows the pattern.
pub(super) fn outline(pattern: &Pattern, state: &PatternState) -> Quad {
    let r = pattern.ring - 2.0 * rim_px(pattern, state)[0] / state.size_px;
    [[-r, -r], [r, -r], [r, r], [-r, r]].map(|[u, v]| state.homography().apply(u, v))
}
