//! Other ways to read an image in which no tag was found: inverted, mirrored, with other families.
//!
//! Input: an image and the options without success. Output: what would have been found otherwise, as a hint for people.
//! It takes several detections and allocates, so that it is not for every image.

use crate::{Detection, Detector, Family, Image, Options};
use std::fmt;

/// Tags that an image shows, though not to a detector with the options given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alternative {
    /// Number of tags.
    pub n_tags: usize,
    /// Their families, each once.
    pub families: Vec<Family>,
    /// Whether they are printed inverted, white for black.
    pub inverted: bool,
    /// Whether they are mirrored: no corners of theirs are worth anything, since the picture is not what a camera sees.
    pub mirrored: bool,
}

/// Least bits of a family of which one tag is evidence.
const MANY_BITS: usize = 30;

/// Least tags of families of fewer bits: texture has some.
const FEW_BITS_TAGS: usize = 3;

impl Alternative {
    /// The way to read most tags, among those that differ from the options; `None` if there is none. The other families
    /// are tried as well as those of the options.
    pub fn find(image: &Image<'_>, options: &Options, others: &[Family]) -> Option<Self> {
        let mirrored = mirrored(image);
        let flipped = image.with_pixels(&mirrored);
        let mut best: Option<Self> = None;
        for families in [options.families.as_slice(), others] {
            for (is_mirrored, inverts) in
                [(false, false), (false, true), (true, false), (true, true)]
            {
                let is_as_before = families == options.families && !is_mirrored && !inverts;
                if is_as_before {
                    continue;
                }
                let inverted = options.inverted != inverts;
                let options = Options {
                    families: families.to_vec(),
                    inverted,
                    ..options.clone()
                };
                // Refused where there are no other families.
                let Ok(mut detector) = Detector::new(options) else {
                    continue;
                };
                let image = if is_mirrored { &flipped } else { image };
                let found = Self {
                    inverted,
                    mirrored: is_mirrored,
                    ..Self::from_tags(detector.detect(image))
                };
                let most = best.as_ref().map_or(0, |best| best.n_tags);
                if found.n_tags > most {
                    best = Some(found);
                }
            }
        }
        best
    }

    /// The tags that were read without a wrong bit, of the families of which there is evidence.
    fn from_tags(tags: &[Detection]) -> Self {
        let read = |family: Family| {
            let read = tags.iter().filter(move |tag| tag.hamming == 0);
            read.filter(|tag| tag.family == family).count()
        };
        let mut families: Vec<Family> = tags.iter().map(|tag| tag.family).collect();
        families.dedup();
        families.retain(|&family| match family.data().bits.len() {
            MANY_BITS.. => read(family) > 0,
            _ => read(family) >= FEW_BITS_TAGS,
        });
        Self {
            n_tags: families.iter().map(|&family| read(family)).sum(),
            families,
            inverted: false,
            mirrored: false,
        }
    }
}

/// `3 inverted tags of tag36h11`.
impl fmt::Display for Alternative {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let inverted = if self.inverted { "inverted " } else { "" };
        let mirrored = if self.mirrored { "mirrored " } else { "" };
        let plural = if self.n_tags == 1 { "" } else { "s" };
        write!(f, "{} {inverted}{mirrored}tag{plural} of ", self.n_tags)?;
        for (i, family) in self.families.iter().enumerate() {
            write!(f, "{}{family}", if i == 0 { "" } else { " and " })?;
        }
        Ok(())
    }
}

fn mirrored(image: &Image<'_>) -> Vec<u8> {
    let rows = (0..image.height()).map(|y| image.row(y));
    rows.flat_map(|row| row.iter().rev()).copied().collect()
}
