//! A tag of one family is no tag of another, above all of those with so few bits that chance makes some of theirs.

#![allow(clippy::unwrap_used)]

use crate::drawing::{Camera, Picture, Random, Tag};
use sextant_apriltag::{Detection, Family};

fn detect(tag: &Tag, family: Family, seed: u64) -> Vec<Detection> {
    detect_in(&draw(tag, 0.5, seed), family)
}

const SIZE: usize = 64;

fn draw(tag: &Tag, blur_px: f64, seed: u64) -> Vec<u8> {
    Picture::draw(&Camera::new(SIZE, SIZE), std::slice::from_ref(tag), 128.0)
        .blurred(blur_px)
        .pixels(1.5, seed)
}

fn detect_in(pixels: &[u8], family: Family) -> Vec<Detection> {
    crate::drawing::detect(pixels, SIZE, &[family])
}

/// A tag so many pixels wide, turned at random.
fn tag(family: Family, id: u32, edge_px: f64, random: &mut Random) -> Tag {
    Tag::turned(family, id, edge_px, 40.0, random)
}

#[test]
fn tags_of_many_bits_are_none_of_few() {
    let mut random = Random(21);
    for i in 0..24 {
        let tag = tag(
            Family::Tag36h11,
            24 * i,
            random.between(12.0, 34.0),
            &mut random,
        );
        let pixels = draw(&tag, 0.5, 5);
        for family in [
            Family::Tag16h5,
            Family::Aruco4x4With50,
            Family::Aruco4x4With1000,
        ] {
            assert_eq!(detect_in(&pixels, family), [], "{family} {}", tag.id);
        }
        assert_eq!(detect_in(&pixels, Family::Tag36h11).len(), 1, "{}", tag.id);
    }
}

/// Of four hundred blurred tags those that show a word of a family of fewer modules: only
/// what is grey in them tells.
#[test]
fn blurred_tags_of_many_bits_are_none_of_few() {
    const IDS: [u32; 24] = [
        38, 42, 69, 77, 78, 80, 121, 130, 146, 153, 162, 187, 198, 222, 255, 268, 270, 281, 340,
        341, 351, 358, 372, 373,
    ];
    for id in IDS {
        let mut random = Random(1000 + u64::from(id));
        let edge_px = random.between(14.0, 40.0);
        let tag = tag(Family::Tag36h11, id, edge_px, &mut random);
        let pixels = draw(&tag, edge_px * random.between(0.03, 0.08), 8);
        for family in [Family::Aruco4x4With250, Family::Aruco4x4With1000] {
            assert_eq!(detect_in(&pixels, family), [], "{family} {id}");
        }
    }
}

/// The same code words within borders of one module and of two: the outermost bits of either lie about where those of
/// the other end, so that some pass for those of the other. A border of two has no room for the least tags.
#[test]
fn tags_with_a_border_of_two_modules_are_none_with_one_and_the_other_way_round() {
    let families = [Family::Tag36h11, Family::Tag36h11b2];
    let (mut random, mut read) = (Random(24), [0; 2]);
    for i in 0..24 {
        for (n, other) in [0, 1].into_iter().zip(families.into_iter().rev()) {
            let edge_px = random.between([9.0, 13.0][n], 44.0);
            let tag = tag(families[n], i * 97 % 587, edge_px, &mut random);
            let pixels = draw(&tag, random.between(0.3, 0.9), 9);
            let found = detect_in(&pixels, families[n]);
            assert!(found.iter().all(|found| found.id == tag.id));
            assert_eq!(detect_in(&pixels, other), [], "{} {edge_px} px", tag.id);
            read[n] += found.len();
        }
    }
    assert!(read[0] >= 23 && read[1] >= 22, "{read:?}");
}

#[test]
fn small_tags_of_few_bits_are_read() {
    let mut random = Random(22);
    for i in 0..24 {
        let (family, n) = [(Family::Tag16h5, 30), (Family::Aruco4x4With50, 50)][i as usize % 2];
        let tag = tag(family, i % n, random.between(11.0, 20.0), &mut random);
        let found = detect(&tag, family, 6);
        assert_eq!(found.len(), 1, "{family} {} at {:?}", tag.id, tag.turn_deg);
        assert_eq!(found[0].id, tag.id);
    }
}

/// How many of twelve tags of every size are read with these modules of the printed tag in the wrong colour.
fn n_read(family: Family, wrong: &[(usize, usize)]) -> usize {
    let mut random = Random(23);
    let is_read = |i: &u32| {
        let tag = Tag {
            wrong: wrong.to_vec(),
            ..tag(family, *i, random.between(16.0, 40.0), &mut random)
        };
        !detect(&tag, family, 7).is_empty()
    };
    (0..12).filter(is_read).count()
}

#[test]
fn what_has_gaps_on_both_sides_is_no_tag_of_few_bits_though_one_hidden_corner_is_forgiven() {
    for family in [Family::Tag16h5, Family::Aruco4x4With250] {
        let (gaps, corner) = ([(1, 3), (6, 4)], [(1, 1)]);
        assert_eq!(n_read(family, &gaps), 0, "{family}: gaps in the border");
        assert_eq!(n_read(family, &corner), 12, "{family}: a hidden corner");
        assert_eq!(n_read(family, &[]), 12, "{family}: whole");
    }
}
