//! How much of what the picture shows over a tag its decoded pattern explains.
//!
//! Input: an image, an upright quad and the tag read there. Output: the coefficient of determination of a linear model
//! of the greys, from 0 to 1: the pattern, blurred, times a contrast, on a plane of light. A word of few bits turns up
//! in texture by chance; border, bits and rim, each over its whole area, don't. Only a narrow rim around the border is
//! looked at, since something dark may lie close beyond it.

use crate::Image;
use crate::homography::{Homography, POINTS};
use crate::kernels::{sample, vectorise};
use crate::quad::{Quad, widths};
use sextant_tag_families::{Family, white_modules};

/// Sample points along a module.
const IN_MODULE: usize = 3;

/// Most modules along a border, of the families with few bits.
const MOST_WIDTH: usize = 9;

/// Modules of border and rim.
const MOST_MODULES: usize = MOST_WIDTH + 2;

/// Most sample points along the border and its rim, in whole blocks.
const MOST_SAMPLES: usize = (IN_MODULE * MOST_WIDTH + 2).next_multiple_of(POINTS);

/// Standard deviations of the blur that are tried, in pixels, the most usual one first.
const BLURS_PX: [f32; 3] = [0.9, 0.5, 1.5];

type Row = [f32; MOST_SAMPLES];

/// Share of the variance that a pattern must explain where its modules are large, and where they are as narrow as
/// [`NARROW_PX`]; and what each further pixel makes up for. Of texture in which words are found .6 is usual, and up to
/// .8 with modules of two pixels.
const LEAST: f32 = 0.75;
const MOST: f32 = 0.95;
const NARROW_PX: f32 = 2.0;
const BY_PX: f32 = 0.2;

/// Blur that most images have, as a standard deviation in pixels: with more, a pixel tells less.
const USUAL_BLUR_PX: f32 = 0.9;

/// Largest blur as a share of a module with which a word is evidence: modules of another number pass for these with
/// more.
const MOST_BLUR: f32 = 0.33;

/// Mean residual of a module, as a share of the contrast, beyond which it is not what the pattern says: of real tags
/// one in a hundred has a module with .25.
const MOST_RESIDUAL: f32 = 0.28;

/// What a pattern explains of the picture.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Match {
    /// Share of the variance of the greys; 0 where the picture shows its negative, for a degenerate quad, or beyond the
    /// image.
    pub(crate) explained: f32,
    /// Whether that is enough for what is seen to be the tag, and every module of border and bits is as the pattern
    /// says, but for what is hidden in one quarter of the tag. The fewer pixels there are, also of a tag that is narrow
    /// or of a marker that is cut in half, the more of them must be as the pattern says.
    pub(crate) is_evident: bool,
}

/// How well the blurred pattern of a tag matches the picture.
pub(crate) fn measure(image: &Image<'_>, quad: &Quad, family: Family, id: u32) -> Match {
    let width = usize::from(family.data().border_width).min(MOST_WIDTH);
    let n = IN_MODULE * width + 2;
    let mut at: Row = [0.0; MOST_SAMPLES];
    for (i, at) in at[..n].iter_mut().enumerate() {
        *at = ((2 * i + 1) as f32 - n as f32) / (IN_MODULE * width) as f32;
    }
    let Some(greys) = greys(image, quad, &at, n) else {
        return Match::default();
    };
    let black = black_modules(family, id, width);
    let module_px = widths(quad).map(|px| px / width as f32);
    let mut best = Match::default();
    for blur_px in BLURS_PX {
        let of_blur = vectorise!({
            let [across, down] = module_px.map(|px| shares(&at[..n], width, blur_px / px));
            let pattern = blurred(&black, &across, &down, n);
            let fit = Fit::between(&greys, &pattern, &at, n);
            let residuals = residuals(&greys, &pattern, &at, &fit);
            let narrow_px = module_px[0].min(module_px[1]);
            let sharp_px = narrow_px * (USUAL_BLUR_PX / blur_px).min(1.0);
            let least = (MOST - BY_PX * (sharp_px - NARROW_PX)).clamp(LEAST, MOST);
            let is_sharp = blur_px <= MOST_BLUR * narrow_px;
            let explained = fit.explained;
            Match {
                explained,
                is_evident: is_sharp && explained >= least && is_whole(&residuals, width),
            }
        });
        best.explained = best.explained.max(of_blur.explained);
        best.is_evident |= of_blur.is_evident;
        if best.is_evident {
            break;
        }
    }
    best
}

/// Greys at the sample points; the mean grey at those outside the image. `None` for a degenerate quad.
fn greys(image: &Image<'_>, quad: &Quad, at: &Row, n: usize) -> Option<[Row; MOST_SAMPLES]> {
    let map = Homography::square_to_quad(quad)?;
    let mut greys = [[0.0; MOST_SAMPLES]; MOST_SAMPLES];
    let (mut sum, mut n_inside) = (0.0, 0.0);
    for (greys, &v) in greys[..n].iter_mut().zip(at) {
        let mut places = [[[v; POINTS]; 2]; MOST_SAMPLES / POINTS];
        for (place, &u) in places.iter_mut().zip(at.as_chunks().0) {
            place[0] = u;
        }
        sample(image, &map, &places[..n.div_ceil(POINTS)], greys);
        greys[n..].fill(0.0);
        for grey in greys[..n].iter().filter(|grey| !grey.is_nan()) {
            (sum, n_inside) = (sum + grey, n_inside + 1.0);
        }
    }
    let mean = sum / n_inside;
    for grey in greys[..n].iter_mut().flat_map(|row| &mut row[..n]) {
        *grey = if grey.is_nan() { mean } else { *grey };
    }
    f32::is_finite(mean).then_some(greys)
}

/// What the model leaves at each sample point, as a share of the contrast.
#[inline(always)]
fn residuals(
    greys: &[Row; MOST_SAMPLES],
    pattern: &[Row; MOST_SAMPLES],
    at: &Row,
    fit: &Fit,
) -> [Row; MOST_SAMPLES] {
    let [mean, right, down] = fit.light;
    let per_grey = 1.0 / fit.contrast;
    std::array::from_fn(|y| {
        std::array::from_fn(|x| {
            let light = mean + right * at[x] + down * at[y];
            (greys[y][x] - light) * per_grey - pattern[y][x]
        })
    })
}

/// Whether the modules of which the mean residual is too large all lie in one quarter of the tag.
#[inline(always)]
fn is_whole(residuals: &[Row; MOST_SAMPLES], width: usize) -> bool {
    let [mut left, mut right, mut top, mut bottom] = [false; 4];
    for (x, y) in (0..width).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let of_module = |at: usize| 1 + IN_MODULE * at..1 + IN_MODULE * (at + 1);
        let rows = residuals[of_module(y)].iter();
        let sum: f32 = rows.map(|row| row[of_module(x)].iter().sum::<f32>()).sum();
        if sum.abs() > MOST_RESIDUAL * (IN_MODULE * IN_MODULE) as f32 {
            (left, right) = (left || 2 * x < width, right || 2 * x + 1 >= width);
            (top, bottom) = (top || 2 * y < width, bottom || 2 * y + 1 >= width);
        }
    }
    !(left && right || top && bottom)
}

/// Rows of modules, border and rim: 1 where black.
fn black_modules(family: Family, id: u32, width: usize) -> [[f32; MOST_MODULES]; MOST_MODULES] {
    let mut black = [[0.0; MOST_MODULES]; MOST_MODULES];
    for row in &mut black[1..=width] {
        row[1..=width].fill(1.0);
    }
    // Columns and rows of the printed tag, which ends with its rim.
    for (x, y) in white_modules(family, id) {
        if let Some(module) = black.get_mut(y).and_then(|row| row.get_mut(x)) {
            *module = 0.0;
        }
    }
    black
}

/// For each module along an axis, how much of it blur brings to each sample point; the blur is in modules.
#[inline(always)]
fn shares(at: &[f32], width: usize, blur: f32) -> [Row; MOST_MODULES] {
    let mut shares = [[0.0; MOST_SAMPLES]; MOST_MODULES];
    let edge = |at: f32, module: usize| {
        let place = (at * width as f32 + width as f32) / 2.0 + 1.0;
        step((place - module as f32) / blur)
    };
    for (module, shares) in shares[..width + 2].iter_mut().enumerate() {
        for (share, &at) in shares.iter_mut().zip(at) {
            *share = edge(at, module) - edge(at, module + 1);
        }
    }
    shares
}

/// The integral of a normal distribution, by a logistic function (Bowling et al., J. Industrial Engineering and
/// Management 2, 2009).
#[inline(always)]
fn step(x: f32) -> f32 {
    1.0 / (1.0 + (-x * (1.5976 + 0.070_56 * x * x)).exp())
}

/// The pattern at the sample points: 1 is white.
#[inline(always)]
fn blurred(
    black: &[[f32; MOST_MODULES]; MOST_MODULES],
    across: &[Row; MOST_MODULES],
    down: &[Row; MOST_MODULES],
    n: usize,
) -> [Row; MOST_SAMPLES] {
    let mut pattern = [[0.0; MOST_SAMPLES]; MOST_SAMPLES];
    for row in &mut pattern[..n] {
        row[..n].fill(1.0);
    }
    for (modules, down) in black.iter().zip(down) {
        let mut row: Row = [0.0; MOST_SAMPLES];
        for (module, across) in modules.iter().zip(across) {
            for (sum, share) in row.iter_mut().zip(across) {
                *sum += module * share;
            }
        }
        for (pattern, share) in pattern[..n].iter_mut().zip(down) {
            for (white, black) in pattern.iter_mut().zip(&row) {
                *white -= share * black;
            }
        }
    }
    pattern
}

/// greys = contrast pattern + light, a plane, by least squares.
struct Fit {
    contrast: f32,
    /// Its mean and slopes.
    light: [f32; 3],
    /// Coefficient of determination; 0 for a contrast that is not positive.
    explained: f32,
}

impl Fit {
    /// On the grid of sample points 1, u and v are orthogonal.
    #[inline(always)]
    fn between(
        greys: &[Row; MOST_SAMPLES],
        pattern: &[Row; MOST_SAMPLES],
        at: &Row,
        n: usize,
    ) -> Self {
        let n_points = (n * n) as f32;
        let squares = n as f32 * at.iter().map(|at| at * at).sum::<f32>();
        let plane = |of: &[Row; MOST_SAMPLES]| {
            let (mut sums, mut along, mut down) = ([0.0; POINTS], [0.0; POINTS], 0.0);
            for (row, v) in of[..n].iter().zip(at) {
                let mut of_row = [0.0; POINTS];
                let blocks = row.as_chunks::<POINTS>().0.iter();
                for (values, u) in blocks.zip(at.as_chunks::<POINTS>().0) {
                    for i in 0..POINTS {
                        of_row[i] += values[i];
                        along[i] += values[i] * u[i];
                    }
                }
                sums = std::array::from_fn(|i| sums[i] + of_row[i]);
                down += v * of_row.iter().sum::<f32>();
            }
            let [sum, along] = [sums, along].map(|lanes| lanes.iter().sum::<f32>());
            [sum / n_points, along / squares, down / squares]
        };
        let (of_grey, of_pattern) = (plane(greys), plane(pattern));
        let rest = |a: &[Row; MOST_SAMPLES], b: &[Row; MOST_SAMPLES], planes: [&[f32; 3]; 2]| {
            let mut sums = [0.0; POINTS];
            for (a, b) in a[..n].iter().zip(b) {
                let blocks = a.as_chunks::<POINTS>().0.iter();
                for (a, b) in blocks.zip(b.as_chunks::<POINTS>().0) {
                    sums = std::array::from_fn(|i| sums[i] + a[i] * b[i]);
                }
            }
            let [[a, a_u, a_v], [b, b_u, b_v]] = planes.map(|plane| *plane);
            sums.iter().sum::<f32>() - n_points * a * b - squares * (a_u * b_u + a_v * b_v)
        };
        let covariance = rest(greys, pattern, [&of_grey, &of_pattern]);
        let of_greys = rest(greys, greys, [&of_grey; 2]);
        let of_patterns = rest(pattern, pattern, [&of_pattern; 2]);
        let contrast = covariance / of_patterns;
        let explained = covariance * contrast / of_greys;
        Self {
            contrast,
            light: std::array::from_fn(|i| of_grey[i] - contrast * of_pattern[i]),
            explained: if contrast > 0.0 && explained.is_finite() {
                explained
            } else {
                0.0
            },
        }
    }
}
