//! The quadrilateral around a component.
//!
//! In: a component's runs. Out: four corners, clockwise as seen, within about a pixel of the
//! border's corners; nothing where the outline is no quadrilateral.

use crate::Rejection;
use crate::bit_plane::BitPlane;
use crate::components::{Component, Components, Span};
use crate::hull::{Hull, Pixel};
use crate::kernels::WORD;

pub(crate) type Point = [f32; 2];

/// Corners clockwise as seen (y runs down).
pub(crate) type Quad = [Point; 4];

/// What is asked of a quad around a component.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    /// Least mean edge, in pixels.
    pub(crate) min_edge_px: f32,
    /// How far the border reaches beyond the centres of the component's outermost pixels on average, in pixels.
    pub(crate) overhang_px: f32,
}

/// Share of the hull of a border's outline that lies within it.
const LEAST_FILLED: f32 = 0.75;

#[derive(Debug, Default)]
pub(crate) struct QuadFinder {
    hull: Hull,
    /// From where to where a component's runs reach in each of its pairs of rows.
    extents: Vec<Span>,
    /// From where to where there is black within that, in each row of each pair; nowhere in a row that is all white there.
    rows: Vec<[Span; 2]>,
}

impl QuadFinder {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, height: usize) {
        self.hull.make_room(height);
        let n_pairs = self.extents.len().max(height.div_ceil(2));
        self.extents.resize(n_pairs, Span::default());
        self.rows.resize(n_pairs, Default::default());
    }

    /// The quad around a component, by its runs and what of the plane is black within them.
    #[inline(always)]
    pub(crate) fn around(
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
        // A border closes around what is within it; part of a side may be occluded. Pixels reach half a pixel beyond the hull of
        // their centres, all along its perimeter, which is twice its longer extent at least.
        let whole = self.hull.area() + component.width().max(2 * component.n_pairs()) as f32;
        require(filled as f32 >= LEAST_FILLED * whole, Rejection::NotAQuad)?;
        let corners = self.hull.largest_quad().ok_or(Rejection::NotAQuad)?;
        let quad =
            circumscribe(&self.hull, corners, outline.overhang_px).ok_or(Rejection::Shape)?;
        check_shape(&quad, outline.min_edge_px)?;
        Ok(quad)
    }

    /// From where to where black reaches in each row, a strip of columns after the other.
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

pub(crate) fn require(holds: bool, otherwise: Rejection) -> Result<(), Rejection> {
    holds.then_some(()).ok_or(otherwise)
}

fn to_point(pixel: Pixel) -> Point {
    pixel.map(|coordinate| coordinate as f32)
}

/// Twice the area of the triangle; positive when clockwise as seen.
fn cross(a: Point, b: Point, c: Point) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

pub(crate) fn distance(a: Point, b: Point) -> f32 {
    ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt()
}

/// Mean of the corners.
pub(crate) fn middle(quad: &Quad) -> Point {
    let mean = |axis: usize| quad.iter().map(|corner| corner[axis]).sum::<f32>() / 4.0;
    [mean(0), mean(1)]
}

/// Mean distances between the left and the right side and between the upper and the lower one.
pub(crate) fn widths(quad: &Quad) -> [f32; 2] {
    let side = |i: usize| distance(quad[i], quad[(i + 1) % 4]);
    let twice_area = cross(quad[0], quad[1], quad[2]) + cross(quad[0], quad[2], quad[3]);
    [side(1) + side(3), side(0) + side(2)].map(|sides| twice_area / sides)
}

pub(crate) fn mean_edge(quad: &Quad) -> f32 {
    let sides = (0..4).map(|i| distance(quad[i], quad[(i + 1) % 4]));
    sides.sum::<f32>() / 4.0
}

/// Moves the sides between four vertices outwards, each half way to the farthest vertex beyond it and by the overhang.
fn circumscribe(hull: &Hull, corners: [usize; 4], overhang_px: f32) -> Option<Quad> {
    let mut moved = [Line::default(); 4];
    for (i, line) in moved.iter_mut().enumerate() {
        let side = hull.between(corners[i], corners[(i + 1) % 4]);
        let [first, .., last] = side else { return None };
        *line = Line::through(to_point(*first), to_point(*last))?;
        let distances = side.iter().map(|vertex| line.distance(to_point(*vertex)));
        let beyond = distances.fold(0.0, |a, b| if b > a { b } else { a });
        line.offset += beyond / 2.0 + overhang_px;
    }
    intersect_sides(&moved)
}

/// The corners between each side and the one before it.
pub(crate) fn intersect_sides(sides: &[Line; 4]) -> Option<Quad> {
    let mut quad = [[0.0; 2]; 4];
    for (i, corner) in quad.iter_mut().enumerate() {
        *corner = sides[(i + 3) % 4].intersect(&sides[i])?;
    }
    Some(quad)
}

/// Sides long enough, angles of a square in perspective, clockwise and convex.
pub(crate) fn check_shape(quad: &Quad, min_edge_px: f32) -> Result<(), Rejection> {
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

/// The points p with `normal . p = offset`; the normal has length 1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    pub(crate) normal: Point,
    pub(crate) offset: f32,
}

impl Line {
    /// From a to b, the normal to the left of the way as seen: outwards on a clockwise quad.
    pub(crate) fn through(a: Point, b: Point) -> Option<Self> {
        let length = distance(a, b);
        let normal = [(b[1] - a[1]) / length, (a[0] - b[0]) / length];
        let offset = normal[0] * a[0] + normal[1] * a[1];
        offset.is_finite().then_some(Self { normal, offset })
    }

    /// Distance of a point beyond the line.
    pub(crate) fn distance(&self, point: Point) -> f32 {
        self.normal[0] * point[0] + self.normal[1] * point[1] - self.offset
    }

    pub(crate) fn intersect(&self, other: &Self) -> Option<Point> {
        let determinant = self.normal[0] * other.normal[1] - self.normal[1] * other.normal[0];
        let x = (self.offset * other.normal[1] - other.offset * self.normal[1]) / determinant;
        let y = (other.offset * self.normal[0] - self.offset * other.normal[0]) / determinant;
        (x.is_finite() && y.is_finite()).then_some([x, y])
    }
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
