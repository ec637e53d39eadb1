//! The filter against numeric derivatives and against the textbook's dense update.

use nalgebra::{Matrix2, Matrix6, Point2, SMatrix, SVector, Vector2, Vector3, Vector6};
use sextant_geometry::lens::Intrinsics;
use sextant_geometry::{Lens, Pose, se3, tag_corners_in_tag};
use sextant_tag_families::Family;

use crate::filter::covariance::Covariance;
use crate::filter::least_squares::{Fit, solve};
use crate::filter::observed_configuration::ObservationTime;
use crate::filter::process_noise::{ProcessNoise, ProcessNoisePsd};
use crate::filter::state::ObjectState;
use crate::filter::update::update;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::{CalibratedCamera, TagView, ViewNoise, WeightedView};
use crate::measurement::rolling_shutter::LinkMotion;
use crate::measurement::view_equations::NoiseSource;
use crate::measurement::whitening::{Matrix8, Whitening};
use sextant_site_model::{TagCorners, TagId};
use sextant_site_report::ClockOffset;

pub(crate) fn camera() -> CalibratedCamera {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 590.0,
        cx: 320.0,
        cy: 240.0,
    };
    let lens = Lens::brown_conrady(intrinsics, [-0.2, 0.05, 0.001, -0.0005, 0.0]).unwrap();
    // Looks down from 1 m above the world's origin, a little askew.
    let turn = Vector3::new(std::f64::consts::PI - 0.1, 0.05, 0.0);
    CalibratedCamera::new(lens, &Pose::new(Vector3::new(0.05, -0.02, 1.0), turn), None)
}

pub(crate) fn object() -> Pose {
    Pose::new(Vector3::new(0.03, 0.04, 0.02), Vector3::new(0.3, -0.2, 0.5))
}

/// A view of a tag of 5 cm, its corners off the truth by `off`.
pub(crate) fn view(
    camera: &CalibratedCamera,
    object_from_tag: Pose,
    off: [Vector2<f64>; 4],
) -> TagView {
    let corners_in_object = tag_corners_in_tag(0.05).map(|corner| object_from_tag * corner);
    let project = |index: usize| {
        let in_camera = camera.camera_from_world * object() * corners_in_object[index];
        camera.lens.project(&in_camera).unwrap() + off[index]
    };
    let corners_in_image = [0, 1, 2, 3].map(|index| Point2::from(project(index)));
    let covariance = Matrix2::new(0.01, 0.002, 0.002, 0.008);
    TagView {
        tag: TagId {
            family: Family::Tag36h11,
            id: 0,
        },
        chain_link: None,
        size_m: 0.05,
        object_from_tag,
        corners_in_object,
        corners_in_image,
        seen: TagCorners {
            tag: TagId {
                family: Family::Tag36h11,
                id: 0,
            },
            corners: corners_in_image,
            corner_covariance: [covariance; 4],
            corner_cross_covariance: [Matrix2::zeros(); 6],
        },
        distortion_bias: None,
        information: [covariance.try_inverse().unwrap(); 4],
        whitening: Whitening::new(&of_all(&covariance)).unwrap(),
        is_joint: false,
        noise_source: NoiseSource::Detector,
        tag_sigma: None,
        after_s: None,
    }
}

/// Of x and y of each corner in turn, all alike and independent.
fn of_all(covariance: &Matrix2<f64>) -> Matrix8 {
    let of = |row: usize, column: usize| match row / 2 == column / 2 {
        true => covariance[(row % 2, column % 2)],
        false => 0.0,
    };
    Matrix8::from_fn(of)
}

pub(crate) fn weighted<'a>(camera: &'a CalibratedCamera, view: &'a TagView) -> WeightedView<'a> {
    let noise = ViewNoise {
        factor: 1.3,
        distortion_share: 0.0,
    };
    WeightedView::new(0, camera, view, noise, None)
}

fn by(camera_index: usize) -> ObservationTime {
    ObservationTime {
        camera_index,
        apart_s: 0.0,
    }
}

pub(crate) fn still(pose: &Pose) -> LinkMotion {
    LinkMotion {
        pose: *pose,
        twist: None,
    }
}

pub(crate) fn small_offsets() -> [Vector2<f64>; 4] {
    [(0.05, -0.1), (-0.08, 0.02), (0.1, 0.1), (-0.03, 0.06)].map(|(x, y)| Vector2::new(x, y))
}

/// A state about the truth, with correlations between pose and twist.
fn state(offset: &Vector6<f64>) -> ObjectState {
    let mixing =
        SMatrix::<f64, 12, 12>::from_fn(|row, column| ((row * 7 + column * 3) as f64).sin());
    let covariance = Covariance::identity() * 1e-4 + mixing * mixing.transpose() * 2e-5;
    let process_noise_psd = ProcessNoisePsd {
        linear: 0.05,
        angular: 0.5,
        clocks: 1e-9,
    };
    ObjectState {
        pose: se3::perturb(&object(), offset),
        twist: Vector6::new(0.2, -0.1, 0.05, 1.0, -0.5, 0.7),
        covariance,
        clocks: None,
        joints: None,
        considered: None,
        information_gain: 0.0,
        motion: ProcessNoise::new(process_noise_psd),
    }
}

fn small_step() -> Vector6<f64> {
    Vector6::new(0.004, -0.003, 0.002, 0.01, -0.008, 0.012)
}

#[test]
fn the_gradient_of_the_corners_is_that_of_their_cost() {
    let camera = camera();
    let view = view(
        &camera,
        Pose::translation(0.02, -0.01, 0.03),
        small_offsets(),
    );
    let weighted = weighted(&camera, &view);
    let pose = se3::perturb(&object(), &(small_step() * 0.01));
    let normal = weighted.normal(&still(&pose)).unwrap();
    for axis in 0..6 {
        let step = Vector6::ith(axis, 1e-6);
        let cost = |step: &Vector6<f64>| {
            let stepped = still(&se3::perturb(&pose, step));
            weighted.normal(&stepped).unwrap().chi2
        };
        let slope = (cost(&step) - cost(&-step)) / 2e-6;
        let gradient = 2.0 * normal.gradient[axis];
        assert!(
            (slope - gradient).abs() < 1e-4 * gradient.abs().max(1.0),
            "{axis}: {slope} {gradient}"
        );
    }
}

#[test]
fn a_rolling_shutters_gradient_by_pose_and_twist_is_that_of_its_cost() {
    let camera = camera();
    let mut view = view(
        &camera,
        Pose::translation(0.02, -0.01, 0.03),
        small_offsets(),
    );
    view.after_s = Some([-0.004, 0.001, 0.007, 0.02]);
    let weighted = weighted(&camera, &view);
    let mut at = Configuration::rigid(&object());
    at.rates.twist = Vector6::new(0.003, -0.002, 0.001, 0.02, -0.01, 0.015);
    let normal = weighted.normal(&view.moving(&at)).unwrap();
    let rolling = normal.rolling.unwrap();
    for place in 0..12 {
        let step = SVector::<f64, 12>::ith(place, 1e-6);
        let cost = |step: &SVector<f64, 12>| {
            let moving = view.moving(&at.perturbed(step));
            weighted.normal(&moving).unwrap().chi2
        };
        let slope = (cost(&step) - cost(&-step)) / 2e-6;
        let gradient = 2.0
            * match place {
                0..6 => normal.gradient[place],
                _ => rolling.gradient[place - 6],
            };
        assert!(
            (slope - gradient).abs() < 1e-3 * gradient.abs().max(1.0),
            "{place}: {slope} {gradient}"
        );
    }
}

#[test]
fn the_fit_is_where_prior_and_corners_balance() {
    let camera = camera();
    let view = view(&camera, Pose::identity(), small_offsets());
    let weighted = weighted(&camera, &view);
    let prior = state(&small_step()).observed::<6>(0).prior().unwrap();
    let fit = solve(&prior, &[weighted], &prior.configuration).unwrap();
    let cost = |step: Vector6<f64>| {
        let at = fit.configuration.perturbed(&step);
        prior.nis(&at) + weighted.chi2(&at)
    };
    let sigma = (prior.information + fit.information).try_inverse().unwrap();
    for axis in 0..6 {
        let step = Vector6::ith(axis, 0.1 * sigma[(axis, axis)].sqrt());
        assert!(
            cost(step) > fit.cost - 1e-3 && cost(-step) > fit.cost - 1e-3,
            "{axis}"
        );
    }
}

#[test]
fn a_wrong_corner_pulls_little() {
    let camera = camera();
    let mut off = [Vector2::zeros(); 4];
    off[2] = Vector2::new(30.0, -20.0);
    let others = [
        view(
            &camera,
            Pose::translation(0.06, 0.0, 0.0),
            [Vector2::zeros(); 4],
        ),
        view(&camera, Pose::identity(), off),
    ];
    let weighted_views: Vec<WeightedView<'_>> =
        others.iter().map(|view| weighted(&camera, view)).collect();
    let prior = state(&small_step()).observed::<6>(0).prior().unwrap();
    let fit = solve(&prior, &weighted_views, &prior.configuration).unwrap();
    assert!(se3::difference(&fit.configuration.pose, &object()).norm() < 0.01);
}

#[test]
fn the_predicted_covariance_is_that_of_predicted_errors() {
    let before = state(&Vector6::zeros());
    let dt = 0.05;
    let after = before.predicted(dt);
    let moved = |error: &SMatrix<f64, 12, 1>| {
        let mut state = before.clone();
        state.pose = se3::perturb(&before.pose, &error.fixed_rows::<6>(0).into_owned());
        state.twist += error.fixed_rows::<6>(6);
        let state = state.predicted(dt);
        let mut out = SMatrix::<f64, 12, 1>::zeros();
        out.fixed_rows_mut::<6>(0)
            .copy_from(&se3::difference(&state.pose, &after.pose));
        out.fixed_rows_mut::<6>(6)
            .copy_from(&(state.twist - after.twist));
        out
    };
    let columns: Vec<_> = (0..12)
        .map(|axis| moved(&(SMatrix::ith(axis, 1e-6))) / 1e-6)
        .collect();
    let transition = SMatrix::<f64, 12, 12>::from_columns(&columns);
    let noise =
        crate::filter::covariance::white_acceleration(dt, before.motion.process_noise_psd(dt));
    let expected = transition * before.covariance * transition.transpose() + noise;
    assert!((after.covariance - expected).amax() < 1e-9);
}

/// A fit at a pose with the information given, whatever corners may have led there.
fn fit_at(pose: Pose, information: Matrix6<f64>) -> Fit<6> {
    Fit {
        configuration: Configuration::rigid(&pose),
        information,
        views: Vec::new(),
        nis: 0.0,
        cost: 0.0,
    }
}

#[test]
fn absorbing_is_the_dense_kalman_update() {
    let before = state(&Vector6::zeros());
    let information = Matrix6::from_diagonal(&Vector6::new(2e4, 3e4, 1e4, 5e3, 6e3, 7e3));
    // The pose at which prior and a measurement of that information, off by `seen`, balance.
    let seen = small_step() * 0.1;
    let prior = before.covariance.fixed_view::<6, 6>(0, 0).into_owned();
    let gain = before.covariance.fixed_columns::<6>(0)
        * (prior + information.try_inverse().unwrap())
            .try_inverse()
            .unwrap();
    let step = gain * seen;
    let pose = se3::perturb(&before.pose, &step.fixed_rows::<6>(0).into_owned());
    let after = update(&before, by(0), &fit_at(pose, information))
        .unwrap()
        .state;
    let dense = before.covariance - gain * before.covariance.fixed_rows::<6>(0);
    assert!((after.twist - before.twist - step.fixed_rows::<6>(6)).amax() < 1e-9);
    // The reset by the small turn changes it by less than a hundredth.
    assert!((after.covariance - dense).amax() < 0.01 * dense.amax());
    assert!(after.covariance.cholesky().is_some());
}

#[test]
fn a_camera_ahead_of_time_sees_the_pose_of_before() {
    let mut state = state(&Vector6::zeros());
    state.know_clock(
        3,
        ClockOffset {
            offset_s: 0.01,
            sigma_s: 0.002,
        },
    );
    let seen = state.observed::<6>(3).configuration.pose;
    let before = state.predicted(-0.01).pose;
    assert!(se3::difference(&seen, &before).amax() < 1e-12);
    assert_eq!(state.observed::<6>(0).configuration.pose, state.pose);
}

#[test]
fn an_offset_is_learned_from_where_the_camera_sees_the_body() {
    let mut known = state(&Vector6::zeros());
    known.covariance *= 1e-4;
    known.know_clock(
        1,
        ClockOffset {
            offset_s: 0.0,
            sigma_s: 0.02,
        },
    );
    let pose = se3::perturb(&known.pose, &(known.twist * -0.008));
    let after = update(&known, by(1), &fit_at(pose, Matrix6::identity() * 1e8))
        .unwrap()
        .state;
    let (camera, offset) = after.clock_offsets().into_iter().next().unwrap();
    assert_eq!(camera, 1);
    assert!(
        (offset.offset_s - 0.008).abs() < 4.0 * offset.sigma_s && offset.sigma_s < 0.002,
        "{offset:?}"
    );
}
