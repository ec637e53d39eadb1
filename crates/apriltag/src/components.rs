//! Connected components of black pixels, joined run by run.
//!
//! In: the bit plane. Out: runs with their component, and each component's box and area. Pixels that touch at a corner
//! are connected. (He, Chao & Suzuki, A run-based two-scan labeling algorithm, IEEE Trans. Image Processing 17, 2008.)

use crate::LabelledRun;
use crate::bit_plane::BitPlane;
use crate::kernels::WORD;

/// Black pixels beside each other in a row: `start..end`.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Run {
    pub(crate) start: u16,
    pub(crate) end: u16,
    pub(crate) component: u32,
}

/// A component, or a part of one that has been joined to its parent.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Component {
    parent: u32,
    pub(crate) area: u32,
    pub(crate) left: u16,
    /// One beyond the last column.
    pub(crate) right: u16,
    pub(crate) top: u16,
    pub(crate) bottom: u16,
    /// How many, but for multiples of 65536.
    pub(crate) n_runs: u16,
    marked: bool,
}

impl Component {
    /// Whether this is a component and not a part that another has absorbed, when it is labelled so.
    pub(crate) fn is_whole(&self, label: usize) -> bool {
        self.parent as usize == label
    }

    /// Label of the component that this belongs to, after [`Components::flatten`].
    pub(crate) fn root(&self) -> usize {
        self.parent as usize
    }

    pub(crate) fn width(&self) -> u32 {
        u32::from(self.right - self.left)
    }

    pub(crate) fn height(&self) -> u32 {
        u32::from(self.bottom - self.top) + 1
    }

    /// Middle of the box.
    pub(crate) fn middle(&self) -> [f32; 2] {
        let mean = |low: u16, high: u16| (f32::from(low) + f32::from(high)) / 2.0;
        [mean(self.left, self.right - 1), mean(self.top, self.bottom)]
    }

    /// Corners of the box, clockwise from the top left.
    pub(crate) fn corners(&self) -> [[f32; 2]; 4] {
        let [left, right] = [self.left, self.right - 1].map(f32::from);
        let [top, bottom] = [self.top, self.bottom].map(f32::from);
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }

    #[inline]
    fn grow(&mut self, run: &Run, y: u16) {
        self.area += u32::from(run.end - run.start);
        self.n_runs = self.n_runs.wrapping_add(1);
        self.left = self.left.min(run.start);
        self.right = self.right.max(run.end);
        self.bottom = y;
    }

    fn absorb(&mut self, other: &Self) {
        self.area += other.area;
        self.n_runs = self.n_runs.wrapping_add(other.n_runs);
        self.left = self.left.min(other.left);
        self.right = self.right.max(other.right);
        self.top = self.top.min(other.top);
        self.bottom = self.bottom.max(other.bottom);
    }
}

#[derive(Debug, Default)]
pub(crate) struct Components {
    /// Room for `max_runs` at least, of which the first `n_runs` count.
    runs: Vec<Run>,
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
        let room = self.runs.len().max(self.max_runs);
        self.runs.resize(room, Run::default());
        self.components.resize(room, Component::default());
        make_room(&mut self.row_starts, height + 1);
    }

    pub(crate) fn label(&mut self, plane: &BitPlane) {
        self.row_starts.clear();
        let mut forest = Forest {
            components: &mut self.components,
            n: 0,
        };
        let (mut above, mut row) = (0, 0);
        for (y, (left, words)) in plane.rows().enumerate() {
            self.row_starts.push(row as u32);
            let (done, free) = self.runs.split_at_mut(row);
            let beside = &done[above..];
            above = row;
            if row + words.len() * WORD / 2 <= self.max_runs {
                let n = find_runs(left as u16, words, free);
                forest.join_row(beside, &mut free[..n], y as u16);
                row += n;
            }
        }
        self.row_starts.push(row as u32);
        (self.n_runs, self.n_components) = (row, forest.n);
        forest.flatten();
    }

    pub(crate) fn max_labels(&self) -> usize {
        self.max_runs
    }

    pub(crate) fn n_runs(&self) -> usize {
        self.n_runs
    }

    /// All components ever begun, by label; those that stand for themselves are [`Component::is_whole`].
    pub(crate) fn labelled(&self) -> &[Component] {
        &self.components[..self.n_components]
    }

    /// The runs of each row.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[Run]> {
        self.row_starts
            .windows(2)
            .map(|ends| &self.runs[ends[0] as usize..ends[1] as usize])
    }

    /// Marks the component that a pixel belongs to.
    pub(crate) fn mark(&mut self, [x, y]: [usize; 2]) {
        let runs = &self.runs[self.row_starts[y] as usize..self.row_starts[y + 1] as usize];
        let after = runs.partition_point(|run| usize::from(run.end) <= x);
        if let Some(run) = runs.get(after)
            && usize::from(run.start) <= x
        {
            let root = self.components[run.component as usize].root();
            self.components[root].marked = true;
        }
    }

    pub(crate) fn marked(&self) -> impl Iterator<Item = &Component> {
        self.labelled().iter().filter(|component| component.marked)
    }

    /// Every run with the component that it belongs to.
    pub(crate) fn labelled_runs(&self) -> impl Iterator<Item = LabelledRun> {
        let root = |run: &Run| self.components[run.component as usize].parent;
        self.rows().zip(0..).flat_map(move |(runs, y)| {
            runs.iter().map(move |run| LabelledRun {
                y,
                start: run.start,
                end: run.end,
                component: root(run),
            })
        })
    }
}

/// Where bits of the words begin and end to be set. Returns how many runs there are.
#[inline(never)]
fn find_runs(left: u16, words: &[u64], runs: &mut [Run]) -> usize {
    let (mut n_starts, mut n_ends, mut carry) = (0, 0, 0);
    for (first, &word) in (left..).step_by(WORD).zip(words) {
        let before = word << 1 | carry;
        carry = word >> (WORD - 1);
        let (mut starts, mut ends) = (word & !before, before & !word);
        while starts != 0 {
            runs[n_starts].start = first + starts.trailing_zeros() as u16;
            n_starts += 1;
            starts &= starts - 1;
        }
        while ends != 0 {
            runs[n_ends].end = first + ends.trailing_zeros() as u16;
            n_ends += 1;
            ends &= ends - 1;
        }
    }
    if carry != 0 {
        runs[n_ends].end = left + (words.len() * WORD) as u16;
    }
    n_starts
}

/// Components as a union-find forest: each label's parent is itself or an earlier one.
struct Forest<'a> {
    /// Of which the first `n` count.
    components: &'a mut [Component],
    n: usize,
}

impl Forest<'_> {
    /// Joins the runs of a row with those of the row above.
    #[inline(never)]
    fn join_row(&mut self, above: &[Run], runs: &mut [Run], y: u16) {
        let mut above = above.iter();
        let mut beside = above.next();
        for run in runs {
            while let Some(Run { end, .. }) = beside
                && *end < run.start
            {
                beside = above.next();
            }
            let Some(first) = beside.filter(|beside| beside.start <= run.end) else {
                run.component = self.plant(run, y);
                continue;
            };
            let (mut component, mut end) = (self.root(first.component), first.end);
            while end <= run.end {
                beside = above.next();
                let Some(further) = beside.filter(|further| further.start <= run.end) else {
                    break;
                };
                component = self.join(component, further.component);
                end = further.end;
            }
            self.components[component as usize].grow(run, y);
            run.component = component;
        }
    }

    fn plant(&mut self, run: &Run, y: u16) -> u32 {
        let label = self.n as u32;
        let &Run { start, end, .. } = run;
        self.components[self.n] = Component {
            parent: label,
            area: u32::from(end - start),
            left: start,
            right: end,
            top: y,
            bottom: y,
            n_runs: 1,
            marked: false,
        };
        self.n += 1;
        label
    }

    /// The root that a root and a label have in common from now on.
    #[inline]
    fn join(&mut self, a: u32, label: u32) -> u32 {
        let b = self.root(label);
        if a == b {
            return a;
        }
        let (root, child) = (a.min(b), a.max(b));
        let absorbed = self.components[child as usize];
        self.components[child as usize].parent = root;
        self.components[root as usize].absorb(&absorbed);
        root
    }

    /// The component that stands for all joined ones, with the path to it halved.
    #[inline]
    fn root(&mut self, mut label: u32) -> u32 {
        loop {
            let parent = self.components[label as usize].parent;
            if parent == label {
                return label;
            }
            let grandparent = self.components[parent as usize].parent;
            self.components[label as usize].parent = grandparent;
            label = grandparent;
        }
    }

    /// Points every label directly to its root.
    fn flatten(&mut self) {
        for label in 0..self.n {
            let parent = self.components[label].parent as usize;
            self.components[label].parent = self.components[parent].parent;
        }
    }
}

/// Takes memory for so many elements, once.
pub(crate) fn make_room<T>(buffer: &mut Vec<T>, n: usize) {
    buffer.clear();
    buffer.reserve_exact(n);
}
