//! Candidates among the components, and the leftmost and rightmost pixel of each of their rows.
//!
//! In: labelled components. Out: outlines of those that could be the black border of a tag by box and area.

use crate::Rejection;
use crate::components::{Component, Components, make_room};
use crate::kernels::TILE;

/// A component that could be a tag's border.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    pub(crate) component: Component,
    /// Where its rows begin among all extents.
    first_extent: usize,
}

/// First and last pixel of a component in a row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent {
    pub(crate) left: u16,
    pub(crate) right: u16,
}

impl Extent {
    pub(crate) fn width(&self) -> u32 {
        u32::from(self.right - self.left) + 1
    }
}

/// Rows of all candidates together, per row of the image: a bound on memory and on time that crowded images of small
/// tags keep well below (a hundred tags beside each other).
const EXTENTS_PER_IMAGE_ROW: usize = 128;

/// Rows of the least candidate.
const LEAST_ROWS: usize = 2;

#[derive(Debug, Default)]
pub(crate) struct Outlines {
    outlines: Vec<Outline>,
    /// Rows of what is no candidate, one a row of the image, and after them those of each outline.
    extents: Vec<Extent>,
    /// Of each label: where among the extents the image's first row would be.
    offsets: Vec<u32>,
    max_extents: usize,
    n_components: u32,
    dropped: u32,
}

impl Outlines {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, max_labels: usize, height: usize) {
        self.max_extents = height * (1 + EXTENTS_PER_IMAGE_ROW);
        self.extents
            .resize(self.max_extents.max(self.extents.len()), Extent::default());
        make_room(&mut self.outlines, self.max_extents / LEAST_ROWS);
        make_room(&mut self.offsets, max_labels);
    }

    pub(crate) fn trace(&mut self, components: &Components, shape: &BorderShape) {
        self.select(components, shape);
        let (extents, offsets) = (&mut self.extents[..], &self.offsets[..]);
        // Of the runs of a row that belong to the same outline the last to be written stands.
        for (y, (spans, labels)) in components.rows().enumerate() {
            let runs = spans.iter().zip(labels);
            for (&[_, end], &label) in runs.clone() {
                extents[offsets[label as usize] as usize + y].right = end - 1;
            }
            for (&[start, _], &label) in runs.rev() {
                extents[offsets[label as usize] as usize + y].left = start;
            }
        }
    }

    fn select(&mut self, components: &Components, shape: &BorderShape) {
        self.outlines.clear();
        self.offsets.clear();
        (self.n_components, self.dropped) = (components.all().len() as u32, 0);
        let mut n_extents = components.rows().len();
        for component in components.all() {
            let height = component.height() as usize;
            let room = n_extents + height <= self.max_extents
                && self.outlines.len() < self.max_extents / LEAST_ROWS;
            let candidate = shape.fits(component);
            self.dropped += u32::from(candidate && !room);
            let mut offset = 0;
            if candidate && room {
                offset = n_extents - component.top as usize;
                self.outlines.push(Outline {
                    component: *component,
                    first_extent: n_extents,
                });
                n_extents += height;
            }
            self.offsets.push(offset as u32);
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&Outline, &[Extent])> {
        self.outlines.iter().map(|outline| {
            let extents =
                outline.first_extent..outline.first_extent + outline.component.height() as usize;
            (outline, &self.extents[extents])
        })
    }

    /// Components that the last image had, candidates or not.
    pub(crate) fn n_components(&self) -> u32 {
        self.n_components
    }

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
}

impl BorderShape {
    /// By box and area alone. A border is a closed band, so its area is at least that of a line along the box's diagonal,
    /// there and back; a tag may be narrow when seen from the side.
    fn fits(&self, component: &Component) -> bool {
        /// Narrowest view of a tag that can be read, as a share of its edge.
        const NARROWEST: f32 = 0.3;
        /// A row of a tag of ten modules changes colour no more often.
        const MOST_RUNS_IN_A_ROW: u32 = 6;
        let (width, height) = (component.width() as f32, component.height() as f32);
        let (long, short) = (width.max(height), width.min(height));
        let area = component.area as f32;
        self.has_size(component)
            && short >= self.min_edge_px * NARROWEST
            && component.n_runs <= MOST_RUNS_IN_A_ROW * component.height()
            && area >= 2.0 * long
            && area <= self.most_solid * width * height
    }

    pub(crate) fn has_size(&self, component: &Component) -> bool {
        (component.width() + component.height()) as f32 >= 2.0 * self.min_edge_px
    }

    /// By what lies between the first and the last pixel of each row: a border takes up a good part of it, and something
    /// must be written within.
    pub(crate) fn check_filling(
        &self,
        component: &Component,
        filled: u32,
    ) -> Result<(), Rejection> {
        let filled = filled as f32;
        let (area, least) = (component.area as f32, LEAST_OF_BORDER * live_border(filled));
        if area >= least && area <= self.most_solid * filled {
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
