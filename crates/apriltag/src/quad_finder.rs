//! Fits a quadrilateral to a component.
//!
//! Input: the runs of a component. Output: four corners, clockwise in the image, within about a pixel of the corners of
//! the border, or the reason why the outline is no quadrilateral.

use crate::Rejection;
use crate::bit_plane::BitPlane;
use crate::components::{Component, Components, Span};
use crate::hull::{Hull, Pixel};
use crate::kernels::WORD;
use crate::quad::{Line, Point, Quad, cross, distance, intersect_sides, mean_edge};

/// Requirements on the quad of a component.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    /// Least mean edge, in pixels.
    pub(crate) min_edge_px: f32,
    /// Mean distance of the edge of the border from the centres of the outermost pixels of the component, in pixels.
    pub(crate) overhang_px: f32,
}

/// Least share of its convex hull that the outline of a border fills.
const LEAST_FILLED: f32 = 0.75;

#[derive(Debug, Default)]
pub(crate) struct QuadFinder {
    hull: Hull,
    /// First and last column of the component in each of its pairs of rows.
    extents: Vec<Span>,
    /// First and last black pixel within these extents in each row of each pair; empty for a row without black.
    rows: Vec<[Span; 2]>,
}

impl QuadFinder {
    /// Allocates the memory that an image of this size can need.
    pub(crate) fn make_room(&mut self, height: usize) {
        self.hull.make_room(height);
        let n_pairs = self.extents.len().max(height.div_ceil(2));
        self.extents.resize(n_pairs, Span::default());
        self.rows.resize(n_pairs, Default::default());
    }

    /// The quad around a component, from its runs and the black pixels within them.
    #[inline(always)]
    pub(crate) fn fit(
        &mut self,
        component: &Component,
        components: &Components,
        plane: &BitPlane,
        outline: Outline,
    ) -> Result<Quad, Rejection> {
        let n_pairs = component.n_pairs() as usize;
        components.read_extents(component, &mut self.extents[..n_pairs]);
        self.read_rows(component, plane);
        let rows = self.rows[..n_pairs].as_flattened();
        let filled: u32 = rows.iter().map(|[left, end]| u32::from(end - left)).sum();
        self.hull.build(component.rows().start, rows);
        // A border closes around what is within it; part of a side may be occluded. Pixels reach half a pixel beyond
        // the hull of their centres, all along its perimeter, which is twice its longer extent at least.
        let whole = self.hull.area() + component.width().max(2 * component.n_pairs()) as f32;
        require(filled as f32 >= LEAST_FILLED * whole, Rejection::NotAQuad)?;
        let corners = self.hull.largest_quad().ok_or(Rejection::NotAQuad)?;
        let quad =
            circumscribe(&self.hull, corners, outline.overhang_px).ok_or(Rejection::Shape)?;
        check_shape(&quad, outline.min_edge_px)?;
        Ok(quad)
    }

    /// Finds the first and last black pixel of each row, one strip of columns after the other.
    #[inline(always)]
    fn read_rows(&mut self, component: &Component, plane: &BitPlane) {
        let rows = &mut self.rows[..component.n_pairs() as usize];
        rows.fill(Default::default());
        for column in component.columns().step_by(WORD) {
            // All columns of the strip from one on.
            let within = |x: u16| u32::from(x).saturating_sub(column);
            let from = |x: u16| u64::MAX.checked_shl(within(x)).unwrap_or(0);
            let mut words = plane.strip(column as usize, component.rows().start as usize);
            for (rows, &[start, end]) in rows.iter_mut().zip(&self.extents) {
                let mask = from(start) & !from(end);
                for ([left, beyond], word) in rows.iter_mut().zip(&mut words) {
                    let black = word & mask;
                    if black != 0 {
                        let first = (column + black.trailing_zeros()) as u16;
                        *left = if *beyond == 0 { first } else { *left };
                        *beyond = (column + u64::BITS - black.leading_zeros()) as u16;
                    }
                }
            }
        }
    }
}

fn require(holds: bool, otherwise: Rejection) -> Result<(), Rejection> {
    holds.then_some(()).ok_or(otherwise)
}

fn to_point(pixel: Pixel) -> Point {
    pixel.map(|coordinate| coordinate as f32)
}

/// Moves the sides between four vertices outwards, each by half the distance of the farthest vertex beyond it and by
/// the overhang.
fn circumscribe(hull: &Hull, corners: [usize; 4], overhang_px: f32) -> Option<Quad> {
    let mut moved = [Line::default(); 4];
    for (i, line) in moved.iter_mut().enumerate() {
        let side = hull.chain(corners[i], corners[(i + 1) % 4]);
        let [first, .., last] = side else { return None };
        *line = Line::through(to_point(*first), to_point(*last))?;
        let distances = side.iter().map(|vertex| line.distance(to_point(*vertex)));
        let beyond = distances.fold(0.0, |a, b| if b > a { b } else { a });
        line.offset += beyond / 2.0 + overhang_px;
    }
    intersect_sides(&moved)
}

/// Checks that a quad is a square in perspective: sides long enough, angles not too small, clockwise and convex.
fn check_shape(quad: &Quad, min_edge_px: f32) -> Result<(), Rejection> {
    /// Shortest side as a share of the least mean edge.
    const SHORTEST: f32 = 0.3;
    /// Least sine of an angle: a square turned by 80 degrees, seen over its corner.
    const MIN_SINE: f32 = 0.17;
    let sides: [f32; 4] = std::array::from_fn(|i| distance(quad[i], quad[(i + 1) % 4]));
    let long_enough = mean_edge(quad) >= min_edge_px * 0.9
        && sides.iter().all(|&side| side >= min_edge_px * SHORTEST);
    let convex = (0..4).all(|i| {
        let turn = cross(quad[(i + 3) % 4], quad[i], quad[(i + 1) % 4]);
        turn > MIN_SINE * sides[(i + 3) % 4] * sides[i]
    });
    require(long_enough && convex, Rejection::Shape)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rows_reach_as_far_as_there_is_black_between_the_ends_of_runs(
            pairs in prop::collection::vec(any::<[[[u64; 3]; 3]; 2]>(), 1..6),
        ) {
            let row = |row: &[[u64; 3]; 3]| row.map(|[a, b, c]| a | b & c).to_vec();
            let rows: Vec<Vec<u64>> = pairs.as_flattened().iter().map(row).collect();
            let plane = BitPlane::of_rows(&rows);
            let (mut components, mut finder) = (Components::default(), QuadFinder::default());
            components.make_room(3 * WORD, 4 * rows.len());
            finder.make_room(rows.len());
            components.label(&plane);
            for component in components.all().iter().filter(|part| part.n_runs > 0) {
                components.read_extents(component, &mut finder.extents);
                finder.read_rows(component, &plane);
                for (i, y) in component.rows().enumerate() {
                    let [start, end] = finder.extents[i / 2];
                    let is_black = |x: &u16| rows[y as usize][usize::from(*x) / WORD] >> (x % 64) & 1 == 1;
                    let black: Vec<u16> = (start..end).filter(is_black).collect();
                    let reach = black.first().zip(black.last()).map_or([0; 2], |(a, b)| [*a, *b + 1]);
                    prop_assert_eq!(finder.rows[i / 2][i % 2], reach);
                }
            }
        }
    }
}
