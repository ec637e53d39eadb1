//! The projective map between a tag's modules and the image, in single precision.
//!
//! `sextant-geometry` has a double-precision version; this one maps thousands of points per image, also on processors
//! with slow double-precision arithmetic.

use crate::quad::{Point, Quad, middle};

/// Points that are mapped and sampled in one batch.
pub(crate) const POINTS: usize = 8;

/// One coordinate, or the grey values, of a batch of points.
pub(crate) type Points = [f32; POINTS];

/// Maps a square's coordinates (u right, v down) to pixels.
///
/// pixel = origin + (m0 u + m1 v + m2, m3 u + m4 v + m5) / (m6 u + m7 v + 1); a nearby origin keeps the numbers small.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homography {
    pub(crate) origin: Point,
    pub(crate) m: [f32; 8],
}

impl Homography {
    /// Maps the corners of the square -1..1 to a quad.
    ///
    /// On these corners u, v, u v and 1 are orthogonal. A corner p times its denominator w = g u + h v + 1 is linear
    /// in u and v. Therefore the sum of u v w p is zero, which determines g and h; the sums of u w p, v w p and w p
    /// determine the rest.
    pub(crate) fn square_to_quad(quad: &Quad) -> Option<Self> {
        let origin = middle(quad);
        let means = |axis: usize| {
            let [a, b, c, d] = quad.map(|corner| (corner[axis] - origin[axis]) / 4.0);
            [b + c - a - d, c + d - a - b, a + c - b - d]
        };
        let ([ux, vx, uvx], [uy, vy, uvy]) = (means(0), means(1));
        let determinant = ux * vy - vx * uy;
        let g = (uvx * uy - ux * uvy) / determinant;
        let h = (vx * uvy - uvx * vy) / determinant;
        let (x, y) = (g * ux + h * vx, g * uy + h * vy);
        let m = [
            ux + h * uvx,
            vx + g * uvx,
            x,
            uy + h * uvy,
            vy + g * uvy,
            y,
            g,
            h,
        ];
        let finite = m.iter().all(|value| value.is_finite());
        finite.then_some(Self { origin, m })
    }

    #[inline(always)]
    pub(crate) fn apply_to_points(&self, [u, v]: &[Points; 2]) -> [Points; 2] {
        let (m, [x, y]) = (&self.m, self.origin);
        let w: Points = std::array::from_fn(|i| 1.0 / (m[6] * u[i] + m[7] * v[i] + 1.0));
        [
            std::array::from_fn(|i| x + (m[0] * u[i] + m[1] * v[i] + m[2]) * w[i]),
            std::array::from_fn(|i| y + (m[3] * u[i] + m[4] * v[i] + m[5]) * w[i]),
        ]
    }

    #[inline(always)]
    pub(crate) fn apply(&self, u: f32, v: f32) -> Point {
        self.apply_to_points(&[[u; POINTS], [v; POINTS]])
            .map(|points| points[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_squares_corners_land_on_the_quads() {
        let quad = [[102.0, 57.0], [161.5, 63.25], [150.0, 120.0], [98.0, 101.5]];
        let homography = Homography::square_to_quad(&quad).unwrap();
        for (corner, [u, v]) in
            quad.iter()
                .zip([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        {
            let mapped = homography.apply(u, v);
            assert!(
                (mapped[0] - corner[0]).abs() < 1e-4 && (mapped[1] - corner[1]).abs() < 1e-4,
                "{mapped:?} {corner:?}"
            );
        }
    }

    #[test]
    fn a_degenerate_quad_has_no_homography() {
        assert!(Homography::square_to_quad(&[[1.0, 1.0]; 4]).is_none());
    }
}
