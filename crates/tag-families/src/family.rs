//! The families by name, and the data of each.

use crate::chessboard::CHESSBOARD;
#[cfg(not(target_family = "wasm"))]
use crate::table::parse_packed;
use crate::table::{FamilyData, Table, parse};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Declares [`Family`]: of each family its documentation, variant, usual name and data.
macro_rules! families {
    ($($(#[$doc:meta])* $variant:ident, $name:literal, $data:expr;)*) => {
        /// A tag family. Written by its usual name (`tag36h11`) in files and messages for people.
        ///
        /// Binary formats count the variants, so the order is part of the wire contract: new families go last.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[non_exhaustive]
        pub enum Family {
            $($(#[$doc])* #[serde(rename = $name)] $variant,)*
        }

        impl Family {
            /// Every family, in the order of the wire.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// Those whose tags have codes.
            pub fn coded() -> impl Iterator<Item = Self> {
                Self::ALL.into_iter().filter(|family| family.data().has_codes())
            }

            /// Code words and layout.
            pub fn data(self) -> &'static FamilyData {
                match self {
                    $(Self::$variant => {
                        static DATA: FamilyData = $data;
                        &DATA
                    })*
                }
            }

            /// The usual name, as in AprilTag's own sources; of ArUco dictionaries the grid and the number of tags.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

static TAG36H11: Table<587, 36> = parse(include_bytes!("../data/tag36h11.txt"));
static TAG36H11B2: Table<587, 36> = parse(include_bytes!("../data/tag36h11b2.txt"));
static TAG25H9: Table<35, 25> = parse(include_bytes!("../data/tag25h9.txt"));
static TAG16H5: Table<30, 16> = parse(include_bytes!("../data/tag16h5.txt"));
static TAG_STANDARD_41H12: Table<2115, 41> = parse(include_bytes!("../data/tagStandard41h12.txt"));

static TAG36H10: Table<2320, 36> = parse(include_bytes!("../data/tag36h10.txt"));
#[cfg(not(target_family = "wasm"))]
static TAG_CUSTOM_48H12: Table<42211, 48> = parse_packed(
    include_bytes!("../data/tagCustom48h12.txt"),
    include_bytes!("../data/tagCustom48h12.bin"),
);
#[cfg(not(target_family = "wasm"))]
static TAG_STANDARD_52H13: Table<48714, 52> = parse_packed(
    include_bytes!("../data/tagStandard52h13.txt"),
    include_bytes!("../data/tagStandard52h13.bin"),
);
/// Most of a browser's download would be the words of the largest families: they are left out there, and the families
/// have no codes.
#[cfg(target_family = "wasm")]
static TAG_CUSTOM_48H12: Table<0, 0> = Table::EMPTY;
#[cfg(target_family = "wasm")]
static TAG_STANDARD_52H13: Table<0, 0> = Table::EMPTY;

#[cfg(not(target_family = "wasm"))]
static TAG_CIRCLE_49H12: Table<65535, 49> = parse_packed(
    include_bytes!("../data/tagCircle49h12.txt"),
    include_bytes!("../data/tagCircle49h12.bin"),
);
#[cfg(target_family = "wasm")]
static TAG_CIRCLE_49H12: Table<0, 0> = Table::EMPTY;
static TAG_CIRCLE_21H7: Table<38, 21> = parse(include_bytes!("../data/tagCircle21h7.txt"));

static ARUCO_MIP_16H3: Table<250, 16> = parse(include_bytes!("../data/arucoMip16h3.txt"));
static ARUCO_MIP_25H7: Table<100, 25> = parse(include_bytes!("../data/arucoMip25h7.txt"));
static ARUCO_ORIGINAL: Table<1024, 25> = parse(include_bytes!("../data/arucoOriginal.txt"));
static ARUCO_MIP_36H12: Table<250, 36> = parse(include_bytes!("../data/arucoMip36h12.txt"));
static ARUCO_4X4: Table<1000, 16> = parse(include_bytes!("../data/aruco4x4.txt"));
static ARUCO_5X5: Table<1000, 25> = parse(include_bytes!("../data/aruco5x5.txt"));
static ARUCO_6X6: Table<1000, 36> = parse(include_bytes!("../data/aruco6x6.txt"));
static ARUCO_7X7: Table<1000, 49> = parse(include_bytes!("../data/aruco7x7.txt"));

families! {
    /// AprilTag 36h11: the usual choice.
    Tag36h11, "tag36h11", TAG36H11.data();
    /// AprilTag 25h9: larger modules, 35 tags.
    Tag25h9, "tag25h9", TAG25H9.data();
    /// AprilTag 16h5: largest modules, 30 tags, weak protection against false detections.
    Tag16h5, "tag16h5", TAG16H5.data();
    /// AprilTag Standard 41h12: data outside the border, 2115 tags.
    TagStandard41h12, "tagStandard41h12", TAG_STANDARD_41H12.data();
    /// ArUco dictionary of 50 tags of 4x4 bits, as OpenCV's `DICT_4X4_50`.
    Aruco4x4With50, "aruco4x4-50", ARUCO_4X4.first(50, 4);
    /// ArUco dictionary of 100 tags of 4x4 bits, as OpenCV's `DICT_4X4_100`.
    Aruco4x4With100, "aruco4x4-100", ARUCO_4X4.first(100, 3);
    /// ArUco dictionary of 250 tags of 4x4 bits, as OpenCV's `DICT_4X4_250`.
    Aruco4x4With250, "aruco4x4-250", ARUCO_4X4.first(250, 3);
    /// ArUco dictionary of 1000 tags of 4x4 bits, as OpenCV's `DICT_4X4_1000`.
    Aruco4x4With1000, "aruco4x4-1000", ARUCO_4X4.first(1000, 2);
    /// ArUco dictionary of 50 tags of 5x5 bits, as OpenCV's `DICT_5X5_50`.
    Aruco5x5With50, "aruco5x5-50", ARUCO_5X5.first(50, 7);
    /// ArUco dictionary of 100 tags of 5x5 bits, as OpenCV's `DICT_5X5_100`.
    Aruco5x5With100, "aruco5x5-100", ARUCO_5X5.first(100, 7);
    /// ArUco dictionary of 250 tags of 5x5 bits, as OpenCV's `DICT_5X5_250`.
    Aruco5x5With250, "aruco5x5-250", ARUCO_5X5.first(250, 6);
    /// ArUco dictionary of 1000 tags of 5x5 bits, as OpenCV's `DICT_5X5_1000`.
    Aruco5x5With1000, "aruco5x5-1000", ARUCO_5X5.first(1000, 5);
    /// ArUco dictionary of 50 tags of 6x6 bits, as OpenCV's `DICT_6X6_50`.
    Aruco6x6With50, "aruco6x6-50", ARUCO_6X6.first(50, 13);
    /// ArUco dictionary of 100 tags of 6x6 bits, as OpenCV's `DICT_6X6_100`.
    Aruco6x6With100, "aruco6x6-100", ARUCO_6X6.first(100, 12);
    /// ArUco dictionary of 250 tags of 6x6 bits, as OpenCV's `DICT_6X6_250`.
    Aruco6x6With250, "aruco6x6-250", ARUCO_6X6.first(250, 11);
    /// ArUco dictionary of 1000 tags of 6x6 bits, as OpenCV's `DICT_6X6_1000`.
    Aruco6x6With1000, "aruco6x6-1000", ARUCO_6X6.first(1000, 9);
    /// AprilTag 36h11 as the tags of Kalibr's AprilGrid have it: within a border of two modules.
    Tag36h11b2, "tag36h11b2", TAG36H11B2.data();
    /// ArUco dictionary of 50 tags of 7x7 bits, as OpenCV's `DICT_7X7_50`.
    Aruco7x7With50, "aruco7x7-50", ARUCO_7X7.first(50, 19);
    /// ArUco dictionary of 100 tags of 7x7 bits, as OpenCV's `DICT_7X7_100`.
    Aruco7x7With100, "aruco7x7-100", ARUCO_7X7.first(100, 18);
    /// ArUco dictionary of 250 tags of 7x7 bits, as OpenCV's `DICT_7X7_250`.
    Aruco7x7With250, "aruco7x7-250", ARUCO_7X7.first(250, 17);
    /// ArUco dictionary of 1000 tags of 7x7 bits, as OpenCV's `DICT_7X7_1000`.
    Aruco7x7With1000, "aruco7x7-1000", ARUCO_7X7.first(1000, 14);
    /// White squares of a ChArUco board with markers of `DICT_4X4_50`.
    Charuco4x4With50, "charuco4x4-50", ARUCO_4X4.first(50, 4).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_4X4_100`.
    Charuco4x4With100, "charuco4x4-100", ARUCO_4X4.first(100, 3).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_4X4_250`.
    Charuco4x4With250, "charuco4x4-250", ARUCO_4X4.first(250, 3).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_4X4_1000`.
    Charuco4x4With1000, "charuco4x4-1000", ARUCO_4X4.first(1000, 2).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_5X5_50`.
    Charuco5x5With50, "charuco5x5-50", ARUCO_5X5.first(50, 7).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_5X5_100`.
    Charuco5x5With100, "charuco5x5-100", ARUCO_5X5.first(100, 7).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_5X5_250`.
    Charuco5x5With250, "charuco5x5-250", ARUCO_5X5.first(250, 6).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_5X5_1000`.
    Charuco5x5With1000, "charuco5x5-1000", ARUCO_5X5.first(1000, 5).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_6X6_50`.
    Charuco6x6With50, "charuco6x6-50", ARUCO_6X6.first(50, 13).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_6X6_100`.
    Charuco6x6With100, "charuco6x6-100", ARUCO_6X6.first(100, 12).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_6X6_250`.
    Charuco6x6With250, "charuco6x6-250", ARUCO_6X6.first(250, 11).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_6X6_1000`.
    Charuco6x6With1000, "charuco6x6-1000", ARUCO_6X6.first(1000, 9).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_7X7_50`.
    Charuco7x7With50, "charuco7x7-50", ARUCO_7X7.first(50, 19).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_7X7_100`.
    Charuco7x7With100, "charuco7x7-100", ARUCO_7X7.first(100, 18).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_7X7_250`.
    Charuco7x7With250, "charuco7x7-250", ARUCO_7X7.first(250, 17).on_charuco();
    /// White squares of a ChArUco board with markers of `DICT_7X7_1000`.
    Charuco7x7With1000, "charuco7x7-1000", ARUCO_7X7.first(1000, 14).on_charuco();
    /// The first ArUco dictionary, as OpenCV's `DICT_ARUCO_ORIGINAL`. Its words differ in as little as one bit, so that
    /// none is corrected; its tag 1023 looks the same upside down, so that its first corner is either of two.
    ArucoOriginal, "aruco-original", ARUCO_ORIGINAL.data();
    /// ArUco dictionary of 250 tags of 6x6 bits, as OpenCV's `DICT_ARUCO_MIP_36h12`.
    ArucoMip36h12, "aruco-mip-36h12", ARUCO_MIP_36H12.data();
    /// AprilTag 36h10: 2320 tags that look like those of 36h11.
    Tag36h10, "tag36h10", TAG36H10.data();
    /// AprilTag Custom 48h12: 42211 tags with room for a smaller tag in the middle.
    TagCustom48h12, "tagCustom48h12", TAG_CUSTOM_48H12.data();
    /// AprilTag Standard 52h13: data outside the border, 48714 tags.
    TagStandard52h13, "tagStandard52h13", TAG_STANDARD_52H13.data();
    /// Squares of a plain chessboard between its inner corners. They have no codes: only a search for the whole board
    /// finds them.
    Chessboard, "chessboard", CHESSBOARD;
    /// AprilTag Circle 21h7: 38 round tags, data outside the border.
    TagCircle21h7, "tagCircle21h7", TAG_CIRCLE_21H7.data();
    /// AprilTag Circle 49h12: 65535 round tags, data outside the border.
    TagCircle49h12, "tagCircle49h12", TAG_CIRCLE_49H12.data();
    /// Dictionary of 250 tags of 4x4 bits of the ArUco library, `ARUCO_MIP_16h3`.
    ArucoMip16h3, "aruco-mip-16h3", ARUCO_MIP_16H3.data();
    /// Dictionary of 100 tags of 5x5 bits of the ArUco library, `ARUCO_MIP_25h7`.
    ArucoMip25h7, "aruco-mip-25h7", ARUCO_MIP_25H7.data();
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no family bears.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown tag family `{0}`; known are tag36h11, tag36h11b2 (Kalibr's AprilGrid), tag25h9, tag16h5, tag36h10, \
    tagStandard41h12, tagStandard52h13, tagCustom48h12, tagCircle21h7, tagCircle49h12, \
    the ArUco dictionaries aruco{{4x4,5x5,6x6,7x7}}-{{50,100,250,1000}}, aruco-original, aruco-mip-16h3, \
    aruco-mip-25h7 and aruco-mip-36h12, and ChArUco boards with their markers, charuco4x4-50 and so on; \
    chessboard, of plain ones"
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
            let of_a_size = family.name().contains("aruco") && family.name().contains('x');
            let named = of_a_size || message.contains(family.name());
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
    fn large_tables_are_read_to_their_ends() {
        let ends = |family: Family| {
            let codes = family.data().codes;
            (codes.first().copied(), codes.last().copied(), codes.len())
        };
        let custom = (Some(0xd6c8_ae76_dff0), Some(0x18bc_cac8_b0f5), 42211);
        assert_eq!(ends(Family::TagCustom48h12), custom);
        let (_, last, n) = ends(Family::TagStandard52h13);
        assert_eq!((last, n), (Some(0xc_dc7a_163a_cc66), 48714));
        assert_eq!(ends(Family::TagCircle49h12).2, 65535);
    }

    #[test]
    fn the_last_word_of_the_first_aruco_dictionary_is_the_same_upside_down() {
        let data = Family::ArucoOriginal.data();
        let same = |code: &u64| rotate_code(*code, data.bits.len(), 2) == *code;
        assert_eq!(data.codes.iter().position(same), Some(1023));
    }

    #[test]
    fn a_border_of_two_modules_leaves_words_and_picture_as_they_are() {
        let (plain, thick) = (Family::Tag36h11.data(), Family::Tag36h11b2.data());
        assert_eq!(plain.codes, thick.codes);
        let moved = plain.bits.iter().map(|(x, y)| (x + 1, y + 1));
        assert!(moved.eq(thick.bits.iter().copied()));
    }

    /// Words of a family that are compared with all before them.
    const MOST_CHECKED: usize = 2500;

    #[test]
    fn code_words_keep_their_distance_under_rotation() {
        for family in Family::coded() {
            let data = family.data();
            // Of the largest families not every word, which would take a minute.
            let step = data.codes.len().div_ceil(MOST_CHECKED);
            for (i, &a) in data.codes.iter().enumerate().step_by(step) {
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
