//! Sites of two to four cameras around a cube of six tags, with one mistake each.

use nalgebra::{Point3, Rotation3, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_site_model::PoseSigma;

use crate::{Explanation, Instant, Mistake, NominalSite, SiteCamera, SiteTag, View, explain};

const SIGMA_PX: f64 = 0.1;

fn lens() -> Lens {
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 322.0,
        cy: 237.0,
    };
    Lens::pinhole(intrinsics).unwrap()
}

fn turned(axis: [f64; 3], angle: f64) -> Pose {
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(axis) * angle);
    Pose::from_parts(Vector3::zeros().into(), rotation)
}

fn looking_from(eye: Vector3<f64>) -> Pose {
    let z = -eye.normalize();
    let x = z.cross(&Vector3::z()).normalize();
    let axes = nalgebra::Matrix3::from_columns(&[x, z.cross(&x), z]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Pose::from_parts(eye.into(), rotation)
}

fn ring(n_cameras: usize) -> Vec<Option<SiteCamera>> {
    let camera = |k: usize| {
        let angle = 0.3 + std::f64::consts::TAU * k as f64 / n_cameras as f64 * 0.7;
        let height = 0.7 + 0.1 * k as f64;
        let eye = Vector3::new(1.2 * angle.cos(), 1.1 * angle.sin(), height);
        Some(SiteCamera {
            lens: lens(),
            world_from_camera: looking_from(eye),
            sigma: PoseSigma::OF_CAMERA,
            clock_s: 0.0,
        })
    };
    (0..n_cameras).map(camera).collect()
}

fn cube() -> Vec<SiteTag> {
    let right = std::f64::consts::FRAC_PI_2;
    let faces = [
        turned([0.0, 1.0, 0.0], 0.0),
        turned([0.0, 1.0, 0.0], right),
        turned([0.0, 1.0, 0.0], 2.0 * right),
        turned([0.0, 1.0, 0.0], -right),
        turned([1.0, 0.0, 0.0], right),
        turned([1.0, 0.0, 0.0], -right),
    ];
    let tag = |face: &Pose| SiteTag {
        body: 0,
        body_from_tag: face * Pose::translation(0.0, 0.0, 0.03),
        size_m: 0.04,
        sigma: PoseSigma::OF_TAG,
    };
    faces.iter().map(tag).collect()
}

fn site(n_cameras: usize) -> NominalSite {
    NominalSite {
        cameras: ring(n_cameras),
        tags: cube(),
    }
}

/// Noise of a unit variance, about.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        (0..12).map(|_| uniform()).sum()
    }
}

fn pose_at(index: f64, seed: u64) -> Pose {
    let t = index * 0.37 + seed as f64;
    let place = Vector3::new((1.1 * t).sin(), (0.7 * t + 1.0).cos(), (0.9 * t).sin()) * 0.12;
    let turn = Vector3::new((0.8 * t).cos(), (0.6 * t).sin(), (0.5 * t + 2.0).cos()) * 1.2;
    Pose::from_parts(place.into(), UnitQuaternion::from_scaled_axis(turn))
}

/// What the cameras of the true site see.
fn images(truth: &NominalSite, seed: u64) -> Vec<Instant> {
    images_at(
        truth,
        (0..24).map(|index| pose_at(f64::from(index), seed)),
        seed,
    )
}

/// The same at some poses of the body.
fn images_at(
    truth: &NominalSite,
    world_from_body: impl Iterator<Item = Pose>,
    seed: u64,
) -> Vec<Instant> {
    let mut noise = Noise(seed.wrapping_mul(77) + 5);
    let instants = world_from_body.map(|world_from_body| {
        let mut views = Vec::new();
        for (camera, model) in truth.cameras.iter().enumerate() {
            let model = model.as_ref().unwrap();
            let camera_from_body = model.world_from_camera.inverse() * world_from_body;
            for (tag, own) in truth.tags.iter().enumerate() {
                let camera_from_tag = camera_from_body * own.body_from_tag;
                let normal = camera_from_tag.rotation * Vector3::z();
                let to_tag = camera_from_tag.translation.vector.normalize();
                if -normal.dot(&to_tag) < 0.3 {
                    continue;
                }
                let seen = tag_corners_in_tag(own.size_m)
                    .map(|corner: Point3<f64>| model.lens.project(&(camera_from_tag * corner)));
                if seen.iter().all(Option::is_some) {
                    let corners = seen.map(|corner| {
                        let noise = nalgebra::Vector2::new(noise.next(), noise.next());
                        corner.unwrap() + noise * SIGMA_PX
                    });
                    views.push(View {
                        camera,
                        tag,
                        corners,
                        velocities: [nalgebra::Vector2::zeros(); 4],
                        sigma_px: SIGMA_PX,
                    });
                }
            }
        }
        Instant { body: 0, views }
    });
    instants.filter(|one| one.views.len() > 1).collect()
}

/// The files with errors of a usual size.
fn shaken(site: &NominalSite, seed: u64) -> NominalSite {
    let mut noise = Noise(seed + 991);
    let mut step = |sigma: PoseSigma| {
        let mut six = nalgebra::Vector6::from_fn(|_, _| noise.next());
        six.fixed_rows_mut::<3>(0).scale_mut(sigma.position_m);
        six.fixed_rows_mut::<3>(3).scale_mut(sigma.orientation_rad);
        six
    };
    let mut site = site.clone();
    for camera in site.cameras.iter_mut().flatten() {
        let error = step(PoseSigma::OF_CAMERA);
        camera.world_from_camera =
            sextant_geometry::se3::perturb(&camera.world_from_camera, &error);
    }
    for tag in &mut site.tags {
        let error = step(PoseSigma::OF_TAG);
        tag.body_from_tag = sextant_geometry::se3::perturb(&tag.body_from_tag, &error);
    }
    site
}

fn explained(files: &NominalSite, truth: &NominalSite, seed: u64) -> Explanation {
    explain(files, &images(truth, seed), |_| true)
}

fn is_same(one: &Mistake, other: &Mistake) -> bool {
    let near = |a: f64, b: f64, within: f64| (a - b).abs() < within;
    match (*one, *other) {
        (
            Mistake::CameraMoved {
                camera,
                world_from_camera,
                sigma,
            },
            Mistake::CameraMoved {
                camera: other,
                world_from_camera: there,
                ..
            },
        ) => {
            let apart = world_from_camera.translation.vector - there.translation.vector;
            camera == other && apart.norm() < 0.02 + 3.0 * sigma.position_m
        }
        (
            Mistake::LensChanged { camera, ratio },
            Mistake::LensChanged {
                camera: other,
                ratio: of_other,
            },
        ) => camera == other && near(ratio, of_other, 0.05 * of_other),
        (Mistake::BodyScaled { ratio, .. }, Mistake::BodyScaled { ratio: other, .. })
        | (Mistake::SizesScaled { ratio, .. }, Mistake::SizesScaled { ratio: other, .. }) => {
            near(ratio, other, 0.05)
        }
        (
            Mistake::TagResized { tag, ratio },
            Mistake::TagResized {
                tag: other,
                ratio: of_other,
            },
        ) => tag == other && near(ratio, of_other, 0.03),
        _ => one == other,
    }
}

/// Whether the mistake is found alone where the true site differs from the files by it.
fn assert_found(truth: &Mistake, n_cameras: usize) {
    for seed in 0..2 {
        for files in [site(n_cameras), shaken(&site(n_cameras), seed)] {
            let explanation = explained(&files, &truth.amended(&site(n_cameras)), seed);
            let [found] = &explanation.found[..] else {
                panic!("{truth:?} of {n_cameras}, seed {seed}: {explanation:?}");
            };
            let is_named = |mistake: &Mistake| is_same(mistake, truth);
            assert!(
                is_named(&found.mistake) || found.or.as_ref().is_some_and(is_named),
                "{truth:?} of {n_cameras}, seed {seed}: {explanation:?}"
            );
            assert_eq!(found.or.is_some(), explanation.is_open(), "{explanation:?}");
        }
    }
}

#[test]
fn small_errors_of_files_are_no_mistake() {
    for seed in 0..10 {
        for n_cameras in 1..=4 {
            let truth = site(n_cameras);
            let explanation = explained(&shaken(&truth, seed), &truth, seed);
            assert!(
                explanation.found.is_empty() && !explanation.is_contradicting(),
                "{n_cameras}, seed {seed}: {explanation:?}"
            );
        }
    }
}

#[test]
fn a_camera_elsewhere_is_found() {
    for (n_cameras, least) in [(2, 0.5), (3, 0.4), (4, 0.4)] {
        for far in [least, 0.7, 1.0] {
            let camera = 1;
            let before = site(n_cameras).cameras[camera].clone().unwrap();
            let eye = before.world_from_camera.translation.vector;
            let eye = eye + Vector3::new(0.8, 0.5, 0.3).normalize() * far;
            let moved = Mistake::CameraMoved {
                camera,
                world_from_camera: looking_from(eye),
                sigma: PoseSigma::NONE,
            };
            assert_found(&moved, n_cameras);
        }
    }
}

#[test]
fn a_camera_elsewhere_is_no_other_lens_while_the_body_hardly_moves() {
    for seed in 0..10 {
        let before = site(4);
        let eye = before.cameras[1].as_ref().unwrap();
        let eye = eye.world_from_camera.translation.vector;
        let mut truth = before.clone();
        let aside = eye.cross(&Vector3::z()).normalize() * 0.2;
        truth.cameras[1].as_mut().unwrap().world_from_camera = looking_from(eye * 1.2 + aside);
        let poses = (0..8).map(|index| pose_at(0.1 * f64::from(index), seed));
        let instants = images_at(&truth, poses, seed);
        let explanation = explain(&before, &instants, |_| true);
        let mut found = explanation.found.iter();
        assert!(
            !found.any(|one| matches!(one.mistake, Mistake::LensChanged { .. })),
            "seed {seed}: {explanation:?}"
        );
    }
}

#[test]
fn a_turned_camera_is_found() {
    for n_cameras in [3, 4] {
        for quarters in 1..=3 {
            let camera = 1;
            assert_found(&Mistake::CameraTurned { camera, quarters }, n_cameras);
        }
    }
}

#[test]
fn exchanged_names_are_found() {
    for n_cameras in [2, 3, 4] {
        assert_found(&Mistake::CamerasExchanged { a: 0, b: 1 }, n_cameras);
    }
}

#[test]
fn another_lens_is_found() {
    for ratio in [0.6, 0.8, 1.3] {
        assert_found(&Mistake::LensChanged { camera: 2, ratio }, 4);
    }
}

#[test]
fn a_body_of_another_scale_is_found() {
    for n_cameras in [3, 4] {
        for ratio in [0.8, 1.25] {
            assert_found(&Mistake::BodyScaled { body: 0, ratio }, n_cameras);
        }
    }
}

#[test]
fn tags_of_another_size_are_found_by_one_camera() {
    for (n_cameras, ratios) in [(1, [0.6, 1.5]), (2, [0.8, 1.25]), (4, [0.8, 1.25])] {
        for ratio in ratios {
            assert_found(&Mistake::SizesScaled { body: 0, ratio }, n_cameras);
        }
    }
}

#[test]
fn turned_and_exchanged_tags_are_found() {
    for n_cameras in [1, 2, 4] {
        for quarters in 1..=3 {
            assert_found(&Mistake::TagTurned { tag: 1, quarters }, n_cameras);
        }
        assert_found(&Mistake::TagsExchanged { a: 0, b: 4 }, n_cameras);
    }
}

#[test]
fn a_small_tag_is_found() {
    for n_cameras in [2, 4] {
        assert_found(&Mistake::TagResized { tag: 0, ratio: 0.7 }, n_cameras);
    }
}

#[test]
fn two_mistakes_are_found_one_after_the_other() {
    let turned = Mistake::CameraTurned {
        camera: 2,
        quarters: 1,
    };
    let exchanged = Mistake::TagsExchanged { a: 1, b: 5 };
    let truth = exchanged.amended(&turned.amended(&site(4)));
    let explanation = explained(&site(4), &truth, 1);
    let found: Vec<Mistake> = explanation.found.iter().map(|one| one.mistake).collect();
    assert!(
        found.contains(&turned) && found.contains(&exchanged),
        "{explanation:?}"
    );
    assert!(!explanation.is_open());
}
