//! The families by name, and the data of each.

use crate::table::{FamilyData, Table, parse};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A tag family. Written by its usual name (`tag36h11`) in files and messages for people.
///
/// Binary formats count the variants, so the order is part of the wire contract: new families go last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Family {
    /// AprilTag 36h11: the usual choice.
    #[serde(rename = "tag36h11")]
    Tag36h11,
    /// AprilTag 25h9: larger modules, 35 tags.
    #[serde(rename = "tag25h9")]
    Tag25h9,
    /// AprilTag 16h5: largest modules, 30 tags, weak protection against false detections.
    #[serde(rename = "tag16h5")]
    Tag16h5,
    /// AprilTag Standard 41h12: data outside the border, 2115 tags.
    #[serde(rename = "tagStandard41h12")]
    TagStandard41h12,
}

static TAG36H11: Table<587, 36> = parse(include_bytes!("../data/tag36h11.txt"));
static TAG25H9: Table<35, 25> = parse(include_bytes!("../data/tag25h9.txt"));
static TAG16H5: Table<30, 16> = parse(include_bytes!("../data/tag16h5.txt"));
static TAG_STANDARD_41H12: Table<2115, 41> = parse(include_bytes!("../data/tagStandard41h12.txt"));

static TAG36H11_DATA: FamilyData = TAG36H11.data();
static TAG25H9_DATA: FamilyData = TAG25H9.data();
static TAG16H5_DATA: FamilyData = TAG16H5.data();
static TAG_STANDARD_41H12_DATA: FamilyData = TAG_STANDARD_41H12.data();

impl Family {
    /// Every family, in the order of the wire.
    pub const ALL: [Self; 4] = [
        Self::Tag36h11,
        Self::Tag25h9,
        Self::Tag16h5,
        Self::TagStandard41h12,
    ];

    /// Code words and layout.
    pub fn data(self) -> &'static FamilyData {
        match self {
            Self::Tag36h11 => &TAG36H11_DATA,
            Self::Tag25h9 => &TAG25H9_DATA,
            Self::Tag16h5 => &TAG16H5_DATA,
            Self::TagStandard41h12 => &TAG_STANDARD_41H12_DATA,
        }
    }

    /// The usual name, as in AprilTag's own sources.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tag36h11 => "tag36h11",
            Self::Tag25h9 => "tag25h9",
            Self::Tag16h5 => "tag16h5",
            Self::TagStandard41h12 => "tagStandard41h12",
        }
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no family bears.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown tag family `{0}`; known are tag36h11, tag25h9, tag16h5 and tagStandard41h12")]
pub struct UnknownFamily(pub String);

impl FromStr for Family {
    type Err = UnknownFamily;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|family| family.name() == name)
            .ok_or_else(|| UnknownFamily(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotate_code;

    #[test]
    fn names_read_back_and_are_all_named_in_the_error() {
        let message = "tag99".parse::<Family>().unwrap_err().to_string();
        for family in Family::ALL {
            assert_eq!(family.to_string().parse(), Ok(family));
            assert!(message.contains(family.name()));
        }
    }

    #[test]
    fn the_tables_carry_the_published_code_words() {
        let data = Family::Tag36h11.data();
        assert_eq!((data.codes.len(), data.bits.len()), (587, 36));
        assert_eq!(data.codes[0], 0xd7e0_0984b);
        assert_eq!(data.codes[586], 0xe8b7_72fe0);
        assert_eq!(data.bits[35], (3, 4));
    }

    #[test]
    fn code_words_keep_their_distance_under_rotation() {
        for family in Family::ALL {
            let data = family.data();
            for (i, &a) in data.codes.iter().enumerate() {
                let rotated = [0, 1, 2, 3].map(|turns| rotate_code(a, data.bits.len(), turns));
                let nearest_self = rotated[1..].iter().map(|r| (r ^ a).count_ones()).min();
                let nearest_other = data.codes[..i]
                    .iter()
                    .flat_map(|b| rotated.iter().map(move |r| (r ^ b).count_ones()))
                    .min();
                let nearest = nearest_self.into_iter().chain(nearest_other).min().unwrap();
                assert!(
                    nearest >= u32::from(data.min_hamming),
                    "{family} id {i}: {nearest}"
                );
            }
        }
    }

    #[test]
    fn bits_stand_within_the_printed_tag_and_off_the_border() {
        for family in Family::ALL {
            let data = family.data();
            let margin = data.margin();
            let border = data.border_width as i8;
            for &(x, y) in data.bits {
                assert!(
                    (-margin..border + margin).contains(&x)
                        && (-margin..border + margin).contains(&y)
                );
                let on_ring = |ring: i8| {
                    let (low, high) = (-ring, border - 1 + ring);
                    (x == low || x == high) && (low..=high).contains(&y)
                        || (y == low || y == high) && (low..=high).contains(&x)
                };
                assert!(!on_ring(0) && !on_ring(1), "{family} {x} {y}");
            }
        }
    }
}
