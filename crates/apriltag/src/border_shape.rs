//! What the borders that are looked for look like, as far as a component's box, runs and area tell.

use crate::components::Component;

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

    /// By box and runs alone. A border is a closed band around something, so somewhere its runs lie beside each other; a tag may
    /// be narrow when seen from the side.
    pub(crate) fn fits(&self, component: &Component) -> bool {
        /// Narrowest view of a tag that can be read, as a share of its edge.
        const NARROWEST: f32 = 0.3;
        let (width, n_pairs) = (component.width(), component.n_pairs());
        (width + 2 * n_pairs) as f32 >= 2.0 * self.min_edge_px
            && width.min(2 * n_pairs) as f32 >= self.min_edge_px * NARROWEST
            && component.n_runs as f32 > (1.0 + self.least_open) * n_pairs as f32
    }
}
