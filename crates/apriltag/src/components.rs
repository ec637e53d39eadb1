//! Connected components of black pixels, joined run by run.
//!
//! In: the bit plane. Out: runs with their component, and each component's box and area. Pixels that touch at a corner
//! are connected. (He, Chao & Suzuki, A run-based two-scan labeling algorithm, IEEE Trans. Image Processing 17, 2008; which
//! runs touch is read off whole words here, so that processors need not guess it.)

use crate::LabelledRun;
use crate::bit_plane::{BitPlane, Row};
use crate::kernels::{Kernels, WORD};
use std::hint::select_unpredictable;

/// Black pixels beside each other in a row: the first column and the one beyond the last.
pub(crate) type Span = [u16; 2];

/// Black pixels that hang together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Component {
    pub(crate) area: u32,
    pub(crate) n_runs: u32,
    pub(crate) left: u32,
    /// One beyond the last column.
    pub(crate) right: u32,
    pub(crate) top: u32,
    pub(crate) bottom: u32,
    marked: bool,
}

impl Component {
    pub(crate) fn width(&self) -> u32 {
        self.right - self.left
    }

    pub(crate) fn height(&self) -> u32 {
        self.bottom - self.top + 1
    }

    /// Middle of the box.
    pub(crate) fn middle(&self) -> [f32; 2] {
        let mean = |low: u32, high: u32| (low + high) as f32 / 2.0;
        [mean(self.left, self.right - 1), mean(self.top, self.bottom)]
    }

    /// Corners of the box, clockwise from the top left.
    pub(crate) fn corners(&self) -> [[f32; 2]; 4] {
        let [left, right] = [self.left, self.right - 1].map(|x| x as f32);
        let [top, bottom] = [self.top, self.bottom].map(|y| y as f32);
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }

    fn begin([start, _]: Span, top: u32) -> Self {
        Self {
            left: u32::from(start),
            top,
            ..Self::default()
        }
    }

    #[inline(always)]
    fn grow(&mut self, [start, end]: Span, y: u32) {
        let [start, end] = [start, end].map(u32::from);
        self.area += end - start;
        self.n_runs += 1;
        self.left = select_unpredictable(start < self.left, start, self.left);
        self.right = select_unpredictable(end > self.right, end, self.right);
        self.bottom = y;
    }
}

#[derive(Debug, Default)]
pub(crate) struct Components {
    /// Room for `max_runs` at least and a few more, of which the first `n_runs` count.
    spans: Vec<Span>,
    /// Of each run: an earlier one that it hangs together with, or itself; in the end its component.
    labels: Vec<u32>,
    n_runs: usize,
    max_runs: usize,
    /// Index of the first run of each row, and one more.
    row_starts: Vec<u32>,
    /// Room as for runs, of which the first `n_components` count.
    components: Vec<Component>,
    n_components: usize,
}

/// Pixels of the image per run, at least: only noise has shorter runs and gaps. Rows beyond this bound are left out.
const PIXELS_PER_RUN: usize = 4;

impl Components {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.max_runs = width * height / PIXELS_PER_RUN;
        let room = self.labels.len().max(self.max_runs);
        self.spans.resize(room + AT_A_TIME, Span::default());
        self.labels.resize(room, 0);
        self.components.resize(room, Component::default());
        make_room(&mut self.row_starts, height + 1);
    }

    /// Forgets what was found in another image.
    pub(crate) fn clear(&mut self) {
        (self.n_runs, self.n_components) = (0, 0);
        self.row_starts.clear();
    }

    pub(crate) fn label(&mut self, plane: &BitPlane, kernels: &Kernels) {
        kernels.run(
            #[inline(always)]
            || self.find_runs(plane),
        );
        kernels.run(
            #[inline(always)]
            || self.measure(),
        );
    }

    /// Finds the runs of each row and joins them with those of the row above.
    #[inline(always)]
    fn find_runs(&mut self, plane: &BitPlane) {
        self.row_starts.clear();
        let mut above = (Row::default(), 0);
        self.n_runs = 0;
        for row in plane.rows() {
            let first = self.n_runs;
            self.row_starts.push(first as u32);
            if first + row.live.len() * WORD / 2 > self.max_runs {
                above = (Row::default(), 0);
                continue;
            }
            self.n_runs += find_spans(&row, &mut self.spans[first..]);
            for (label, run) in self.labels[first..self.n_runs].iter_mut().zip(first..) {
                *label = run as u32;
            }
            let here = (row, first);
            join_rows(&mut self.labels, &here, &above);
            above = here;
        }
        self.row_starts.push(self.n_runs as u32);
    }

    /// Numbers the components in the order of their first runs and measures them.
    #[inline(always)]
    fn measure(&mut self) {
        let (spans, labels) = (&self.spans[..], &mut self.labels[..]);
        let (components, mut n) = (&mut self.components[..], 0);
        for (y, ends) in (0..).zip(self.row_starts.windows(2)) {
            for run in ends[0] as usize..ends[1] as usize {
                let (span, earlier) = (spans[run], labels[run] as usize);
                if earlier == run {
                    components[n] = Component::begin(span, y);
                    labels[run] = n as u32;
                    n += 1;
                } else {
                    labels[run] = labels[earlier];
                }
                components[labels[run] as usize].grow(span, y);
            }
        }
        self.n_components = n;
    }

    pub(crate) fn max_labels(&self) -> usize {
        self.max_runs
    }

    pub(crate) fn n_runs(&self) -> usize {
        self.n_runs
    }

    /// All components, by label.
    pub(crate) fn all(&self) -> &[Component] {
        &self.components[..self.n_components]
    }

    /// The runs of each row, from left to right, and their components.
    pub(crate) fn rows(&self) -> impl ExactSizeIterator<Item = (&[Span], &[u32])> {
        self.row_starts.windows(2).map(|ends| {
            let runs = ends[0] as usize..ends[1] as usize;
            (&self.spans[runs.clone()], &self.labels[runs])
        })
    }

    /// Marks the component that a pixel belongs to.
    pub(crate) fn mark(&mut self, [x, y]: [usize; 2]) {
        let runs = self.row_starts[y] as usize..self.row_starts[y + 1] as usize;
        let spans = &self.spans[runs.clone()];
        let after = spans.partition_point(|&[_, end]| usize::from(end) <= x);
        if spans
            .get(after)
            .is_some_and(|&[start, _]| usize::from(start) <= x)
        {
            let label = self.labels[runs.start + after];
            self.components[label as usize].marked = true;
        }
    }

    pub(crate) fn marked(&self) -> impl Iterator<Item = &Component> {
        self.all().iter().filter(|component| component.marked)
    }

    /// Every run with the component that it belongs to.
    pub(crate) fn labelled_runs(&self) -> impl Iterator<Item = LabelledRun> {
        self.rows().zip(0..).flat_map(|((spans, labels), y)| {
            let runs = spans.iter().zip(labels);
            runs.map(move |(&[start, end], &component)| LabelledRun {
                y,
                start,
                end,
                component,
            })
        })
    }
}

/// Places that are written at a time, be there as many or not: that costs less than a loop whose end no processor foresees.
const AT_A_TIME: usize = 4;

/// Where bits of a row begin and end to be set, in turn. Returns how many runs there are.
#[inline(always)]
fn find_spans(row: &Row<'_>, spans: &mut [Span]) -> usize {
    let columns = spans.as_flattened_mut();
    let (mut n, mut carry) = (0, 0);
    for i in row.live.clone() {
        let word = row.words[i];
        let mut changes = word ^ (word << 1 | carry);
        carry = word >> (WORD - 1);
        let n_here = n + changes.count_ones() as usize;
        for columns in columns[n..].chunks_exact_mut(AT_A_TIME) {
            for column in columns {
                *column = (i * WORD) as u16 + changes.trailing_zeros() as u16;
                changes &= changes.wrapping_sub(1);
            }
            if changes == 0 {
                break;
            }
        }
        n = n_here;
    }
    if carry != 0 {
        columns[n] = (row.live.end * WORD) as u16;
        n += 1;
    }
    n / 2
}

/// A word of a row: where runs begin, and where they are or have just ended.
#[inline(always)]
fn begun_and_reached(word: u64, carry: &mut u64) -> [u64; 2] {
    let before = word << 1 | *carry;
    *carry = word >> (WORD - 1);
    [word & !before, word | before]
}

/// Joins the runs of a row with those of the row above, each with the number of its first run.
///
/// Two runs touch where both are or have just ended; the first such place is where one of the two begins, and no other two
/// runs have it.
#[inline(always)]
fn join_rows(
    labels: &mut [u32],
    (row, first): &(Row<'_>, usize),
    (above, first_above): &(Row<'_>, usize),
) {
    if row.live.is_empty() || above.live.is_empty() {
        return;
    }
    let (mut n, mut n_above) = (*first as u32, *first_above as u32);
    let (mut carry, mut carry_above) = (0, 0);
    for i in row.live.start.min(above.live.start)..row.live.end.max(above.live.end) {
        let [begun, reached] = begun_and_reached(row.words[i], &mut carry);
        let [begun_above, reached_above] = begun_and_reached(above.words[i], &mut carry_above);
        let mut touching = reached & reached_above & (begun | begun_above);
        while touching != 0 {
            let up_to_here = touching ^ (touching - 1);
            let run = n + (begun & up_to_here).count_ones() - 1;
            let run_above = n_above + (begun_above & up_to_here).count_ones() - 1;
            join(labels, run, run_above);
            touching &= touching - 1;
        }
        n += begun.count_ones();
        n_above += begun_above.count_ones();
    }
}

/// Lets two runs hang together: the first run of either component goes by that of the other.
#[inline(always)]
fn join(labels: &mut [u32], a: u32, b: u32) {
    let (a, b) = (first_run(labels, a), first_run(labels, b));
    let (later, earlier) = (
        select_unpredictable(a > b, a, b),
        select_unpredictable(a > b, b, a),
    );
    labels[later as usize] = earlier;
}

/// The first run of a run's component, with the path to it halved. Most runs know it, be it themselves or another.
#[inline(always)]
fn first_run(labels: &mut [u32], mut run: u32) -> u32 {
    loop {
        let earlier = labels[run as usize];
        let earliest = labels[earlier as usize];
        if earliest == earlier {
            return earliest;
        }
        labels[run as usize] = earliest;
        run = earliest;
    }
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
            rows in prop::collection::vec(prop::collection::vec(any::<[u64; 2]>().prop_map(|[a, b]| a & b), 3), 1..8),
            fastest in any::<bool>(),
        ) {
            let mut components = Components::default();
            components.make_room(3 * WORD, 2 * rows.len());
            let kernels = if fastest { Kernels::fastest() } else { Kernels::SCALAR };
            components.label(&BitPlane::of_rows(&rows), &kernels);
            let mut sizes = vec![0; components.all().len()];
            let mut firsts = Vec::new();
            let labels: Vec<usize> = components.labelled_runs().flat_map(|run| {
                (run.start..run.end).map(move |_| run.component as usize)
            }).collect();
            let expected = flooded(&rows);
            for (&label, &first) in labels.iter().zip(&expected) {
                if label == firsts.len() {
                    firsts.push(first);
                }
                prop_assert_eq!(firsts[label], first);
                sizes[label] += 1;
            }
            prop_assert_eq!(labels.len(), expected.len());
            prop_assert_eq!(sizes, components.all().iter().map(|component| component.area).collect::<Vec<_>>());
        }
    }
}
