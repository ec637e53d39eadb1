//! Reading a tag within a quad: black and white, bits, code word.
//!
//! In: an image and a quad. Out: which tag it is and how the quad's corners must be turned.

mod layout;
mod modules;

use crate::code_index::{CodeIndex, Match};
use crate::quad::Quad;
use crate::view::View;
use crate::{Options, Pass, Rejection};
use layout::Layout;
use modules::{Modules, USUAL_BLUR_PX};
use sextant_tag_families::{Board, BorderColour, Family, FamilyData};
use std::collections::BTreeSet;

/// A family with its index.
#[derive(Debug)]
pub(crate) struct Reader {
    pub(crate) family: Family,
    border: BorderColour,
    /// Whether black squares touch the tags' borders.
    is_touched: bool,
    layout: Layout,
    /// Least share of the rows of its border in which something shows.
    pub(crate) least_open: f32,
    index: CodeIndex,
    /// Most modules with a bit that may be neither clearly black nor clearly white, where the family has few bits.
    most_in_doubt: usize,
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
        let index = CodeIndex::new(data, options.max_hamming);
        Self {
            family,
            border: data.border,
            is_touched: data.board == Some(Board::Aprilgrid),
            layout: Layout::new(data),
            least_open: least_open(data),
            most_in_doubt: (data.bits.len() / LEAST_PLAIN).min(index.bits_to_spare),
            index,
            min_margin: options.min_margin,
        }
    }

    /// Whether the family's tags may show in a pass.
    pub(crate) fn takes_part_in(&self, pass: Pass) -> bool {
        self.border == pass.border() && (pass != Pass::Eroded || self.is_touched)
    }

    #[inline(always)]
    pub(crate) fn read(&self, view: &View<'_>, quad: &Quad) -> Result<Reading, Unread> {
        let mut modules =
            Modules::new(view, &self.layout, quad).map_err(|reason| unread(reason, false))?;
        let (contrast, right) = (modules.contrast(), modules.right_in_rings());
        let rings_agree = right.into_iter().all(|share| share >= LEAST_RIGHT);
        let is_nearly_clear = contrast > NEARLY * view.min_contrast;
        if !rings_agree || contrast < view.min_contrast {
            return Err(unread(
                Rejection::FaintBorder,
                rings_agree && is_nearly_clear,
            ));
        }
        if !modules.sample_bits() {
            return Err(unread(Rejection::NoCode, true));
        }
        let rings_are_right = (right[0] + right[1]) / 2.0 >= MOSTLY_RIGHT;
        let reading = self.recognise(&modules, rings_are_right)?;
        // Letters and texture show a code word of few bits now and then, so that the word alone is no evidence: border, ring
        // and bits must be all that a tag's are. The frame has three times as many modules as the word.
        if self.index.is_weak
            && !(modules.rings_are_whole() && modules.n_in_doubt() <= self.most_in_doubt)
        {
            return Err(unread(Rejection::NoCode, true));
        }
        Ok(reading)
    }

    /// The code word under usual blur or, failing that, under strong blur.
    #[inline(always)]
    fn recognise(&self, modules: &Modules<'_>, rings_are_right: bool) -> Result<Reading, Unread> {
        let (usual, clarity) = modules.word(USUAL_BLUR_PX);
        let found = self.index.find(usual).map(|found| (found, clarity));
        // Fewer wrong bits: every further attempt is a further chance for what is no tag.
        let or_blurred = || {
            let (strong, margin) = modules.word(STRONG_BLUR_PX);
            let found = (strong != usual).then(|| self.index.find(strong))??;
            (found.hamming <= 1).then_some((found, margin))
        };
        let is_clear = clarity > LEAST_CLARITY * modules.contrast() && modules.are_small();
        let no_code = unread(Rejection::NoCode, rings_are_right && is_clear);
        let (found, margin) = found.or_else(or_blurred).ok_or(no_code)?;
        if margin < self.min_margin {
            return Err(unread(Rejection::SmallMargin, true));
        }
        let word = self.index.as_seen(&found);
        if self.border == BorderColour::Black && !modules.white_ends_at_the_border(word) {
            return Err(unread(Rejection::NoCode, true));
        }
        let [black, white] = modules.black_and_white();
        Ok(Reading {
            family: self.family,
            found,
            margin,
            black,
            white,
        })
    }
}

/// Share of the rows of a border, or of its columns where those are fewer, that show something within it: in the code word
/// where those are fewest, as far as blur leaves it.
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

/// Why a tag was not read, and whether it might be with better corners: corners that are a pixel off leave border and
/// ring mostly right, and bits of both colours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unread {
    pub(crate) reason: Rejection,
    pub(crate) hopeful: bool,
}

fn unread(reason: Rejection, hopeful: bool) -> Unread {
    Unread { reason, hopeful }
}

/// Among so many modules with a bit one may be in doubt: blur and corners a pixel off make some of those of a tag.
const LEAST_PLAIN: usize = 5;

/// Share of the modules of border and of ring that have their colours at least: an occluded corner is forgiven.
const LEAST_RIGHT: f32 = 0.75;

/// As much of both together where better corners may help: those a pixel off leave it so in all but tags hidden in part.
const MOSTLY_RIGHT: f32 = 0.85;

/// Share of the least contrast that a border may show between corners a pixel off.
const NEARLY: f32 = 0.8;

/// Mean distance of a tag's bits of either colour from the threshold, as a share of the contrast: half in a sharp picture, less
/// where blur or corners more than a pixel off mix neighbours; next to nothing where there are no bits of one colour.
const LEAST_CLARITY: f32 = 0.25;

/// Blur of a lens out of focus or a hand that shook, as a standard deviation in pixels.
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
