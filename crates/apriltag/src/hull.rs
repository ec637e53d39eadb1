//! The convex hull of an outline and the four of its vertices that span most of it.
//!
//! In: the leftmost and rightmost pixel of each row. Out: vertices at centres of pixels, clockwise as seen (y runs down).

use crate::components::make_room;
use crate::quad::Extent;

pub(crate) type Pixel = [i32; 2];

#[derive(Debug, Default)]
pub(crate) struct Hull {
    vertices: Vec<Pixel>,
}

impl Hull {
    /// Takes the memory that an image of a size can ask for.
    pub(crate) fn make_room(&mut self, height: usize) {
        make_room(&mut self.vertices, 2 * height + 1);
    }

    /// Of rows from the last to the first: down the right side and up the left (Andrew's monotone chain).
    #[inline(always)]
    pub(crate) fn build(&mut self, rows: &[Extent]) {
        self.vertices.clear();
        let ([last, ..], [.., first]) = (rows, rows) else {
            return;
        };
        let vertex = |row: &Extent, x: u16| [x, row.row].map(i32::from);
        self.vertices.push(vertex(first, first.right));
        for [below, here, above] in rows.array_windows().rev() {
            if 2 * u32::from(here.right) > u32::from(above.right) + u32::from(below.right) {
                self.extend_chain(0, vertex(here, here.right));
            }
        }
        self.extend_chain(0, vertex(last, last.right));
        let left_chain = self.vertices.len() - 1;
        self.extend_chain(left_chain, vertex(last, last.left));
        for [below, here, above] in rows.array_windows() {
            if 2 * u32::from(here.left) < u32::from(above.left) + u32::from(below.left) {
                self.extend_chain(left_chain, vertex(here, here.left));
            }
        }
        self.extend_chain(left_chain, vertex(first, first.left));
    }

    #[inline]
    fn extend_chain(&mut self, first: usize, point: Pixel) {
        while let [.., a, b] = self.vertices[first..]
            && cross(a, b, point) <= 0
        {
            self.vertices.pop();
        }
        self.vertices.push(point);
    }

    pub(crate) fn vertices(&self) -> &[Pixel] {
        &self.vertices
    }

    pub(crate) fn area(&self) -> f32 {
        let [first, .., last] = self.vertices[..] else {
            return 0.0;
        };
        let twice = |a: Pixel, b: Pixel| a[0] * b[1] - a[1] * b[0];
        let sides = self.vertices.array_windows();
        let sum = sides.map(|&[a, b]| twice(a, b)).sum::<i32>() + twice(last, first);
        sum as f32 / 2.0
    }

    /// Four vertices that span a (locally) largest area.
    pub(crate) fn largest_quad(&self) -> Option<[Pixel; 4]> {
        let hull = &self.vertices;
        let mut corners = self.first_guess();
        // Whether a corner is the farthest from the line through its neighbours, as the last two guessed are.
        let mut is_farthest = [false, true, false, true];
        for i in (0..4).chain(0..4) {
            if !is_farthest[i] {
                let (last, next) = ((i + 3) % 4, (i + 1) % 4);
                let found = self.farthest_beyond(hull[corners[last]], hull[corners[next]]);
                if found != corners[i] {
                    (is_farthest[last], is_farthest[next]) = (false, false);
                }
                (corners[i], is_farthest[i]) = (found, true);
            }
        }
        corners.sort_unstable();
        let distinct = corners.windows(2).all(|pair| pair[0] != pair[1]);
        distinct.then(|| corners.map(|i| hull[i]))
    }

    /// The vertex farthest from the first, the one farthest from that, and those farthest to either side.
    fn first_guess(&self) -> [usize; 4] {
        let hull = &self.vertices;
        let a = self.farthest(|point| distance_squared(point, hull[0]));
        let c = self.farthest(|point| distance_squared(point, hull[a]));
        let b = self.farthest_beyond(hull[a], hull[c]);
        let d = self.farthest_beyond(hull[c], hull[a]);
        [a, b, c, d]
    }

    /// Index of the vertex farthest to the left, as seen, of the way from one point to another.
    fn farthest_beyond(&self, from: Pixel, to: Pixel) -> usize {
        let normal = [to[1] - from[1], from[0] - to[0]];
        self.farthest(|point| normal[0] * point[0] + normal[1] * point[1])
    }

    /// Index of the vertex with the greatest value.
    fn farthest(&self, value: impl Fn(Pixel) -> i32) -> usize {
        let mut best = (0, i32::MIN);
        for (i, &point) in self.vertices.iter().enumerate() {
            let here = value(point);
            if here > best.1 {
                best = (i, here);
            }
        }
        best.0
    }
}

/// Twice the area of the triangle; positive when clockwise as seen.
fn cross(a: Pixel, b: Pixel, c: Pixel) -> i32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn distance_squared(a: Pixel, b: Pixel) -> i32 {
    (a[0] - b[0]).pow(2) + (a[1] - b[1]).pow(2)
}
