//! Connected components of black pixels, joined run by run.
//!
//! In: the bit plane. Out: runs with their component, and each component's box and area. Pixels that touch at a corner
//! are connected. (He, Chao & Suzuki, A run-based two-scan labeling algorithm, IEEE Trans. Image Processing 17, 2008.)

use crate::bit_plane::BitPlane;
use crate::kernels::WORD;

/// Black pixels beside each other in a row: `start..end`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) start: u16,
    pub(crate) end: u16,
    component: u32,
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
    components: Vec<Component>,
    max_runs: usize,
}

/// Pixels of the image per run, at least: only noise has shorter runs and gaps. Rows beyond this bound are left out.
const PIXELS_PER_RUN: usize = 4;

impl Components {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, width: usize, height: usize) {
        self.max_runs = width * height / PIXELS_PER_RUN;
        make_room(&mut self.runs, self.max_runs);
        make_room(&mut self.components, self.max_runs);
        make_room(&mut self.row_starts, height + 1);
    }

    pub(crate) fn label(&mut self, plane: &BitPlane) {
        self.runs.clear();
        self.row_starts.clear();
        self.components.clear();
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
        let (mut carry, mut start) = (0, None);
        for (i, &word) in words.iter().enumerate() {
            let mut changes = word ^ (word << 1 | carry);
            carry = word >> (WORD - 1);
            while changes != 0 {
                let x = (i * WORD) as u16 + changes.trailing_zeros() as u16;
                changes &= changes - 1;
                start = match start {
                    None => Some(x),
                    Some(start) => {
                        self.runs.push(Run {
                            start,
                            end: x,
                            component: 0,
                        });
                        None
                    }
                };
            }
        }
        if let Some(start) = start {
            self.runs.push(Run {
                start,
                end: (words.len() * WORD) as u16,
                component: 0,
            });
        }
    }

    /// Joins the runs from `row` on with those from `row_above` up to `row`.
    fn join_row(&mut self, row_above: usize, row: usize, y: u16) {
        let mut above = row_above;
        for i in row..self.runs.len() {
            let Run { start, end, .. } = self.runs[i];
            while above < row && self.runs[above].end < start {
                above += 1;
            }
            let mut component = None;
            let mut touching = above;
            while touching < row && self.runs[touching].start <= end {
                component = Some(self.join(component, self.runs[touching].component));
                touching += 1;
            }
            self.runs[i].component = self.add_run(component, start, end, y);
        }
    }

    fn join(&mut self, a: Option<u32>, b: u32) -> u32 {
        let b = self.root(b);
        let Some(a) = a.filter(|&a| a != b) else {
            return b;
        };
        let (root, child) = (a.min(b), a.max(b));
        let absorbed = self.components[child as usize];
        self.components[child as usize].parent = root;
        self.components[root as usize].absorb(&absorbed);
        root
    }

    fn add_run(&mut self, component: Option<u32>, start: u16, end: u16, y: u16) -> u32 {
        let area = u32::from(end - start);
        if let Some(root) = component {
            let component = &mut self.components[root as usize];
            component.area += area;
            component.left = component.left.min(start);
            component.right = component.right.max(end);
            component.bottom = y;
            return root;
        }
        let label = self.components.len() as u32;
        self.components.push(Component {
            parent: label,
            area,
            left: start,
            right: end,
            top: y,
            bottom: y,
        });
        label
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

    pub(crate) fn max_labels(&self) -> usize {
        self.max_runs
    }

    pub(crate) fn n_runs(&self) -> usize {
        self.runs.len()
    }

    /// Labels given; those in use as components are [`Self::whole`].
    pub(crate) fn n_labels(&self) -> usize {
        self.components.len()
    }

    /// The components that nothing has absorbed, with their labels.
    pub(crate) fn whole(&self) -> impl Iterator<Item = (u32, &Component)> {
        let labelled = self
            .components
            .iter()
            .enumerate()
            .map(|(label, component)| (label as u32, component));
        labelled.filter(|(label, component)| component.parent == *label)
    }

    /// Points every label directly to its root.
    pub(crate) fn flatten(&mut self) {
        for label in 0..self.components.len() {
            let parent = self.components[label].parent as usize;
            self.components[label].parent = self.components[parent].parent;
        }
    }

    /// The root's label of a run, after [`Self::flatten`].
    pub(crate) fn label_of(&self, run: &Run) -> u32 {
        self.components[run.component as usize].parent
    }

    /// The runs of a row.
    pub(crate) fn row(&self, y: usize) -> &[Run] {
        &self.runs[self.row_starts[y] as usize..self.row_starts[y + 1] as usize]
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.row_starts.len() - 1
    }
}

/// Takes memory for so many elements, once.
pub(crate) fn make_room<T>(buffer: &mut Vec<T>, n: usize) {
    buffer.clear();
    buffer.reserve_exact(n);
}
