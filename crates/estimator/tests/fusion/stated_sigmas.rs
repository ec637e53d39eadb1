//! What calibration leaves wrong for good is in the covariance, as far as files have its deviation: Monte Carlo over
//! calibrations.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::FusionOptions;
use sextant_geometry::lens::Intrinsics;
use sextant_geometry::{Lens, Pose, se3};
use sextant_site_model::{
    Camera, Exposure, ImageObservation, LensSigma, ObjectModel, PoseSigma, Prior, Rig, Stamp,
};

use crate::arm_scene::{self, ALL, arm};
use crate::scene::{
    self, Random, cube, feed, fusion, path_at, rig, run, with_cameras, with_pose_priors,
};
use crate::uncertainty::nees;

const MISPLACED: PoseSigma = PoseSigma {
    position_m: 0.0005,
    orientation_rad: 0.0005,
};
const MISCAST: LensSigma = LensSigma {
    focal_px: 1.5,
    distortion_px: 0.8,
};
const EXPOSED: Exposure = Exposure {
    length_s: 0.004,
    stamp: Stamp::End,
};
const MISSTUCK: PoseSigma = PoseSigma {
    position_m: 0.0003,
    orientation_rad: 0.006,
};

/// A site as it is and as calibration says that it is.
struct Site {
    truth: (Rig, ObjectModel),
    configured: (Rig, ObjectModel),
}

/// Seconds of images, and how many of them are passed over from one to the next: so far apart that self-calibration
/// does not compare the cameras, after which covariances are relative to them.
const SECONDS: f64 = 2.4;
const APART: usize = 11;

/// NEES per degree of freedom after some seconds at many sites, with the configured deviations and without.
fn with_and_without(
    calibrated: impl Fn(&mut Random) -> Site,
    state: impl Fn(&Site) -> (Rig, ObjectModel),
) -> (f64, f64) {
    let (mut with, mut without, sites) = (0.0, 0.0, 60);
    for seed in 0..sites {
        let site = calibrated(&mut Random(seed + 900));
        let at_the_end = |(rig, object): &(Rig, ObjectModel)| {
            let mut fusion = fusion(rig, object, FusionOptions::default());
            let mut last = None;
            let (true_rig, true_object) = &site.truth;
            let images = run(true_rig, true_object, 0.05, SECONDS, &mut Random(seed));
            for image in images.into_iter().step_by(APART) {
                last = feed(&mut fusion, image).pop().or(last);
            }
            let last = last.unwrap();
            nees(&last, &path_at(last.capture_ns))
        };
        with += at_the_end(&state(&site)) / sites as f64;
        without += at_the_end(&site.configured) / sites as f64;
    }
    println!("{with} {without}");
    (with, without)
}

fn displaced(pose: &Pose, sigma: PoseSigma, random: &mut Random) -> Pose {
    let mut step =
        |sigma: f64| Vector3::new(random.gauss(), random.gauss(), random.gauss()) * sigma;
    let (shift, turn) = (step(sigma.position_m), step(sigma.orientation_rad));
    let turned = UnitQuaternion::from_scaled_axis(turn) * pose.rotation;
    Pose::from_parts((pose.translation.vector + shift).into(), turned)
}

fn changed(rig: &Rig, change: impl FnMut(Camera) -> Camera) -> Rig {
    unstated(rig, change).exact()
}

fn unstated(rig: &Rig, change: impl FnMut(Camera) -> Camera) -> Rig {
    let cameras = rig.cameras().iter().map(scene::unstated);
    Rig::new(cameras.map(change).collect()).unwrap()
}

fn placed(camera: &mut Camera) {
    camera.pose_prior = Prior::Sigma(MISPLACED);
}

#[test]
fn what_is_stated_about_the_cameras_poses_is_in_the_covariance() {
    let (with, without) = with_and_without(
        |random| {
            let configured = changed(&rig(3), |camera| Camera {
                world_from_camera: camera
                    .world_from_camera
                    .map(|pose| displaced(&pose, MISPLACED, random)),
                ..camera
            });
            Site {
                truth: (rig(3), cube()),
                configured: (configured, cube()),
            }
        },
        |site| {
            let (rig, object) = &site.configured;
            (with_cameras(rig, placed), object.clone())
        },
    );
    assert!((0.5..1.5).contains(&with), "NEES {with}");
    assert!(without > 2.0 * with, "NEES {without} against {with}");
}

/// Whether or not the cameras' clocks are to be found out beside the joints.
#[test]
fn what_is_stated_about_the_cameras_poses_holds_for_the_links_of_an_arm() {
    let truth = rig(3);
    for clock_error_ns in [0, ImageObservation::CLOCK_ERROR_UNKNOWN] {
        let mut all = Vec::new();
        for seed in 0..20 {
            let random = &mut Random(seed + 300);
            let configured = changed(&truth, |camera| Camera {
                world_from_camera: camera
                    .world_from_camera
                    .map(|pose| displaced(&pose, MISPLACED, random)),
                ..camera
            });
            let configured = with_cameras(&configured, placed);
            let mut fusion = fusion(&configured, &arm(), FusionOptions::default());
            let mut last = None;
            let images = arm_scene::run(&truth, SECONDS, |_| ALL, seed);
            for mut image in images.into_iter().step_by(APART) {
                image.clock_error_ns = clock_error_ns;
                last = feed(&mut fusion, image).pop().or(last);
            }
            let last = last.unwrap();
            let (base, values) = arm_scene::at(last.capture_ns);
            let links = last.articulated.unwrap().links.into_iter();
            for (link, truth) in links.zip(arm_scene::links(&base, values)) {
                let off = se3::difference(&link.world_from_link, &truth);
                all.push(off.dot(&link.covariance.cholesky().unwrap().solve(&off)) / 6.0);
            }
        }
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        assert!((0.5..1.5).contains(&mean), "NEES {mean}");
    }
}

/// The same lens with other errors: distortion as the sigma means it, the cube of the distance from the centre.
fn recast(focal_px: f64, distortion_px: f64) -> Lens {
    let numbers = Intrinsics {
        fx: 600.0 + focal_px,
        fy: 600.0 + focal_px,
        cx: 319.5,
        cy: 239.5,
    };
    let reach = 319.5f64.hypot(239.5) / 600.0;
    let cubic = distortion_px / 600.0 / reach.powi(3);
    Lens::brown_conrady(numbers, [cubic, 0.0, 0.0, 0.0, 0.0]).unwrap()
}

#[test]
fn what_is_stated_about_the_lenses_is_in_the_covariance() {
    let (with, without) = with_and_without(
        |random| Site {
            truth: (
                changed(&rig(2), |camera| Camera {
                    lens: recast(0.0, 0.0),
                    ..camera
                }),
                cube(),
            ),
            configured: (
                changed(&rig(2), |camera| Camera {
                    lens: recast(
                        MISCAST.focal_px * random.gauss(),
                        MISCAST.distortion_px * random.gauss(),
                    ),
                    ..camera
                }),
                cube(),
            ),
        },
        |site| {
            let (rig, object) = &site.configured;
            let cast = |camera: &mut Camera| camera.lens_prior = Prior::Sigma(MISCAST);
            (with_cameras(rig, cast), object.clone())
        },
    );
    assert!((0.5..1.5).contains(&with), "NEES {with}");
    assert!(without > 2.0 * with, "NEES {without} against {with}");
}

#[test]
fn what_is_stated_about_the_tags_places_is_in_the_covariance() {
    let (with, without) = with_and_without(
        |random| {
            let mut tags = cube().tags().to_vec();
            for tag in &mut tags {
                let place = tag.object_from_tag.unwrap();
                tag.object_from_tag = Some(displaced(&place, MISSTUCK, random));
            }
            Site {
                truth: (rig(3), cube()),
                configured: (
                    rig(3),
                    ObjectModel::new(cube().id().clone(), tags).unwrap().exact(),
                ),
            }
        },
        |site| {
            let (rig, object) = &site.configured;
            (rig.clone(), with_pose_priors(object, MISSTUCK))
        },
    );
    assert!((0.5..1.5).contains(&with), "NEES {with}");
    assert!(without > 2.0 * with, "NEES {without} against {with}");
}

/// A cube whose tags are all off by one motion of its frame.
fn off_its_frame(sigma: PoseSigma, random: &mut Random) -> ObjectModel {
    let frame = displaced(&Pose::identity(), sigma, random);
    let mut tags = cube().tags().to_vec();
    for tag in &mut tags {
        tag.object_from_tag = tag.object_from_tag.map(|place| frame * place);
    }
    ObjectModel::new(cube().id().clone(), tags).unwrap().exact()
}

#[test]
fn what_is_stated_about_an_objects_frame_is_in_the_covariance() {
    let (with, without) = with_and_without(
        |random| Site {
            truth: (rig(3), cube()),
            configured: (rig(3), off_its_frame(MISSTUCK, random)),
        },
        |site| {
            let (rig, object) = site.configured.clone();
            (rig, object.with_frame_sigma(Some(MISSTUCK)).unwrap())
        },
    );
    assert!((0.5..1.5).contains(&with), "NEES {with}");
    assert!(without > 2.0 * with, "NEES {without} against {with}");
}

#[test]
fn what_is_stated_about_the_scale_of_a_rig_is_in_the_covariance() {
    let sigma = 0.003;
    let scaled = |factor: f64| {
        let centres = rig(3);
        let centres = centres
            .cameras()
            .iter()
            .map(|camera| camera.world_from_camera.unwrap().translation.vector);
        let centre = centres.sum::<Vector3<f64>>() / 3.0;
        let rig = changed(&rig(3), |mut camera| {
            let pose = camera.world_from_camera.as_mut().unwrap();
            pose.translation.vector = centre + (pose.translation.vector - centre) * factor;
            camera
        });
        let mut tags = cube().tags().to_vec();
        for tag in &mut tags {
            tag.size_m *= factor;
            let place = tag.object_from_tag.as_mut().unwrap();
            place.translation.vector *= factor;
        }
        (
            rig,
            ObjectModel::new(cube().id().clone(), tags).unwrap().exact(),
        )
    };
    let (with, without) = with_and_without(
        |random| Site {
            truth: (rig(3), cube()),
            configured: scaled(1.0 + sigma * random.gauss()),
        },
        |site| {
            let (rig, object) = site.configured.clone();
            (rig.with_scale_sigma(Some(sigma)).unwrap(), object)
        },
    );
    assert!((0.5..1.5).contains(&with), "NEES {with}");
    assert!(without > 2.0 * with, "NEES {without} against {with}");
}

#[test]
fn what_a_former_rig_states_holds_as_long_as_what_it_is_about() {
    let stated = with_cameras(&rig(3), |camera| {
        placed(camera);
        camera.lens_prior = Prior::Sigma(MISCAST);
        camera.line_delay_s = Some(2e-5);
        camera.exposure = Some(EXPOSED);
    });
    let stated = stated.with_scale_sigma(Some(0.003)).unwrap();
    let mut index = 0;
    let other = unstated(&rig(3), |camera| {
        index += 1;
        match index {
            1 => Camera {
                world_from_camera: Some(Pose::identity()),
                ..camera
            },
            2 => Camera {
                lens: recast(1.0, 0.0),
                ..camera
            },
            _ => Camera {
                resolution: [800, 600],
                ..camera
            },
        }
    });
    let held = other.holding_on_to(&stated);
    assert_eq!(
        held.scale_sigma(),
        Some(0.003),
        "two cameras stand where they stood"
    );
    let of = |camera: &Camera| {
        let pose = camera.pose_prior == Prior::Sigma(MISPLACED);
        let lens = camera.lens_prior == Prior::Sigma(MISCAST);
        assert_eq!(camera.line_delay_s.is_some(), camera.exposure.is_some());
        [pose, lens, camera.line_delay_s.is_some()]
    };
    let found: Vec<[bool; 3]> = held.cameras().iter().map(of).collect();
    assert_eq!(
        found,
        [
            [false, true, true],
            [true, false, true],
            [true, true, false]
        ]
    );
}
