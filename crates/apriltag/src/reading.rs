//! Reading a tag within a quad: border vote, grey models, bits, code word.
//!
//! In: an image and a quad. Out: which tag it is and how the quad's corners must be turned. The grey models of black and
//! white are planes over the tag, from its border and the ring around it, as in AprilTag 2 (Wang & Olson, IROS 2016).

use crate::code_index::{CodeIndex, Match};
use crate::homography::Homography;
use crate::quad::{Point, Quad, widths};
use crate::{Image, Options, Rejection};
use sextant_tag_families::{BorderColour, Family, FamilyData};

/// Most modules along a printed tag's edge.
const MAX_MODULES: usize = 12;

/// A family with its index.
#[derive(Debug)]
pub(crate) struct Reader {
    pub(crate) family: Family,
    data: &'static FamilyData,
    index: CodeIndex,
    min_contrast: f32,
    min_margin: f32,
}

/// A tag that was read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    pub(crate) family: Family,
    pub(crate) found: Match,
    pub(crate) margin: f32,
    /// Mean grey of the border and of the ring around it.
    pub(crate) black: f32,
    pub(crate) white: f32,
}

impl Reader {
    pub(crate) fn new(family: Family, options: &Options) -> Self {
        let data = family.data();
        Self {
            family,
            data,
            index: CodeIndex::new(data, options.max_hamming),
            min_contrast: f32::from(options.min_contrast),
            min_margin: options.min_margin,
        }
    }

    pub(crate) fn border(&self) -> BorderColour {
        self.data.border
    }

    pub(crate) fn read(&self, image: &Image<'_>, quad: &Quad) -> Result<Reading, Unread> {
        let mut modules =
            Modules::new(image, quad, self.data).ok_or(Unread::hopeless(Rejection::Shape))?;
        modules.sample_rings(self.data);
        let thresholds = modules
            .thresholds(self.data)
            .ok_or(Unread::hopeless(Rejection::FaintBorder))?;
        let contrast = thresholds.contrast();
        if contrast < self.min_contrast {
            return Err(Unread {
                reason: Rejection::FaintBorder,
                hopeful: contrast > NEARLY * self.min_contrast,
            });
        }
        if !modules.rings_agree(self.data, &thresholds) {
            return Err(Unread::hopeless(Rejection::FaintBorder));
        }
        modules
            .sample_bits(self.data)
            .ok_or(Unread::hopeful(Rejection::NoCode))?;
        modules.subtract(&thresholds);
        self.recognise(&modules, &thresholds)
    }

    /// The code word under usual blur or, failing that, under strong blur.
    fn recognise(&self, modules: &Modules<'_>, thresholds: &Thresholds) -> Result<Reading, Unread> {
        let (usual, clarity) = bits(&modules.sharpened(USUAL_BLUR_PX), self.data);
        let (found, margin) = self
            .decode(usual, u32::MAX)
            .map(|found| (found, clarity))
            .or_else(|| {
                let (strong, margin) = bits(&modules.sharpened(STRONG_BLUR_PX), self.data);
                Some((self.decode(strong, 1)?, margin))
            })
            .ok_or(Unread {
                reason: Rejection::NoCode,
                hopeful: clarity > LEAST_CLARITY * thresholds.contrast(),
            })?;
        if margin < self.min_margin {
            return Err(Unread::hopeful(Rejection::SmallMargin));
        }
        Ok(Reading {
            family: self.family,
            found,
            margin,
            black: thresholds.black,
            white: thresholds.white,
        })
    }

    /// The code word, if it has no more wrong bits than allowed: every further attempt is a further chance for what is
    /// no tag.
    fn decode(&self, observed: u64, max_hamming: u32) -> Option<Match> {
        self.index
            .find(observed)
            .filter(|found| found.hamming <= max_hamming)
    }
}

/// Why a tag was not read, and whether it might be with better corners: corners that are a pixel off leave border and
/// ring mostly right, and bits of both colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unread {
    pub(crate) reason: Rejection,
    pub(crate) hopeful: bool,
}

impl Unread {
    pub(crate) fn hopeful(reason: Rejection) -> Self {
        Self {
            reason,
            hopeful: true,
        }
    }

    pub(crate) fn hopeless(reason: Rejection) -> Self {
        Self {
            reason,
            hopeful: false,
        }
    }
}

/// Share of the least contrast that a border may show between corners a pixel off.
const NEARLY: f32 = 0.5;

/// Mean distance of a tag's bits of either colour from the threshold, as a share of the contrast: half in a sharp picture,
/// a fifth between corners several pixels off; next to nothing where there are no bits of one colour.
const LEAST_CLARITY: f32 = 0.1;

/// Blur that most images have and blur of a lens out of focus or a hand that shook, as standard deviations in pixels.
const USUAL_BLUR_PX: f32 = 0.75;
const STRONG_BLUR_PX: f32 = 2.0;

type Values = [[f32; MAX_MODULES]; MAX_MODULES];

/// Grey values at the modules' centres, NaN outside the image; first row and column are the printed tag's.
struct Modules<'a> {
    image: &'a Image<'a>,
    homography: Homography,
    /// Width and height of a module, each at right angles to its sides.
    module_px: [f32; 2],
    /// Whether all of the printed tag lies in the image.
    within: bool,
    margin: f32,
    width: usize,
    values: Values,
}

/// Grey between black and white all over the tag, and the means of both.
struct Thresholds {
    middle: GreyPlane,
    black: f32,
    white: f32,
}

impl Thresholds {
    fn contrast(&self) -> f32 {
        self.white - self.black
    }
}

impl<'a> Modules<'a> {
    fn new(image: &'a Image<'a>, quad: &Quad, data: &FamilyData) -> Option<Self> {
        let (border, margin) = (f32::from(data.border_width), f32::from(data.margin()));
        let homography = Homography::square_to_quad(quad, border)?;
        let outer = [
            (-margin, -margin),
            (border + margin, -margin),
            (-margin, border + margin),
            (border + margin, border + margin),
        ];
        Some(Self {
            image,
            homography,
            module_px: widths(quad).map(|width| width / border),
            within: outer
                .into_iter()
                .all(|(u, v)| image.contains(homography.apply(u, v))),
            margin,
            width: usize::from(data.total_width),
            values: [[f32::NAN; MAX_MODULES]; MAX_MODULES],
        })
    }

    /// Grey at a place within a module, NaN outside the image.
    #[inline]
    fn grey(&self, x: usize, y: usize, [du, dv]: Point) -> f32 {
        let point = self.homography.apply(
            x as f32 + 0.5 - self.margin + du,
            y as f32 + 0.5 - self.margin + dv,
        );
        if self.within || self.image.contains(point) {
            self.image.sample_within(point)
        } else {
            f32::NAN
        }
    }

    /// The border and the ring around it, one sample a module.
    fn sample_rings(&mut self, data: &FamilyData) {
        for ring in [0, 1] {
            for (x, y) in ring_modules(data, ring) {
                self.values[y][x] = self.grey(x, y, [0.0; 2]);
            }
        }
    }

    /// The modules that carry bits: one sample in the middle of a small one; four around it where there is room, against
    /// noise. Nothing when one lies outside the image.
    fn sample_bits(&mut self, data: &FamilyData) -> Option<()> {
        const ROOMY_PX: f32 = 4.0;
        const ASIDE: [Point; 4] = [[-0.2, -0.2], [0.2, -0.2], [-0.2, 0.2], [0.2, 0.2]];
        for &(x, y) in data.bits {
            let (x, y) = ((x + data.margin()) as usize, (y + data.margin()) as usize);
            let grey = if self.module_px[0].min(self.module_px[1]) < ROOMY_PX {
                self.grey(x, y, [0.0; 2])
            } else {
                ASIDE
                    .into_iter()
                    .map(|aside| self.grey(x, y, aside))
                    .sum::<f32>()
                    / ASIDE.len() as f32
            };
            self.values[y][x] = (!grey.is_nan()).then_some(grey)?;
        }
        Some(())
    }

    fn thresholds(&self, data: &FamilyData) -> Option<Thresholds> {
        let plane = |ring: i8| {
            GreyPlane::fit(
                ring_modules(data, ring).map(|(x, y)| (self.place(x, y), self.values[y][x])),
            )
        };
        let (border, around) = (plane(0)?, plane(1)?);
        let (black, white) = match data.border {
            BorderColour::Black => (border.mean, around.mean),
            BorderColour::White => (around.mean, border.mean),
        };
        Some(Thresholds {
            middle: border.midway(&around),
            black,
            white,
        })
    }

    /// Of a module, from the middle of the tag.
    fn place(&self, x: usize, y: usize) -> Point {
        let middle = (self.width - 1) as f32 / 2.0;
        [x as f32 - middle, y as f32 - middle]
    }

    /// Border and ring must by and large have the colours that they should; an occluded corner is forgiven.
    fn rings_agree(&self, data: &FamilyData, thresholds: &Thresholds) -> bool {
        const LEAST_SHARE: f32 = 0.75;
        let sign = if data.border == BorderColour::Black {
            1.0
        } else {
            -1.0
        };
        let agrees = |ring: i8, sign: f32| {
            let (mut right, mut all) = (0, 0);
            for (x, y) in ring_modules(data, ring) {
                let above = self.values[y][x] - thresholds.middle.at(self.place(x, y));
                right += u32::from(above * sign > 0.0);
                all += u32::from(!above.is_nan());
            }
            right as f32 >= LEAST_SHARE * all as f32
        };
        agrees(0, -sign) && agrees(1, sign)
    }

    /// Makes each value relative to the threshold at its place.
    fn subtract(&mut self, thresholds: &Thresholds) {
        for y in 0..self.width {
            for x in 0..self.width {
                self.values[y][x] -= thresholds.middle.at(self.place(x, y));
            }
        }
    }

    /// Takes out what blur carries over from the neighbours, which matters where a module is hardly wider than the blur:
    /// the inverse of a blur by modules of that width, fitted by a power law. A tag seen from the side is narrow one way
    /// only.
    fn sharpened(&self, blur_px: f32) -> Values {
        let [across, down] = self
            .module_px
            .map(|width| (3.3 * (blur_px / width).powi(3)).min(0.5));
        let (blurred, mut sharp) = (&self.values, self.values);
        for y in 1..self.width - 1 {
            for x in 1..self.width - 1 {
                let here = 2.0 * blurred[y][x];
                let edge = across * (here - blurred[y][x - 1] - blurred[y][x + 1])
                    + down * (here - blurred[y - 1][x] - blurred[y + 1][x]);
                if edge.is_finite() {
                    sharp[y][x] += edge;
                }
            }
        }
        sharp
    }
}

/// The observed code word and its margin.
fn bits(values: &Values, data: &FamilyData) -> (u64, f32) {
    let (mut code, mut sums, mut counts) = (0, [0.0, 0.0], [0, 0]);
    for &(x, y) in data.bits {
        let value = values[(y + data.margin()) as usize][(x + data.margin()) as usize];
        let bit = usize::from(value > 0.0);
        code = code << 1 | bit as u64;
        sums[bit] += value.abs();
        counts[bit] += 1;
    }
    let mean = |bit: usize| sums[bit] / counts[bit].max(1) as f32;
    (code, mean(0).min(mean(1)))
}

/// Column and row of each module of the border (0) or of the ring around it (1).
fn ring_modules(data: &FamilyData, ring: i8) -> impl Iterator<Item = (usize, usize)> {
    let first = (data.margin() - ring) as usize;
    let last = usize::from(data.total_width) - 1 - first;
    let corner_to_corner = (first..last).map(move |i| (i, first + last - i));
    corner_to_corner.flat_map(move |(i, back)| [(i, first), (last, i), (back, last), (first, back)])
}

/// grey = mean + slope . place
struct GreyPlane {
    mean: f32,
    slope: Point,
}

impl GreyPlane {
    /// Least squares over places that lie symmetrically about the middle, so that mean and slopes part. Where some are
    /// missing, the mean alone.
    fn fit(samples: impl Iterator<Item = (Point, f32)>) -> Option<Self> {
        let (mut n, mut missing, mut sum, mut moments, mut squares) =
            (0.0_f32, false, 0.0, [0.0; 2], 0.0);
        for ([x, y], grey) in samples {
            if grey.is_nan() {
                missing = true;
                continue;
            }
            n += 1.0;
            sum += grey;
            moments = [moments[0] + x * grey, moments[1] + y * grey];
            squares += x * x;
        }
        let slope = if missing {
            [0.0; 2]
        } else {
            moments.map(|moment| moment / squares)
        };
        (n > 0.0).then(|| Self {
            mean: sum / n,
            slope,
        })
    }

    fn midway(&self, other: &Self) -> Self {
        let mean = |a: f32, b: f32| (a + b) / 2.0;
        let slope = [
            mean(self.slope[0], other.slope[0]),
            mean(self.slope[1], other.slope[1]),
        ];
        Self {
            mean: mean(self.mean, other.mean),
            slope,
        }
    }

    fn at(&self, place: Point) -> f32 {
        self.mean + self.slope[0] * place[0] + self.slope[1] * place[1]
    }
}

/// Cheap test before anything else: beyond the quad's sides it is brighter than within them (or darker, for a white
/// border), nearly everywhere along them.
pub(crate) fn check_sides(
    image: &Image<'_>,
    quad: &Quad,
    border: BorderColour,
    min_contrast: u8,
) -> Result<(), Rejection> {
    const PLACES: [f32; 5] = [0.5, 0.1, 0.9, 0.3, 0.7];
    /// Half a module of the families with the narrowest border, as a share of the edge.
    const ASIDE: f32 = 1.0 / 16.0;
    const MOST_WRONG: usize = 5;
    let homography = Homography::square_to_quad(quad, 1.0).ok_or(Rejection::Shape)?;
    let sign = if border == BorderColour::Black {
        1.0
    } else {
        -1.0
    };
    let least = f32::from(min_contrast) / 3.0;
    let steps_up = |inside: Point, outside: Point| {
        let grey = |[u, v]: Point| image.sample(homography.apply(u, v));
        match (grey(inside), grey(outside)) {
            (Some(inside), Some(outside)) => sign * (outside - inside) > least,
            _ => false,
        }
    };
    let (near, far) = (ASIDE, 1.0 - ASIDE);
    let mut n_wrong = 0;
    for t in PLACES {
        let pairs = [
            ([t, near], [t, -near]),
            ([t, far], [t, 1.0 + near]),
            ([near, t], [-near, t]),
            ([far, t], [1.0 + near, t]),
        ];
        n_wrong += pairs
            .into_iter()
            .filter(|&(inside, outside)| !steps_up(inside, outside))
            .count();
        if n_wrong > MOST_WRONG {
            return Err(Rejection::FaintBorder);
        }
    }
    Ok(())
}
