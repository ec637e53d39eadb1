//! The quadrilateral around a component.
//!
//! In: a component's runs. Out: four corners, clockwise as seen, within about a pixel of the
//! border's corners; nothing where the outline is no quadrilateral.

use crate::Rejection;
use crate::bit_plane::{BitPlane, set_between};
use crate::border_shape::BorderShape;
use crate::components::{Component, Components, Span};
use crate::hull::{Hull, Pixel};

pub(crate) type Point = [f32; 2];

/// Corners clockwise as seen (y runs down).
pub(crate) type Quad = [Point; 4];

/// How far the border reaches beyond the centres of its outermost pixels on average, in pixels.
const OVERHANG_PX: f32 = 0.4;

/// First and last pixel of an outline in a row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent {
    pub(crate) row: u16,
    pub(crate) left: u16,
    pub(crate) right: u16,
}

#[derive(Debug, Default)]
pub(crate) struct QuadFinder {
    hull: Hull,
    rows: Vec<Extent>,
}

impl QuadFinder {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, height: usize) {
        self.hull.make_room(height);
        let most = self.rows.len().max(height + 2);
        self.rows.resize(most, Extent::default());
    }

    /// The quad around a component, by its runs and what of the plane is black within them.
    #[inline(always)]
    pub(crate) fn around(
        &mut self,
        component: &Component,
        components: &Components,
        plane: &BitPlane,
        shape: &BorderShape,
    ) -> Result<Quad, Rejection> {
        let (n_rows, n_black, filled) = self.read_rows(components.extents_of(component), plane);
        shape.check_filling(n_black, filled)?;
        self.hull.build(&self.rows[..n_rows]);
        check_convexity(&self.hull, filled)?;
        let inscribed = self.hull.largest_quad().ok_or(Rejection::NotAQuad)?;
        let inscribed = inscribed.map(to_point);
        let quad = circumscribe(&self.hull, &inscribed).ok_or(Rejection::Shape)?;
        check_shape(&quad, shape.min_edge_px)?;
        Ok(quad)
    }

    /// The exact extents of each row; how many rows, how many black pixels, and how many between the ends of rows.
    #[inline(always)]
    fn read_rows(
        &mut self,
        extents: impl Iterator<Item = (usize, Span)>,
        plane: &BitPlane,
    ) -> (usize, u32, u32) {
        let (mut n_rows, mut n_black, mut filled) = (0, 0, 0);
        for (pair, span) in extents {
            for row in [2 * pair + 1, 2 * pair] {
                let ([left, end], n) = set_between(plane.row(row), span);
                let (row, right) = (row as u16, end.wrapping_sub(1));
                self.rows[n_rows] = Extent { row, left, right };
                n_rows += usize::from(n > 0);
                n_black += n;
                filled += u32::from(end - left);
            }
        }
        (n_rows, n_black, filled)
    }
}

pub(crate) fn require(holds: bool, otherwise: Rejection) -> Result<(), Rejection> {
    holds.then_some(()).ok_or(otherwise)
}

fn to_point(pixel: Pixel) -> Point {
    pixel.map(|coordinate| coordinate as f32)
}

/// A border closes around what is within it; part of a side may be occluded.
fn check_convexity(hull: &Hull, filled: u32) -> Result<(), Rejection> {
    const LEAST_SHARE: f32 = 0.80;
    require(
        filled as f32 >= LEAST_SHARE * hull.area(),
        Rejection::NotAQuad,
    )
}

/// Twice the area of the triangle; positive when clockwise as seen.
fn cross(a: Point, b: Point, c: Point) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

pub(crate) fn twice_area(quad: &Quad) -> f32 {
    cross(quad[0], quad[1], quad[2]) + cross(quad[0], quad[2], quad[3])
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
    let area = twice_area(quad);
    [area / (side(1) + side(3)), area / (side(0) + side(2))]
}

pub(crate) fn mean_edge(quad: &Quad) -> f32 {
    let sides = (0..4).map(|i| distance(quad[i], quad[(i + 1) % 4]));
    sides.sum::<f32>() / 4.0
}

/// Moves each side outwards, half way to the farthest vertex beyond it and by the overhang.
fn circumscribe(hull: &Hull, quad: &Quad) -> Option<Quad> {
    let mut moved = [Line::default(); 4];
    for (i, line) in moved.iter_mut().enumerate() {
        *line = Line::through(quad[i], quad[(i + 1) % 4])?;
        let beyond = hull
            .vertices()
            .iter()
            .map(|&vertex| line.distance(to_point(vertex)))
            .fold(0.0, f32::max);
        line.offset += beyond / 2.0 + OVERHANG_PX;
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
