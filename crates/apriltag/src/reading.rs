//! Reading a tag within a quad: grey models, bits, code word.
//!
//! In: an image and a quad. Out: which tag it is and how the quad's corners must be turned.

mod greys;
mod layout;

use crate::code_index::{CodeIndex, Match};
use crate::homography::Homography;
use crate::kernels::{POINTS, Points};
use crate::quad::{Quad, widths};
use crate::view::View;
use crate::{Options, Rejection};
use greys::{CLEARLY, Thresholds};
use layout::{Layout, MAX_BLOCKS};
use sextant_tag_families::{BorderColour, Family, FamilyData};
use std::collections::BTreeSet;

/// A family with its index.
#[derive(Debug)]
pub(crate) struct Reader {
    pub(crate) family: Family,
    data: &'static FamilyData,
    layout: Layout,
    /// Most of the area within the border that can have its colour.
    pub(crate) most_solid: f32,
    /// Least share of a border's rows that show something within it.
    pub(crate) least_open: f32,
    index: CodeIndex,
    /// Most modules with a bit that may be neither clearly black nor clearly white, where the family has few bits.
    most_in_doubt: usize,
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

/// Grey at the modules' middles in the order of the layout, NaN outside the image.
struct Modules {
    greys: [Points; MAX_BLOCKS],
    /// Width and height of a module, each at right angles to its sides.
    size_px: [f32; 2],
}

impl Modules {
    fn all(&self) -> &[f32] {
        self.greys.as_flattened()
    }
}

impl Reader {
    pub(crate) fn new(family: Family, options: &Options) -> Self {
        let data = family.data();
        let index = CodeIndex::new(data, options.max_hamming);
        Self {
            family,
            data,
            layout: Layout::new(data),
            most_solid: 1.0
                - LEFT_BY_BLUR * fewest_holes(data, data.border_width.pow(2), <[_]>::len),
            least_open: LEFT_BY_BLUR * fewest_holes(data, data.border_width, fewest_rows),
            most_in_doubt: (data.bits.len() / LEAST_PLAIN).min(index.bits_to_spare),
            index,
            min_contrast: f32::from(options.min_contrast),
            min_margin: options.min_margin,
        }
    }

    pub(crate) fn border(&self) -> BorderColour {
        self.data.border
    }

    pub(crate) fn read(&self, view: &View<'_>, quad: &Quad) -> Result<Reading, Unread> {
        let border = f32::from(self.data.border_width);
        let map =
            Homography::square_to_quad(quad, border).ok_or(Unread::hopeless(Rejection::Shape))?;
        let mut modules = Modules {
            greys: [[0.0; POINTS]; MAX_BLOCKS],
            size_px: widths(quad).map(|width| width / border),
        };
        let n_rings = self.layout.ring_blocks();
        view.sample(
            &map,
            &self.layout.places[..n_rings],
            &mut modules.greys[..n_rings],
        );
        let thresholds = self.thresholds(&modules)?;
        self.sample_bits(view, &map, &mut modules)
            .ok_or(Unread::hopeful(Rejection::NoCode))?;
        let bits = Bits::new(&self.layout, &modules, &thresholds);
        let reading = self.recognise(&bits, &thresholds)?;
        // Letters and texture show a code word of few bits now and then, so that the word alone is no evidence: border, ring
        // and bits must be all that a tag's are. The frame has three times as many modules as the word.
        let is_beyond_doubt = !self.index.is_weak
            || thresholds.rings_are_whole(&self.layout, modules.all(), self.data.border)
                && self.modules_are_plain(view, &map, &bits, &thresholds);
        if is_beyond_doubt {
            Ok(reading)
        } else {
            Err(Unread::hopeful(Rejection::NoCode))
        }
    }

    /// Whether the modules with a bit are clearly black or clearly white and have one colour throughout, but for as many as may
    /// be in doubt. Those of a tag with more and smaller modules, which now and then show a code word of a family of few bits,
    /// have not, or are grey where that tag is blurred.
    fn modules_are_plain(
        &self,
        view: &View<'_>,
        map: &Homography,
        bits: &Bits,
        thresholds: &Thresholds,
    ) -> bool {
        let mut greys = [[[0.0; POINTS]; MAX_BLOCKS]; 4];
        for (greys, places) in greys.iter_mut().zip(&self.layout.around) {
            view.sample(map, places, greys);
        }
        let clearly = CLEARLY * thresholds.contrast();
        let middles = bits.without_blur(USUAL_BLUR_PX);
        let is_in_doubt = |(i, middle): (usize, f32)| {
            let threshold = thresholds.at(self.layout.from_middle[self.layout.bits.start + i]);
            let other = |greys: &[Points; MAX_BLOCKS]| {
                middle.signum() * (greys.as_flattened()[i] - threshold) < -clearly
            };
            middle.abs() < clearly || greys.iter().any(other)
        };
        middles.enumerate().filter(|bit| is_in_doubt(*bit)).count() <= self.most_in_doubt
    }

    /// Black and white, as long as border and ring have them.
    fn thresholds(&self, modules: &Modules) -> Result<Thresholds, Unread> {
        let thresholds = Thresholds::new(&self.layout, modules.all(), self.data.border)
            .ok_or(Unread::hopeless(Rejection::FaintBorder))?;
        let contrast = thresholds.contrast();
        let hopeful = contrast > NEARLY * self.min_contrast
            && thresholds.rings_agree(&self.layout, modules.all(), self.data.border);
        if hopeful && contrast >= self.min_contrast {
            return Ok(thresholds);
        }
        Err(Unread {
            reason: Rejection::FaintBorder,
            hopeful,
        })
    }

    /// The modules that carry bits: one sample in the middle of a small one; four around it where there is room, against
    /// noise. Nothing when one lies outside the image.
    fn sample_bits(&self, view: &View<'_>, map: &Homography, modules: &mut Modules) -> Option<()> {
        const ROOMY_PX: f32 = 4.0;
        let layout = &self.layout;
        let bits = &mut modules.greys[layout.ring_blocks()..layout.places.len()];
        if modules.size_px[0].min(modules.size_px[1]) < ROOMY_PX {
            view.sample(map, &layout.places[layout.ring_blocks()..], bits);
        } else {
            let mut greys = [[0.0; POINTS]; MAX_BLOCKS];
            for places in &layout.around {
                view.sample(map, places, &mut greys);
                for (sum, grey) in bits.as_flattened_mut().iter_mut().zip(greys.as_flattened()) {
                    *sum += grey / layout.around.len() as f32;
                }
            }
        }
        let outside = bits.as_flattened().iter().any(|grey| grey.is_nan());
        (!outside).then_some(())
    }

    /// The code word under usual blur or, failing that, under strong blur.
    fn recognise(&self, bits: &Bits, thresholds: &Thresholds) -> Result<Reading, Unread> {
        let (usual, clarity) = bits.word(USUAL_BLUR_PX);
        let found = self.index.find(usual).map(|found| (found, clarity));
        // Fewer wrong bits: every further attempt is a further chance for what is no tag.
        let or_blurred = || {
            let (strong, margin) = bits.word(STRONG_BLUR_PX);
            let found = self.index.find(strong)?;
            (found.hamming <= 1).then_some((found, margin))
        };
        let (found, margin) = found.or_else(or_blurred).ok_or(Unread {
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
}

/// The modules with a bit: how far the grey of each is above the threshold, and by how much it is brighter than the modules to
/// its sides and than those above and below it, twice.
struct Bits {
    above: [[f32; 3]; MOST_BITS],
    count: usize,
    /// Width and height of a module.
    size_px: [f32; 2],
}

/// A code word is 64 bits at most.
const MOST_BITS: usize = 64;

impl Bits {
    fn new(layout: &Layout, modules: &Modules, thresholds: &Thresholds) -> Self {
        let greys = modules.all();
        let mut above = [[0.0; 3]; MOST_BITS];
        let seen = greys[layout.bits.clone()].iter();
        let places = layout.from_middle[layout.bits.clone()].iter();
        let bits = seen.zip(places).zip(&layout.beside);
        for (above, ((&grey, &place), beside)) in above.iter_mut().zip(bits) {
            let [left, right, top, bottom] = beside.map(|at| greys[usize::from(at)]);
            let twice = 2.0 * grey;
            *above = [
                grey - thresholds.at(place),
                twice - left - right,
                twice - top - bottom,
            ];
        }
        Self {
            above,
            count: layout.bits.len(),
            size_px: modules.size_px,
        }
    }

    /// The observed code word and its margin: the mean distance from the threshold of the weaker colour.
    fn word(&self, blur_px: f32) -> (u64, f32) {
        let (mut code, mut sum, mut distances) = (0_u64, 0.0, 0.0);
        for value in self.without_blur(blur_px) {
            code = code << 1 | u64::from(value > 0.0);
            sum += value;
            distances += value.abs();
        }
        let white = code.count_ones();
        let mean = |twice: f32, count: u32| twice / (2 * count.max(1)) as f32;
        let of_white = mean(distances + sum, white);
        (
            code,
            of_white.min(mean(distances - sum, self.count as u32 - white)),
        )
    }

    /// How far each bit's grey is above the threshold.
    ///
    /// What blur carries over from the neighbours, which matters where a module is hardly wider than the blur, is taken
    /// out: the inverse of a blur by modules of that width, fitted by a power law. A tag seen from the side is narrow one
    /// way only.
    fn without_blur(&self, blur_px: f32) -> impl Iterator<Item = f32> {
        let [across, down] = self
            .size_px
            .map(|width| (3.3 * (blur_px / width).powi(3)).min(0.5));
        self.above[..self.count].iter().map(move |[above, x, y]| {
            let edge = across * x + down * y;
            above + if edge.is_nan() { 0.0 } else { edge }
        })
    }
}

/// Share of the holes in a border that blur leaves.
const LEFT_BY_BLUR: f32 = 0.3;

/// Of the places within the border those without its colour, in the tag that has fewest of them by some count, and that as a
/// share of `all`.
fn fewest_holes(data: &FamilyData, all: u8, count: impl Fn(&[(i8, i8)]) -> usize) -> f32 {
    let edge = 0..data.border_width as i8;
    let holes = data.codes.iter().map(|code| {
        let bits = data.bits.iter().rev().enumerate();
        let holes = bits.filter(|(i, (x, y))| {
            let white = code >> i & 1 == 1;
            edge.contains(x) && edge.contains(y) && white == (data.border == BorderColour::Black)
        });
        count(&holes.map(|(_, place)| *place).collect::<Vec<_>>())
    });
    holes.min().unwrap_or(0) as f32 / f32::from(all)
}

/// How many rows, or columns where those are fewer, some places lie in.
fn fewest_rows(places: &[(i8, i8)]) -> usize {
    let distinct = |at: fn(&(i8, i8)) -> i8| places.iter().map(at).collect::<BTreeSet<_>>().len();
    distinct(|place| place.0).min(distinct(|place| place.1))
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

/// Among so many modules with a bit one may be in doubt: blur and corners a pixel off make some of those of a tag.
const LEAST_PLAIN: usize = 5;

/// Share of the least contrast that a border may show between corners a pixel off.
const NEARLY: f32 = 0.5;

/// Mean distance of a tag's bits of either colour from the threshold, as a share of the contrast: half in a sharp picture,
/// a fifth between corners several pixels off; next to nothing where there are no bits of one colour.
const LEAST_CLARITY: f32 = 0.1;

/// Blur that most images have and blur of a lens out of focus or a hand that shook, as standard deviations in pixels.
const USUAL_BLUR_PX: f32 = 0.75;
const STRONG_BLUR_PX: f32 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_family_of_many_words_forgives_fewer_modules_in_doubt() {
        let most_in_doubt = |family: Family| Reader::new(family, &Options::default()).most_in_doubt;
        assert_eq!(most_in_doubt(Family::Tag16h5), 3);
        assert_eq!(most_in_doubt(Family::Aruco4x4With50), 3);
        assert_eq!(most_in_doubt(Family::Aruco4x4With1000), 0);
    }
}
