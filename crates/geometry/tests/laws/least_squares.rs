//! The laws of the minimiser.

use crate::generators::{pose, vector};
use nalgebra::{Matrix3, Matrix3x6, Point3, SMatrix, SVector, Vector1, Vector2, Vector3, Vector6};
use proptest::prelude::*;
use sextant_geometry::least_squares::{
    Kernel, LeastSquaresError, NormalEquations, Options, Problem, Termination, minimise,
};
use sextant_geometry::{Pose, se3, so3};

/// Aligns two sets of points: the manifold problem with a closed answer.
struct Alignment {
    points: Vec<Point3<f64>>,
    seen: Vec<Point3<f64>>,
    information: Matrix3<f64>,
    kernel: Kernel,
}

impl Problem<6> for Alignment {
    type State = Pose;

    fn linearise(&self, pose: &Pose, equations: &mut NormalEquations<6>) -> Option<()> {
        for (point, seen) in self.points.iter().zip(&self.seen) {
            let arm = pose.rotation * point.coords;
            let mut jacobian = Matrix3x6::identity();
            jacobian
                .fixed_view_mut::<3, 3>(0, 3)
                .copy_from(&-so3::hat(&arm));
            equations.add(
                &(pose * point - seen),
                &jacobian,
                &self.information,
                self.kernel,
            );
        }
        Some(())
    }

    fn step(&self, pose: &Pose, step: &Vector6<f64>) -> Pose {
        se3::perturb(pose, step)
    }
}

fn alignment(truth: &Pose, kernel: Kernel) -> Alignment {
    let points: Vec<_> = (0..8)
        .map(|i| Point3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64))
        .collect();
    let seen = points.iter().map(|point| truth * point).collect();
    Alignment {
        points,
        seen,
        information: Matrix3::identity() * 100.0,
        kernel,
    }
}

fn patient() -> Options {
    Options {
        max_iterations: 200,
        ..Options::default()
    }
}

proptest! {
    #[test]
    fn a_pose_is_found_from_far_away(truth in pose(), step in vector::<6>(1.0)) {
        let start = se3::perturb(&truth, &step);
        let solution = minimise(&alignment(&truth, Kernel::Quadratic), start, &patient()).unwrap();
        prop_assert_eq!(solution.outcome, Termination::Converged);
        prop_assert!(se3::difference(&solution.state, &truth).norm() < 1e-9);
    }

    #[test]
    fn the_gradient_is_the_derivative_of_the_cost(truth in pose(), step in vector::<6>(0.5)) {
        for kernel in [Kernel::Quadratic, Kernel::Huber { width: 3.0 }, Kernel::CauchyTails { width: 3.0 }] {
            let problem = alignment(&truth, kernel);
            let at = se3::perturb(&truth, &step);
            let equations = |pose: &Pose| {
                let mut equations = NormalEquations::default();
                problem.linearise(pose, &mut equations).unwrap();
                equations
            };
            let analytic = equations(&at).gradient().transpose();
            let numeric = crate::numeric::jacobian_at_zero(|d: &Vector6<f64>| {
                Vector1::new(equations(&se3::perturb(&at, d)).cost())
            });
            prop_assert!((analytic - numeric).amax() < 1e-6 * (1.0 + analytic.amax()), "{:?}", kernel);
        }
    }
}

#[test]
fn the_covariance_is_that_of_the_mean_of_the_points() {
    // Eight points with sigma 0.1: the mean, which fixes the position of their centroid, has sigma 0.1 / sqrt(8).
    let centred = {
        let mut problem = alignment(&Pose::identity(), Kernel::Quadratic);
        for point in problem.points.iter_mut().chain(&mut problem.seen) {
            *point -= Vector3::repeat(0.5);
        }
        problem
    };
    let solution = minimise(&centred, Pose::identity(), &Options::default()).unwrap();
    let covariance = solution.covariance().unwrap();
    assert!((covariance[(0, 0)] - 0.01 / 8.0).abs() < 1e-12);
    assert!(covariance[(0, 1)].abs() < 1e-12);
}

#[test]
fn robust_kernels_ignore_an_outlier() {
    let truth = Pose::translation(1.0, 2.0, 3.0);
    let off = |kernel| {
        let mut problem = alignment(&truth, kernel);
        problem.seen[3] += Vector3::new(0.0, 5.0, 0.0);
        let solution = minimise(&problem, truth, &patient()).unwrap();
        se3::difference(&solution.state, &truth).norm()
    };
    assert!(off(Kernel::Quadratic) > 0.5);
    assert!(off(Kernel::Huber { width: 1.5 }) < 0.1);
    assert!(off(Kernel::CauchyTails { width: 1.5 }) < 0.01);
}

#[test]
fn what_is_not_determined_stays_and_has_no_covariance() {
    // All points at the origin say nothing about attitude.
    let mut problem = alignment(&Pose::identity(), Kernel::Quadratic);
    problem.points.fill(Point3::origin());
    problem.seen.fill(Point3::new(1.0, 0.0, 0.0));
    let start = se3::exp(&Vector6::new(0.0, 0.0, 0.0, 0.1, 0.2, 0.3));
    let solution = minimise(&problem, start, &patient()).unwrap();
    assert!((solution.state.translation.vector - Vector3::x()).norm() < 1e-9);
    assert!(solution.state.rotation.angle_to(&start.rotation) < 1e-12);
    assert_eq!(solution.covariance(), None);
}

/// H. Rosenbrock, 1960: the curved valley.
struct Rosenbrock;

impl Problem<2> for Rosenbrock {
    type State = Vector2<f64>;

    fn linearise(&self, at: &Vector2<f64>, equations: &mut NormalEquations<2>) -> Option<()> {
        let residual = Vector2::new(1.0 - at.x, 10.0 * (at.y - at.x * at.x));
        let jacobian = SMatrix::<f64, 2, 2>::new(-1.0, 0.0, -20.0 * at.x, 10.0);
        equations.add_unweighted(&residual, &jacobian);
        Some(())
    }

    fn step(&self, at: &Vector2<f64>, step: &Vector2<f64>) -> Vector2<f64> {
        at + step
    }
}

#[test]
fn the_curved_valley_is_walked_to_its_end() {
    let solution = minimise(&Rosenbrock, Vector2::new(-1.2, 1.0), &patient()).unwrap();
    assert_eq!(solution.outcome, Termination::Converged);
    assert!((solution.state - Vector2::new(1.0, 1.0)).norm() < 1e-9);
    assert!(solution.iterations < 50, "{}", solution.iterations);
}

#[test]
fn running_out_of_iterations_is_said() {
    let hasty = Options {
        max_iterations: 2,
        ..Options::default()
    };
    let solution = minimise(&Rosenbrock, Vector2::new(-1.2, 1.0), &hasty).unwrap();
    assert_eq!(
        (solution.outcome, solution.iterations),
        (Termination::OutOfIterations, 2)
    );
}

/// Only positive states are in its domain, and its Gauss-Newton step from 1 leaps out of it.
struct Logarithm;

impl Problem<1> for Logarithm {
    type State = f64;

    fn linearise(&self, x: &f64, equations: &mut NormalEquations<1>) -> Option<()> {
        let in_domain = *x > 0.0;
        in_domain
            .then(|| equations.add_unweighted(&Vector1::new(x.ln() + 3.0), &Vector1::new(1.0 / x)))
    }

    fn step(&self, x: &f64, step: &SVector<f64, 1>) -> f64 {
        x + step.x
    }
}

#[test]
fn steps_out_of_the_domain_are_shortened() {
    let solution = minimise(&Logarithm, 1.0, &patient()).unwrap();
    assert!((solution.state - (-3.0_f64).exp()).abs() < 1e-9);
}

#[test]
fn a_start_outside_the_domain_is_an_error() {
    for start in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            minimise(&Logarithm, start, &patient()).unwrap_err(),
            LeastSquaresError::BadStart
        );
    }
}
