//! Motion model between instants: a constant twist with white noise acceleration.
//!
//! Between instants `dt` apart, `e = (log(T_k^-1 T_k+1) - dt x_k, x_k+1 - x_k)` with the twists `x` in the object's
//! axes has the information `[12/dt^3 -6/dt^2; -6/dt^2 4/dt] / q^2` (T. Barfoot, State Estimation for Robotics, 2017,
//! section 3.4).

use super::node::Node;
use super::state::{Bundle, Instant, Motion};
use nalgebra::{Matrix6, SMatrix, SVector, Vector6};
use sextant_geometry::se3;

/// Prior standard deviation of velocity, m/s, and angular velocity, rad/s, which bounds the twist of an isolated
/// instant.
const FASTEST: f64 = 10.0;

/// A matrix over (pose, twist) of an instant.
type TieMatrix = SMatrix<f64, 12, 12>;

/// Residual between two instants, its information, and its derivatives with respect to the earlier and the later
/// instant.
struct Tie {
    error: SVector<f64, 12>,
    information: TieMatrix,
    by_earlier: TieMatrix,
    by_later: TieMatrix,
}

/// Adds the residuals of the motion model to the nodes and returns the sum of their squares; zero without a motion
/// model.
pub(super) fn tie<const D: usize>(bundle: &Bundle, nodes: &mut [Node<D>]) -> f64 {
    let Some(motion) = bundle.motion.filter(|_| D == 12) else {
        return 0.0;
    };
    for (node, instant) in nodes.iter_mut().zip(&bundle.instants) {
        for axis in 0..6 {
            node.own[(6 + axis, 6 + axis)] += FASTEST.powi(-2);
            node.gradient[6 + axis] += instant.twist[axis] * FASTEST.powi(-2);
        }
    }
    for (at, pair) in bundle.instants.windows(2).enumerate() {
        let Some(tie) = Tie::between(&pair[0], &pair[1], &motion) else {
            continue;
        };
        let earlier: SMatrix<f64, D, D> = resized(&tie.by_earlier);
        let later: SMatrix<f64, D, D> = resized(&tie.by_later);
        let weighted: SMatrix<f64, D, D> = resized(&tie.information);
        let pull: SVector<f64, D> = resized_column(&tie);
        nodes[at].own += earlier.transpose() * weighted * earlier;
        nodes[at].gradient += earlier.transpose() * pull;
        nodes[at].next = Some(earlier.transpose() * weighted * later);
        nodes[at + 1].own += later.transpose() * weighted * later;
        nodes[at + 1].gradient += later.transpose() * pull;
    }
    rho(bundle)
}

/// Sum of the squares of all residuals of the motion model.
pub(super) fn rho(bundle: &Bundle) -> f64 {
    let Some(motion) = bundle.motion else {
        return 0.0;
    };
    let ties = bundle.instants.windows(2).filter_map(|pair| {
        let tie = Tie::between(&pair[0], &pair[1], &motion)?;
        Some(tie.error.dot(&(tie.information * tie.error)))
    });
    let twists = bundle.instants.iter().map(|i| i.twist.norm_squared());
    ties.sum::<f64>() + twists.sum::<f64>() * FASTEST.powi(-2)
}

/// Logarithm of the determinant of the information of the motion model: what normalises its residuals.
pub(super) fn log_prior(bundle: &Bundle) -> f64 {
    let Some(motion) = bundle.motion else {
        return 0.0;
    };
    let densities = [motion.acceleration, motion.angular_acceleration];
    let ties = bundle.instants.windows(2).filter_map(|pair| {
        let dt = pair[1].seconds - pair[0].seconds;
        // Of each axis it is 12 / dt^4 / q^4.
        let of_axis = |q: f64| 12.0_f64.ln() - 4.0 * (dt.ln() + q.ln());
        let of_axes = densities.into_iter().map(|q| 3.0 * of_axis(q));
        (dt <= motion.longest_gap_s).then(|| of_axes.sum::<f64>())
    });
    ties.sum::<f64>() - 12.0 * FASTEST.ln() * bundle.instants.len() as f64
}

impl Tie {
    fn between(earlier: &Instant, later: &Instant, motion: &Motion) -> Option<Self> {
        let dt = later.seconds - earlier.seconds;
        if dt > motion.longest_gap_s {
            return None;
        }
        let way = se3::log(&(earlier.world_from_object.inverse() * later.world_from_object));
        let mut error = SVector::<f64, 12>::zeros();
        error
            .fixed_rows_mut::<6>(0)
            .copy_from(&(way - earlier.twist * dt));
        error
            .fixed_rows_mut::<6>(6)
            .copy_from(&(later.twist - earlier.twist));
        let (mut by_earlier, mut by_later) = (TieMatrix::zeros(), TieMatrix::zeros());
        let mut block = by_earlier.fixed_view_mut::<6, 6>(0, 0);
        block.copy_from(&-se3::left_jacobian_inverse(&way));
        let mut block = by_later.fixed_view_mut::<6, 6>(0, 0);
        // The right Jacobian is the left one of the inverse motion.
        block.copy_from(&se3::left_jacobian_inverse(&-way));
        for axis in 0..6 {
            by_earlier[(axis, 6 + axis)] = -dt;
            by_earlier[(6 + axis, 6 + axis)] = -1.0;
            by_later[(6 + axis, 6 + axis)] = 1.0;
        }
        Some(Self {
            error,
            information: information(dt, motion),
            by_earlier,
            by_later,
        })
    }
}

fn information(dt: f64, motion: &Motion) -> TieMatrix {
    let (a, w) = (motion.acceleration, motion.angular_acceleration);
    let weights = Vector6::new(a, a, a, w, w, w).map(|q| q.powi(-2));
    let weights = Matrix6::from_diagonal(&weights);
    let mut whole = TieMatrix::zeros();
    let mut put = |row: usize, column: usize, factor: f64| {
        let mut block = whole.fixed_view_mut::<6, 6>(row, column);
        block.copy_from(&(weights * factor));
    };
    put(0, 0, 12.0 / dt.powi(3));
    put(0, 6, -6.0 / dt.powi(2));
    put(6, 0, -6.0 / dt.powi(2));
    put(6, 6, 4.0 / dt);
    whole
}

/// The matrix with `D` columns; the compiler cannot know that `D` is 12 here.
fn resized<const D: usize>(whole: &TieMatrix) -> SMatrix<f64, D, D> {
    SMatrix::from_fn(|row, column| whole[(row, column)])
}

fn resized_column<const D: usize>(tie: &Tie) -> SVector<f64, D> {
    let pull = tie.information * tie.error;
    SVector::from_fn(|row, _| pull[row])
}
