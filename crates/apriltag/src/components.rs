//! Connected components of black pixels, joined run by run.
//!
//! In: the bit plane. Out: runs with their component, and each component's box and area. Pixels that touch at a corner
//! are connected. (He, Chao & Suzuki, A run-based two-scan labeling algorithm, IEEE Trans. Image Processing 17, 2008.)

use crate::LabelledRun;
use crate::bit_plane::BitPlane;
use crate::kernels::WORD;

/// No component.
const NONE: u32 = u32::MAX;

/// Black pixels beside each other in a row: `start..end`.
#[derive(Clone, Copy, Debug, Default)]
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
    /// Room for `max_runs` at least, of which the first `n_runs` count.
    runs: Vec<Run>,
    n_runs: usize,
    max_runs: usize,
    /// Index of the first run of each row, and one more.
    row_starts: Vec<u32>,
    forest: Forest,
    /// Where runs of a row begin and end in turn.
    ends: Vec<u16>,
}

/// Pixels of the image per run, at least: only noise has shorter runs and gaps. Rows beyond this bound are left out.
const PIXELS_PER_RUN: usize = 4;

impl Components {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.max_runs = width * height / PIXELS_PER_RUN;
        let room = self.runs.len().max(self.max_runs);
        self.runs.resize(room, Run::default());
        make_room(&mut self.forest.components, self.max_runs);
        self.ends.resize(width.next_multiple_of(WORD) + 2, 0);
        make_room(&mut self.row_starts, height + 1);
    }

    pub(crate) fn label(&mut self, plane: &BitPlane) {
        self.n_runs = 0;
        self.row_starts.clear();
        self.forest.components.clear();
        let mut row_above = 0;
        for (y, (left, words)) in plane.rows().enumerate() {
            let row = self.n_runs;
            self.row_starts.push(row as u32);
            let n_ends = self.find_ends(left, words);
            if row + n_ends / 2 <= self.max_runs {
                self.join_row(row_above, n_ends, y as u16);
            }
            row_above = row;
        }
        self.row_starts.push(self.n_runs as u32);
    }

    /// Each set bit of `word ^ (word << 1)` is the first pixel of a run or the first beyond one. Returns how many.
    fn find_ends(&mut self, left: usize, words: &[u64]) -> usize {
        let (mut n, mut carry) = (0, 0);
        for (word_start, &word) in (left as u16..).step_by(WORD).zip(words) {
            let mut changes = word ^ (word << 1 | carry);
            carry = word >> (WORD - 1);
            while changes != 0 {
                self.ends[n] = word_start + changes.trailing_zeros() as u16;
                n += 1;
                changes &= changes - 1;
            }
        }
        if carry != 0 {
            self.ends[n] = (left + words.len() * WORD) as u16;
            n += 1;
        }
        n
    }

    /// Takes in the runs between the first `n_ends` ends, and joins them with those from `row_above` on.
    fn join_row(&mut self, row_above: usize, n_ends: usize, y: u16) {
        let (done, free) = self.runs.split_at_mut(self.n_runs);
        let mut above = &done[row_above..];
        let forest = &mut self.forest;
        let ends = self.ends[..n_ends].as_chunks::<2>().0;
        for (run, &[start, end]) in free.iter_mut().zip(ends) {
            let mut component = NONE;
            while let [first, rest @ ..] = above
                && first.start <= end
            {
                if first.end >= start {
                    component = forest.join(component, first.component);
                }
                if first.end > end {
                    break;
                }
                above = rest;
            }
            if component == NONE {
                component = forest.plant(start, end, y);
            } else {
                forest.grow(component, start, end, y);
            }
            *run = Run {
                start,
                end,
                component,
            };
        }
        self.n_runs += ends.len();
    }

    pub(crate) fn max_labels(&self) -> usize {
        self.max_runs
    }

    pub(crate) fn n_runs(&self) -> usize {
        self.n_runs
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
    fn plant(&mut self, start: u16, end: u16, y: u16) -> u32 {
        let label = self.components.len() as u32;
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

    fn grow(&mut self, root: u32, start: u16, end: u16, y: u16) {
        let component = &mut self.components[root as usize];
        component.area += u32::from(end - start);
        component.left = component.left.min(start);
        component.right = component.right.max(end);
        component.bottom = y;
    }

    /// The component that a label and a root (or none) have in common from now on.
    fn join(&mut self, a: u32, label: u32) -> u32 {
        let b = self.root(label);
        if a == b || a == NONE {
            return b;
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
