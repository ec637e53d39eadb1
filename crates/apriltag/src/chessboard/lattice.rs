//! The corners of a chessboard in columns and rows, grown over links and completed by local prediction, so that a lens
//! may bend them.

use super::candidates::Candidate;
use super::links::{Link, is_edge};
use super::smoothed::Smoothed;
use crate::Image;
use crate::quad::{Point, distance};
use crate::saddle::{self, Guess, RADIUS_PX, Saddle};
use std::collections::{BTreeMap, VecDeque};

/// Column and row, relative to the corner from which the lattice grew.
pub(super) type Index = [i32; 2];

/// Steps to the neighbours, clockwise: right, down, left, up.
pub(super) const STEPS: [Index; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// Largest distance of a corner from its prediction, as a share of the distance to its neighbours.
const MOST_OFF: f32 = 0.3;
/// Radius of a saddle point's window, as a share of the distance to the nearest neighbour.
const CLEAR: f32 = 0.45;
/// Most rounds in which missing corners are predicted.
const ROUNDS: usize = 12;

/// A corner with its place in the lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub(super) place: Point,
    /// Covariance (xx, xy, yy) in square pixels.
    pub(super) covariance: [f32; 3],
    /// Half the difference between bright and dark, in grey levels.
    pub(super) swing: f32,
}

/// Corners by column and row; columns run to the right of rows seen from the front, as x and y in the image.
#[derive(Clone, Debug, Default)]
pub(super) struct Lattice {
    pub(super) corners: BTreeMap<Index, Corner>,
    /// Whether the square to the lower right of corner (0, 0), and every other one from it, is bright.
    pub(super) is_bright: bool,
}

/// A corner of the lattice under growth: its candidate, and which of its edges leads to the next column.
type Node = (usize, usize);

/// The connected sets of candidates, the largest first.
pub(super) fn lattices(candidates: &[Candidate], links: &[[Link; 4]]) -> Vec<Lattice> {
    let mut is_taken = vec![false; candidates.len()];
    let mut lattices: Vec<Lattice> = (0..candidates.len())
        .filter_map(|seed| {
            let nodes = connected(seed, links, &mut is_taken);
            (nodes.len() >= 4).then(|| Lattice {
                is_bright: true,
                corners: nodes
                    .into_iter()
                    .map(|(index, (candidate, _))| {
                        let Candidate { place, swing, .. } = candidates[candidate];
                        // Unknown until it is located.
                        let covariance = [f32::NAN; 3];
                        let corner = Corner {
                            place,
                            covariance,
                            swing,
                        };
                        (index, corner)
                    })
                    .collect(),
            })
        })
        .collect();
    lattices.sort_by_key(|lattice| std::cmp::Reverse(lattice.corners.len()));
    lattices
}

/// The candidates that links connect with a seed. Its first edge leads to the next column.
fn connected(seed: usize, links: &[[Link; 4]], is_taken: &mut [bool]) -> BTreeMap<Index, Node> {
    let mut nodes = BTreeMap::new();
    if is_taken[seed] {
        return nodes;
    }
    is_taken[seed] = true;
    nodes.insert([0, 0], (seed, 0));
    let mut queue = VecDeque::from([[0, 0]]);
    while let Some(index) = queue.pop_front() {
        let (candidate, first) = nodes[&index];
        for (turn, step) in STEPS.iter().enumerate() {
            let Some((next, back)) = links[candidate][(first + turn) % 4] else {
                continue;
            };
            let place = [index[0] + step[0], index[1] + step[1]];
            if !is_taken[next] && !nodes.contains_key(&place) {
                is_taken[next] = true;
                // Its edge `back` leads opposite to the step.
                nodes.insert(place, (next, (back + 2 + 4 - turn) % 4));
                queue.push_back(place);
            }
        }
    }
    nodes
}

impl Lattice {
    /// Removes corners that contradict their neighbours, finds missing ones where neighbours predict them, and locates
    /// all with sub-pixel accuracy. Corners that are no saddle points are removed.
    pub(super) fn complete(&mut self, image: &Image<'_>, smoothed: &Smoothed) {
        self.remove_outliers();
        self.locate(image, smoothed);
        self.remove_outliers();
        for _ in 0..ROUNDS {
            let found = self.missing(image, smoothed);
            if found.is_empty() {
                break;
            }
            self.corners.extend(found);
            self.remove_outliers();
        }
    }

    fn remove_outliers(&mut self) {
        let is_off = |(index, corner): (&Index, &Corner)| {
            let (predicted, spacing) = self.prediction(*index)?;
            (distance(predicted, corner.place) > MOST_OFF * spacing).then_some(*index)
        };
        let wrong: Vec<Index> = self.corners.iter().filter_map(is_off).collect();
        for index in wrong {
            self.corners.remove(&index);
        }
    }

    fn locate(&mut self, image: &Image<'_>, smoothed: &Smoothed) {
        let located = self.corners.iter().filter_map(|(index, corner)| {
            Some((*index, self.corner(image, smoothed, *index, corner.place)?))
        });
        self.corners = located.collect();
    }

    /// The corner with this index, at the saddle point next to a place.
    fn corner(
        &self,
        image: &Image<'_>,
        smoothed: &Smoothed,
        index: Index,
        place: Point,
    ) -> Option<Corner> {
        let guess = self.guess(smoothed, index, place)?;
        let Saddle { place, covariance } = saddle::find(image, &guess)?;
        Some(Corner {
            place,
            covariance,
            swing: guess.step / 2.0,
        })
    }

    /// Corners next to known ones that are not in the lattice yet, where there are saddle points.
    fn missing(&self, image: &Image<'_>, smoothed: &Smoothed) -> Vec<(Index, Corner)> {
        let mut places: Vec<Index> = self
            .corners
            .keys()
            .flat_map(|index| STEPS.map(|step| add(*index, step, 1)))
            .filter(|index| !self.corners.contains_key(index))
            .collect();
        places.sort_unstable();
        places.dedup();
        let found = places.into_iter().filter_map(|index| {
            let (predicted, spacing) = self.prediction(index)?;
            let corner = self.corner(image, smoothed, index, predicted)?;
            let is_near = distance(corner.place, predicted) < MOST_OFF * spacing;
            (is_near && self.is_joined(smoothed, index, &corner)).then_some((index, corner))
        });
        found.collect()
    }

    /// Whether edges lead from a new corner to all of its neighbours.
    fn is_joined(&self, smoothed: &Smoothed, index: Index, corner: &Corner) -> bool {
        STEPS.iter().enumerate().all(|(turn, step)| {
            let Some(next) = self.corners.get(&add(index, *step, 1)) else {
                return true;
            };
            let bright_right = self.is_bright_at(index) == (turn % 2 == 0);
            let least = 0.5 * (corner.swing + next.swing);
            is_edge(smoothed, [corner.place, next.place], bright_right, least)
        })
    }

    /// Whether the square to the lower right of a corner is bright.
    pub(super) fn is_bright_at(&self, [column, row]: Index) -> bool {
        self.is_bright == ((column + row).rem_euclid(2) == 0)
    }

    /// Where the neighbours say that a corner is, and the distance to the nearest of them; `None` where they are too
    /// few.
    fn prediction(&self, index: Index) -> Option<(Point, f32)> {
        let at =
            |step: Index, times: i32| self.corners.get(&add(index, step, times)).map(|c| c.place);
        let mut sum = [0.0, 0.0];
        let mut weight = 0.0;
        let mut spacing = f32::INFINITY;
        let mut propose = |place: Point, share: f32| {
            sum = [sum[0] + share * place[0], sum[1] + share * place[1]];
            weight += share;
        };
        for axis in 0..2 {
            let (ahead, behind) = (STEPS[axis], STEPS[axis + 2]);
            if let (Some(a), Some(b)) = (at(ahead, 1), at(behind, 1)) {
                propose([(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0], 4.0);
                spacing = spacing.min(distance(a, b) / 2.0);
                continue;
            }
            for step in [ahead, behind] {
                match (at(step, 1), at(step, 2), at(step, 3)) {
                    (Some(a), Some(b), Some(c)) => {
                        propose(std::array::from_fn(|i| 3.0 * (a[i] - b[i]) + c[i]), 1.0);
                        spacing = spacing.min(distance(a, b));
                    }
                    (Some(a), Some(b), None) => {
                        propose(std::array::from_fn(|i| 2.0 * a[i] - b[i]), 1.0);
                        spacing = spacing.min(distance(a, b));
                    }
                    _ => {}
                }
            }
        }
        for turn in 0..4 {
            let (one, other) = (STEPS[turn], STEPS[(turn + 1) % 4]);
            let across = self.corners.get(&add(add(index, one, 1), other, 1));
            if let (Some(a), Some(b), Some(c)) = (at(one, 1), at(other, 1), across) {
                propose(std::array::from_fn(|i| a[i] + b[i] - c.place[i]), 1.0);
                spacing = spacing.min(distance(a, c.place)).min(distance(b, c.place));
            }
        }
        (weight > 0.0).then(|| (sum.map(|part| part / weight), spacing))
    }

    /// Initial guess of the saddle point at a corner.
    fn guess(&self, smoothed: &Smoothed, index: Index, place: Point) -> Option<Guess> {
        let right = self.tangent(index, place, 0)?;
        let down = self.tangent(index, place, 1)?;
        let edges = match self.is_bright_at(index) {
            true => [right, down],
            // The bright quadrant is the next one.
            false => [down, right.map(|part| -part)],
        };
        let [a, b] = edges;
        let middle = |along_a: f32, along_b: f32| {
            smoothed.sample([0, 1].map(|i| place[i] + along_a * a[i] + along_b * b[i]))
        };
        let bright = middle(0.5, 0.5)? + middle(-0.5, -0.5)?;
        let dark = middle(0.5, -0.5)? + middle(-0.5, 0.5)?;
        let step = (bright - dark) / 2.0;
        if step <= 0.0 {
            return None;
        }
        let lengths = [a, b].map(|[x, y]| x.hypot(y));
        let sine = (a[0] * b[1] - a[1] * b[0]) / (lengths[0] * lengths[1]);
        let clear = CLEAR * sine * lengths[0].min(lengths[1]);
        Some(Guess {
            place,
            edges,
            step,
            radius_px: clear.clamp(RADIUS_PX[0], RADIUS_PX[1]),
            gap_px: 0.0,
        })
    }

    /// Way from a corner to the next one along an axis, by its neighbours or, without any, those of its neighbours.
    fn tangent(&self, index: Index, place: Point, axis: usize) -> Option<Point> {
        let difference = |a: Point, b: Point, by: f32| [(a[0] - b[0]) / by, (a[1] - b[1]) / by];
        let at = |index: Index| self.corners.get(&index).map(|corner| corner.place);
        let step = STEPS[axis];
        let of = |index: Index, place: Point| match (
            at(add(index, step, 1)),
            at(add(index, step, -1)),
        ) {
            (Some(a), Some(b)) => Some(difference(a, b, 2.0)),
            (Some(a), None) => Some(difference(a, place, 1.0)),
            (None, Some(b)) => Some(difference(place, b, 1.0)),
            (None, None) => None,
        };
        let beside = || {
            STEPS.iter().find_map(|step| {
                let next = add(index, *step, 1);
                of(next, at(next)?)
            })
        };
        of(index, place).or_else(beside)
    }
}

pub(super) fn add(index: Index, step: Index, times: i32) -> Index {
    [index[0] + times * step[0], index[1] + times * step[1]]
}
