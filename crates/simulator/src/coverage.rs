//! Exact area coverage: polygons added into a grid of pixels, each pixel weighted by the area of it that is covered.
//!
//! Every edge leaves the change of coverage it causes to its right; a sum along each row turns the changes into
//! coverage (as in R. Levien's font-rs, 2016). The result is linear in the polygons: colours of nested and neighbouring
//! areas add up to what an infinitely fine supersampling would give. Coordinates here have (0, 0) at the **corner** of
//! the first pixel.

use crate::polygon::signed_area;
use nalgebra::Point2;
use std::ops::Range;

/// An edge lower than this bounds no area worth mentioning, and its slope might be no number, px.
const LEVEL_PX: f64 = 1e-9;

/// A picture of weighted coverage.
pub(crate) struct Coverage {
    width: usize,
    height: usize,
    /// Changes of coverage; two columns more than the picture, for edges on its right border.
    changes: Vec<f32>,
    /// What is filled counts in these rows only.
    rows: Range<usize>,
}

/// A straight piece of an edge, going down.
#[derive(Clone, Copy)]
struct Piece {
    x: f64,
    y: f64,
    slope: f64,
}

impl Piece {
    fn x_at(&self, y: f64) -> f64 {
        self.x + (y - self.y) * self.slope
    }
}

impl Coverage {
    pub fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            changes: vec![0.0; (width + 2) * height],
            rows: 0..height,
        }
    }

    /// Restricts filling to these rows.
    pub fn keep_to(&mut self, rows: Range<usize>) {
        self.rows = rows.start..rows.end.min(self.height);
    }

    /// Adds `weight` times the area inside a closed line that doesn't cross itself, whichever way round it runs.
    pub fn fill(&mut self, outline: &[Point2<f64>], weight: f32) {
        let Some(&last) = outline.last() else {
            return;
        };
        let weight = if signed_area(outline) < 0.0 {
            weight
        } else {
            -weight
        };
        let mut from = last;
        for &to in outline {
            self.edge(from, to, f64::from(weight));
            from = to;
        }
    }

    /// Puts the coverage of a row's pixels from `start` up to `end` into `row` and forgets the row's changes there.
    ///
    /// All that was filled in this row must lie in start..end.
    pub fn take_row(&mut self, y: usize, start: usize, end: usize, row: &mut [f32]) {
        let stride = self.width + 2;
        let last = (end + 2).min(stride);
        let changes = &mut self.changes[y * stride + start..y * stride + last];
        let mut sum = 0.0;
        for (value, change) in row.iter_mut().zip(changes.iter()).take(end - start) {
            sum += change;
            *value = sum;
        }
        changes.fill(0.0);
    }

    fn edge(&mut self, from: Point2<f64>, to: Point2<f64>, weight: f64) {
        if (from.y - to.y).abs() < LEVEL_PX {
            return;
        }
        let (top, bottom, weight) = if from.y < to.y {
            (from, to, weight)
        } else {
            (to, from, -weight)
        };
        let (first, end) = (self.rows.start as f64, self.rows.end as f64);
        let (y_start, y_end) = (top.y.max(first), bottom.y.min(end));
        if y_start >= y_end {
            return;
        }
        let piece = Piece {
            x: top.x,
            y: top.y,
            slope: (bottom.x - top.x) / (bottom.y - top.y),
        };
        self.split_at_borders(piece, y_start, y_end, weight);
    }

    /// Left of the picture an edge acts like one on the border, right of it not at all.
    fn split_at_borders(&mut self, piece: Piece, y_start: f64, y_end: f64, weight: f64) {
        let width = self.width as f64;
        let crossing = |x: f64| (piece.y + (x - piece.x) / piece.slope).clamp(y_start, y_end);
        let inside = |x: f64| (0.0..=width).contains(&x);
        if inside(piece.x_at(y_start)) && inside(piece.x_at(y_end)) {
            return self.add(piece, y_start, y_end, weight);
        }
        let (mut first, mut second) = (y_start, y_end);
        if piece.slope != 0.0 {
            (first, second) = (crossing(0.0), crossing(width));
            if first > second {
                (first, second) = (second, first);
            }
        }
        for (start, end) in [(y_start, first), (first, second), (second, y_end)] {
            let middle = piece.x_at((start + end) / 2.0);
            if start < end && middle < 0.0 {
                let border = Piece {
                    x: 0.0,
                    y: start,
                    slope: 0.0,
                };
                self.add(border, start, end, weight);
            } else if start < end && middle <= width {
                self.add(piece, start, end, weight);
            }
        }
    }

    fn add(&mut self, piece: Piece, y_start: f64, y_end: f64, weight: f64) {
        let mut row = y_start as i32 as usize;
        let mut y = y_start;
        let mut x = piece.x_at(y);
        while y < y_end && row < self.height {
            let y_next = y_end.min((row + 1) as f64);
            let x_next = piece.x_at(y_next);
            self.add_in_row(row, x, x_next, (y_next - y) * weight);
            (x, y) = (x_next, y_next);
            row += 1;
        }
    }

    /// An edge within one row from x to x_next; `height` is its signed, weighted height.
    fn add_in_row(&mut self, row: usize, x: f64, x_next: f64, height: f64) {
        let stride = self.width + 2;
        let cells = &mut self.changes[row * stride..(row + 1) * stride];
        let width = self.width as f64;
        let (left, right) = if x < x_next { (x, x_next) } else { (x_next, x) };
        let (left, right) = (left.clamp(0.0, width), right.clamp(0.0, width));
        // By way of i32, which a processor converts to in one step.
        let (first, last) = (left as i32 as usize, right as i32 as usize);
        if first == last {
            let beyond = (left + right) / 2.0 - first as f64;
            cells[first] += (height * (1.0 - beyond)) as f32;
            cells[first + 1] += (height * beyond) as f32;
        } else {
            let ends = [left - first as f64, right - last as f64];
            add_across(&mut cells[first..last + 2], ends, height);
        }
    }
}

/// An edge from the first of `cells` to the last but one; `ends` is how far into these it begins and ends.
///
/// The area to its right grows quadratically in the first and the last pixel it crosses and linearly in between.
fn add_across(cells: &mut [f32], [start, end]: [f64; 2], height: f64) {
    let crossed = cells.len() - 2;
    let per_column = height / (crossed as f64 + end - start);
    let in_first = 0.5 * per_column * (1.0 - start) * (1.0 - start);
    let beyond_last = 0.5 * per_column * end * end;
    cells[0] += in_first as f32;
    let mut covered = in_first;
    let mut full = per_column * (1.5 - start);
    for cell in &mut cells[1..crossed] {
        *cell += (full - covered) as f32;
        covered = full;
        full += per_column;
    }
    cells[crossed] += (height - beyond_last - covered) as f32;
    cells[crossed + 1] += beyond_last as f32;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::{Polygon, convex_hull};
    use proptest::prelude::*;

    const SIZE: usize = 12;

    fn picture(outline: &[Point2<f64>]) -> Vec<f32> {
        let mut coverage = Coverage::new(SIZE, SIZE);
        coverage.fill(outline, 1.0);
        let mut pixels = vec![0.0; SIZE * SIZE];
        for (y, row) in pixels.chunks_mut(SIZE).enumerate() {
            coverage.take_row(y, 0, SIZE, row);
        }
        assert!(coverage.changes.iter().all(|&change| change == 0.0));
        pixels
    }

    fn pixel(x: usize, y: usize) -> Polygon {
        let (x, y) = (x as f64, y as f64);
        let corner = |dx, dy| Point2::new(x + dx, y + dy);
        convex_hull(&mut [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(1.0, 1.0),
            corner(0.0, 1.0),
        ])
    }

    fn point() -> impl Strategy<Value = Point2<f64>> {
        (-6.0..18.0, -6.0..18.0).prop_map(|(x, y)| Point2::new(x, y))
    }

    proptest! {
        #[test]
        fn a_pixel_gets_the_area_of_the_polygon_inside_it(
            mut points in prop::collection::vec(point(), 3..9),
            turn in any::<bool>(),
        ) {
            let polygon = convex_hull(&mut points);
            let mut outline = polygon.corners().to_vec();
            if turn {
                outline.reverse();
            }
            let pixels = picture(&outline);
            for y in 0..SIZE {
                for x in 0..SIZE {
                    let expected = polygon.clipped(&pixel(x, y)).area();
                    let got = f64::from(pixels[y * SIZE + x]);
                    prop_assert!((got - expected).abs() < 1e-5, "({x}, {y}): {got} not {expected}");
                }
            }
        }
    }

    #[test]
    fn nested_areas_add_up() {
        let square = |a: f64, b: f64| {
            [
                Point2::new(a, a),
                Point2::new(b, a),
                Point2::new(b, b),
                Point2::new(a, b),
            ]
        };
        let mut coverage = Coverage::new(SIZE, SIZE);
        coverage.fill(&square(1.0, 9.0), 200.0);
        coverage.fill(&square(2.5, 7.5), -150.0);
        let mut row = [0.0; SIZE];
        coverage.take_row(4, 0, SIZE, &mut row);
        assert_eq!(row[..8], [0.0, 200.0, 125.0, 50.0, 50.0, 50.0, 50.0, 125.0]);
    }
}
