//! Compares the edges of a decoded tag's modules with the picture.
//!
//! Input: an image, a tag and its fitted corners. Output: the share of the edges between black and white modules,
//! border and ring included, at which the picture brightens towards the white one. Corners that a fit placed beside the
//! border leave edges without a step: the border's own, and those of modules that the displaced homography moves.

use crate::Image;
use crate::homography::{Homography, POINTS, Points};
use crate::kernels::sample;
use crate::quad::{Quad, widths};
use crate::reading::Reading;
use sextant_tag_families::white_modules;

/// Most modules along a printed tag.
const MOST_MODULES: usize = 16;

/// Distance from an edge at which its two sides are sampled, in pixels: beyond usual blur, and less than corners may be
/// off.
const AWAY_PX: f32 = 2.0;

/// The same as a share of a module, at most: so as not to reach the next edge.
const AWAY_SHARE: f32 = 0.4;

/// Least step at an edge, as a share of the tag's contrast. Strong blur leaves little of the step; texture has as many
/// wrong steps as right ones.
const LEAST_STEP: f32 = 0.1;

/// Shares of the edges between modules of different colours at which the picture shows a step, in the quarters of the
/// tag at its corners; those outside the image do not count. Zero for a degenerate quad, or if the image shows no edge.
pub(crate) fn measure(image: &Image<'_>, reading: &Reading, quad: &Quad) -> Agreement {
    let away = (AWAY_PX / module_px(reading, quad)).min(AWAY_SHARE);
    count_steps(image, reading, quad, away)
}

/// How many edges agree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Agreement {
    right: [u32; 4],
    seen: [u32; 4],
}

impl Agreement {
    /// Share of all edges.
    pub(crate) fn share(&self) -> f32 {
        let [right, seen] = [self.right, self.seen].map(|counts| counts.iter().sum::<u32>());
        right as f32 / seen.max(1) as f32
    }

    /// Share of the edges that do not, in the quarter at each corner; none where no edge is seen.
    pub(crate) fn wrong_at_corners(&self) -> [f32; 4] {
        std::array::from_fn(|corner| {
            let (right, seen) = (self.right[corner], self.seen[corner]);
            (seen - right) as f32 / seen.max(1) as f32
        })
    }
}

/// Width of a module across its narrower side, in pixels.
pub(crate) fn module_px(reading: &Reading, quad: &Quad) -> f32 {
    let [width, height] = widths(quad);
    width.min(height) / f32::from(reading.family.data().border_width)
}

/// Moves sides and corners of a quad by up to a module each as long as more edges agree (a pattern search, coarse to
/// fine: Hooke & Jeeves, J. ACM 8, 1961).
pub(crate) fn improve(image: &Image<'_>, reading: &Reading, quad: &Quad) -> Quad {
    const STEPS_IN_MODULES: [f32; 3] = [0.6, 0.3, 0.15];
    const MOST_MOVES: usize = 8;
    let value = |quad: &Quad| count_steps(image, reading, quad, AWAY_SHARE).share();
    let (mut best, mut best_value) = (*quad, value(quad));
    for step in STEPS_IN_MODULES {
        for _ in 0..MOST_MOVES {
            let moved = moves(&best, step / f32::from(reading.family.data().border_width));
            let valued = moved.map(|quad| (quad, value(&quad)));
            let found = valued.max_by(|(_, a), (_, b)| a.total_cmp(b));
            match found {
                Some((quad, value)) if value > best_value => (best, best_value) = (quad, value),
                _ => break,
            }
        }
    }
    best
}

/// A quad with each side, and each end of each side, moved outwards and inwards by a share of the adjacent sides.
fn moves(quad: &Quad, share: f32) -> impl Iterator<Item = Quad> {
    let ends = [[true, true], [true, false], [false, true]];
    let kinds = (0..4).flat_map(move |side| ends.map(|ends| (side, ends)));
    kinds.flat_map(move |(side, [first, second])| {
        [share, -share].map(|share| {
            let mut moved = *quad;
            let (a, b) = (side, (side + 1) % 4);
            let (before, after) = ((side + 3) % 4, (side + 2) % 4);
            let away = |from: usize, to: usize| {
                [0, 1].map(|axis| quad[to][axis] + share * (quad[to][axis] - quad[from][axis]))
            };
            if first {
                moved[a] = away(before, a);
            }
            if second {
                moved[b] = away(after, b);
            }
            moved
        })
    })
}

/// As [`measure`], with both sides of an edge sampled this share of a module away from it.
fn count_steps(image: &Image<'_>, reading: &Reading, quad: &Quad, away: f32) -> Agreement {
    let Some(map) = Homography::square_to_quad(quad) else {
        return Agreement::default();
    };
    let data = reading.family.data();
    let (total, border) = (usize::from(data.total_width), f32::from(data.border_width));
    let least = LEAST_STEP * (reading.white - reading.black);
    // A bit for each white module of a row.
    let mut rows = [0_u32; MOST_MODULES];
    for (x, y) in white_modules(reading.family, reading.found.id) {
        rows[y % MOST_MODULES] |= 1 << x;
    }
    let is_white = |x: usize, y: usize| rows[y % MOST_MODULES] >> x & 1 == 1;
    let mut tally = Tally::default();
    for (x, y) in (0..total).flat_map(|y| (0..total).map(move |x| (x, y))) {
        for [dx, dy] in [[1, 0], [0, 1]] {
            let (next_x, next_y) = (x + dx, y + dy);
            if next_x >= total || next_y >= total || is_white(x, y) == is_white(next_x, next_y) {
                continue;
            }
            // The middle of the edge, in modules from the middle of the tag, and its two sides, the white one first.
            let place =
                [x + next_x + 1, y + next_y + 1].map(|twice| (twice as f32 - total as f32) / 2.0);
            let towards_white = if is_white(next_x, next_y) {
                away
            } else {
                -away
            };
            for sign in [towards_white, -towards_white] {
                let at = [place[0] + sign * dx as f32, place[1] + sign * dy as f32];
                tally.push(at.map(|at| 2.0 * at / border));
            }
            if tally.n == POINTS {
                tally.count(image, &map, least);
            }
        }
    }
    tally.count(image, &map, least);
    tally.agreement
}

/// Places to be sampled, in pairs, and the pairs sampled so far.
#[derive(Default)]
struct Tally {
    places: [Points; 2],
    n: usize,
    agreement: Agreement,
}

impl Tally {
    fn push(&mut self, [u, v]: [f32; 2]) {
        self.places[0][self.n] = u;
        self.places[1][self.n] = v;
        self.n += 1;
    }

    fn count(&mut self, image: &Image<'_>, map: &Homography, least: f32) {
        let mut greys = [0.0; POINTS];
        sample(image, map, &[self.places], &mut greys);
        for (pair, [white, black]) in greys[..self.n].as_chunks().0.iter().enumerate() {
            let step = white - black;
            let [is_right, is_low] = self.places.map(|at| at[2 * pair] + at[2 * pair + 1] > 0.0);
            let corner = [[0, 1], [3, 2]][usize::from(is_low)][usize::from(is_right)];
            self.agreement.seen[corner] += u32::from(!step.is_nan());
            self.agreement.right[corner] += u32::from(step >= least);
        }
        self.n = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code_index::Match;
    use crate::quad::distance;
    use sextant_tag_families::Family;

    const SIZE: usize = 200;
    const MODULE: usize = 16;
    const FIRST: usize = 20;

    /// A picture of a tag, straight, with modules of 16 pixels, and what was read.
    fn tag() -> (Vec<u8>, Reading) {
        let mut pixels = vec![120; SIZE * SIZE];
        for y in 0..10 * MODULE {
            for x in 0..10 * MODULE {
                pixels[(y + FIRST) * SIZE + x + FIRST] = 30;
            }
        }
        for (x, y) in white_modules(Family::Tag36h11, 5) {
            for i in 0..MODULE * MODULE {
                let (x, y) = (x * MODULE + i % MODULE, y * MODULE + i / MODULE);
                pixels[(y + FIRST) * SIZE + x + FIRST] = 220;
            }
        }
        let found = Match {
            id: 5,
            hamming: 0,
            turns: 0,
        };
        let reading = Reading {
            family: Family::Tag36h11,
            found,
            margin: 80.0,
            black: 30.0,
            white: 220.0,
            is_evident: true,
        };
        (pixels, reading)
    }

    fn square() -> Quad {
        let (low, high) = (
            (FIRST + MODULE) as f32 - 0.5,
            (FIRST + 9 * MODULE) as f32 - 0.5,
        );
        [[low, low], [high, low], [high, high], [low, high]]
    }

    #[test]
    fn all_edges_agree_with_the_true_corners() {
        let (pixels, reading) = tag();
        let image = Image::new(&pixels, SIZE, SIZE, SIZE).unwrap();
        assert_eq!(measure(&image, &reading, &square()).share(), 1.0);
    }

    #[test]
    fn a_side_beside_its_edge_is_noticed_and_moved_back() {
        let (pixels, reading) = tag();
        let image = Image::new(&pixels, SIZE, SIZE, SIZE).unwrap();
        for side in 0..4 {
            for (first_px, second_px) in [(12.0, 12.0), (12.0, 0.0), (-10.0, -10.0)] {
                let mut quad = square();
                let axis = (side + 1) % 2;
                let inwards = if side == 0 || side == 3 { 1.0 } else { -1.0 };
                quad[side][axis] += inwards * first_px;
                quad[(side + 1) % 4][axis] += inwards * second_px;
                let share = measure(&image, &reading, &quad).share();
                assert!(share < 0.85, "side {side}: {share}");
                let moved = improve(&image, &reading, &quad);
                let mut corners = moved.into_iter().zip(square());
                assert!(
                    corners.all(|(a, b)| distance(a, b) < 0.4 * MODULE as f32),
                    "side {side}: {moved:?}"
                );
            }
        }
    }
}
