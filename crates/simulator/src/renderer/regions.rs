//! The parts of an image in which something moves: a few rectangles that do not touch.

use crate::polygon::Bounds;

/// Painting may exceed its bounds by this much, px.
const SLACK_PX: f64 = 0.5;

/// A rectangle of pixels, from `start` up to but excluding `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rectangle {
    start: [usize; 2],
    end: [usize; 2],
}

impl Rectangle {
    pub fn whole(resolution: [u32; 2]) -> Self {
        Self {
            start: [0; 2],
            end: resolution.map(|n| n as usize),
        }
    }

    pub fn columns(&self) -> [usize; 2] {
        [self.start[0], self.end[0]]
    }

    pub fn rows(&self) -> [usize; 2] {
        [self.start[1], self.end[1]]
    }

    /// The rectangle with a margin, clipped to the image.
    pub fn grown(&self, rim: usize, resolution: [u32; 2]) -> Self {
        let limit = |axis: usize| (self.end[axis] + rim).min(resolution[axis] as usize);
        Self {
            start: self.start.map(|n| n.saturating_sub(rim)),
            end: [limit(0), limit(1)],
        }
    }

    /// With a margin of [`SLACK_PX`], since pieces of a curved outline may exceed its bounds slightly.
    fn enclose(bounds: &Bounds, resolution: [u32; 2]) -> Option<Self> {
        let limit =
            |value: f64, axis: usize| value.clamp(0.0, f64::from(resolution[axis])) as usize;
        let (min, max) = (bounds.min, bounds.max);
        let start = [min.x, min.y].map(|v| (v - SLACK_PX).floor());
        let end = [max.x, max.y].map(|v| (v + SLACK_PX).ceil());
        let rectangle = Self {
            start: [limit(start[0], 0), limit(start[1], 1)],
            end: [limit(end[0], 0), limit(end[1], 1)],
        };
        let is_empty = (0..2).any(|axis| rectangle.start[axis] >= rectangle.end[axis]);
        (!is_empty).then_some(rectangle)
    }

    /// Whether the two would touch with a margin around both.
    fn is_near(&self, other: &Self, rim: usize) -> bool {
        (0..2).all(|axis| {
            self.start[axis] <= other.end[axis] + rim && other.start[axis] <= self.end[axis] + rim
        })
    }

    fn union(&self, other: &Self) -> Self {
        let pair = |f: fn(usize, usize) -> usize, a: [usize; 2], b: [usize; 2]| {
            [f(a[0], b[0]), f(a[1], b[1])]
        };
        Self {
            start: pair(usize::min, self.start, other.start),
            end: pair(usize::max, self.end, other.end),
        }
    }
}

/// Where something was painted in this image.
pub(super) struct Regions {
    resolution: [u32; 2],
    painted: Vec<Bounds>,
    rectangles: Vec<Rectangle>,
}

impl Regions {
    /// Allocates for `n_things` painted things.
    pub fn new(resolution: [u32; 2], n_things: usize) -> Self {
        Self {
            resolution,
            painted: vec![Bounds::NOTHING; n_things],
            rectangles: Vec::with_capacity(n_things),
        }
    }

    pub fn clear(&mut self) {
        self.painted.fill(Bounds::NOTHING);
        self.rectangles.clear();
    }

    /// Records that thing number `thing` was painted within these bounds, too.
    pub fn include(&mut self, thing: usize, bounds: &Bounds) {
        self.painted[thing] = self.painted[thing].union(bounds);
    }

    /// Turns what was painted into rectangles, and merges those closer than twice the margin.
    pub fn finish(&mut self, rim: usize) {
        let resolution = self.resolution;
        let rectangles = self
            .painted
            .iter()
            .filter_map(|bounds| Rectangle::enclose(bounds, resolution));
        self.rectangles.extend(rectangles);
        while self.merge_two(2 * rim) {}
    }

    pub fn rectangles(&self) -> &[Rectangle] {
        &self.rectangles
    }

    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    fn merge_two(&mut self, gap: usize) -> bool {
        for first in 0..self.rectangles.len() {
            for second in first + 1..self.rectangles.len() {
                let (a, b) = (self.rectangles[first], self.rectangles[second]);
                if a.is_near(&b, gap) {
                    self.rectangles[first] = a.union(&b);
                    self.rectangles.swap_remove(second);
                    return true;
                }
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point2;

    fn bounds(x: f64, y: f64, edge: f64) -> Bounds {
        Bounds::around(&[Point2::new(x, y), Point2::new(x + edge, y + edge)])
    }

    #[test]
    fn near_rectangles_become_one_and_far_ones_stay() {
        let mut regions = Regions::new([640, 480], 3);
        regions.include(0, &bounds(10.2, 10.2, 20.0));
        regions.include(1, &bounds(33.0, 10.0, 20.0));
        regions.include(2, &bounds(300.0, 10.0, 20.0));
        regions.finish(2);
        let mut columns: Vec<_> = regions
            .rectangles()
            .iter()
            .map(Rectangle::columns)
            .collect();
        columns.sort_unstable();
        assert_eq!(columns, [[9, 54], [299, 321]]);
    }

    #[test]
    fn what_lies_beyond_the_image_makes_no_rectangle() {
        let mut regions = Regions::new([640, 480], 2);
        regions.include(0, &bounds(-50.0, 10.0, 20.0));
        regions.include(1, &bounds(630.0, 470.0, 50.0));
        regions.finish(1);
        assert_eq!(
            regions.rectangles(),
            [Rectangle {
                start: [629, 469],
                end: [640, 480]
            }]
        );
    }
}
