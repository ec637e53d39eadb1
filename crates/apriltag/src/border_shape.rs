//! What the borders that are looked for look like, as far as a component's box, runs and area tell.

use crate::Rejection;
use crate::components::Component;
use crate::kernels::TILE;
use crate::quad::require;

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
    /// What looks like the one or the other.
    pub(crate) fn or(&self, other: &Self) -> Self {
        Self {
            most_solid: self.most_solid.max(other.most_solid),
            least_open: self.least_open.min(other.least_open),
            ..*self
        }
    }

    /// By box and runs alone. A border is a closed band around something, so its runs are together as long as its box and
    /// somewhere lie beside each other; a tag may be narrow when seen from the side.
    pub(crate) fn fits(&self, component: &Component) -> bool {
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
        let share = LEAST_OF_BORDER * live_border(filled)..=self.most_solid * filled;
        require(share.contains(&n_black), Rejection::NotAQuad)
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
