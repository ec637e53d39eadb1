//! The best rigid motion between estimated and true poses, and the residual errors, from sums of constant size.
//!
//! A rig that is wrong as a whole is another world frame, which images cannot reveal. With imperfect files, poses are
//! therefore compared after the motion `estimated_from_true` = (R, t) that minimises `sum |p - R q - t|^2 / sp^2 +
//! sum |P - R Q|_F^2 / sr^2` over estimates (P, p) and truths (Q, q) (K. S. Arun, T. S. Huang, S. D. Blostein,
//! "Least-squares fitting of two 3-D point sets", 1987, with attitudes added).

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use sextant_geometry::Pose;

/// Typical error of a position, m, and of an attitude, rad: the weights of the two.
const SIGMAS: [f64; 2] = [1e-3, 8e-3];
/// Time constant of forgetting, ns.
const MEMORY_NS: f64 = 10e9;

/// Sums over pairs of an estimate and a truth, with forgetting.
#[derive(Debug, Clone, Default)]
pub struct PosePairs {
    newest_ns: u64,
    n: f64,
    estimates: Vector3<f64>,
    truths: Vector3<f64>,
    /// Sum of p q^T.
    products: Matrix3<f64>,
    /// Sums of |p|^2 and |q|^2.
    squares: [f64; 2],
    /// Sum of P Q^T.
    attitudes: Matrix3<f64>,
    /// Sums of the published variances, over three axes each.
    variances: [f64; 2],
}

/// Root mean squares over three axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rms {
    /// Distance of the origins, m.
    pub position_m: f64,
    /// Angle between the attitudes, rad.
    pub attitude_rad: f64,
}

impl PosePairs {
    /// Adds an estimate with its covariance (6x6, position before attitude) and the true pose at its capture time.
    pub fn add(&mut self, capture_ns: u64, estimate: &Pose, covariance: &[f64; 36], truth: &Pose) {
        if capture_ns > self.newest_ns {
            self.forget((capture_ns - self.newest_ns) as f64);
            self.newest_ns = capture_ns;
        }
        let (p, q) = (estimate.translation.vector, truth.translation.vector);
        self.n += 1.0;
        self.estimates += p;
        self.truths += q;
        self.products += p * q.transpose();
        self.squares[0] += p.norm_squared();
        self.squares[1] += q.norm_squared();
        let turn = estimate.rotation * truth.rotation.inverse();
        self.attitudes += turn.to_rotation_matrix().into_inner();
        for (sum, first) in self.variances.iter_mut().zip([0, 3]) {
            *sum += (first..first + 3)
                .map(|axis| covariance[7 * axis])
                .sum::<f64>();
        }
    }

    fn forget(&mut self, after_ns: f64) {
        let kept = (-after_ns / MEMORY_NS).exp();
        self.n *= kept;
        self.estimates *= kept;
        self.truths *= kept;
        self.products *= kept;
        self.attitudes *= kept;
        for sum in self.squares.iter_mut().chain(&mut self.variances) {
            *sum *= kept;
        }
    }

    /// The best motion from true to estimated poses; none without a pair.
    pub fn alignment<'a>(of: impl Iterator<Item = &'a Self>) -> Option<Pose> {
        let (mut n, mut estimates, mut truths) = (0.0, Vector3::zeros(), Vector3::zeros());
        let (mut products, mut attitudes) = (Matrix3::zeros(), Matrix3::zeros());
        for pairs in of {
            n += pairs.n;
            estimates += pairs.estimates;
            truths += pairs.truths;
            products += pairs.products;
            attitudes += pairs.attitudes;
        }
        if n == 0.0 {
            return None;
        }
        let spread = products - estimates * truths.transpose() / n;
        let [position, attitude] = SIGMAS.map(|sigma| 1.0 / (sigma * sigma));
        let svd = (spread * position + attitudes * attitude).svd(true, true);
        let (u, v_t) = (svd.u?, svd.v_t?);
        let mirror = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
        let rotation = Rotation3::from_matrix_unchecked(u * Matrix3::from_diagonal(&mirror) * v_t);
        let shift = (estimates - rotation * truths) / n;
        Some(Pose::from_parts(
            Translation3::from(shift),
            UnitQuaternion::from_rotation_matrix(&rotation),
        ))
    }

    /// Errors that remain after a motion; none without a pair.
    pub fn errors(&self, estimated_from_true: &Pose) -> Option<Rms> {
        let rotation = estimated_from_true.rotation.to_rotation_matrix();
        let shift = estimated_from_true.translation.vector;
        let turned = rotation * self.truths;
        let crossed = (rotation.matrix().transpose() * self.products).trace();
        let square = self.squares[0] + self.squares[1] - 2.0 * crossed
            + self.n * shift.norm_squared()
            - 2.0 * shift.dot(&(self.estimates - turned));
        // The trace of a rotation by an angle a is 3 - 2 (1 - cos a), about 3 - a^2.
        let turn = 3.0 * self.n - (rotation.matrix().transpose() * self.attitudes).trace();
        self.rms([square, turn])
    }

    /// Errors predicted by the published covariances; none without a pair.
    pub fn sigmas(&self) -> Option<Rms> {
        self.rms(self.variances)
    }

    fn rms(&self, [position, attitude]: [f64; 2]) -> Option<Rms> {
        let root = |sum: f64| (sum.max(0.0) / self.n).sqrt();
        (self.n > 0.0).then(|| Rms {
            position_m: root(position),
            attitude_rad: root(attitude),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_simulator::{Random, Scenario};

    /// Pairs whose estimates are displaced as a whole, with noise of 1 mm and 5 mrad per axis.
    fn pairs(displacement: &Pose) -> PosePairs {
        let object = &Scenario::demo(1, 1, 1).objects[0];
        let mut random = Random::new(3);
        let mut covariance = [0.0; 36];
        (0..3).for_each(|axis| covariance[7 * axis] = 1e-6);
        (3..6).for_each(|axis| covariance[7 * axis] = 25e-6);
        let mut pairs = PosePairs::default();
        for i in 0..2000 {
            let capture_ns = i * 5_000_000;
            let truth = object.world_from_object(capture_ns);
            let mut noise = |sigma: f64| Vector3::from_fn(|_, _| random.normal() * sigma);
            let mut estimate = displacement * truth;
            estimate.translation.vector += noise(1e-3);
            estimate.rotation = UnitQuaternion::from_scaled_axis(noise(5e-3)) * estimate.rotation;
            pairs.add(capture_ns, &estimate, &covariance, &truth);
        }
        pairs
    }

    #[test]
    fn a_displaced_world_is_found_and_leaves_the_noise() {
        let displacement = Pose::new(Vector3::new(0.1, -0.2, 0.3), Vector3::new(0.3, 0.2, -0.4));
        let pairs = pairs(&displacement);
        let alignment = PosePairs::alignment([&pairs].into_iter()).unwrap();
        let off = alignment.inverse() * displacement;
        assert!(off.translation.vector.norm() < 5e-4 && off.rotation.angle() < 1e-3);
        let (errors, sigmas) = (pairs.errors(&alignment).unwrap(), pairs.sigmas().unwrap());
        assert!(
            (errors.position_m / 3f64.sqrt() - 1e-3).abs() < 5e-5,
            "{errors:?}"
        );
        assert!(
            (errors.attitude_rad / 3f64.sqrt() - 5e-3).abs() < 3e-4,
            "{errors:?}"
        );
        assert!((errors.position_m / sigmas.position_m - 1.0).abs() < 0.05);
        assert!((errors.attitude_rad / sigmas.attitude_rad - 1.0).abs() < 0.05);
    }

    #[test]
    fn without_a_motion_the_whole_displacement_is_error() {
        let pairs = pairs(&Pose::translation(0.1, 0.0, 0.0));
        let errors = pairs.errors(&Pose::identity()).unwrap();
        assert!((errors.position_m - 0.1).abs() < 1e-4);
        assert_eq!(PosePairs::alignment(std::iter::empty()), None);
    }

    #[test]
    fn what_is_long_past_counts_no_more() {
        let mut pairs = pairs(&Pose::translation(0.1, 0.0, 0.0));
        let truth = Pose::identity();
        for i in 0..3000 {
            let capture_ns = 10_000_000_000 + i * 33_000_000;
            pairs.add(capture_ns, &truth, &[0.0; 36], &truth);
        }
        let errors = pairs.errors(&Pose::identity()).unwrap();
        assert!(errors.position_m < 2e-3, "{errors:?}");
    }
}
