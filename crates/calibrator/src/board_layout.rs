//! Which of OpenCV's two layouts a ChArUco board has: the upper left square black, or white with a marker (before
//! version 4.6, with an even number of rows).
//!
//! Both have the same markers in the same order, at other squares. White squares that touch at a corner report the same
//! point of the image, which tells the layouts apart without any lens or pose.

use nalgebra::distance;
use sextant_site_model::{ImageObservation, ObjectModel, TagCorners, TagId};
use sextant_tag_families::Board;
use std::collections::{BTreeMap, BTreeSet};
use thiserror::Error;

/// Corners are one if they are closer than this share of the distance between adjacent corners.
const SAME: f64 = 0.1;
/// Least number of touching squares that contradict the file, and how many times as many as agree with it.
const LEAST: usize = 4;
const TIMES: usize = 3;

/// The board that the images show has the other layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum OtherLayout {
    /// The file has the layout since OpenCV 4.6.
    #[error(
        "the board in the images begins with a marker in its upper left corner, where the board \
         file has a black square: \
        it is of OpenCV's layout before version 4.6; add `legacyPattern: true` to the file that describes the board"
    )]
    Legacy,
    /// The file has the layout before OpenCV 4.6.
    #[error(
        "the board in the images begins with a black square in its upper left corner, where the \
         board file has a marker: \
        it is of OpenCV's layout since version 4.6; remove `legacyPattern` from the file that describes the board"
    )]
    Current,
}

/// Two tags, the first one's lower corner that they share, and the second one's upper corner.
type Touch = (TagId, TagId, [usize; 2]);

/// Compares both layouts of a board with images.
#[derive(Clone, Debug)]
pub struct LayoutCheck {
    other: OtherLayout,
    /// Squares that touch in the layout of the file only, and in the other one only.
    touching: [BTreeSet<Touch>; 2],
    /// How many of them touch in the images.
    seen: [usize; 2],
}

impl LayoutCheck {
    /// Of a ChArUco board in one of the layouts that differ; none for any other object.
    pub fn for_board(object: &ObjectModel) -> Option<Self> {
        let places = places_of(object)?;
        let bound = |axis: usize| places.keys().map(|place| place[axis]).max();
        let [columns, rows] = [bound(0)? + 1, bound(1)? + 1];
        let parity = |[column, row]: &[i64; 2]| (column + row).rem_euclid(2);
        let layout = |colour: i64| {
            let squares = (0..rows).flat_map(|row| (0..columns).map(move |column| [row, column]));
            let white = squares.map(|[row, column]| [column, row]);
            white.filter(move |place| parity(place) == colour)
        };
        let own = parity(places.keys().min_by_key(|[column, row]| (*row, *column))?);
        let mut tags: Vec<TagId> = places.values().copied().collect();
        tags.sort_unstable();
        let laid = |colour: i64| -> BTreeMap<[i64; 2], TagId> {
            layout(colour).zip(tags.iter().copied()).collect()
        };
        let is_whole = layout(own).count() == tags.len() && laid(own) == places;
        if !is_whole || rows % 2 != 0 {
            return None;
        }
        let [own_touching, other_touching] = [own, 1 - own].map(|colour| touching(&laid(colour)));
        let only = |a: &BTreeSet<Touch>, b: &BTreeSet<Touch>| a.difference(b).copied().collect();
        Some(Self {
            other: if own == 0 {
                OtherLayout::Current
            } else {
                OtherLayout::Legacy
            },
            touching: [
                only(&own_touching, &other_touching),
                only(&other_touching, &own_touching),
            ],
            seen: [0; 2],
        })
    }

    /// Takes an image in.
    pub fn observe(&mut self, image: &ImageObservation) {
        let tags: BTreeMap<TagId, &TagCorners> =
            image.tags.iter().map(|seen| (seen.tag, seen)).collect();
        for (touching, seen) in self.touching.iter().zip(&mut self.seen) {
            let touches = touching.iter().filter(|(a, b, [of_a, of_b])| {
                let (Some(a), Some(b)) = (tags.get(a), tags.get(b)) else {
                    return false;
                };
                let edge = distance(&a.corners[*of_a], &a.corners[(of_a + 1) % 4]);
                distance(&a.corners[*of_a], &b.corners[*of_b]) < SAME * edge
            });
            *seen += touches.count();
        }
    }

    /// Whether the images show the layout of the file.
    ///
    /// # Errors
    /// The other one, if they show that clearly.
    pub fn check(&self) -> Result<(), OtherLayout> {
        let [own, other] = self.seen;
        match other >= LEAST && other > TIMES * own {
            true => Err(self.other),
            false => Ok(()),
        }
    }
}

/// Columns and rows of the squares of a ChArUco board whose origin is its upper left corner.
fn places_of(object: &ObjectModel) -> Option<BTreeMap<[i64; 2], TagId>> {
    let places = object.tags().iter().map(|tag| {
        let is_square = tag.tag.family.data().board == Some(Board::Charuco);
        let middle = tag.object_from_tag.filter(|_| is_square)?.translation;
        let place = [middle.x, middle.y].map(|at| at / tag.size_m - 0.5);
        let is_in_grid = place
            .iter()
            .all(|at| (at - at.round()).abs() < 0.01 && *at < 1e3);
        is_in_grid.then(|| (place.map(|at| at.round() as i64), tag.tag))
    });
    places.collect()
}

/// White squares that touch at a corner.
fn touching(places: &BTreeMap<[i64; 2], TagId>) -> BTreeSet<Touch> {
    const BELOW: [(i64, [usize; 2]); 2] = [(1, [2, 0]), (-1, [3, 1])];
    let pairs = places.iter().flat_map(|([column, row], tag)| {
        BELOW.into_iter().filter_map(move |(aside, corners)| {
            let below = places.get(&[column + aside, row + 1])?;
            Some((*tag, *below, corners))
        })
    });
    pairs.collect()
}
