//! Decodes an observed code word, possibly rotated and with bit errors, to the id of a tag.
//!
//! At most two bit errors affect at most two of three quarters of the word, so one of the first three quarters of the
//! right word is correct: an index by quarter leaves a handful of code words to compare.

use sextant_tag_families::{FamilyData, rotate_code};

/// Most bit errors that the index can correct.
pub(crate) const MAX_HAMMING: u32 = 2;

const PARTS: usize = MAX_HAMMING as usize + 1;

/// A code word that matches an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Match {
    pub(crate) id: u32,
    pub(crate) hamming: u32,
    /// Quarter turns counter-clockwise that make the observed pattern upright.
    pub(crate) turns: u32,
}

#[derive(Debug)]
pub(crate) struct CodeIndex {
    codes: &'static [u64],
    n_bits: usize,
    part_bits: usize,
    max_hamming: u32,
    /// Whether what is no tag often matches a code word: the family has few bits, or has words as plain as a single
    /// white bar.
    pub(crate) is_weak: bool,
    /// Most ambiguous bits with which a match is still significant.
    pub(crate) bits_to_spare: usize,
    /// Ids of the code words by the value of each quarter.
    ids: Vec<Vec<u16>>,
}

impl CodeIndex {
    pub(crate) fn new(family: &FamilyData, max_hamming: u8) -> Self {
        let n_bits = family.bits.len();
        let part_bits = n_bits.div_ceil(4);
        let most = u32::from(max_hamming)
            .min(correctable(family))
            .min(MAX_HAMMING);
        let mut index = Self {
            codes: family.codes,
            n_bits,
            part_bits,
            max_hamming: most,
            is_weak: chance(family, 0) > MOST_CHANCE || family.min_hamming < LEAST_DISTANCE,
            bits_to_spare: bits_to_spare(family),
            ids: vec![Vec::new(); PARTS << part_bits],
        };
        for (id, &code) in (0..=u16::MAX).zip(index.codes) {
            for part in 0..PARTS {
                let place = index.place(code, part);
                index.ids[place].push(id);
            }
        }
        index
    }

    /// The matched code word without errors, in the orientation of the observation.
    pub(crate) fn as_seen(&self, found: &Match) -> u64 {
        let code = self.codes[found.id as usize];
        rotate_code(code, self.n_bits, (4 - found.turns) % 4)
    }

    /// Whether a word is the same upside down, as a white bar is: of these there are more in any picture.
    pub(crate) fn is_symmetric(&self, found: &Match) -> bool {
        let code = self.codes[found.id as usize];
        rotate_code(code, self.n_bits, 2) == code
    }

    /// Range of the ids with this value of a quarter.
    fn place(&self, code: u64, part: usize) -> usize {
        let value = code >> (part * self.part_bits) & ((1 << self.part_bits) - 1);
        part << self.part_bits | value as usize
    }

    /// The nearest code word within the allowed distance; exact ones first, then fewer turns, then those found by
    /// earlier parts.
    pub(crate) fn find(&self, observed: u64) -> Option<Match> {
        let mut nearest = None;
        let mut allowed = self.max_hamming + 1;
        for turns in 0..4 {
            let upright = rotate_code(observed, self.n_bits, turns);
            for part in 0..PARTS {
                for &id in &self.ids[self.place(upright, part)] {
                    let hamming = (self.codes[usize::from(id)] ^ upright).count_ones();
                    if hamming < allowed {
                        let id = u32::from(id);
                        (allowed, nearest) = (hamming, Some(Match { id, hamming, turns }));
                    }
                }
            }
        }
        nearest
    }
}

/// Probability that random bits match a code word in some orientation beyond which a family needs stricter checks.
const MOST_CHANCE: f64 = 5e-4;

/// Least distance of a family that was chosen for it, and so lacks plain words such as a single white bar.
const LEAST_DISTANCE: u8 = 3;

/// Number of bit errors to correct: at most what the family's distance allows, and so few that random bits match a code
/// word in some orientation with a probability of `MOST_CHANCE` at most, or no more often than without correction.
fn correctable(family: &FamilyData) -> u32 {
    let by_distance = u32::from(family.min_hamming.saturating_sub(1) / 2);
    (1..=by_distance)
        .take_while(|&wrong| chance(family, wrong) <= MOST_CHANCE)
        .last()
        .unwrap_or(0)
}

/// Most ambiguous bits. Each doubles the probability that random bits match a code word; beyond one in thirty the code
/// word adds too little evidence to a complete border.
fn bits_to_spare(family: &FamilyData) -> usize {
    const HARDLY_WORTH: f64 = 1.0 / 32.0;
    let doublings = (HARDLY_WORTH / chance(family, 0)).log2();
    doublings.max(0.0) as usize
}

/// Probability that random bits match a code word of the family in some orientation up to this number of bit errors.
fn chance(family: &FamilyData, wrong: u32) -> f64 {
    let n_bits = family.bits.len() as u32;
    let (mut near, mut nearer) = (1.0, 1.0);
    for wrong in 1..=wrong {
        near *= f64::from(n_bits - wrong + 1) / f64::from(wrong);
        nearer += near;
    }
    (4 * family.codes.len()) as f64 / 2_f64.powi(n_bits as i32) * nearer
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use sextant_tag_families::Family;

    #[test]
    fn every_code_word_is_found_under_every_turn() {
        for family in Family::coded() {
            let data = family.data();
            let index = CodeIndex::new(data, 2);
            for (id, &code) in data.codes.iter().enumerate() {
                let is_same_turned = rotate_code(code, data.bits.len(), 2) == code;
                for turns in 0..if is_same_turned { 2 } else { 4 } {
                    let observed = rotate_code(code, data.bits.len(), (4 - turns) % 4);
                    assert_eq!(
                        index.find(observed),
                        Some(Match {
                            id: id as u32,
                            hamming: 0,
                            turns
                        })
                    );
                }
            }
        }
    }

    #[test]
    fn families_of_few_bits_get_fewer_corrected() {
        let corrected = |family: Family| CodeIndex::new(family.data(), 2).max_hamming;
        assert_eq!(corrected(Family::Tag36h11), 2);
        assert_eq!(corrected(Family::TagStandard41h12), 2);
        assert_eq!(corrected(Family::Tag25h9), 1);
        assert_eq!(corrected(Family::Tag16h5), 0);
    }

    #[test]
    fn families_of_few_bits_or_plain_words_need_stricter_checks() {
        let is_weak = |family: Family| CodeIndex::new(family.data(), 2).is_weak;
        assert!(is_weak(Family::Tag16h5) && is_weak(Family::ArucoOriginal));
        assert!(!is_weak(Family::Aruco5x5With1000) && !is_weak(Family::Tag25h9));
    }

    #[test]
    fn the_more_words_a_family_has_the_fewer_bits_may_be_in_doubt() {
        let to_spare = |family: Family| CodeIndex::new(family.data(), 2).bits_to_spare;
        assert_eq!(to_spare(Family::Tag16h5), 4);
        assert_eq!(to_spare(Family::Aruco4x4With50), 3);
        assert_eq!(to_spare(Family::Aruco4x4With250), 1);
        assert_eq!(to_spare(Family::Aruco4x4With1000), 0);
    }

    /// The code word seen in a mirror.
    fn mirrored(data: &FamilyData, code: u64) -> u64 {
        let last = data.border_width as i8 - 1;
        let n_bits = data.bits.len();
        let bit = |at: (i8, i8)| {
            let i = data.bits.iter().position(|bit| *bit == at).unwrap();
            code >> (n_bits - 1 - i) & 1
        };
        data.bits
            .iter()
            .fold(0, |word, &(x, y)| word << 1 | bit((last - x, y)))
    }

    /// The dictionaries do not exclude mirror images of their words; larger ones have more of them.
    #[test]
    fn a_mirrored_tag_is_no_tag_but_in_dictionaries_that_have_that_word_too() {
        for family in Family::coded() {
            let data = family.data();
            let index = CodeIndex::new(data, 2);
            let is_word = |code: &&u64| index.find(mirrored(data, **code)).is_some();
            let n = data.codes.iter().filter(is_word).count();
            let known = match family.name().trim_start_matches("ch") {
                // Made of lines of bits in any order, so that each word is another one in a mirror.
                "aruco-original" => 1024,
                "aruco4x4-50" => 4,
                "aruco4x4-100" => 7,
                "aruco-mip-16h3" => 12,
                "aruco4x4-250" => 14,
                "aruco4x4-1000" => 92,
                "aruco5x5-1000" => 3,
                "aruco6x6-1000" | "tag36h10" => 2,
                "aruco5x5-250" | "tagStandard41h12" | "tagCircle49h12" => 1,
                _ => 0,
            };
            assert_eq!(n, known, "{family}");
        }
    }

    proptest! {
        #[test]
        fn two_wrong_bits_are_corrected_and_three_are_not(
            id in 0_usize..587,
            turns in 0_u32..4,
            bits in prop::collection::btree_set(0_u32..36, 1..4),
        ) {
            let data = Family::Tag36h11.data();
            let wrong = bits.iter().fold(data.codes[id], |code, bit| code ^ 1 << bit);
            let found = CodeIndex::new(data, 2).find(rotate_code(wrong, 36, (4 - turns) % 4));
            let expected = Match { id: id as u32, hamming: bits.len() as u32, turns };
            prop_assert_eq!(found, (bits.len() <= 2).then_some(expected));
        }
    }
}
