//! A start from poses alone: base and hand from pairs of a robot's pose and what an image shows.
//!
//! For a given attitude of the carried frame on the hand, the base's attitude is a mean of rotations and both positions
//! solve linear equations, so that starts from the rotations of a cube, refined by [`minimise`], need no motion of any
//! kind: what the motions leave undetermined keeps the value of least norm. The classical closed forms (M. Shah,
//! Solving the robot-world/hand-eye calibration problem using the Kronecker product, 2013) fail where all rotations
//! have one axis, and on a single wrong pose.

use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Rotation3, SMatrix, SVector, Vector3, Vector6};
use sextant_adjustment::HandError;
use sextant_geometry::least_squares::{Kernel, NormalEquations, Options, Problem, minimise};
use sextant_geometry::{Pose, se3};
use std::f64::consts::FRAC_PI_2;

/// A pose of the hand, and the poses of the carried frame in the site that an image allows, best first.
pub(super) struct PosePair {
    pub base_from_hand: Pose,
    pub site_from_carried: Vec<Pose>,
}

/// The two transforms of a robot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transforms {
    pub base_from_site: Pose,
    pub hand_from_carried: Pose,
}

/// Most pairs; more cost time and add nothing to a start.
const MOST_PAIRS: usize = 100;
/// Coarse standard deviations of a pair, m and rad: of a robot and an image that are both poor.
const SIGMA: [f64; 2] = [0.01, 0.02];
/// Relative singular value of the linear equations below which a direction is undetermined.
const RANK: f64 = 1e-6;

/// The transforms that most pairs agree on; `None` without a pair.
pub(super) fn start(pairs: &[PosePair]) -> Option<Transforms> {
    let every = pairs.len().div_ceil(MOST_PAIRS).max(1);
    let pairs: Vec<&PosePair> = pairs.iter().step_by(every).collect();
    let problem = PairProblem { pairs };
    let options = Options {
        initial_damping: 1e-3,
        max_iterations: 50,
        tolerance: 1e-3,
    };
    let solutions = cube_rotations().filter_map(|hand_from_carried| {
        let first = problem.for_attitude(&hand_from_carried)?;
        minimise(&problem, first, &options).ok()
    });
    let best = solutions.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    Some(best.state)
}

/// The 24 rotations of a cube: none is further than 62.8 degrees from one of them.
fn cube_rotations() -> impl Iterator<Item = Rotation3<f64>> {
    let quarter = |n: i32| f64::from(n) * FRAC_PI_2;
    let faces = [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (0, 3)];
    faces.into_iter().flat_map(move |(x, y)| {
        (0..4).map(move |z| {
            Rotation3::from_euler_angles(quarter(x), quarter(y), 0.0)
                * Rotation3::from_euler_angles(0.0, 0.0, quarter(z))
        })
    })
}

struct PairProblem<'a> {
    pairs: Vec<&'a PosePair>,
}

impl PairProblem<'_> {
    /// The best transforms with this attitude on the hand, each pair with the first of its poses.
    fn for_attitude(&self, hand_from_carried: &Rotation3<f64>) -> Option<Transforms> {
        let pairs = || {
            let pairs = self.pairs.iter();
            pairs.filter_map(|pair| Some((&pair.base_from_hand, pair.site_from_carried.first()?)))
        };
        let sum: Matrix3<f64> = pairs()
            .map(|(hand, carried)| {
                let seen = hand.rotation.to_rotation_matrix() * hand_from_carried;
                (seen * carried.rotation.to_rotation_matrix().inverse()).into_inner()
            })
            .sum();
        let base_from_site = nearest_rotation(&sum)?;
        // R_B t_H - t_P = R_P t_M - t_B (M. Shah 2013, eq. 12).
        let n = pairs().count();
        let (mut left, mut right) = (DMatrix::zeros(3 * n, 6), DVector::zeros(3 * n));
        for (at, (hand, carried)) in pairs().enumerate() {
            let turn = hand.rotation.to_rotation_matrix();
            left.fixed_view_mut::<3, 3>(3 * at, 0)
                .copy_from(turn.matrix());
            left.fixed_view_mut::<3, 3>(3 * at, 3)
                .copy_from(&-Matrix3::identity());
            let shift = base_from_site * carried.translation.vector - hand.translation.vector;
            right.fixed_rows_mut::<3>(3 * at).copy_from(&shift);
        }
        let svd = left.svd(true, true);
        let shifts = svd.solve(&right, RANK * svd.singular_values.max()).ok()?;
        let pose = |at: usize, rotation: &Rotation3<f64>| {
            let shift = shifts.fixed_rows::<3>(at).into_owned();
            Pose::from_parts(shift.into(), (*rotation).into())
        };
        Some(Transforms {
            base_from_site: pose(3, &base_from_site),
            hand_from_carried: pose(0, hand_from_carried),
        })
    }
}

/// The rotation nearest to a sum of rotations (M. Moakher, Means and averaging in the group of rotations, 2002, section
/// 3.1).
fn nearest_rotation(sum: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    let svd = sum.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mirror = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    let nearest = u * Matrix3::from_diagonal(&mirror) * v_t;
    Some(Rotation3::from_matrix_unchecked(nearest))
}

impl Problem<12> for PairProblem<'_> {
    type State = Transforms;

    fn linearise(&self, state: &Transforms, equations: &mut NormalEquations<12>) -> Option<()> {
        let [p, r] = SIGMA.map(|sigma| f64::powi(sigma, -2));
        let information = Matrix6::from_diagonal(&Vector6::new(p, p, p, r, r, r));
        for pair in &self.pairs {
            let errors = pair.site_from_carried.iter().map(|carried| {
                HandError::new(
                    &pair.base_from_hand,
                    &state.base_from_site,
                    carried,
                    &state.hand_from_carried,
                )
            });
            let square = |found: &HandError| found.error.dot(&(information * found.error));
            let best = errors.min_by(|a, b| square(a).total_cmp(&square(b)));
            let Some(best) = best else { continue };
            let mut by_step = SMatrix::<f64, 6, 12>::zeros();
            by_step.fixed_columns_mut::<6>(0).copy_from(&best.by_base);
            by_step.fixed_columns_mut::<6>(6).copy_from(&best.by_hand);
            let kernel = Kernel::CauchyTails { width: 3.0 };
            equations.add(&best.error, &by_step, &information, kernel);
        }
        Some(())
    }

    fn step(&self, state: &Transforms, step: &SVector<f64, 12>) -> Transforms {
        let moved =
            |pose: &Pose, at: usize| se3::perturb(pose, &step.fixed_rows::<6>(at).into_owned());
        Transforms {
            base_from_site: moved(&state.base_from_site, 0),
            hand_from_carried: moved(&state.hand_from_carried, 6),
        }
    }
}
