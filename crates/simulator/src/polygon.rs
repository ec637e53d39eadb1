//! Convex polygons in the normalised image plane (x/z, y/z), where straight edges of the world are straight.
//!
//! Fixed capacity, so that a picture needs no heap. Neither pixels nor lenses here.

use nalgebra::{Point2, Vector2};

/// The most corners of a polygon; further ones are dropped. A face cut by a dozen neighbours has fewer.
pub(crate) const MAX_CORNERS: usize = 64;

/// A convex polygon with its corners in order, either way round.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    corners: [Point2<f64>; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    pub fn empty() -> Self {
        Self {
            corners: [Point2::origin(); MAX_CORNERS],
            len: 0,
        }
    }

    pub fn push(&mut self, corner: Point2<f64>) {
        if self.len < MAX_CORNERS {
            self.corners[self.len] = corner;
            self.len += 1;
        }
    }

    pub fn corners(&self) -> &[Point2<f64>] {
        &self.corners[..self.len]
    }

    pub fn corners_mut(&mut self) -> &mut [Point2<f64>] {
        &mut self.corners[..self.len]
    }

    /// Pairs of corners that an edge joins.
    pub fn edges(&self) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
        let corners = self.corners();
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(&a, &b)| (a, b))
    }

    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.corners())
    }

    pub fn area(&self) -> f64 {
        signed_area(self.corners()).abs()
    }

    /// The part of this polygon inside `window`, a convex polygon that runs the positive way round.
    ///
    /// I. Sutherland, G. Hodgman, "Reentrant polygon clipping", 1974.
    pub fn clipped(&self, window: &Polygon) -> Self {
        let mut part = *self;
        for (a, b) in window.edges() {
            if part.len == 0 {
                break;
            }
            part = part.on_positive_side(&a, &b);
        }
        part
    }

    fn on_positive_side(&self, a: &Point2<f64>, b: &Point2<f64>) -> Self {
        let mut part = Self::empty();
        for (from, to) in self.edges() {
            let (d_from, d_to) = (side(a, b, &from), side(a, b, &to));
            if d_from >= 0.0 {
                part.push(from);
            }
            if (d_from > 0.0 && d_to < 0.0) || (d_from < 0.0 && d_to > 0.0) {
                part.push(from + (to - from) * (d_from / (d_from - d_to)));
            }
        }
        part
    }
}

/// Twice the signed area of the triangle a, b, p.
fn side(a: &Point2<f64>, b: &Point2<f64>, p: &Point2<f64>) -> f64 {
    (b - a).perp(&(p - a))
}

/// The area inside a closed line, positive where it turns from x to y.
pub(crate) fn signed_area(corners: &[Point2<f64>]) -> f64 {
    let Some(origin) = corners.first() else {
        return 0.0;
    };
    let fan = corners.windows(2).map(|pair| {
        let (a, b): (Vector2<f64>, Vector2<f64>) = (pair[0] - origin, pair[1] - origin);
        a.perp(&b)
    });
    fan.sum::<f64>() / 2.0
}

/// The convex hull, the positive way round. `points` is put in another order.
///
/// A. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979.
pub(crate) fn convex_hull(points: &mut [Point2<f64>]) -> Polygon {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull = Polygon::empty();
    half_hull(&mut hull, points.iter());
    half_hull(&mut hull, points.iter().rev());
    hull
}

/// Adds one half of the hull without its last point, with which the other half begins.
fn half_hull<'a>(hull: &mut Polygon, points: impl Iterator<Item = &'a Point2<f64>>) {
    let start = hull.len;
    for point in points {
        while hull.len >= start + 2
            && side(
                &hull.corners[hull.len - 2],
                &hull.corners[hull.len - 1],
                point,
            ) <= 0.0
        {
            hull.len -= 1;
        }
        hull.push(*point);
    }
    hull.len = hull.len.saturating_sub(1).max(start);
}

/// An upright rectangle around something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub min: Point2<f64>,
    pub max: Point2<f64>,
}

impl Bounds {
    pub const NOTHING: Self = Self {
        min: Point2::new(f64::INFINITY, f64::INFINITY),
        max: Point2::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub fn around(points: &[Point2<f64>]) -> Self {
        points.iter().fold(Self::NOTHING, |bounds, point| Self {
            min: bounds.min.inf(point),
            max: bounds.max.sup(point),
        })
    }

    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.inf(&other.min),
            max: self.max.sup(&other.max),
        }
    }

    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.x < other.max.x
            && other.min.x < self.max.x
            && self.min.y < other.max.y
            && other.min.y < self.max.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn square(x: f64, y: f64, edge: f64) -> Polygon {
        let corner = |dx: f64, dy: f64| Point2::new(x + dx * edge, y + dy * edge);
        convex_hull(&mut [
            corner(0.0, 0.0),
            corner(1.0, 1.0),
            corner(1.0, 0.0),
            corner(0.0, 1.0),
        ])
    }

    fn point() -> impl Strategy<Value = Point2<f64>> {
        (-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| Point2::new(x, y))
    }

    proptest! {
        #[test]
        fn hull_holds_all_its_points(mut points in prop::collection::vec(point(), 3..12)) {
            let hull = convex_hull(&mut points);
            prop_assert!(signed_area(hull.corners()) > 0.0);
            for (a, b) in hull.edges() {
                prop_assert!(points.iter().all(|p| side(&a, &b, p) > -1e-12));
            }
        }

        #[test]
        fn parts_inside_and_outside_a_line_make_the_whole(
            mut points in prop::collection::vec(point(), 3..9),
            a in point(),
            b in point(),
        ) {
            let whole = convex_hull(&mut points);
            let parts = whole.on_positive_side(&a, &b).area() + whole.on_positive_side(&b, &a).area();
            prop_assert!((parts - whole.area()).abs() < 1e-12);
        }
    }

    #[test]
    fn clipping_gives_the_common_part() {
        let part = square(0.0, 0.0, 2.0).clipped(&square(1.0, 1.0, 3.0));
        assert!((part.area() - 1.0).abs() < 1e-15);
        assert_eq!(
            square(0.0, 0.0, 1.0).clipped(&square(2.0, 2.0, 1.0)).area(),
            0.0
        );
    }

    #[test]
    fn hull_drops_points_inside_and_on_its_edges() {
        let mut points: Vec<_> = square(0.0, 0.0, 2.0).corners().to_vec();
        points.extend([Point2::new(1.0, 1.0), Point2::new(1.0, 0.0)]);
        assert_eq!(convex_hull(&mut points).corners().len(), 4);
    }
}
