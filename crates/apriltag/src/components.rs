//! Connected components of black pixels, joined run by run.
//!
//! Input: the bit plane, two rows at a time. Output: runs with their component, and the bounding box of each component.
//! Pixels that touch at a corner are connected (8-connectivity). Therefore adjacent columns that are black in either of
//! two rows are connected, and a run covers both rows. (He, Chao & Suzuki, A run-based two-scan labeling algorithm,
//! IEEE Trans. Image Processing 17, 2008, with the blocks of Grana, Borghesani & Cucchiara, IEEE Trans. Image
//! Processing 19, 2010; touching runs are found in whole words here, without unpredictable branches.)

mod runs;

use crate::bit_plane::BitPlane;
use crate::kernels::{WORD, vectorise};
use crate::quad::Quad;
use runs::{NumberedPair, UNLABELLED, find_spans, join_pairs};
use std::mem;
use std::ops::Range;

/// Adjacent columns with a black pixel in either of two rows: the first one and one past the last.
pub(crate) type Span = [u16; 2];

/// Connected black pixels; during labelling, a part of a component.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Component {
    left: u32,
    /// Zero in a part that was merged into another.
    pub(crate) n_runs: u32,
    /// One past the last column.
    right: u32,
    /// First and last pair of rows.
    top_pair: u16,
    bottom_pair: u16,
    /// Ends of the linked list of runs.
    last_run: u32,
    first_run: u32,
    /// An earlier part that this one is connected to, or itself.
    earlier: u32,
}

impl Component {
    pub(crate) fn width(&self) -> u32 {
        self.right - self.left
    }

    pub(crate) fn n_pairs(&self) -> u32 {
        u32::from(self.bottom_pair - self.top_pair) + 1
    }

    pub(crate) fn columns(&self) -> Range<u32> {
        self.left..self.right
    }

    /// Its rows, possibly with one more above and below.
    pub(crate) fn rows(&self) -> Range<u32> {
        2 * u32::from(self.top_pair)..2 * u32::from(self.bottom_pair) + 2
    }

    /// Whether its box and runs allow it to be the border of a tag with this mean edge at least. A border is a closed
    /// band, so in this share of its rows at least it has two runs; a tag may be narrow when viewed from the side.
    pub(crate) fn may_be_border(&self, min_edge_px: f32, least_open: f32) -> bool {
        /// Narrowest view of a tag that can be read, as a share of its edge.
        const NARROWEST: f32 = 0.3;
        let (width, n_pairs) = (self.width(), self.n_pairs());
        (width + 2 * n_pairs) as f32 >= 2.0 * min_edge_px
            && width.min(2 * n_pairs) as f32 >= min_edge_px * NARROWEST
            && self.n_runs as f32 > (1.0 + least_open) * n_pairs as f32
    }

    /// Whether it may be a tag and something that touches it: large and with many gaps.
    pub(crate) fn may_be_touched(&self, min_edge_px: f32) -> bool {
        /// Twice the runs in a pair of rows: two of the border in most, one of a square at a corner in some.
        const LEAST_RUNS: u32 = 3;
        let n_pairs = self.n_pairs();
        self.width().min(2 * n_pairs) as f32 >= 2.0 * min_edge_px
            && 2 * self.n_runs >= LEAST_RUNS * n_pairs
    }

    /// Corners of the box, clockwise from the top left.
    pub(crate) fn corners(&self) -> Quad {
        let (columns, rows) = (self.columns(), self.rows());
        let [left, right] = [columns.start, columns.end - 1].map(|x| x as f32);
        let [top, bottom] = [rows.start, rows.end - 1].map(|y| y as f32);
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }

    fn begin(number: u32, top_pair: u16, run: u32) -> Self {
        Self {
            left: u32::MAX,
            top_pair,
            last_run: run,
            first_run: run,
            earlier: number,
            ..Self::default()
        }
    }

    #[inline(always)]
    fn grow(&mut self, [start, end]: Span, pair: u16) {
        let [start, end] = [start, end].map(u32::from);
        self.n_runs += 1;
        self.left = self.left.min(start);
        self.right = self.right.max(end);
        self.bottom_pair = pair;
    }

    /// Merges a later part into this one, with its list of runs.
    fn absorb(&mut self, part: &mut Self, steps: &mut [Step]) {
        self.n_runs += mem::take(&mut part.n_runs);
        self.left = self.left.min(part.left);
        self.right = self.right.max(part.right);
        self.bottom_pair = self.bottom_pair.max(part.bottom_pair);
        steps[part.first_run as usize].before = self.last_run;
        self.last_run = part.last_run;
    }
}

/// A run in the linked list of its component.
#[derive(Clone, Copy, Debug, Default)]
struct Step {
    pair: u16,
    /// The previous run; the first run refers to itself.
    before: u32,
}

#[derive(Debug, Default)]
pub(crate) struct Components {
    /// Capacity of `max_runs` at least, of which the first `n_runs` are in use.
    spans: Vec<Span>,
    /// The part of a component that each run belongs to. Runs after the first `n_runs` have none.
    labels: Vec<u32>,
    steps: Vec<Step>,
    n_runs: usize,
    max_runs: usize,
    /// In the order of their first runs. Capacity as for runs; memory beyond the parts of past images is never written.
    parts: Vec<Component>,
}

/// Least number of image pixels per run: only noise has shorter runs and gaps. Rows beyond this bound are ignored.
const PIXELS_PER_RUN: usize = 8;

impl Components {
    /// Allocates the memory that an image of this size can need.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.max_runs = width * height / PIXELS_PER_RUN;
        let room = self.labels.len().max(self.max_runs);
        self.spans.resize(room, Span::default());
        self.labels.resize(room, UNLABELLED);
        self.steps.resize(room, Step::default());
        self.parts.clear();
        self.parts.reserve_exact(room);
    }

    pub(crate) fn label(&mut self, plane: &BitPlane) {
        vectorise!(self.find_runs(plane));
        self.gather_parts();
    }

    /// Finds the runs of each pair of rows, connects them with those of the pair above, and updates the parts.
    #[inline(always)]
    fn find_runs(&mut self, plane: &BitPlane) {
        self.labels[..self.n_runs].fill(UNLABELLED);
        self.n_runs = 0;
        self.parts.clear();
        let mut above = NumberedPair::default();
        for (pair, number) in plane.row_pairs().zip(0..) {
            let first = self.n_runs;
            if first + pair.live.len() * WORD / 2 > self.max_runs {
                above = NumberedPair::default();
                continue;
            }
            self.n_runs += find_spans(&pair, &mut self.spans[first..]);
            let here = NumberedPair {
                rows: pair,
                first_run: first,
            };
            join_pairs(&mut self.labels, &mut self.parts, &here, &above);
            above = here;
            self.measure(first, number);
        }
    }

    /// Adds the last pair of rows to the parts. A run that touches no earlier one begins a part. A separate function,
    /// because the loops of its caller leave too few registers.
    #[inline(never)]
    fn measure(&mut self, first: usize, pair: u16) {
        let runs = first..self.n_runs;
        let labels = &mut self.labels[runs.clone()];
        let steps = &mut self.steps[runs.clone()];
        let each = self.spans[runs].iter().zip(labels).zip(steps);
        for (run, ((&span, label), step)) in (first as u32..).zip(each) {
            // Unlabelled, which is beyond all parts.
            if *label as usize >= self.parts.len() {
                *label = self.parts.len() as u32;
                self.parts.push(Component::begin(*label, pair, run));
            }
            let part = &mut self.parts[*label as usize];
            let before = mem::replace(&mut part.last_run, run);
            *step = Step { pair, before };
            part.grow(span, pair);
        }
    }

    /// Merges connected parts into components, each into its first part.
    fn gather_parts(&mut self) {
        for part in (0..self.parts.len()).rev() {
            let (before, here) = self.parts.split_at_mut(part);
            if let Some(earlier) = before.get_mut(here[0].earlier as usize) {
                earlier.absorb(&mut here[0], &mut self.steps);
            }
        }
    }

    pub(crate) fn n_runs(&self) -> usize {
        self.n_runs
    }

    pub(crate) fn n_components(&self) -> usize {
        self.all().iter().filter(|part| part.n_runs > 0).count()
    }

    /// All components, indexed by their first part; merged parts in between have no runs.
    pub(crate) fn all(&self) -> &[Component] {
        &self.parts
    }

    /// First and last column of a component in each of its pairs of rows.
    #[inline(always)]
    pub(crate) fn read_extents(&self, component: &Component, extents: &mut [Span]) {
        extents.fill([u16::MAX, 0]);
        let mut run = component.last_run;
        loop {
            let Step { pair, before } = self.steps[run as usize];
            let [start, end] = self.spans[run as usize];
            let [first, beyond] = &mut extents[usize::from(pair - component.top_pair)];
            (*first, *beyond) = (start.min(*first), end.max(*beyond));
            if before == run {
                return;
            }
            run = before;
        }
    }

    /// The component that a part belongs to.
    fn component_of(&self, mut part: u32) -> u32 {
        while self.parts[part as usize].n_runs == 0 {
            part = self.parts[part as usize].earlier;
        }
        part
    }

    /// Black pixels, column and row, with their components.
    pub(crate) fn labelled_pixels(
        &self,
        plane: &BitPlane,
    ) -> impl Iterator<Item = ([u16; 2], u32)> {
        (0..self.n_runs).flat_map(move |run| {
            let (row, [start, end]) = (2 * self.steps[run].pair, self.spans[run]);
            let places = [row, row + 1].map(|y| (start..end).map(move |x| [x, y]));
            let component = self.component_of(self.labels[run]);
            let black = places
                .into_iter()
                .flatten()
                .filter(|place| plane.is_set(*place));
            black.map(move |place| (place, component))
        })
    }
}

/// Clears a buffer and allocates memory for `n` elements.
pub(crate) fn make_room<T>(buffer: &mut Vec<T>, n: usize) {
    buffer.clear();
    buffer.reserve_exact(n);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// Index of the first set bit, in row-major order, of the component that contains each set bit.
    fn flooded(rows: &[Vec<u64>]) -> Vec<usize> {
        let width = rows[0].len() * WORD;
        let set = |at: usize| rows[at / width][at % width / WORD] >> (at % WORD) & 1 == 1;
        let mut firsts: Vec<usize> = (0..rows.len() * width).collect();
        let touching = |a: usize, b: usize| (a % width).abs_diff(b % width) <= 1;
        let (n, mut changed) = (firsts.len(), true);
        while changed {
            changed = false;
            for at in (0..n).filter(|at| set(*at)) {
                let beside = [at + 1, at + width - 1, at + width, at + width + 1];
                for other in beside.into_iter().filter(|other| *other < n) {
                    if set(other) && touching(at, other) && firsts[at] != firsts[other] {
                        let first = firsts[at].min(firsts[other]);
                        (firsts[at], firsts[other]) = (first, first);
                        changed = true;
                    }
                }
            }
        }
        (0..n).filter(|at| set(*at)).map(|at| firsts[at]).collect()
    }

    proptest! {
        #[test]
        fn pixels_have_a_component_in_common_when_they_hang_together(
            pairs in prop::collection::vec(any::<[[[u64; 2]; 3]; 2]>(), 1..5),
        ) {
            let row = |row: &[[u64; 2]; 3]| row.map(|[a, b]| a & b).to_vec();
            let rows: Vec<Vec<u64>> = pairs.as_flattened().iter().map(row).collect();
            let mut components = Components::default();
            components.make_room(3 * WORD, 4 * rows.len());
            let plane = BitPlane::of_rows(&rows);
            components.label(&plane);
            let mut firsts = vec![None; components.all().len()];
            let pixel = |([x, y], component): ([u16; 2], u32)| (u32::from(x), u32::from(y), component as usize);
            let mut pixels: Vec<_> = components.labelled_pixels(&plane).map(pixel).collect();
            pixels.sort_by_key(|(x, y, _)| (*y, *x));
            let expected = flooded(&rows);
            prop_assert_eq!(pixels.len(), expected.len());
            for (&(x, y, label), &first) in pixels.iter().zip(&expected) {
                prop_assert_eq!(*firsts[label].get_or_insert(first), first);
                let component = &components.all()[label];
                prop_assert!(component.columns().contains(&x) && component.rows().contains(&y));
            }
            let distinct: BTreeSet<_> = firsts.iter().copied().flatten().collect();
            prop_assert_eq!(distinct.len(), firsts.iter().flatten().count());
            prop_assert_eq!(distinct.len(), components.n_components());
            let found = components.all().iter().enumerate();
            for (label, component) in found.filter(|(_, part)| part.n_runs > 0) {
                let mut expected = vec![[u16::MAX, 0]; component.n_pairs() as usize];
                for (x, y, _) in pixels.iter().filter(|pixel| pixel.2 == label) {
                    let [first, beyond] = &mut expected[(*y - component.rows().start) as usize / 2];
                    (*first, *beyond) = ((*x as u16).min(*first), (*x as u16 + 1).max(*beyond));
                }
                let mut extents = expected.clone();
                components.read_extents(component, &mut extents);
                prop_assert_eq!(&extents, &expected);
                let columns = component.columns();
                prop_assert!(expected.iter().any(|span| u32::from(span[0]) == columns.start));
                prop_assert!(expected.iter().any(|span| u32::from(span[1]) == columns.end));
            }
        }
    }
}
