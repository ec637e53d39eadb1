//! The place of a lattice on a board: which of its corners is the board's first, and which way its columns run.

use super::lattice::{Corner, Index, Lattice};
use super::{BoardShape, ChessboardView, Extent};
use crate::quad::Point;
use crate::{Detection, Refinement};
use sextant_tag_families::{Family, chessboard_id};
use std::collections::BTreeMap;

/// A lattice with the corners of a board: indices from 0 to the lattice's size.
struct Placed {
    size: [u16; 2],
    corners: BTreeMap<Index, Corner>,
    /// Whether the square between the first corners is dark.
    is_dark: bool,
    /// Horizontal component of the direction of the columns.
    rightwards: f32,
}

/// The view of a board that a lattice is.
pub(super) fn placed(lattice: &Lattice, board: BoardShape) -> Option<ChessboardView> {
    let turns: Vec<Placed> = (0..4)
        .filter_map(|turn| Placed::turned(lattice, turn))
        .collect();
    let board_size = [board.columns, board.rows];
    let fits = |placed: &&Placed| (0..2).all(|axis| placed.size[axis] <= board_size[axis]);
    let rank = |placed: &Placed| {
        // A partial view has no known place, so that colours do not matter.
        let is_right = placed.size != board_size || placed.is_dark;
        (is_right, placed.rightwards)
    };
    let best = turns.iter().filter(fits).max_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let Some(best) = best else {
        let seen = turns
            .iter()
            .max_by(|a, b| a.rightwards.total_cmp(&b.rightwards))?;
        return Some(ChessboardView {
            size: seen.size,
            extent: Extent::Larger,
            squares: Vec::new(),
        });
    };
    Some(ChessboardView {
        size: best.size,
        extent: if best.size == board_size {
            Extent::Whole
        } else {
            Extent::Part
        },
        squares: best.squares(),
    })
}

impl Placed {
    /// The lattice turned by quarters, with its first corner at (0, 0).
    fn turned(lattice: &Lattice, turn: usize) -> Option<Self> {
        let turned = |[column, row]: Index| match turn {
            0 => [column, row],
            1 => [row, -column],
            2 => [-column, -row],
            _ => [-row, column],
        };
        let indices = lattice.corners.keys().map(|index| turned(*index));
        let bound = |axis: usize| {
            let along = indices.clone().map(move |index| index[axis]);
            Some((along.clone().min()?, along.max()?))
        };
        let (first_column, last_column) = bound(0)?;
        let (first_row, last_row) = bound(1)?;
        let size = [last_column - first_column + 1, last_row - first_row + 1];
        let moved = |index: Index| {
            let [column, row] = turned(index);
            [column - first_column, row - first_row]
        };
        let corners: BTreeMap<Index, Corner> = lattice
            .corners
            .iter()
            .map(|(index, corner)| (moved(*index), *corner))
            .collect();
        let rightwards = corners
            .iter()
            .filter_map(|(index, corner)| {
                let next = corners.get(&[index[0] + 1, index[1]])?;
                Some(next.place[0] - corner.place[0])
            })
            .sum();
        // Colours of all squares follow from those of the corner that was (0, 0).
        let (origin, is_bright) = lattice
            .corners
            .keys()
            .next()
            .map(|index| (moved(*index), lattice.is_bright_at(*index)))?;
        // By a turn, the square to the lower right becomes another one of the corner.
        let is_even = (origin[0] + origin[1]).rem_euclid(2) == 0;
        let lower_right_is_bright = is_bright == turn.is_multiple_of(2);
        Some(Self {
            size: size.map(|n| u16::try_from(n).unwrap_or(u16::MAX)),
            corners,
            is_dark: lower_right_is_bright != is_even,
            rightwards,
        })
    }

    /// Squares whose four corners are seen, as few as contain every such corner. A corner of several squares is
    /// reported with each, with a part of the information.
    fn squares(&self) -> Vec<Detection> {
        let whole: Vec<Index> = self
            .corners
            .keys()
            .copied()
            .filter(|i| self.square(*i).is_some())
            .collect();
        let mut uses: BTreeMap<Index, u8> = BTreeMap::new();
        let mut chosen = Vec::new();
        for least_new in (1..=4).rev() {
            for &index in &whole {
                let new = around(index)
                    .into_iter()
                    .filter(|corner| !uses.contains_key(corner))
                    .count();
                if new >= least_new {
                    chosen.push(index);
                    for corner in around(index) {
                        *uses.entry(corner).or_default() += 1;
                    }
                }
            }
        }
        chosen.sort_by_key(|[column, row]| (*row, *column));
        let detections = chosen.into_iter().filter_map(|index| {
            let corners = self.square(index)?;
            let shares = around(index).map(|corner| f32::from(uses[&corner]));
            let covariance = |i: usize| corners[i].covariance.map(|value| shares[i] * value);
            Some(Detection {
                family: Family::Chessboard,
                id: chessboard_id(index.map(|n| n as u16)),
                hamming: 0,
                margin: corners
                    .iter()
                    .map(|corner| corner.swing)
                    .fold(f32::INFINITY, f32::min),
                corners: corners.map(|corner| -> Point { corner.place }),
                corner_covariance: [0, 1, 2, 3].map(covariance),
                corner_cross_covariance: Default::default(),
                refinement: Refinement::Photometric,
            })
        });
        detections.collect()
    }

    fn square(&self, index: Index) -> Option<[Corner; 4]> {
        let [a, b, c, d] = around(index).map(|corner| self.corners.get(&corner).copied());
        Some([a?, b?, c?, d?])
    }
}

/// The corners of the square to the lower right of a corner, clockwise from that one.
fn around([column, row]: Index) -> [Index; 4] {
    [
        [column, row],
        [column + 1, row],
        [column + 1, row + 1],
        [column, row + 1],
    ]
}
