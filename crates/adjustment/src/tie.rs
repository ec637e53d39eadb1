//! The motion of a body between two instants: a constant twist disturbed by white acceleration.
//!
//! With `e = x(k+1) - predict(x(k))` at the present values and `w ~ N(0, 1)` the noise, a step obeys
//!
//! ```text
//! dx(k+1) + e = F dx(k) + C w,   C C' = Q = q [dt^3/3, dt^2/2; dt^2/2, dt] of each axis
//! ```
//!
//! (Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, section
//! 6.2). Neither has an inverse power of `dt`, so that instants may be as close as they like. Attitudes are compared by
//! `log(R(k+1) R_predicted')`, whose Jacobians `J_l^-1(e)` and `J_r^-1(e)` are moved to the right side: `J_l(e)
//! J_r^-1(e) = exp(e)`.

use crate::values::{Bundle, Instant, Motion};
use nalgebra::{Dim, Matrix, Matrix3, RawStorageMut, SVector, Vector3};
use sextant_geometry::{se3, so3};

/// Prior standard deviation of velocity, m/s, and angular velocity, rad/s, which bounds the twist of an isolated
/// instant.
pub(crate) const FASTEST: f64 = 10.0;

/// Instants closer than this count as this far apart where steps are damped, s.
const LEAST_STIFF_S: f64 = 1e-3;

/// What ties an instant to the next one of its body.
#[derive(Clone, Debug)]
pub(crate) struct Tie {
    dt: f64,
    /// Derivatives of the later attitude by the earlier one and by the angular velocity.
    by_attitude: Matrix3<f64>,
    by_rate: Matrix3<f64>,
    /// By the noise of the attitude.
    by_noise: Matrix3<f64>,
    /// Roots of the power densities.
    acceleration: f64,
    angular_acceleration: f64,
    /// Of the values: the later instant less the predicted one.
    pub error: Vector12,
}

/// Over (position, attitude, velocity, angular velocity).
pub(crate) type Vector12 = SVector<f64, 12>;

impl Tie {
    /// The tie of two instants in a row; `None` where they are of two bodies or too far apart.
    pub(crate) fn between(earlier: &Instant, later: &Instant, motion: &Motion) -> Option<Self> {
        let dt = later.seconds - earlier.seconds;
        if earlier.body != later.body || dt > motion.longest_gap_s {
            return None;
        }
        let predicted = earlier.after(dt);
        let mut error = Vector12::zeros();
        let pose = se3::difference(&later.world_from_object, &predicted.world_from_object);
        error.fixed_rows_mut::<6>(0).copy_from(&pose);
        error
            .fixed_rows_mut::<6>(6)
            .copy_from(&(later.twist - earlier.twist));
        let turn: Vector3<f64> = earlier.twist.fixed_rows::<3>(3) * dt;
        let off: Vector3<f64> = pose.fixed_rows::<3>(3).into_owned();
        let rotation = |w: &Vector3<f64>| so3::exp(w).to_rotation_matrix().into_inner();
        Some(Self {
            dt,
            by_attitude: rotation(&off) * rotation(&turn),
            by_rate: rotation(&off) * so3::left_jacobian(&turn) * dt,
            by_noise: so3::left_jacobian(&off),
            acceleration: motion.acceleration,
            angular_acceleration: motion.angular_acceleration,
            error,
        })
    }

    /// Squared error in units of its covariance.
    pub(crate) fn square(&self) -> f64 {
        self.noise().norm_squared()
    }

    /// The noise that explains the error: `C^-1 e`. Zero where the instants are of one time.
    pub(crate) fn noise(&self) -> Vector12 {
        let e = |at: usize| self.error.fixed_rows::<3>(at).into_owned();
        let mut noise = Vector12::zeros();
        for (first, density) in [(0, self.acceleration), (3, self.angular_acceleration)] {
            let [c11, c21, c22] = factors(self.dt, density);
            if c11 > 0.0 {
                // The error of the attitude is that of the logarithm, where C has no Jacobian.
                let of_place = e(first) / c11;
                noise.fixed_rows_mut::<3>(first).copy_from(&of_place);
                let of_rate = (e(first + 6) - of_place * c21) / c22;
                noise.fixed_rows_mut::<3>(first + 6).copy_from(&of_rate);
            }
        }
        noise
    }

    /// `F^-T X`, in place.
    pub(crate) fn pull_back<R, C, S>(&self, x: &mut Matrix<f64, R, C, S>)
    where
        R: Dim,
        C: Dim,
        S: RawStorageMut<f64, R, C>,
    {
        for mut column in x.column_iter_mut() {
            let part = |at: usize| Vector3::from_fn(|n, _| column[at + n]);
            let (place, turn) = (part(0), self.by_attitude * part(3));
            let by_velocity = part(6) - place * self.dt;
            let by_rate = part(9) - self.by_rate.tr_mul(&turn);
            for n in 0..3 {
                column[3 + n] = turn[n];
                column[6 + n] = by_velocity[n];
                column[9 + n] = by_rate[n];
            }
        }
    }

    /// `F^-1 x`.
    pub(crate) fn earlier<const D: usize>(&self, x: &SVector<f64, D>) -> SVector<f64, D> {
        let part = |at: usize| Vector3::from_fn(|n, _| x[at + n]);
        let place = part(0) - part(6) * self.dt;
        let turn = self.by_attitude.tr_mul(&(part(3) - self.by_rate * part(9)));
        let mut earlier = *x;
        for n in 0..3 {
            earlier[n] = place[n];
            earlier[3 + n] = turn[n];
        }
        earlier
    }

    /// `C w`.
    pub(crate) fn noisy<const D: usize>(&self, w: &SVector<f64, D>) -> SVector<f64, D> {
        let part = |at: usize| Vector3::from_fn(|n, _| w[at + n]);
        let [a11, a21, a22] = factors(self.dt, self.acceleration);
        let [w11, w21, w22] = factors(self.dt, self.angular_acceleration);
        let parts = [
            part(0) * a11,
            self.by_noise * part(3) * w11,
            part(0) * a21 + part(6) * a22,
            part(3) * w21 + part(9) * w22,
        ];
        SVector::from_fn(|row, _| parts.get(row / 3).map_or(0.0, |part| part[row % 3]))
    }

    /// `C' X`, in place.
    pub(crate) fn by_noise<R, C, S>(&self, x: &mut Matrix<f64, R, C, S>)
    where
        R: Dim,
        C: Dim,
        S: RawStorageMut<f64, R, C>,
    {
        let [a11, a21, a22] = factors(self.dt, self.acceleration);
        let [w11, w21, w22] = factors(self.dt, self.angular_acceleration);
        for mut column in x.column_iter_mut() {
            let part = |at: usize| Vector3::from_fn(|n, _| column[at + n]);
            let (velocity, rate) = (part(6), part(9));
            let place = part(0) * a11 + velocity * a21;
            let turn = self.by_noise.tr_mul(&part(3)) * w11 + rate * w21;
            for n in 0..3 {
                column[n] = place[n];
                column[3 + n] = turn[n];
                column[6 + n] = velocity[n] * a22;
                column[9 + n] = rate[n] * w22;
            }
        }
    }

    /// The diagonal of its information about one of its instants, were the other one known: `12 / (q dt^3)` of a pose
    /// and `4 / (q dt)` of a twist. Of instants that are almost one it is bounded.
    pub(crate) fn stiffness<const D: usize>(&self) -> SVector<f64, D> {
        let dt = self.dt.max(LEAST_STIFF_S);
        SVector::from_fn(|row, _| {
            let density = match row % 6 {
                0..3 => self.acceleration,
                _ => self.angular_acceleration,
            };
            match row {
                0..6 => 12.0 / (density.powi(2) * dt.powi(3)),
                6..12 => 4.0 / (density.powi(2) * dt),
                _ => 0.0,
            }
        })
    }

    /// The error with as many rows as an instant has.
    pub(crate) fn error_of<const D: usize>(&self) -> SVector<f64, D> {
        SVector::from_fn(|row, _| self.error.get(row).copied().unwrap_or(0.0))
    }
}

/// `[c11, c21, c22]` of the lower triangle C with `C C' = q^2 [dt^3/3, dt^2/2; dt^2/2, dt]`.
fn factors(dt: f64, density: f64) -> [f64; 3] {
    let root = density * dt.sqrt();
    [
        root * dt / 3.0_f64.sqrt(),
        root * 0.75_f64.sqrt(),
        0.5 * root,
    ]
}

/// Sum of the squares of all residuals of the motion model.
pub(crate) fn rho(bundle: &Bundle) -> f64 {
    let Some(motion) = bundle.motion else {
        return 0.0;
    };
    let ties = bundle
        .instants
        .windows(2)
        .filter_map(|pair| Some(Tie::between(&pair[0], &pair[1], &motion)?.square()));
    let twists = bundle.instants.iter().map(|i| i.twist.norm_squared());
    ties.sum::<f64>() + twists.sum::<f64>() * FASTEST.powi(-2)
}

/// Logarithm of the determinant of the information of the priors of all twists.
pub(crate) fn log_prior(bundle: &Bundle) -> f64 {
    if bundle.motion.is_none() {
        return 0.0;
    }
    -12.0 * FASTEST.ln() * bundle.instants.len() as f64
}
