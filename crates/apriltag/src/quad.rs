//! Points, lines and quadrilaterals in the image, in pixels (x right, y down), in single precision.

pub(crate) type Point = [f32; 2];

/// Corners, clockwise in the image (y points down).
pub(crate) type Quad = [Point; 4];

/// Twice the signed area of the triangle; positive if clockwise in the image.
pub(crate) fn cross(a: Point, b: Point, c: Point) -> f32 {
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

/// Mean distances between the left and right sides and between the upper and lower sides.
pub(crate) fn widths(quad: &Quad) -> [f32; 2] {
    let side = |i: usize| distance(quad[i], quad[(i + 1) % 4]);
    let twice_area = cross(quad[0], quad[1], quad[2]) + cross(quad[0], quad[2], quad[3]);
    [side(1) + side(3), side(0) + side(2)].map(|sides| twice_area / sides)
}

pub(crate) fn mean_edge(quad: &Quad) -> f32 {
    let sides = (0..4).map(|i| distance(quad[i], quad[(i + 1) % 4]));
    sides.sum::<f32>() / 4.0
}

/// The intersections of each side with the previous one.
pub(crate) fn intersect_sides(sides: &[Line; 4]) -> Option<Quad> {
    let mut quad = [[0.0; 2]; 4];
    for (i, corner) in quad.iter_mut().enumerate() {
        *corner = sides[(i + 3) % 4].intersect(&sides[i])?;
    }
    Some(quad)
}

/// The points p with `normal . p = offset`; the normal has length 1.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    pub(crate) normal: Point,
    pub(crate) offset: f32,
}

impl Line {
    /// The line from a to b, with its normal to the left: outwards on a clockwise quad.
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
