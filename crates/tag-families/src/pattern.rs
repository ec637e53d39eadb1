//! What a printed tag looks like, and what becomes of its code word when it is turned.

use crate::{Board, BorderColour, Family, FamilyData};

/// Colour of a module of the printed, upright tag; row 0 is the top, column 0 the left, white ring included.
///
/// As AprilTag's own `apriltag_to_image` draws it: `x` and `y` run over `0..total_width`. Out of the tag, and for an
/// id that the family lacks, the answer is white like the paper.
pub fn module_is_white(family: Family, id: u32, x: usize, y: usize) -> bool {
    let data = family.data();
    let (total, margin) = (usize::from(data.total_width), data.margin());
    let Some(&code) = data.codes.get(id as usize) else {
        return true;
    };
    if x >= total || y >= total {
        return true;
    }
    let (x, y) = (x as i8 - margin, y as i8 - margin);
    match data.bits.iter().rev().position(|&bit| bit == (x, y)) {
        Some(significance) => code >> significance & 1 == 1,
        None => ring_is_white(data, x, y),
    }
}

/// All white modules of the printed, upright tag, as column and row: what [`module_is_white`] says of each, at once.
/// Nothing for an id that the family lacks.
pub fn white_modules(family: Family, id: u32) -> impl Iterator<Item = (usize, usize)> {
    let data = family.data();
    let margin = data.margin();
    let on_print = move |x: i8, y: i8| ((x + margin) as usize, (y + margin) as usize);
    let (first, last) = match data.border {
        BorderColour::Black => (-1, data.border_width as i8),
        BorderColour::White => (0, data.border_width as i8 - 1),
    };
    let code = data.codes.get(id as usize).copied();
    let ring = (first + i8::from(corners_are_black(data))..last).flat_map(move |i| {
        [
            (i, first),
            (last, i),
            (first + last - i, last),
            (first, first + last - i),
        ]
    });
    let end = data.border_width as i8 - 1 + margin;
    let beyond = (-margin..=end).flat_map(move |y| (-margin..=end).map(move |x| (x, y)));
    let inwards = move |at: i8| at.min(end - margin - at);
    let beyond = beyond
        .filter(move |&(x, y)| inwards(x).min(inwards(y)) < -1 && !data.bits.contains(&(x, y)));
    let bits = data.bits.iter().rev().enumerate();
    let set = bits
        .filter(move |(i, _)| code.is_some_and(|code| code >> i & 1 == 1))
        .map(|(_, &bit)| bit);
    ring.chain(beyond)
        .filter(move |_| code.is_some())
        .chain(set)
        .map(move |(x, y)| on_print(x, y))
}

/// The square's ring and the ring around it have opposite colours, but for squares that touch the corners of an
/// AprilGrid's tag. What carries no data elsewhere is black inside and paper outside, beyond a round tag.
fn ring_is_white(data: &FamilyData, x: i8, y: i8) -> bool {
    let inwards = |at: i8| at.min(data.border_width as i8 - 1 - at);
    let ring = inwards(x).min(inwards(y));
    let is_corner = inwards(x) == inwards(y);
    match data.border {
        BorderColour::Black => ring == -1 && !(is_corner && corners_are_black(data)),
        BorderColour::White => ring == 0 || ring < -1,
    }
}

fn corners_are_black(data: &FamilyData) -> bool {
    data.board == Some(Board::Aprilgrid)
}

/// The code word of the tag's picture turned by `turns` quarter turns counter-clockwise.
///
/// AprilTag 3 orders the bits in four quadrants, so a quarter turn rotates the word by a quarter of its length;
/// with an odd number of bits the last stands in the centre and stays.
pub fn rotate_code(code: u64, n_bits: usize, turns: u32) -> u64 {
    let centre = n_bits % 4;
    let ring = n_bits - centre;
    let (shift, mask) = (ring / 4 * (turns % 4) as usize, (1_u64 << ring) - 1);
    let outer = code >> centre;
    let rotated = (outer << shift | outer >> (ring - shift)) & mask;
    rotated << centre | code & ((1 << centre) - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(family: Family, id: u32) -> Vec<String> {
        let width = usize::from(family.data().total_width);
        let row = |y| {
            (0..width)
                .map(|x| {
                    if module_is_white(family, id, x, y) {
                        '.'
                    } else {
                        '#'
                    }
                })
                .collect()
        };
        (0..width).map(row).collect()
    }

    /// The same picture as OpenCV's dictionary, which draws it turned by 180 degrees.
    #[test]
    fn tag36h11_id_0_looks_as_published() {
        let expected = [
            "..........",
            ".########.",
            ".#..#.#.#.",
            ".##...#.#.",
            ".##..####.",
            ".#.#.####.",
            ".##.#..##.",
            ".####.###.",
            ".########.",
            "..........",
        ];
        assert_eq!(picture(Family::Tag36h11, 0), expected);
    }

    #[test]
    fn tag36h11b2_id_0_is_that_of_an_aprilgrid() {
        let expected = ["#..........#", ".##########.", ".##########."];
        let seen = picture(Family::Tag36h11b2, 0);
        let plain = picture(Family::Tag36h11, 0);
        assert_eq!(seen[..3], expected);
        assert_eq!((&seen[9], &seen[11]), (&seen[1], &seen[0]));
        for y in 0..6 {
            assert_eq!(seen[y + 3], format!(".##{}##.", &plain[y + 2][2..8]));
        }
    }

    #[test]
    fn turning_the_code_turns_the_picture() {
        for family in Family::ALL {
            let data = family.data();
            let bit = |code: u64, i: usize| code >> (data.bits.len() - 1 - i) & 1;
            let last = data.border_width as i8 - 1;
            let (code, turned) = (
                data.codes[7],
                rotate_code(data.codes[7], data.bits.len(), 1),
            );
            for (i, &(x, y)) in data.bits.iter().enumerate() {
                let seen_at = data.bits.iter().position(|&b| b == (y, last - x)).unwrap();
                assert_eq!(bit(turned, seen_at), bit(code, i), "{family} bit {i}");
            }
        }
    }

    #[test]
    fn four_quarter_turns_are_none() {
        for n_bits in [16, 21, 25, 36, 41, 48, 49, 52] {
            let code = 0xf_1234_5678_9abc & ((1 << n_bits) - 1);
            let turned = (0..4).fold(code, |code, _| rotate_code(code, n_bits, 1));
            assert_eq!(turned, code);
            assert_eq!(
                rotate_code(code, n_bits, 3),
                rotate_code(rotate_code(code, n_bits, 1), n_bits, 2)
            );
        }
    }

    #[test]
    fn white_modules_are_those_that_are_white() {
        for family in Family::ALL {
            let width = usize::from(family.data().total_width);
            let mut listed: Vec<_> = white_modules(family, 11).collect();
            listed.sort_unstable();
            let all = (0..width).flat_map(|x| (0..width).map(move |y| (x, y)));
            let white: Vec<_> = all
                .filter(|&(x, y)| module_is_white(family, 11, x, y))
                .collect();
            assert_eq!(listed, white, "{family}");
            assert_eq!(white_modules(family, 99_999).count(), 0);
        }
    }

    #[test]
    fn beyond_the_tag_there_is_paper() {
        assert!(module_is_white(Family::Tag36h11, 0, 10, 3));
        assert!(module_is_white(Family::Tag36h11, 9999, 3, 3));
    }
}
