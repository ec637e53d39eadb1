//! The projective map between a tag's modules and the image, in single precision.
//!
//! `sextant-geometry` has the double-precision one; here thousands of points an image are mapped, also on processors
//! whose double-precision arithmetic is slow.

use crate::kernels::Points;
use crate::quad::{Point, Quad};

/// Maps modules (u right, v down, (0, 0) at the top left corner of the border) to pixels.
///
/// pixel = origin + (m0 u + m1 v + m2, m3 u + m4 v + m5) / (m6 u + m7 v + 1); the origin, a corner, keeps the numbers small.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Homography {
    pub(crate) origin: Point,
    pub(crate) m: [f32; 8],
}

impl Homography {
    /// Maps the corners of a square of `modules` to a quad (Heckbert, Fundamentals of Texture Mapping, 1989, section 2.2.3).
    pub(crate) fn square_to_quad(quad: &Quad, modules: f32) -> Option<Self> {
        let origin = quad[0];
        let [_, b, c, d] = quad.map(|corner| [corner[0] - origin[0], corner[1] - origin[1]]);
        let (right, below) = ([b[0] - c[0], b[1] - c[1]], [d[0] - c[0], d[1] - c[1]]);
        let sum = [c[0] - b[0] - d[0], c[1] - b[1] - d[1]];
        let determinant = right[0] * below[1] - below[0] * right[1];
        let g = (sum[0] * below[1] - below[0] * sum[1]) / determinant;
        let h = (right[0] * sum[1] - sum[0] * right[1]) / determinant;
        let scale = 1.0 / modules;
        let [bx, by] = [0, 1].map(|axis| b[axis] * (1.0 + g) * scale);
        let [dx, dy] = [0, 1].map(|axis| d[axis] * (1.0 + h) * scale);
        let m = [bx, dx, 0.0, by, dy, 0.0, g * scale, h * scale];
        let finite = m.iter().all(|value| value.is_finite());
        finite.then_some(Self { origin, m })
    }

    /// Maps the corners of the square -1..1 to a quad, with the square's middle as the origin.
    pub(crate) fn centred_square_to_quad(quad: &Quad) -> Option<Self> {
        let Self {
            origin: corner,
            m: [a, b, _, d, e, _, g, h],
        } = Self::square_to_quad(quad, 2.0)?;
        // With u = u' + 1 and v = v' + 1 the denominator is g u' + h v' + (g + h + 1).
        let scale = 1.0 / (g + h + 1.0);
        let middle = [(a + b) * scale, (d + e) * scale];
        let (g, h) = (g * scale, h * scale);
        let (a, b) = (a * scale - middle[0] * g, b * scale - middle[0] * h);
        let (d, e) = (d * scale - middle[1] * g, e * scale - middle[1] * h);
        let m = [a, b, 0.0, d, e, 0.0, g, h];
        let origin = [corner[0] + middle[0], corner[1] + middle[1]];
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

    #[inline]
    pub(crate) fn apply(&self, u: f32, v: f32) -> Point {
        let m = &self.m;
        let w = 1.0 / (m[6] * u + m[7] * v + 1.0);
        [
            self.origin[0] + (m[0] * u + m[1] * v + m[2]) * w,
            self.origin[1] + (m[3] * u + m[4] * v + m[5]) * w,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_squares_corners_land_on_the_quads() {
        let quad = [[102.0, 57.0], [161.5, 63.25], [150.0, 120.0], [98.0, 101.5]];
        let homography = Homography::square_to_quad(&quad, 8.0).unwrap();
        for (corner, [u, v]) in quad
            .iter()
            .zip([[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]])
        {
            let mapped = homography.apply(u, v);
            assert!(
                (mapped[0] - corner[0]).abs() < 1e-4 && (mapped[1] - corner[1]).abs() < 1e-4,
                "{mapped:?} {corner:?}"
            );
        }
    }

    #[test]
    fn the_centred_squares_corners_land_on_the_quads() {
        let quad = [[102.0, 57.0], [161.5, 63.25], [150.0, 120.0], [98.0, 101.5]];
        let homography = Homography::centred_square_to_quad(&quad).unwrap();
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
        assert!(Homography::square_to_quad(&[[1.0, 1.0]; 4], 8.0).is_none());
    }
}
