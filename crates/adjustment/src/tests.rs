//! The core on small bundles of exact and noisy corners.

use crate::elimination::ReducedSystem;
use crate::equations::{self, NormalEquations};
use crate::layout::Layout;
use crate::solve::Descent;
use crate::tie::Tie;
use crate::*;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix2, Point2, SMatrix, Vector2, Vector3, Vector6};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::{Intrinsics, Lens, Pose, se3, tag_corners_in_tag};
use sextant_simulator::Random;
use sextant_site_model::PoseSigma;

fn twist(random: &mut Random, translation: f64, rotation: f64) -> Vector6<f64> {
    Vector6::from_fn(|at, _| random.normal() * if at < 3 { translation } else { rotation })
}

fn lens() -> Lens {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 605.0,
        cx: 322.0,
        cy: 238.0,
    };
    Lens::brown_conrady(intrinsics, [-0.2, 0.05, 0.001, -0.0005, 0.0]).unwrap()
}

fn looking_at_origin(from: Vector3<f64>) -> Pose {
    let eye = Point2::origin().to_homogeneous() * 0.0;
    Isometry3::face_towards(&from.into(), &eye.into(), &-Vector3::z())
}

const CARRIED: Vector6<f64> = Vector6::new(0.1, -0.05, 0.08, 0.5, -0.4, 0.7);
const SHAKEN: Vector6<f64> = Vector6::new(-0.05, 0.04, 0.06, 0.2, 0.3, -0.2);

fn object_at(seconds: f64) -> Pose {
    let tilt = Isometry3::new(Vector3::new(-0.1, 0.05, 0.0), Vector3::new(0.2, 0.1, 0.4));
    tilt * se3::exp(&(CARRIED * seconds)) * se3::exp(&(SHAKEN * (5.0 * seconds).sin()))
}

fn twist_at(seconds: f64) -> Vector6<f64> {
    let h = 1e-5;
    se3::difference(&object_at(seconds + h), &object_at(seconds - h)) / (2.0 * h)
}

/// Three cameras around, six tags in two planes, twelve instants, cameras 7 ms apart; everything at the truth.
fn truth(motion: Option<Motion>) -> Bundle {
    let camera = |at: usize| {
        let angle = 0.7 * at as f64;
        let from = Vector3::new(1.2 * angle.cos(), 1.2 * angle.sin(), 0.9 + 0.2 * angle);
        BundleCamera::with_known_lens(lens(), looking_at_origin(from))
    };
    let tag = |at: usize| BundleTag {
        object_from_tag: Isometry3::new(
            Vector3::new(0.1 * (at % 3) as f64 - 0.1, 0.1 * (at / 3) as f64, 0.0),
            Vector3::new(0.0, 0.5 * (at / 3) as f64, 0.3),
        ),
        size_m: 0.06,
        pose: Freedom::Fixed,
        size: Freedom::Fixed,
        scale: None,
    };
    let mut bundle = Bundle {
        cameras: (0..3).map(camera).collect(),
        tags: (0..6).map(tag).collect(),
        motion,
        ..Bundle::default()
    };
    bundle.cameras[0].pose = Freedom::Fixed;
    for at in 0..12 {
        let seconds = 0.05 * f64::from(at);
        bundle.instants.push(Instant {
            body: BodyId::Moving(0),
            seconds,
            world_from_object: object_at(seconds),
            twist: twist_at(seconds),
        });
        for camera in 0..3 {
            let delay = motion.map_or(0.0, |_| 0.007 * camera as f64);
            let image = image_of(&bundle, camera, at as usize, delay);
            bundle.images.push(image);
        }
    }
    bundle
}

fn image_of(bundle: &Bundle, camera: usize, instant: usize, delay: f64) -> BundleImage {
    let taken_by = &bundle.cameras[camera];
    let object = object_at(bundle.instants[instant].seconds + delay);
    let camera_from_object = taken_by.world_from_camera.inverse() * object;
    let tags = bundle.tags.iter().enumerate().filter_map(|(index, tag)| {
        let corners = tag_corners_in_tag(tag.size_m);
        let corners = corners.map(|c| {
            taken_by
                .lens
                .project(&(camera_from_object * tag.object_from_tag * c))
        });
        let [Some(a), Some(b), Some(c), Some(d)] = corners else {
            return None;
        };
        Some(TagObservation::with_sigma(index, [a, b, c, d], 0.1))
    });
    BundleImage {
        camera,
        instant,
        seconds_after_instant: delay,
        stamp_error_s: 0.0,
        tags: tags.collect(),
    }
}

fn shaken(bundle: &mut Bundle, noise: &mut Random, sigma_px: f64) {
    for corner in bundle
        .images
        .iter_mut()
        .flat_map(|image| image.tags.iter_mut())
        .flat_map(|seen| &mut seen.corners)
    {
        *corner += Vector2::new(noise.normal(), noise.normal()) * sigma_px;
    }
}

/// Moves everything that is free away from the truth.
fn displaced(bundle: &mut Bundle, noise: &mut Random) {
    for camera in &mut bundle.cameras {
        if camera.pose == Freedom::Free {
            camera.world_from_camera =
                se3::exp(&twist(noise, 0.03, 0.03)) * camera.world_from_camera;
        }
    }
    for tag in &mut bundle.tags {
        if tag.pose == Freedom::Free {
            tag.object_from_tag = se3::exp(&twist(noise, 0.01, 0.05)) * tag.object_from_tag;
        }
    }
    for instant in &mut bundle.instants {
        instant.world_from_object *= se3::exp(&twist(noise, 0.02, 0.05));
    }
}

fn apart(a: &Pose, b: &Pose) -> f64 {
    se3::difference(a, b).amax()
}

const WALK: Motion = Motion {
    acceleration: 3.0,
    angular_acceleration: 10.0,
    longest_gap_s: 0.3,
};

fn free_everything(bundle: &mut Bundle) {
    for camera in &mut bundle.cameras[1..] {
        camera.clock = Freedom::Free;
    }
    bundle.cameras[1].free_lens = FreeLens::ALL;
    for tag in &mut bundle.tags[1..] {
        tag.pose = Freedom::Free;
        tag.size = Freedom::Free;
    }
    bundle.tags[2].pose = Freedom::Fixed;
}

/// All tags but the first two are of one sheet, which is a little larger than its file says.
fn share_a_scale(bundle: &mut Bundle) {
    bundle.scales.push(ObjectScale {
        log_factor: 0.02,
        freedom: Freedom::Free,
    });
    bundle.anchors.push(Anchor::Scale {
        scale: 0,
        sigma: 0.005,
    });
    for tag in &mut bundle.tags[2..] {
        tag.scale = Some(0);
    }
}

/// A camera and a tag have priors a little elsewhere.
fn anchored(bundle: &mut Bundle) {
    let elsewhere = Vector6::new(0.01, -0.02, 0.005, 0.004, -0.003, 0.005);
    let sigma = PoseSigma {
        position_m: 1e-3,
        orientation_rad: 1e-3,
    };
    bundle.anchors.push(Anchor::Camera {
        camera: 1,
        world_from_camera: se3::perturb(&bundle.cameras[1].world_from_camera, &elsewhere),
        sigma,
    });
    bundle.anchors.push(Anchor::Tag {
        across: 1.0,
        tag: 3,
        object_from_tag: se3::perturb(&bundle.tags[3].object_from_tag, &elsewhere),
        sigma,
    });
}

#[test]
fn derivatives_are_those_of_the_cost() {
    let untied = Motion {
        longest_gap_s: 0.0,
        ..WALK
    };
    let mut bundle = truth(Some(untied));
    free_everything(&mut bundle);
    share_a_scale(&mut bundle);
    for camera in &mut bundle.cameras[1..] {
        camera.line_delay = Freedom::Free;
        camera.line_delay_s = 4e-5;
        camera.middle_row = 239.5;
    }
    displaced(&mut bundle, &mut Random::new(3));
    anchored(&mut bundle);
    let options = BundleOptions::default();
    let kernel = Kernel::Huber { width: 40.0 };
    let layout = Layout::new(&bundle);
    let equations = NormalEquations::<12>::new(&bundle, &layout, &kernel);
    let descent = Descent::<12>::new(bundle, &options);
    let cost_after = |kept: usize, node: usize, length: f64| {
        let mut step = descent.no_step();
        if kept < layout.n {
            step.kept[kept] = length;
        } else {
            step.instants[node][kept - layout.n] = length;
        }
        let estimates = descent.stepped(&step).unwrap();
        let moved = Bundle {
            cameras: estimates.site.cameras,
            tags: estimates.site.tags,
            scales: estimates.site.scales,
            instants: estimates.instants,
            ..descent.bundle.clone()
        };
        0.5 * equations::rho(&moved, &kernel)
    };
    let h = 1e-6;
    for at in 0..layout.n + 12 {
        let node = 5;
        let slope = (cost_after(at, node, h) - cost_after(at, node, -h)) / (2.0 * h);
        let given = if at < layout.n {
            equations.gradient[at]
        } else {
            equations.nodes[node].gradient[at - layout.n]
        };
        let scale = slope.abs().max(1e3);
        assert!(
            (slope - given).abs() < 1e-6 * scale,
            "{at}: {slope} {given}"
        );
    }
}

/// The noise of a tie as a function of the steps of both of its instants, differentiated numerically.
fn whitened_tie(pair: &[Instant], motion: &Motion) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let noise = |steps: &DVector<f64>| {
        let step = |at: usize| SMatrix::<f64, 12, 1>::from_fn(|row, _| steps[at + row]);
        let [earlier, later] = [0, 1].map(|at| pair[at].stepped(&step(12 * at)));
        Tie::between(&earlier, &later, motion).map(|tie| tie.noise())
    };
    let at_rest = DVector::zeros(24);
    let noise_here = noise(&at_rest)?;
    let h = 1e-6;
    let mut slopes = DMatrix::zeros(12, 24);
    for column in 0..24 {
        let mut steps = at_rest.clone();
        steps[column] = h;
        let ahead = noise(&steps)?;
        steps[column] = -h;
        let slope = (ahead - noise(&steps)?) / (2.0 * h);
        slopes.view_mut((0, column), (12, 1)).copy_from(&slope);
    }
    Some((DVector::from_column_slice(noise_here.as_slice()), slopes))
}

/// The step of all parameters, kept ones first, by one dense system.
fn dense_step(bundle: &Bundle, equations: &NormalEquations<12>) -> DVector<f64> {
    let n = equations.kept.nrows();
    let size = n + 12 * bundle.instants.len();
    let (mut whole, mut pull) = (DMatrix::zeros(size, size), DVector::zeros(size));
    let mut kept = equations.kept.clone();
    kept.fill_lower_triangle_with_upper_triangle();
    whole.view_mut((0, 0), (n, n)).copy_from(&kept);
    pull.rows_mut(0, n).copy_from(&equations.gradient);
    for (at, node) in equations.nodes.iter().enumerate() {
        let first = n + 12 * at;
        whole
            .view_mut((first, first), (12, 12))
            .copy_from(&node.own);
        pull.rows_mut(first, 12).copy_from(&node.gradient);
        for (local, column) in node.columns.iter().enumerate() {
            let coupling = node.coupling.column(local);
            whole
                .view_mut((first, *column), (12, 1))
                .copy_from(&coupling);
            let across = coupling.transpose();
            whole.view_mut((*column, first), (1, 12)).copy_from(&across);
        }
    }
    let motion = bundle.motion.unwrap();
    for (at, pair) in bundle.instants.windows(2).enumerate() {
        let Some((noise, slopes)) = whitened_tie(pair, &motion) else {
            continue;
        };
        let first = n + 12 * at;
        let mut own = whole.view_mut((first, first), (24, 24));
        own += slopes.tr_mul(&slopes);
        let mut gradient = pull.rows_mut(first, 24);
        gradient += slopes.tr_mul(&noise);
    }
    -whole.lu().solve(&pull).unwrap()
}

#[test]
fn the_step_is_that_of_a_dense_solution() {
    let mut bundle = truth(Some(WALK));
    free_everything(&mut bundle);
    share_a_scale(&mut bundle);
    // Two bodies, one of them with instants two milliseconds apart.
    for (at, instant) in bundle.instants.iter_mut().enumerate().skip(7) {
        instant.body = BodyId::Moving(1);
        instant.seconds = 0.35 + 2e-3 * at as f64;
        instant.world_from_object = object_at(instant.seconds);
        instant.twist = twist_at(instant.seconds);
    }
    let bundle = bundle;
    let layout = Layout::new(&bundle);
    let kernel = Kernel::Huber { width: 40.0 };
    let equations = NormalEquations::<12>::new(&bundle, &layout, &kernel);
    let reduced = ReducedSystem::new(&equations, 0.0).unwrap();
    let step = reduced.step(&equations).unwrap();
    let dense = dense_step(&bundle, &equations);
    let scale = 1e-4 * dense.amax();
    for (at, kept) in step.kept.iter().enumerate() {
        assert!(
            (kept - dense[at]).abs() < scale,
            "kept {at}: {kept} {}",
            dense[at]
        );
    }
    for (instant, step) in step.instants.iter().enumerate() {
        for (row, value) in step.iter().enumerate() {
            let dense = dense[layout.n + 12 * instant + row];
            assert!(
                (value - dense).abs() < scale,
                "{instant}, {row}: {value} {dense}"
            );
        }
    }
}

#[test]
fn instants_of_one_time_are_one() {
    let mut bundle = truth(Some(WALK));
    free_everything(&mut bundle);
    displaced(&mut bundle, &mut Random::new(5));
    // Each image has an instant of its own, those of one time at no distance.
    let mut apart = bundle.clone();
    apart.instants = bundle
        .images
        .iter()
        .map(|image| bundle.instants[image.instant].clone())
        .collect();
    for (at, image) in apart.images.iter_mut().enumerate() {
        image.instant = at;
    }
    let options = BundleOptions::default();
    let (together, apart) = (
        solve(bundle, &options).unwrap(),
        solve(apart, &options).unwrap(),
    );
    for (a, b) in together.bundle.cameras.iter().zip(&apart.bundle.cameras) {
        let off = self::apart(&a.world_from_camera, &b.world_from_camera);
        assert!(off < 5e-5, "{off}");
        assert!((a.clock_offset_s - b.clock_offset_s).abs() < 1e-4);
    }
}

#[test]
fn an_error_of_a_stamp_acts_as_an_instant_of_another_time() {
    let mut bundle = truth(Some(WALK));
    for camera in &mut bundle.cameras {
        camera.stamp_sigma_s = 0.01;
    }
    let late = [0.012, -0.007, 0.015, 0.003];
    for (at, image) in bundle.images.iter_mut().enumerate() {
        image.seconds_after_instant += late[at % 4];
    }
    displaced(&mut bundle, &mut Random::new(4));
    let solution = solve(bundle, &BundleOptions::default()).unwrap();
    assert!(solution.converged, "{}", solution.iterations);
    let right = truth(Some(WALK));
    for (found, right) in solution.bundle.cameras.iter().zip(&right.cameras) {
        let off = apart(&found.world_from_camera, &right.world_from_camera);
        assert!(off < 2e-3, "{off}");
    }
    let images = solution.bundle.images.iter().enumerate();
    let left = images.map(|(at, image)| (image.stamp_error_s - late[at % 4]).abs());
    let mean = left.sum::<f64>() / solution.bundle.images.len() as f64;
    assert!(mean < 0.007, "{mean} of a mean of 0.009");
}

#[test]
fn exact_corners_bring_back_cameras_and_tags() {
    let mut bundle = truth(None);
    for tag in &mut bundle.tags[1..] {
        tag.pose = Freedom::Free;
    }
    let right = bundle.clone();
    displaced(&mut bundle, &mut Random::new(7));
    let solution = solve(bundle, &BundleOptions::default()).unwrap();
    assert!(solution.converged && solution.weak.is_empty());
    for (found, right) in solution.bundle.cameras.iter().zip(&right.cameras) {
        assert!(apart(&found.world_from_camera, &right.world_from_camera) < 1e-6);
    }
    for (found, right) in solution.bundle.tags.iter().zip(&right.tags) {
        assert!(apart(&found.object_from_tag, &right.object_from_tag) < 1e-6);
    }
}

#[test]
fn clocks_of_cameras_that_run_free_are_found() {
    let mut bundle = truth(Some(WALK));
    free_everything(&mut bundle);
    bundle.cameras[1].free_lens = FreeLens::FIXED;
    for image in &mut bundle.images {
        image.seconds_after_instant += [0.0, 0.012, -0.008][image.camera];
    }
    displaced(&mut bundle, &mut Random::new(9));
    let solution = solve(bundle, &BundleOptions::default()).unwrap();
    let offsets = solution.bundle.cameras.iter().map(|c| c.clock_offset_s);
    for (found, right) in offsets.zip([0.0, 0.012, -0.008]) {
        assert!((found - right).abs() < 2e-4, "{found} {right}");
    }
}

#[test]
fn stated_deviations_are_those_of_repetition() {
    let (mut inside, mut all) = (0, 0);
    for seed in 1..40 {
        let mut bundle = truth(None);
        let right = bundle.clone();
        let mut noise = Random::new(seed);
        shaken(&mut bundle, &mut noise, 0.2); // twice what is stated
        displaced(&mut bundle, &mut noise);
        let solution = solve(bundle, &BundleOptions::default()).unwrap();
        for camera in 1..3 {
            let sigmas = solution.covariance.camera(camera).unwrap().diagonal();
            let error = se3::difference(
                &solution.bundle.cameras[camera].world_from_camera,
                &right.cameras[camera].world_from_camera,
            );
            let within = error.zip_map(&sigmas, |e, v| e.abs() <= 2.0 * v.sqrt());
            inside += within.iter().filter(|within| **within).count();
            all += 6;
        }
    }
    let part = inside as f64 / all as f64;
    assert!((0.9..=0.99).contains(&part), "{part}");
}

#[test]
fn a_lens_is_found_from_one_camera() {
    let mut bundle = truth(None);
    bundle.images.retain(|image| image.camera == 0);
    bundle.cameras.truncate(1);
    bundle.cameras[0].free_lens = FreeLens::ALL;
    let right = bundle.cameras[0].lens;
    let mut start = right.parameters();
    (start[0], start[1]) = (580.0, 580.0);
    start[4..].fill(0.0);
    bundle.cameras[0].lens = right.with_parameters(&start).unwrap();
    let solution = solve(bundle, &BundleOptions::default()).unwrap();
    let found = solution.bundle.cameras[0].lens.parameters();
    assert!((found[0] - 600.0).abs() < 0.5, "{found:?}");
    assert_eq!(solution.covariance.lens(0).nrows(), 9);
}

#[test]
fn a_size_that_disagrees_is_found() {
    let mut bundle = truth(None);
    for tag in &mut bundle.tags[1..] {
        (tag.pose, tag.size) = (Freedom::Free, Freedom::Free);
        tag.size_m *= 1.02;
    }
    let solution = solve(bundle, &BundleOptions::default()).unwrap();
    for tag in &solution.bundle.tags {
        assert!((tag.size_m - 0.06).abs() < 1e-7, "{}", tag.size_m);
    }
}

#[test]
fn a_camera_that_sees_nothing_is_named_and_stays() {
    let mut bundle = truth(None);
    bundle.images.retain(|image| image.camera != 2);
    let before = bundle.cameras[2].world_from_camera;
    let solution = solve(bundle, &BundleOptions::default()).unwrap();
    assert!(apart(&solution.bundle.cameras[2].world_from_camera, &before) < 1e-9);
    assert_eq!(solution.weak.len(), 6);
    for weak in &solution.weak {
        assert!(weak.part_of_prior > 0.9);
        let of_two = |p: &KeptParameter| {
            matches!(
                p,
                KeptParameter::CameraPosition { camera: 2, .. }
                    | KeptParameter::CameraRotation { camera: 2, .. }
            )
        };
        assert!(weak.made_of.iter().all(|(p, _)| of_two(p)));
    }
}

#[test]
fn gross_errors_hardly_count() {
    let mut bundle = truth(None);
    let right = bundle.clone();
    let mut noise = Random::new(21);
    shaken(&mut bundle, &mut noise, 0.1);
    for image in &mut bundle.images {
        for seen in image.tags.iter_mut().take(1) {
            seen.corners[0] += Vector2::new(30.0, -20.0);
        }
    }
    let solution = solve(bundle, &BundleOptions::default()).unwrap();
    for (found, right) in solution.bundle.cameras.iter().zip(&right.cameras) {
        assert!(apart(&found.world_from_camera, &right.world_from_camera) < 1e-3);
    }
}

#[test]
fn wrong_bundles_are_refused() {
    let options = BundleOptions::default();
    let refused = |bundle: Bundle| solve(bundle, &options).unwrap_err();
    assert_eq!(refused(Bundle::default()), BundleError::Nothing);
    let mut bundle = truth(None);
    bundle.images.swap(0, 35);
    assert!(matches!(refused(bundle), BundleError::Image(_)));
    let mut bundle = truth(None);
    bundle.images[4].tags[0].corners[2].x = f64::NAN;
    assert_eq!(refused(bundle), BundleError::NotFinite(4));
    let mut bundle = truth(None);
    bundle.cameras[1].clock = Freedom::Free;
    assert_eq!(refused(bundle), BundleError::Time);
    let mut bundle = truth(Some(WALK));
    bundle.instants[3].seconds = 0.0;
    assert_eq!(refused(bundle), BundleError::Time);
}

#[test]
fn covariances_whiten() {
    let covariance = Matrix2::new(0.04, 0.01, 0.01, 0.02);
    let corners = [Point2::origin(); 4];
    let seen = TagObservation::with_covariance(0, corners, &[covariance; 4], 0.1).unwrap();
    let information = seen.whitening[1].transpose() * seen.whitening[1];
    let whole = covariance + Matrix2::from_diagonal_element(0.01);
    assert!((information * whole - Matrix2::identity()).amax() < 1e-12);
    let indefinite = Matrix2::new(0.0, 1.0, 1.0, 0.0);
    assert!(TagObservation::with_covariance(0, corners, &[indefinite; 4], 0.01).is_none());
}
