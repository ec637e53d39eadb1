//! Connected components of black pixels, joined run by run.
//!
//! In: the bit plane, two rows at a time. Out: runs with their component, and each component's box. Pixels that touch at a
//! corner are connected, so that of two rows what is black in either of them in columns beside each other hangs together:
//! a run is of both rows at once. (He, Chao & Suzuki, A run-based two-scan labeling algorithm, IEEE Trans. Image Processing
//! 17, 2008, with the blocks of Grana, Borghesani & Cucchiara, IEEE Trans. Image Processing 19, 2010; which runs touch is read
//! off whole words here, so that processors need not guess it.)

mod runs;

use crate::LabelledRun;
use crate::bit_plane::{BitPlane, RowPair};
use crate::kernels::{WORD, vectorised};
use crate::quad::Quad;
use runs::{find_spans, join_pairs};
use std::hint::select_unpredictable;
use std::iter;
use std::ops::Range;

/// Columns beside each other with a black pixel in either of two rows: the first and the one beyond the last.
pub(crate) type Span = [u16; 2];

/// Black pixels that hang together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Component {
    /// Length of all runs.
    pub(crate) length: u32,
    pub(crate) n_runs: u32,
    pub(crate) left: u32,
    /// One beyond the last column.
    pub(crate) right: u32,
    /// First and last pair of rows.
    top_pair: u32,
    bottom_pair: u32,
    last_run: u32,
}

impl Component {
    pub(crate) fn width(&self) -> u32 {
        self.right - self.left
    }

    pub(crate) fn n_pairs(&self) -> u32 {
        self.bottom_pair - self.top_pair + 1
    }

    pub(crate) fn columns(&self) -> Range<u32> {
        self.left..self.right
    }

    /// Its rows, and maybe the one above and the one below.
    pub(crate) fn rows(&self) -> Range<u32> {
        2 * self.top_pair..2 * self.bottom_pair + 2
    }

    /// Corners of the box, clockwise from the top left.
    pub(crate) fn corners(&self) -> Quad {
        let (columns, rows) = (self.columns(), self.rows());
        let [left, right] = [columns.start, columns.end - 1].map(|x| x as f32);
        let [top, bottom] = [rows.start, rows.end - 1].map(|y| y as f32);
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }

    fn begin([start, _]: Span, top_pair: u32, run: u32) -> Self {
        Self {
            left: u32::from(start),
            top_pair,
            last_run: run,
            ..Self::default()
        }
    }

    #[inline(always)]
    fn grow(&mut self, [start, end]: Span, pair: u32) {
        let [start, end] = [start, end].map(u32::from);
        self.length += end - start;
        self.n_runs += 1;
        self.left = select_unpredictable(start < self.left, start, self.left);
        self.right = select_unpredictable(end > self.right, end, self.right);
        self.bottom_pair = pair;
    }
}

#[derive(Debug, Default)]
pub(crate) struct Components {
    /// Room for `max_runs` at least, of which the first `n_runs` count.
    spans: Vec<Span>,
    /// Of each run: an earlier one that it hangs together with, or itself; in the end its component.
    labels: Vec<u32>,
    /// Of each run but a component's first: the last of its component before.
    runs_before: Vec<u32>,
    n_runs: usize,
    max_runs: usize,
    /// Index of the first run of each pair of rows, and one more.
    pair_starts: Vec<u32>,
    /// Room as for runs, of which the first `n_components` count.
    components: Vec<Component>,
    n_components: usize,
}

/// Pixels of the image per run, at least: only noise has shorter runs and gaps. Rows beyond this bound are left out.
const PIXELS_PER_RUN: usize = 8;

impl Components {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.max_runs = width * height / PIXELS_PER_RUN;
        let room = self.labels.len().max(self.max_runs);
        self.spans.resize(room, Span::default());
        self.labels.resize(room, 0);
        self.runs_before.resize(room, 0);
        self.components.resize(room, Component::default());
        make_room(&mut self.pair_starts, height.div_ceil(2) + 1);
    }

    pub(crate) fn label(&mut self, plane: &BitPlane) {
        vectorised(
            #[inline(always)]
            || self.find_runs(plane),
        );
        vectorised(
            #[inline(always)]
            || self.measure(),
        );
    }

    /// Finds the runs of each pair of rows and joins them with those of the pair above.
    #[inline(always)]
    fn find_runs(&mut self, plane: &BitPlane) {
        self.pair_starts.clear();
        let mut above = (RowPair::default(), 0);
        self.n_runs = 0;
        for pair in plane.row_pairs() {
            let first = self.n_runs;
            self.pair_starts.push(first as u32);
            if first + pair.live.len() * WORD / 2 > self.max_runs {
                above = (RowPair::default(), 0);
                continue;
            }
            self.n_runs += find_spans(&pair, &mut self.spans[first..]);
            for (label, run) in self.labels[first..self.n_runs].iter_mut().zip(first..) {
                *label = run as u32;
            }
            let here = (pair, first);
            join_pairs(&mut self.labels, &here, &above);
            above = here;
        }
        self.pair_starts.push(self.n_runs as u32);
    }

    /// Numbers the components in the order of their first runs and measures them.
    #[inline(always)]
    fn measure(&mut self) {
        let (labels, components) = (&mut self.labels[..], &mut self.components[..]);
        let mut n = 0;
        for (pair, ends) in (0..).zip(self.pair_starts.windows(2)) {
            let runs = ends[0] as usize..ends[1] as usize;
            let befores = &mut self.runs_before[runs.clone()];
            let each = self.spans[runs].iter().zip(befores);
            for (run, (&span, before)) in (ends[0]..ends[1]).zip(each) {
                let earlier = labels[run as usize];
                let label = if earlier == run {
                    components[n] = Component::begin(span, pair, run);
                    n += 1;
                    n as u32 - 1
                } else {
                    labels[earlier as usize]
                };
                labels[run as usize] = label;
                let component = &mut components[label as usize];
                *before = component.last_run;
                component.last_run = run;
                component.grow(span, pair);
            }
        }
        self.n_components = n;
    }

    pub(crate) fn n_runs(&self) -> usize {
        self.n_runs
    }

    /// All components, by label.
    pub(crate) fn all(&self) -> &[Component] {
        &self.components[..self.n_components]
    }

    /// From where to where the runs of a component reach in each of its pairs of rows, the last one first.
    #[inline(always)]
    pub(crate) fn extents_of(&self, component: &Component) -> impl Iterator<Item = (usize, Span)> {
        let mut run = component.last_run as usize;
        let pairs = component.top_pair as usize..component.bottom_pair as usize + 1;
        pairs.rev().map(move |pair| {
            let first_of_pair = self.pair_starts[pair] as usize;
            let [mut start, end] = self.spans[run];
            let mut before = self.runs_before[run] as usize;
            while (first_of_pair..run).contains(&before) {
                run = before;
                start = self.spans[run][0];
                before = self.runs_before[run] as usize;
            }
            run = before;
            (pair, [start, end])
        })
    }

    /// The run that a black pixel belongs to: its component, and where it ends.
    pub(crate) fn at(&self, [x, y]: [usize; 2]) -> Option<(usize, usize)> {
        let runs = self.pair_starts[y / 2] as usize..self.pair_starts[y / 2 + 1] as usize;
        let before = |&[_, end]: &Span| usize::from(end) <= x;
        let run = runs.start + self.spans[runs.clone()].partition_point(before);
        let label = self.labels[..runs.end].get(run)?;
        Some((*label as usize, usize::from(self.spans[run][1])))
    }

    /// Black pixels beside each other, row after row, with their components.
    pub(crate) fn labelled_runs(&self, plane: &BitPlane) -> impl Iterator<Item = LabelledRun> {
        plane.rows().zip(0..).flat_map(move |(row, y)| {
            runs_in(row).filter_map(move |[start, end]| {
                let (component, _) = self.at([start, y].map(usize::from))?;
                Some(LabelledRun {
                    y,
                    start,
                    end,
                    component: component as u32,
                })
            })
        })
    }
}

/// Where bits beside each other are set in a row.
fn runs_in(row: &[u64]) -> impl Iterator<Item = Span> {
    let is_set = |x: &u16| row[usize::from(*x) / WORD] >> (usize::from(*x) % WORD) & 1 == 1;
    let width = (row.len() * WORD) as u16;
    let mut next = 0;
    iter::from_fn(move || {
        let first = (next..width).find(is_set)?;
        next = (first..width).find(|x| !is_set(x)).unwrap_or(width);
        Some([first, next])
    })
}

/// Takes memory for so many elements, once.
pub(crate) fn make_room<T>(buffer: &mut Vec<T>, n: usize) {
    buffer.clear();
    buffer.reserve_exact(n);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// The lowest place, row after row, of what hangs together with each set bit.
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
            let pixels: Vec<_> = components.labelled_runs(&plane).flat_map(|run| {
                (run.start..run.end).map(move |x| (u32::from(x), u32::from(run.y), run.component as usize))
            }).collect();
            let expected = flooded(&rows);
            prop_assert_eq!(pixels.len(), expected.len());
            for (&(x, y, label), &first) in pixels.iter().zip(&expected) {
                prop_assert_eq!(*firsts[label].get_or_insert(first), first);
                let component = &components.all()[label];
                prop_assert!(component.columns().contains(&x) && component.rows().contains(&y));
            }
            let distinct: BTreeSet<_> = firsts.iter().copied().flatten().collect();
            prop_assert_eq!(distinct.len(), firsts.len());
            for (label, component) in components.all().iter().enumerate() {
                let mut columns = pixels.iter().filter(|pixel| pixel.2 == label).map(|pixel| pixel.0);
                prop_assert!(columns.clone().any(|x| x == component.columns().start));
                prop_assert!(columns.any(|x| x + 1 == component.columns().end));
            }
        }
    }
}
