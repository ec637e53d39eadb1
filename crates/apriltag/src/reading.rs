//! Reading a tag within a quad: black and white, bits, code word.
//!
//! Input: an image and a quad. Output: the tag, and the rotation that makes the quad upright.

mod layout;
mod modules;

use crate::code_index::{self, CodeIndex};
use crate::match_quality::{self, Match};
use crate::quad::Quad;
use crate::view::ImageView;
use crate::{Options, Pass, Rejection};
use layout::ModuleLayout;
use modules::{Modules, RimWidth, USUAL_BLUR_PX};
use sextant_tag_families::{BorderColour, Family, FamilyData};
use std::collections::BTreeSet;

/// A family with its index.
#[derive(Debug)]
pub(crate) struct Reader {
    pub(crate) family: Family,
    border: BorderColour,
    layout: ModuleLayout,
    /// Least share of the rows within its border that contain white.
    pub(crate) least_open: f32,
    index: CodeIndex,
    /// Most ambiguous modules, neither clearly black nor clearly white, in a family with few bits.
    most_in_doubt: usize,
    min_margin: f32,
}

/// A decoded tag.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    pub(crate) family: Family,
    pub(crate) found: code_index::Match,
    pub(crate) margin: f32,
    /// Mean grey of the border and of the ring around it.
    pub(crate) black: f32,
    pub(crate) white: f32,
    /// Whether the word is enough evidence, or all of the tag is as its pattern says.
    pub(crate) is_evident: bool,
}

impl Reader {
    pub(crate) fn new(family: Family, options: &Options) -> Self {
        let data = family.data();
        let index = CodeIndex::new(data, options.max_hamming);
        Self {
            family,
            border: data.border,
            layout: ModuleLayout::new(data),
            least_open: least_open(data),
            most_in_doubt: (data.bits.len() / LEAST_PLAIN).min(index.bits_to_spare),
            index,
            min_margin: options.min_margin,
        }
    }

    /// Whether a pass can find tags of the family.
    pub(crate) fn takes_part_in(&self, pass: Pass) -> bool {
        self.border == pass.border()
    }

    /// Border and ring, and their shares of right modules, if both have their colours.
    #[inline(always)]
    fn see<'a>(
        &'a self,
        view: &'a ImageView<'a>,
        quad: &Quad,
        rim: RimWidth,
    ) -> Result<(Modules<'a>, [f32; 2]), ReadFailure> {
        let modules = Modules::new(view, &self.layout, quad, rim)
            .map_err(|reason| ReadFailure::new(reason, false))?;
        let (contrast, right) = (modules.contrast(), modules.right_in_rings());
        let rings_agree = right.into_iter().all(|share| share >= LEAST_RIGHT);
        let is_nearly_clear = contrast > NEARLY * view.min_contrast;
        if rings_agree && contrast >= view.min_contrast {
            return Ok((modules, right));
        }
        // Then the border is dark, or nothing is lighter than it a module away.
        let may_have_narrow_rim = right[0] >= LEAST_RIGHT || contrast.abs() < view.min_contrast;
        Err(ReadFailure {
            may_have_narrow_rim,
            ..ReadFailure::new(Rejection::FaintBorder, rings_agree && is_nearly_clear)
        })
    }

    #[inline(always)]
    pub(crate) fn read(&self, view: &ImageView<'_>, quad: &Quad) -> Result<Reading, ReadFailure> {
        let (mut modules, right) = match self.see(view, quad, RimWidth::Module) {
            Ok(seen) => seen,
            Err(failure) if failure.may_have_narrow_rim => self
                .see(view, quad, RimWidth::Narrow)
                .map_err(|_| failure)?,
            Err(failure) => return Err(failure),
        };
        if !modules.sample_bits() {
            return Err(ReadFailure::new(Rejection::NoCode, true));
        }
        let rings_are_right = (right[0] + right[1]) / 2.0 >= MOSTLY_RIGHT;
        let reading = self.recognise(&mut modules, rings_are_right)?;
        if !self.index.is_weak {
            return Ok(reading);
        }
        // Letters and texture show a code word of few bits now and then, so that the word alone is no evidence.
        let mut upright = *quad;
        upright.rotate_left(reading.found.turns as usize);
        let Match {
            explained,
            is_evident,
        } = match_quality::measure(view.image, &upright, self.family, reading.found.id);
        let n_in_doubt = modules.n_in_doubt();
        let spare = match self.index.is_symmetric(&reading.found) {
            true => 0,
            false => DOUBT_IF_EXPLAINED,
        };
        let is_evident = is_evident && n_in_doubt <= self.most_in_doubt + spare
            || spare > 0
                && explained >= EXPLAINED_IF_WHOLE
                && n_in_doubt <= self.most_in_doubt
                && modules.rings_are_whole();
        let may_be_evident =
            explained >= EXPLAINED_IN_DOUBT && n_in_doubt <= self.most_in_doubt + spare;
        if !is_evident && !may_be_evident {
            return Err(ReadFailure::new(Rejection::NoCode, true));
        }
        Ok(Reading {
            is_evident,
            ..reading
        })
    }

    /// The code word, assuming usual blur or, if that fails, strong blur, or something drawn over the tag.
    #[inline(always)]
    fn recognise(
        &self,
        modules: &mut Modules<'_>,
        rings_are_right: bool,
    ) -> Result<Reading, ReadFailure> {
        let (usual, clarity) = modules.word(USUAL_BLUR_PX);
        let found = self.index.find(usual).map(|found| (found, clarity));
        // Fewer wrong bits: every further attempt is a further chance for what is no tag.
        let again = |(word, margin): (u64, f32)| {
            let found = (word != usual).then(|| self.index.find(word))??;
            (found.hamming <= 1).then_some((found, margin))
        };
        let is_clear = clarity > LEAST_CLARITY * modules.contrast();
        let no_code = ReadFailure::new(
            Rejection::NoCode,
            rings_are_right && is_clear && modules.are_small(),
        );
        let found = found.or_else(|| again(modules.word(STRONG_BLUR_PX)));
        let found = found.or_else(|| {
            let spread = rings_are_right && is_clear && modules.narrowest_px() >= SPREAD_PX;
            spread.then(|| modules.spread_bits())?;
            again(modules.word(USUAL_BLUR_PX))
        });
        let (found, margin) = found.ok_or(no_code)?;
        if margin < self.min_margin {
            return Err(ReadFailure::new(Rejection::SmallMargin, true));
        }
        let word = self.index.as_seen(&found);
        if self.border == BorderColour::Black && !modules.white_ends_at_the_border(word) {
            return Err(ReadFailure::new(Rejection::NoCode, true));
        }
        let [black, white] = modules.black_and_white();
        Ok(Reading {
            family: self.family,
            found,
            margin,
            black,
            white,
            is_evident: true,
        })
    }
}

/// Share of the rows within a border, or of its columns if these are fewer, that contain white: of the code word with
/// the fewest, reduced by blur.
fn least_open(data: &FamilyData) -> f32 {
    const LEFT_BY_BLUR: f32 = 0.3;
    let edge = 0..data.border_width as i8;
    let open = data.codes.iter().map(|code| {
        let bits = data.bits.iter().rev().enumerate();
        let holes = bits.filter(|(i, (x, y))| {
            let white = code >> i & 1 == 1;
            edge.contains(x) && edge.contains(y) && white == (data.border == BorderColour::Black)
        });
        let (columns, rows): (BTreeSet<_>, BTreeSet<_>) = holes.map(|(_, place)| *place).unzip();
        columns.len().min(rows.len())
    });
    LEFT_BY_BLUR * open.min().unwrap_or(0) as f32 / f32::from(data.border_width)
}

/// Why a tag was not decoded, and whether better corners might help: with corners off by a pixel, border and ring are
/// still mostly right, and there are bits of both colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadFailure {
    pub(crate) reason: Rejection,
    pub(crate) can_retry: bool,
    /// Whether the ring may be narrower than a module.
    may_have_narrow_rim: bool,
}

impl ReadFailure {
    pub(crate) fn new(reason: Rejection, can_retry: bool) -> Self {
        Self {
            reason,
            can_retry,
            may_have_narrow_rim: false,
        }
    }
}

/// Share of the variance that a pattern explains at least, where border, ring and bits leave no doubt; and where it may
/// explain enough with better corners.
const EXPLAINED_IF_WHOLE: f32 = 0.7;
const EXPLAINED_IN_DOUBT: f32 = 0.5;

/// How many more modules may be in doubt if the pattern explains enough: in blurred tags with modules of another
/// number, whose words are those of a family now and then, more are.
const DOUBT_IF_EXPLAINED: usize = 1;

/// One in this many data modules may be ambiguous: blur and corners off by a pixel cause some in a real tag.
const LEAST_PLAIN: usize = 5;

/// Least share of the modules of border and ring with the right colour: one corner may be occluded.
const LEAST_RIGHT: f32 = 0.75;

/// Least share of right modules of border and ring for a retry with better corners.
const MOSTLY_RIGHT: f32 = 0.85;

/// Share of the least contrast that is required while corners may be off by a pixel.
const NEARLY: f32 = 0.8;

/// Least mean distance of the bits of each colour from the threshold, as a share of the contrast. It is a half in a
/// sharp image, less with blur or wrong corners, and almost zero without bits of one colour.
const LEAST_CLARITY: f32 = 0.25;

/// Strong blur, from defocus or camera shake, as a standard deviation in pixels.
const STRONG_BLUR_PX: f32 = 2.0;

/// Width of a module from which on points all over it show no other one.
const SPREAD_PX: f32 = 5.0;

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
