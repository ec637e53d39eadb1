//! Candidates among the components, and the leftmost and rightmost pixel of each of their pairs of rows.
//!
//! In: labelled components. Out: outlines of those that could be the black border of a tag by their box and runs.

use crate::Rejection;
use crate::components::{Component, Components, make_room};
use crate::kernels::TILE;
use crate::quad::Quad;

/// A component that could be a tag's border.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    pub(crate) component: Component,
    pub(crate) label: usize,
    /// Where its pairs of rows begin among all extents.
    first_extent: usize,
}

impl Outline {
    /// Corners of the box, clockwise from the top left.
    pub(crate) fn corners(&self) -> Quad {
        let (columns, rows) = (self.component.columns(), self.component.rows());
        let [left, right] = [columns.start, columns.end - 1].map(|x| x as f32);
        let [top, bottom] = [rows.start, rows.end - 1].map(|y| y as f32);
        [[left, top], [right, top], [right, bottom], [left, bottom]]
    }
}

/// First and last pixel of a component in a pair of rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent {
    pub(crate) left: u16,
    pub(crate) right: u16,
}

/// Extents of all candidates together, per pair of rows of the image: a bound on memory and on time that crowded images of
/// small tags keep well below (a hundred tags beside each other).
const MOST_BESIDE: usize = 128;

#[derive(Debug, Default)]
pub(crate) struct Outlines {
    outlines: Vec<Outline>,
    /// Extents of what is no candidate, one a pair of rows of the image, and after them those of each outline.
    extents: Vec<Extent>,
    /// Of each label: where among the extents the image's first pair of rows would be.
    offsets: Vec<u32>,
    max_extents: usize,
    dropped: u32,
}

impl Outlines {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, max_labels: usize, height: usize) {
        self.max_extents = height.div_ceil(2) * (1 + MOST_BESIDE);
        self.extents
            .resize(self.max_extents.max(self.extents.len()), Extent::default());
        make_room(&mut self.outlines, self.max_extents);
        make_room(&mut self.offsets, max_labels);
    }

    pub(crate) fn trace(&mut self, components: &Components, shape: &BorderShape) {
        self.select(components, shape);
        let (extents, offsets) = (&mut self.extents[..], &self.offsets[..]);
        // Of the runs beside each other that belong to the same outline the last to be written stands.
        for (pair, (spans, labels)) in components.row_pairs().enumerate() {
            let runs = spans.iter().zip(labels);
            for (&[_, end], &label) in runs.clone() {
                extents[offsets[label as usize] as usize + pair].right = end - 1;
            }
            for (&[start, _], &label) in runs.rev() {
                extents[offsets[label as usize] as usize + pair].left = start;
            }
        }
    }

    fn select(&mut self, components: &Components, shape: &BorderShape) {
        self.outlines.clear();
        self.offsets.clear();
        self.dropped = 0;
        let mut n_extents = components.row_pairs().len();
        for (label, component) in components.all().iter().enumerate() {
            let n_pairs = component.n_pairs() as usize;
            let room = n_extents + n_pairs <= self.max_extents;
            let candidate = shape.fits(component);
            self.dropped += u32::from(candidate && !room);
            let mut offset = 0;
            if candidate && room {
                offset = n_extents - component.top_pair as usize;
                self.outlines.push(Outline {
                    component: *component,
                    label,
                    first_extent: n_extents,
                });
                n_extents += n_pairs;
            }
            self.offsets.push(offset as u32);
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&Outline, &[Extent])> {
        self.outlines.iter().map(|outline| {
            let n_pairs = outline.component.n_pairs() as usize;
            (outline, &self.extents[outline.first_extent..][..n_pairs])
        })
    }

    /// Candidates of the last image for which there was no room.
    pub(crate) fn n_dropped(&self) -> u32 {
        self.dropped
    }
}

/// What the borders that are looked for can look like.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BorderShape {
    /// Least mean edge.
    pub(crate) min_edge_px: f32,
    /// Most of the area within the border that has its colour.
    pub(crate) most_solid: f32,
    /// Least share of the rows that show something within the border.
    pub(crate) least_open: f32,
}

impl BorderShape {
    /// By box and runs alone. A border is a closed band around something, so its runs are together as long as its box and
    /// somewhere lie beside each other; a tag may be narrow when seen from the side.
    fn fits(&self, component: &Component) -> bool {
        /// Narrowest view of a tag that can be read, as a share of its edge.
        const NARROWEST: f32 = 0.3;
        /// A row of a tag of ten modules changes colour no more often.
        const MOST_RUNS: u32 = 6;
        let (width, n_pairs) = (component.width(), component.n_pairs());
        self.has_size(component)
            && width.min(2 * n_pairs) as f32 >= self.min_edge_px * NARROWEST
            && component.n_runs as f32 > (1.0 + self.least_open) * n_pairs as f32
            && component.n_runs <= MOST_RUNS * n_pairs
            && component.length >= width.max(2 * n_pairs)
    }

    pub(crate) fn has_size(&self, component: &Component) -> bool {
        (component.width() + 2 * component.n_pairs()) as f32 >= 2.0 * self.min_edge_px
    }

    /// By black pixels and all between the first and the last one of each row: a border takes up a good part of that, and
    /// something must be written within.
    pub(crate) fn check_filling(&self, n_black: u32, filled: u32) -> Result<(), Rejection> {
        let (n_black, filled) = (n_black as f32, filled as f32);
        if n_black >= LEAST_OF_BORDER * live_border(filled) && n_black <= self.most_solid * filled {
            Ok(())
        } else {
            Err(Rejection::NotAQuad)
        }
    }
}

/// Share of a border that must be there: the rest may be occluded.
const LEAST_OF_BORDER: f32 = 0.75;

/// Least area of the live part of a border around this area in all. The border of a tag of eight modules; of one broader
/// than a tile nothing but what lies a tile's width from its edges is live for certain.
fn live_border(filled: f32) -> f32 {
    const OF_EIGHT_MODULES: f32 = 1.0 - 0.75 * 0.75;
    let (edge, band) = (filled.sqrt(), TILE as f32);
    (OF_EIGHT_MODULES * filled).min(4.0 * band * (edge - band).max(0.0))
}
