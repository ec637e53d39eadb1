//! Connected components of black pixels, joined run by run.
//!
//! In: the bit plane. Out: runs with their component, and each component's box and area. Pixels that touch at a corner
//! are connected. (He, Chao & Suzuki, A run-based two-scan labeling algorithm, IEEE Trans. Image Processing 17, 2008.)

use crate::LabelledRun;
use crate::bit_plane::BitPlane;
use crate::kernels::WORD;

/// Black pixels beside each other in a row: `start..end`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) start: u16,
    pub(crate) end: u16,
    pub(crate) component: u32,
}

/// A component, or a part of one that has been joined to its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Component {
    parent: u32,
    pub(crate) area: u32,
    pub(crate) left: u16,
    /// One beyond the last column.
    pub(crate) right: u16,
    pub(crate) top: u16,
    pub(crate) bottom: u16,
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

    fn absorb(&mut self, other: &Self) {
        self.area += other.area;
        self.left = self.left.min(other.left);
        self.right = self.right.max(other.right);
        self.top = self.top.min(other.top);
        self.bottom = self.bottom.max(other.bottom);
    }
}

#[derive(Debug, Default)]
pub(crate) struct Components {
    runs: Vec<Run>,
    /// Index of the first run of each row, and one more.
    row_starts: Vec<u32>,
    forest: Forest,
    /// Where runs of a row begin and end in turn.
    ends: Vec<u16>,
    max_runs: usize,
}

/// Pixels of the image per run, at least: only noise has shorter runs and gaps. Rows beyond this bound are left out.
const PIXELS_PER_RUN: usize = 4;

impl Components {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.max_runs = width * height / PIXELS_PER_RUN;
        make_room(&mut self.runs, self.max_runs);
        make_room(&mut self.forest.components, self.max_runs);
        make_room(&mut self.ends, width.next_multiple_of(WORD) + 1);
        make_room(&mut self.row_starts, height + 1);
    }

    pub(crate) fn label(&mut self, plane: &BitPlane) {
        self.runs.clear();
        self.row_starts.clear();
        self.forest.components.clear();
        let mut row_above = 0;
        for (y, words) in plane.rows().enumerate() {
            let row = self.runs.len();
            self.row_starts.push(row as u32);
            if row + words.len() * WORD / 2 <= self.max_runs {
                self.take_runs(words);
            }
            self.join_row(row_above, row, y as u16);
            row_above = row;
        }
        self.row_starts.push(self.runs.len() as u32);
    }

    /// Each set bit of `word ^ (word << 1)` is the first pixel of a run or the first beyond one.
    fn take_runs(&mut self, words: &[u64]) {
        self.ends.clear();
        let mut carry = 0;
        for (word_start, &word) in (0..).step_by(WORD).zip(words) {
            let mut changes = word ^ (word << 1 | carry);
            carry = word >> (WORD - 1);
            while changes != 0 {
                self.ends.push(word_start + changes.trailing_zeros() as u16);
                changes &= changes - 1;
            }
        }
        if carry != 0 {
            self.ends.push((words.len() * WORD) as u16);
        }
        let runs = self.ends.chunks_exact(2).map(|ends| Run {
            start: ends[0],
            end: ends[1],
            component: 0,
        });
        self.runs.extend(runs);
    }

    /// Joins the runs from `row` on with those from `row_above` up to `row`.
    fn join_row(&mut self, row_above: usize, row: usize, y: u16) {
        let (done, runs) = self.runs.split_at_mut(row);
        let mut above = &done[row_above..];
        let forest = &mut self.forest;
        for run in runs {
            while let [first, rest @ ..] = above
                && first.end < run.start
            {
                above = rest;
            }
            let mut touching = above.iter().take_while(|first| first.start <= run.end);
            let Some(first) = touching.next() else {
                run.component = forest.plant(run, y);
                continue;
            };
            let mut component = forest.root(first.component);
            for further in touching {
                component = forest.join(component, further.component);
            }
            forest.grow(component, run, y);
            run.component = component;
        }
    }

    pub(crate) fn max_labels(&self) -> usize {
        self.max_runs
    }

    pub(crate) fn n_runs(&self) -> usize {
        self.runs.len()
    }

    /// All components ever begun, by label; those that stand for themselves are [`Component::is_whole`].
    pub(crate) fn labelled(&self) -> &[Component] {
        &self.forest.components
    }

    /// The runs of each row.
    pub(crate) fn rows(&self) -> impl Iterator<Item = &[Run]> {
        self.row_starts
            .windows(2)
            .map(|ends| &self.runs[ends[0] as usize..ends[1] as usize])
    }

    /// Every run with the component that it belongs to, after [`Self::flatten`].
    pub(crate) fn labelled_runs(&self) -> impl Iterator<Item = LabelledRun> {
        let root = |run: &Run| self.forest.components[run.component as usize].parent;
        self.rows().zip(0..).flat_map(move |(runs, y)| {
            runs.iter().map(move |run| LabelledRun {
                y,
                start: run.start,
                end: run.end,
                component: root(run),
            })
        })
    }

    /// Points every label directly to its root.
    pub(crate) fn flatten(&mut self) {
        let components = &mut self.forest.components;
        for label in 0..components.len() {
            components[label].parent = components[components[label].parent as usize].parent;
        }
    }
}

/// Components as a union-find forest: each label's parent is itself or an earlier one.
#[derive(Debug, Default)]
struct Forest {
    components: Vec<Component>,
}

impl Forest {
    fn plant(&mut self, run: &Run, y: u16) -> u32 {
        let label = self.components.len() as u32;
        let Run { start, end, .. } = *run;
        self.components.push(Component {
            parent: label,
            area: u32::from(end - start),
            left: start,
            right: end,
            top: y,
            bottom: y,
        });
        label
    }

    fn grow(&mut self, root: u32, run: &Run, y: u16) {
        let component = &mut self.components[root as usize];
        component.area += u32::from(run.end - run.start);
        component.left = component.left.min(run.start);
        component.right = component.right.max(run.end);
        component.bottom = y;
    }

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
}

/// Takes memory for so many elements, once.
pub(crate) fn make_room<T>(buffer: &mut Vec<T>, n: usize) {
    buffer.clear();
    buffer.reserve_exact(n);
}
