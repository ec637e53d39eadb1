//! Lenses of models that are unknown here, by the lens of a known one that maps the same image.
//!
//! OpenCV's rational and thin-prism polynomial: `x_d = x (1 + k1 r2 + k2 r4 + k3 r6) / (1 + k4 r2 + k5 r4 + k6 r6) +
//! tangential + prism`. Rays over the whole image are projected by it, and a Brown-Conrady and a Kannala-Brandt lens
//! are fitted to the pixels by Gauss-Newton over all their parameters. The better one counts if it is nowhere further
//! off than [`MOST_PX`].

use nalgebra::{DMatrix, DVector, Point2};
use sextant_geometry::{Intrinsics, Lens};

/// Greatest deviation anywhere in the image, px: twice the standard deviation that a lens without a stated one has in
/// the corners ([`sextant_site_model::LensSigma::usual`]).
pub(super) const MOST_PX: f64 = 1.0;

/// Rays around the axis, and from the axis outwards.
const DIRECTIONS: usize = 48;
const STEPS: usize = 40;
/// Outermost ray, as the tangent of its angle: 80 degrees.
const MOST_RADIUS: f64 = 5.7;
const ITERATIONS: usize = 12;

/// k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4.
pub(super) struct Rational {
    pub(super) intrinsics: Intrinsics,
    pub(super) coefficients: [f64; 12],
}

/// A ray, as normalised point, and its pixel.
type Sample = (Point2<f64>, Point2<f64>);

impl Rational {
    fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4] = self.coefficients;
        let r2 = x * x + y * y;
        let radial =
            (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        let u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + r2 * s2);
        let v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + r2 * s4);
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        [fx * u + cx, fy * v + cy]
    }

    /// Rays from the axis outwards in each direction, up to the edge of the image or where the model folds over.
    fn samples(&self, [width, height]: [u32; 2]) -> Vec<Sample> {
        let Intrinsics { fx, fy, cx, cy } = self.intrinsics;
        let outermost = [cx, f64::from(width) - cx].map(|edge| edge.abs() / fx);
        let uppermost = [cy, f64::from(height) - cy].map(|edge| edge.abs() / fy);
        let corner = outermost[0]
            .max(outermost[1])
            .hypot(uppermost[0].max(uppermost[1]));
        // Barrel distortion brings rays from beyond into the image.
        let step = (3.0 * corner).min(MOST_RADIUS) / STEPS as f64;
        let mut samples = Vec::new();
        for direction in 0..DIRECTIONS {
            let (sin, cos) =
                (std::f64::consts::TAU * direction as f64 / DIRECTIONS as f64).sin_cos();
            let mut before = 0.0;
            for number in 1..=3 * STEPS {
                let radius = step * number as f64 / 3.0;
                let ray = [radius * cos, radius * sin];
                let [u, v] = self.pixel(ray);
                let distance = (u - cx).hypot(v - cy);
                let inside =
                    (-0.5..f64::from(width)).contains(&u) && (-0.5..f64::from(height)).contains(&v);
                // NaN is not inside.
                if !inside || distance <= before {
                    break;
                }
                before = distance;
                samples.push((ray.into(), [u, v].into()));
            }
        }
        samples
    }

    /// The known lens that is nearest to this one, and its greatest deviation in an image of this size, px.
    pub(super) fn nearest(&self, size: [u32; 2]) -> Option<(Lens, f64)> {
        let samples = self.samples(size);
        let start = [
            Lens::brown_conrady(self.intrinsics, [0.0; 5]),
            Lens::kannala_brandt(self.intrinsics, [0.0; 4]),
        ];
        let fitted = start
            .into_iter()
            .filter_map(|lens| fitted(lens.ok()?, &samples));
        fitted.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

fn fitted(mut lens: Lens, samples: &[Sample]) -> Option<(Lens, f64)> {
    for _ in 0..ITERATIONS {
        let n = lens.n_parameters();
        let mut rows = DMatrix::zeros(2 * samples.len(), n);
        let mut residuals = DVector::zeros(2 * samples.len());
        for (index, (ray, pixel)) in samples.iter().enumerate() {
            let by_parameters = lens.parameter_jacobian(&ray.to_homogeneous().into())?;
            let residual = pixel - lens.distort(ray)?;
            rows.view_mut((2 * index, 0), (2, n))
                .copy_from(&by_parameters.columns(0, n));
            residuals.rows_mut(2 * index, 2).copy_from(&residual);
        }
        let normal = rows.tr_mul(&rows);
        let step = normal.cholesky()?.solve(&rows.tr_mul(&residuals));
        let moved = DVector::from_vec(lens.parameters()) + step;
        lens = lens.with_parameters(moved.as_slice()).ok()?;
    }
    let off = samples
        .iter()
        .map(|(ray, pixel)| Some((lens.distort(ray)? - pixel).norm()));
    let worst = off
        .collect::<Option<Vec<f64>>>()?
        .into_iter()
        .fold(0.0, f64::max);
    worst.is_finite().then_some((lens, worst))
}
