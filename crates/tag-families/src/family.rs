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
    /// ArUco dictionary of 50 tags of 4x4 bits, as OpenCV's `DICT_4X4_50`.
    #[serde(rename = "aruco4x4-50")]
    Aruco4x4With50,
    /// ArUco dictionary of 100 tags of 4x4 bits, as OpenCV's `DICT_4X4_100`.
    #[serde(rename = "aruco4x4-100")]
    Aruco4x4With100,
    /// ArUco dictionary of 250 tags of 4x4 bits, as OpenCV's `DICT_4X4_250`.
    #[serde(rename = "aruco4x4-250")]
    Aruco4x4With250,
    /// ArUco dictionary of 1000 tags of 4x4 bits, as OpenCV's `DICT_4X4_1000`.
    #[serde(rename = "aruco4x4-1000")]
    Aruco4x4With1000,
    /// ArUco dictionary of 50 tags of 5x5 bits, as OpenCV's `DICT_5X5_50`.
    #[serde(rename = "aruco5x5-50")]
    Aruco5x5With50,
    /// ArUco dictionary of 100 tags of 5x5 bits, as OpenCV's `DICT_5X5_100`.
    #[serde(rename = "aruco5x5-100")]
    Aruco5x5With100,
    /// ArUco dictionary of 250 tags of 5x5 bits, as OpenCV's `DICT_5X5_250`.
    #[serde(rename = "aruco5x5-250")]
    Aruco5x5With250,
    /// ArUco dictionary of 1000 tags of 5x5 bits, as OpenCV's `DICT_5X5_1000`.
    #[serde(rename = "aruco5x5-1000")]
    Aruco5x5With1000,
    /// ArUco dictionary of 50 tags of 6x6 bits, as OpenCV's `DICT_6X6_50`.
    #[serde(rename = "aruco6x6-50")]
    Aruco6x6With50,
    /// ArUco dictionary of 100 tags of 6x6 bits, as OpenCV's `DICT_6X6_100`.
    #[serde(rename = "aruco6x6-100")]
    Aruco6x6With100,
    /// ArUco dictionary of 250 tags of 6x6 bits, as OpenCV's `DICT_6X6_250`.
    #[serde(rename = "aruco6x6-250")]
    Aruco6x6With250,
    /// ArUco dictionary of 1000 tags of 6x6 bits, as OpenCV's `DICT_6X6_1000`.
    #[serde(rename = "aruco6x6-1000")]
    Aruco6x6With1000,
}

static TAG36H11: Table<587, 36> = parse(include_bytes!("../data/tag36h11.txt"));
static TAG25H9: Table<35, 25> = parse(include_bytes!("../data/tag25h9.txt"));
static TAG16H5: Table<30, 16> = parse(include_bytes!("../data/tag16h5.txt"));
static TAG_STANDARD_41H12: Table<2115, 41> = parse(include_bytes!("../data/tagStandard41h12.txt"));

static ARUCO_4X4: Table<1000, 16> = parse(include_bytes!("../data/aruco4x4.txt"));
static ARUCO_5X5: Table<1000, 25> = parse(include_bytes!("../data/aruco5x5.txt"));
static ARUCO_6X6: Table<1000, 36> = parse(include_bytes!("../data/aruco6x6.txt"));

static TAG36H11_DATA: FamilyData = TAG36H11.data();
static TAG25H9_DATA: FamilyData = TAG25H9.data();
static TAG16H5_DATA: FamilyData = TAG16H5.data();
static TAG_STANDARD_41H12_DATA: FamilyData = TAG_STANDARD_41H12.data();
static ARUCO_4X4_50: FamilyData = ARUCO_4X4.first(50, 4);
static ARUCO_4X4_100: FamilyData = ARUCO_4X4.first(100, 3);
static ARUCO_4X4_250: FamilyData = ARUCO_4X4.first(250, 3);
static ARUCO_4X4_1000: FamilyData = ARUCO_4X4.first(1000, 2);
static ARUCO_5X5_50: FamilyData = ARUCO_5X5.first(50, 7);
static ARUCO_5X5_100: FamilyData = ARUCO_5X5.first(100, 7);
static ARUCO_5X5_250: FamilyData = ARUCO_5X5.first(250, 6);
static ARUCO_5X5_1000: FamilyData = ARUCO_5X5.first(1000, 5);
static ARUCO_6X6_50: FamilyData = ARUCO_6X6.first(50, 13);
static ARUCO_6X6_100: FamilyData = ARUCO_6X6.first(100, 12);
static ARUCO_6X6_250: FamilyData = ARUCO_6X6.first(250, 11);
static ARUCO_6X6_1000: FamilyData = ARUCO_6X6.first(1000, 9);

impl Family {
    /// Every family, in the order of the wire.
    pub const ALL: [Self; 16] = [
        Self::Tag36h11,
        Self::Tag25h9,
        Self::Tag16h5,
        Self::TagStandard41h12,
        Self::Aruco4x4With50,
        Self::Aruco4x4With100,
        Self::Aruco4x4With250,
        Self::Aruco4x4With1000,
        Self::Aruco5x5With50,
        Self::Aruco5x5With100,
        Self::Aruco5x5With250,
        Self::Aruco5x5With1000,
        Self::Aruco6x6With50,
        Self::Aruco6x6With100,
        Self::Aruco6x6With250,
        Self::Aruco6x6With1000,
    ];

    /// Code words and layout.
    pub fn data(self) -> &'static FamilyData {
        match self {
            Self::Tag36h11 => &TAG36H11_DATA,
            Self::Tag25h9 => &TAG25H9_DATA,
            Self::Tag16h5 => &TAG16H5_DATA,
            Self::TagStandard41h12 => &TAG_STANDARD_41H12_DATA,
            Self::Aruco4x4With50 => &ARUCO_4X4_50,
            Self::Aruco4x4With100 => &ARUCO_4X4_100,
            Self::Aruco4x4With250 => &ARUCO_4X4_250,
            Self::Aruco4x4With1000 => &ARUCO_4X4_1000,
            Self::Aruco5x5With50 => &ARUCO_5X5_50,
            Self::Aruco5x5With100 => &ARUCO_5X5_100,
            Self::Aruco5x5With250 => &ARUCO_5X5_250,
            Self::Aruco5x5With1000 => &ARUCO_5X5_1000,
            Self::Aruco6x6With50 => &ARUCO_6X6_50,
            Self::Aruco6x6With100 => &ARUCO_6X6_100,
            Self::Aruco6x6With250 => &ARUCO_6X6_250,
            Self::Aruco6x6With1000 => &ARUCO_6X6_1000,
        }
    }

    /// The usual name, as in AprilTag's own sources; of ArUco dictionaries the grid and the number of tags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tag36h11 => "tag36h11",
            Self::Tag25h9 => "tag25h9",
            Self::Tag16h5 => "tag16h5",
            Self::TagStandard41h12 => "tagStandard41h12",
            Self::Aruco4x4With50 => "aruco4x4-50",
            Self::Aruco4x4With100 => "aruco4x4-100",
            Self::Aruco4x4With250 => "aruco4x4-250",
            Self::Aruco4x4With1000 => "aruco4x4-1000",
            Self::Aruco5x5With50 => "aruco5x5-50",
            Self::Aruco5x5With100 => "aruco5x5-100",
            Self::Aruco5x5With250 => "aruco5x5-250",
            Self::Aruco5x5With1000 => "aruco5x5-1000",
            Self::Aruco6x6With50 => "aruco6x6-50",
            Self::Aruco6x6With100 => "aruco6x6-100",
            Self::Aruco6x6With250 => "aruco6x6-250",
            Self::Aruco6x6With1000 => "aruco6x6-1000",
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
#[error(
    "unknown tag family `{0}`; known are tag36h11, tag25h9, tag16h5, tagStandard41h12 and \
    the ArUco dictionaries aruco{{4x4,5x5,6x6}}-{{50,100,250,1000}}"
)]
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
            let named = family.name().starts_with("aruco") || message.contains(family.name());
            assert!(named, "{message} lacks {family}");
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
