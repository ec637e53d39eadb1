//! Values of `--family`: the name of a tag family, or `all` for those worth a search when the family is unknown.

use sextant_tag_families::{Board, Family, FamilyData, UnknownFamily};
use std::str::FromStr;

/// Families to look for, by the value of `--family`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sought {
    One(Family),
    All,
}

impl FromStr for Sought {
    type Err = UnknownFamily;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "all" => Ok(Self::All),
            name => name.parse().map(Self::One),
        }
    }
}

/// The families that are meant.
pub fn families(sought: &[Sought]) -> Vec<Family> {
    let each = |sought: &Sought| match sought {
        Sought::One(family) => vec![*family],
        Sought::All => every_family()
            .filter(|family| family.data().bits.len() >= FEWEST_BITS)
            .collect(),
    };
    sought.iter().flat_map(each).collect()
}

/// Fewest bits of a family that `all` includes: shorter words are found in texture and in the tags of other families.
const FEWEST_BITS: usize = 21;

/// Every family with codes but those whose tags another one has too, and ChArUco boards, whose markers are ArUco tags.
pub fn every_family() -> impl Iterator<Item = Family> {
    let is_sought = |family: &Family| {
        let data = family.data();
        data.has_codes()
            && data.board != Some(Board::Charuco)
            && !Family::ALL
                .iter()
                .any(|other| is_part_of(data, other.data()))
    };
    Family::ALL.into_iter().filter(is_sought)
}

/// Whether a family is the first tags of a larger one.
fn is_part_of(part: &FamilyData, whole: &FamilyData) -> bool {
    part.bits == whole.bits
        && part.board == whole.board
        && part.codes.len() < whole.codes.len()
        && whole.codes.starts_with(part.codes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_the_largest_families_of_enough_bits() {
        let names: Vec<_> = families(&["all".parse().unwrap()])
            .into_iter()
            .map(Family::name)
            .collect();
        let expected = [
            "tag36h11",
            "tag25h9",
            "tagStandard41h12",
            "aruco5x5-1000",
            "aruco6x6-1000",
            "tag36h11b2",
            "aruco7x7-1000",
            "aruco-original",
            "aruco-mip-36h12",
            "tag36h10",
            "tagCustom48h12",
            "tagStandard52h13",
            "tagCircle21h7",
            "tagCircle49h12",
            "aruco-mip-25h7",
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn one_family_stays_alone() {
        let sought = ["tag16h5", "aruco4x4-50"].map(|name| name.parse().unwrap());
        let expected = [Family::Tag16h5, Family::Aruco4x4With50];
        assert_eq!(families(&sought), expected);
        assert!("tag99".parse::<Sought>().is_err());
    }
}
