//! The convex hull of an outline, and the four of its vertices that span the largest area.
//!
//! Input: the first and last column of each row. Output: vertices at pixel centres, clockwise in the image (y points
//! down).

use crate::components::{Span, make_room};

pub(crate) type Pixel = [i32; 2];

#[derive(Debug, Default)]
pub(crate) struct Hull {
    /// All vertices twice, so that the path from any to any other is a slice.
    vertices: Vec<Pixel>,
}

impl Hull {
    /// Allocates the memory that an image of this size can need.
    pub(crate) fn make_room(&mut self, height: usize) {
        make_room(&mut self.vertices, 4 * height + 2);
    }

    /// Hull of rows from the given one on, of which the first and the last may be empty: down the right side and up the
    /// left (Andrew's monotone chain).
    #[inline(always)]
    pub(crate) fn build(&mut self, top: u32, rows: &[Span]) {
        self.vertices.clear();
        let is_empty = |i: usize| usize::from(rows[i][1] == 0);
        let (first, last) = (is_empty(0), rows.len() - 1 - is_empty(rows.len() - 1));
        let vertex =
            |i: usize, end: usize| [i32::from(rows[i][end]) - end as i32, top as i32 + i as i32];
        let vertices = &mut self.vertices;
        vertices.push(vertex(first, 1));
        for (i, [above, here, below]) in (first + 1..last).zip(rows[first..].array_windows()) {
            if 2 * here[1] > above[1] + below[1] {
                extend_chain(vertices, 0, vertex(i, 1));
            }
        }
        extend_chain(vertices, 0, vertex(last, 1));
        let left_chain = vertices.len() - 1;
        extend_chain(vertices, left_chain, vertex(last, 0));
        for (i, [above, here, below]) in (first + 1..last)
            .zip(rows[first..=last].array_windows())
            .rev()
        {
            if 2 * here[0] < above[0] + below[0] {
                extend_chain(vertices, left_chain, vertex(i, 0));
            }
        }
        extend_chain(vertices, left_chain, vertex(first, 0));
        vertices.extend_from_within(..);
    }

    /// Vertices from one to another, inclusive, clockwise.
    pub(crate) fn chain(&self, from: usize, to: usize) -> &[Pixel] {
        let round = usize::from(to <= from) * self.vertices.len() / 2;
        &self.vertices[from..=to + round]
    }

    pub(crate) fn area(&self) -> f32 {
        let twice = |a: Pixel, b: Pixel| a[0] * b[1] - a[1] * b[0];
        let sides = self.vertices.array_windows().take(self.vertices.len() / 2);
        sides.map(|&[a, b]| twice(a, b)).sum::<i32>() as f32 / 2.0
    }

    /// Four vertices that span a (locally) largest area, clockwise: an extreme one, the one farthest from it, the
    /// farthest on either side of their diagonal, then each optimised once given its neighbours.
    pub(crate) fn largest_quad(&self) -> Option<[usize; 4]> {
        let n = self.vertices.len() / 2;
        let farthest_from = |i: usize| {
            let [x, y] = self.vertices[i];
            farthest(&self.vertices[..n], |to| {
                (to[0] - x).pow(2) + (to[1] - y).pow(2)
            })
        };
        let a = farthest_from(0);
        let mut corners = [a, 0, farthest_from(a), 0];
        for i in [1, 3, 0, 2, 1, 3] {
            corners[i] = self.farthest_between(corners[(i + 3) % 4], corners[(i + 1) % 4]);
        }
        corners.sort_unstable();
        let distinct = corners.windows(2).all(|pair| pair[0] != pair[1]);
        distinct.then_some(corners)
    }

    /// Of the vertices from one to another, the one farthest from the line through both.
    fn farthest_between(&self, from: usize, to: usize) -> usize {
        let n = self.vertices.len() / 2;
        let [a, b] = [from, to].map(|i| self.vertices[i]);
        let normal = [b[1] - a[1], a[0] - b[0]];
        let value = |point: Pixel| normal[0] * point[0] + normal[1] * point[1];
        let found = from + farthest(self.chain(from, to), value);
        if found < n { found } else { found - n }
    }
}

/// Index of the first point with the greatest value.
#[inline(always)]
fn farthest(points: &[Pixel], value: impl Fn(Pixel) -> i32) -> usize {
    let indices = (0..points.len()).rev();
    indices.max_by_key(|&i| value(points[i])).unwrap_or(0)
}

/// Appends a vertex to those from the given one on, and removes those that are no longer on the hull.
#[inline]
fn extend_chain(vertices: &mut Vec<Pixel>, first: usize, point: Pixel) {
    while let [.., a, b] = vertices[first..]
        && cross(a, b, point) <= 0
    {
        vertices.pop();
    }
    vertices.push(point);
}

/// Twice the signed area of the triangle; positive if clockwise in the image.
fn cross(a: Pixel, b: Pixel, c: Pixel) -> i32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
