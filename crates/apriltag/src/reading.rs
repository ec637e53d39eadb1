//! Reading a tag within a quad: border vote, grey models, bits, code word.
//!
//! In: an image and a quad. Out: which tag it is and how the quad's corners must be turned. The grey models of black and
//! white are planes over the tag, from its border and the ring around it, as in AprilTag 2 (Wang & Olson, IROS 2016).

use crate::code_index::{CodeIndex, Match};
use crate::homography::Homography;
use crate::quad::{Point, Quad, mean_edge};
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

    pub(crate) fn read(&self, image: &Image<'_>, quad: &Quad) -> Result<Reading, Rejection> {
        let mut modules = Modules::sample(image, quad, self.data).ok_or(Rejection::FaintBorder)?;
        let (black, white) = modules.subtract_thresholds(self.data);
        if white - black < self.min_contrast || !modules.border_agrees(self.data) {
            return Err(Rejection::FaintBorder);
        }
        modules.sharpen();
        let (observed, margin) = modules.bits(self.data).ok_or(Rejection::NoCode)?;
        let found = self.index.find(observed).ok_or(Rejection::NoCode)?;
        if margin < self.min_margin {
            return Err(Rejection::SmallMargin);
        }
        Ok(Reading {
            family: self.family,
            found,
            margin,
            black,
            white,
        })
    }
}

/// Grey values at the modules' centres, NaN outside the image; first row and column are the printed tag's.
struct Modules {
    values: [[f32; MAX_MODULES]; MAX_MODULES],
    width: usize,
    module_px: f32,
}

impl Modules {
    fn sample(image: &Image<'_>, quad: &Quad, data: &FamilyData) -> Option<Self> {
        let border = f32::from(data.border_width);
        let homography = Homography::square_to_quad(quad, border)?;
        let margin = f32::from(data.margin());
        let width = usize::from(data.total_width);
        let module_px = mean_edge(quad) / border;
        let mut values = [[f32::NAN; MAX_MODULES]; MAX_MODULES];
        for (y, row) in values[..width].iter_mut().enumerate() {
            for (x, value) in row[..width].iter_mut().enumerate() {
                let centre = [x as f32 + 0.5 - margin, y as f32 + 0.5 - margin];
                *value = sample_module(image, &homography, centre, module_px);
            }
        }
        Some(Self {
            values,
            width,
            module_px,
        })
    }

    /// The modules of a ring around the border (-1) or of the border itself (0), each with its place.
    fn ring<'a>(&'a self, data: &FamilyData, ring: i8) -> impl Iterator<Item = (Point, f32)> + 'a {
        let (first, last) = (
            (data.margin() - ring) as usize,
            self.width - 1 - (data.margin() - ring) as usize,
        );
        let along = first..=last;
        let rows = [first, last]
            .into_iter()
            .flat_map(move |y| along.clone().map(move |x| (x, y)));
        let columns = [first, last]
            .into_iter()
            .flat_map(move |x| (first + 1..last).map(move |y| (x, y)));
        let middle = (self.width - 1) as f32 / 2.0;
        let place = move |(x, y): (usize, usize)| {
            ([x as f32 - middle, y as f32 - middle], self.values[y][x])
        };
        rows.chain(columns).map(place)
    }

    /// Makes each value relative to the threshold at its place; returns the mean grey of black and white.
    fn subtract_thresholds(&mut self, data: &FamilyData) -> (f32, f32) {
        let (border, around) = (
            GreyPlane::fit(self.ring(data, 0)),
            GreyPlane::fit(self.ring(data, 1)),
        );
        let middle = (self.width - 1) as f32 / 2.0;
        for (y, row) in self.values[..self.width].iter_mut().enumerate() {
            for (x, value) in row[..self.width].iter_mut().enumerate() {
                let place = [x as f32 - middle, y as f32 - middle];
                *value -= (border.at(place) + around.at(place)) / 2.0;
            }
        }
        match data.border {
            BorderColour::Black => (border.mean, around.mean),
            BorderColour::White => (around.mean, border.mean),
        }
    }

    /// Border and ring must by and large have the colours that they should; an occluded corner is forgiven.
    fn border_agrees(&self, data: &FamilyData) -> bool {
        const LEAST_SHARE: f32 = 0.75;
        let sign = if data.border == BorderColour::Black {
            1.0
        } else {
            -1.0
        };
        let share = |ring: i8, sign: f32| {
            let (mut right, mut all) = (0, 0);
            for (_, value) in self.ring(data, ring).filter(|(_, value)| !value.is_nan()) {
                right += u32::from(value * sign > 0.0);
                all += 1;
            }
            all > 0 && right as f32 >= LEAST_SHARE * all as f32
        };
        share(0, -sign) && share(1, sign)
    }

    /// Takes out what blur carries over from the four neighbours, which matters where a module is hardly wider than the
    /// blur: the inverse of a blur of 0.75 px by modules of that width, fitted by a power law.
    fn sharpen(&mut self) {
        let strength = (1.4 / self.module_px.powi(3)).min(0.5);
        let blurred = self.values;
        let last = self.width - 1;
        for y in 1..last {
            for x in 1..last {
                let around =
                    blurred[y - 1][x] + blurred[y + 1][x] + blurred[y][x - 1] + blurred[y][x + 1];
                let edge = 4.0 * blurred[y][x] - around;
                if edge.is_finite() {
                    self.values[y][x] += strength * edge;
                }
            }
        }
    }

    /// The observed code word and its margin; nothing when a bit lies outside the image.
    fn bits(&self, data: &FamilyData) -> Option<(u64, f32)> {
        let (mut code, mut sums, mut counts) = (0, [0.0, 0.0], [0, 0]);
        for &(x, y) in data.bits {
            let value = self.values[(y + data.margin()) as usize][(x + data.margin()) as usize];
            if value.is_nan() {
                return None;
            }
            let bit = usize::from(value > 0.0);
            code = code << 1 | bit as u64;
            sums[bit] += value.abs();
            counts[bit] += 1;
        }
        let mean = |bit: usize| sums[bit] / counts[bit].max(1) as f32;
        Some((code, mean(0).min(mean(1))))
    }
}

/// One sample in the middle of a small module; four around it where there is room, against noise.
fn sample_module(image: &Image<'_>, homography: &Homography, [u, v]: Point, module_px: f32) -> f32 {
    const ROOMY_PX: f32 = 4.0;
    const ASIDE: f32 = 0.2;
    let sample = |du, dv| {
        image
            .sample(homography.apply(u + du, v + dv))
            .unwrap_or(f32::NAN)
    };
    if module_px < ROOMY_PX {
        return sample(0.0, 0.0);
    }
    let aside = [
        (-ASIDE, -ASIDE),
        (ASIDE, -ASIDE),
        (-ASIDE, ASIDE),
        (ASIDE, ASIDE),
    ];
    aside
        .into_iter()
        .map(|(du, dv)| sample(du, dv))
        .sum::<f32>()
        / 4.0
}

/// grey = mean + slope . place
struct GreyPlane {
    mean: f32,
    slope: Point,
}

impl GreyPlane {
    /// Least squares over places that lie symmetrically about the middle, so that mean and slopes part. Where some are
    /// missing, the mean alone.
    fn fit(samples: impl Iterator<Item = (Point, f32)>) -> Self {
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
        Self {
            mean: sum / n,
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
    const PLACES: [f32; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
    /// Half a module of the families with the narrowest border, as a share of the edge.
    const ASIDE: f32 = 1.0 / 16.0;
    const LEAST_RIGHT: usize = 15;
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
    let right = PLACES.iter().flat_map(|&t| {
        let (near, far) = (ASIDE, 1.0 - ASIDE);
        [
            ([t, near], [t, -near]),
            ([t, far], [t, 1.0 + near]),
            ([near, t], [-near, t]),
            ([far, t], [1.0 + near, t]),
        ]
    });
    let n_right = right
        .filter(|&(inside, outside)| steps_up(inside, outside))
        .count();
    if n_right >= LEAST_RIGHT {
        Ok(())
    } else {
        Err(Rejection::FaintBorder)
    }
}
