//! Constellations that are learned, and images that cannot teach them.

use crate::scene::*;
use nalgebra::{Isometry3, Vector3};
use sextant_calibrator::{Gauge, Grade, LearnError, LearnPlan, LearnSession, LearnedObject};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{Camera, FOCAL_SIGMA, ImageObservation, ObjectModel, Rig};

fn one_camera() -> Rig {
    let camera = Camera {
        world_from_camera: Some(looking([-0.4, 0.35, 0.5], [0.0, 0.0, 0.0])),
        ..rig().cameras()[0].clone()
    };
    Rig::new(vec![camera]).unwrap()
}

fn turning(model: &ObjectModel, n: u32, seed: u64) -> Vec<ImageObservation> {
    let rig = one_camera();
    let mut noise = Random::new(seed);
    (0..n)
        .map(|at| {
            let seconds = 0.1 * f64::from(at);
            image(
                &rig.cameras()[0],
                model,
                &turned(seconds),
                seconds,
                SHARP,
                &mut noise,
            )
        })
        .collect()
}

fn plan(ids: impl Iterator<Item = u32>) -> LearnPlan {
    LearnPlan {
        object: "thing".parse().unwrap(),
        tags: ids.map(|id| (tag(id), 0.038)).collect(),
        cameras: Vec::new(),
        gauge: Gauge::Tag(tag(0)),
        from: None,
    }
}

fn learned(plan: LearnPlan, images: &[ImageObservation]) -> Result<LearnedObject, LearnError> {
    let mut session = LearnSession::new(blind(&one_camera()), plan)?;
    images.iter().for_each(|image| session.handle(image));
    session.solve()
}

/// Largest error of position (mm) and attitude (degrees) relative to the first tag.
fn errors(found: &ObjectModel, truth: &ObjectModel) -> (f64, f64) {
    let relative = |model: &ObjectModel, at: usize| {
        let pose = |at: usize| model.tags()[at].object_from_tag.unwrap();
        pose(0).inverse() * pose(at)
    };
    let error = |at| se3::difference(&relative(found, at), &relative(truth, at));
    let errors: Vec<_> = (1..truth.tags().len()).map(error).collect();
    let worst = |first: usize| {
        errors
            .iter()
            .map(|e| e.fixed_rows::<3>(first).norm())
            .fold(0.0, f64::max)
    };
    (worst(0) * 1e3, worst(3).to_degrees())
}

#[test]
fn every_tag_finds_its_place() {
    let found = learned(plan(0..7), &turning(&thing(), 90, 1)).unwrap();
    let (mm, deg) = errors(&found.object, &thing());
    assert!(mm < 0.5 && deg < 0.4, "{mm} {deg}");
    assert_eq!(
        found.report.verdict.grade,
        Grade::Good,
        "{}",
        found.report.verdict
    );
    assert!(
        (found.object.tags()[0]
            .object_from_tag
            .unwrap()
            .translation
            .vector)
            .norm()
            < 1e-9
    );
}

#[test]
fn the_centroid_is_the_origin_where_nobody_says_otherwise() {
    let mut plan = plan(0..7);
    plan.gauge = Gauge::Centroid;
    let found = learned(plan, &turning(&thing(), 60, 2)).unwrap();
    let tags = found.object.tags().iter();
    let sum: Vector3<f64> = tags
        .map(|t| t.object_from_tag.unwrap().translation.vector)
        .sum();
    assert!(sum.norm() < 1e-9);
}

#[test]
fn tags_that_no_image_joins_are_named_with_the_turn() {
    let mut images = turning(&thing(), 90, 3);
    for image in &mut images {
        let low = image.tags.iter().filter(|t| t.tag.id < 3).count();
        let high = image.tags.len() - low;
        image.tags.retain(|t| (t.tag.id < 3) == (low >= high));
    }
    let refused = match learned(plan(0..7), &images) {
        Ok(found) => found.report.unsolved.join("; "),
        Err(refused) => refused.to_string(),
    };
    assert!(
        refused.contains("fall into groups")
            && refused.contains("Turn the object slowly from tag36h11:"),
        "{refused}"
    );
}

#[test]
fn tags_that_no_image_shows_are_named() {
    let found = learned(plan(0..9), &turning(&thing(), 40, 4)).unwrap();
    let unsolved = found.report.unsolved.join("; ");
    assert!(
        unsolved.contains("no image shows tag36h11:7 and tag36h11:8"),
        "{unsolved}"
    );
    assert_eq!(found.object.tags().len(), 7);
    let (mm, deg) = errors(&found.object, &thing());
    assert!(mm < 0.5 && deg < 0.4, "{mm} {deg}");
    assert!(matches!(
        learned(plan(0..7), &[]),
        Err(LearnError::NothingSeen { .. })
    ));
    let mut other = plan(50..52);
    other.gauge = Gauge::Centroid;
    let foreign = learned(other, &turning(&thing(), 10, 4))
        .unwrap_err()
        .to_string();
    assert!(foreign.contains("only tag36h11:"), "{foreign}");
}

#[test]
fn a_tag_is_added_and_one_that_moved_is_learned_anew() {
    let before = changed(&thing(), |tag| {
        if tag.tag.id == 2 {
            tag.object_from_tag = tag
                .object_from_tag
                .map(|at| at * Isometry3::translation(0.01, 0.0, 0.0));
        }
        if tag.tag.id == 6 {
            tag.object_from_tag = None;
        }
    });
    let mut adding = plan([6].into_iter());
    adding.from = Some(before.clone());
    let images = turning(&thing(), 90, 5);
    let refused = learned(adding.clone(), &images).unwrap_err().to_string();
    assert!(
        refused.contains("tag36h11:2 cannot be placed: not where the given object has"),
        "{refused}"
    );
    adding.tags.push((tag(2), 0.038));
    let found = learned(adding, &images).unwrap();
    for (found, truth) in found.object.tags().iter().zip(thing().tags()) {
        let error = se3::difference(
            &found.object_from_tag.unwrap(),
            &truth.object_from_tag.unwrap(),
        );
        assert!(
            error.fixed_rows::<3>(0).norm() < 1e-4,
            "{}: {error}",
            found.tag
        );
    }
    assert_eq!(found.report.kept.len(), 5);
}

#[test]
fn a_size_that_disagrees_is_estimated() {
    let mut plan = plan(0..7);
    plan.tags[3].1 = 0.038 * 1.02;
    let found = learned(plan, &turning(&thing(), 90, 6)).unwrap();
    let relative = |at: usize| found.report.tags[at].size_ratio / found.report.tags[0].size_ratio;
    assert!((relative(3) * 1.02 - 1.0).abs() < 1e-3, "{}", relative(3));
    assert!((relative(4) - 1.0).abs() < 1e-3, "{}", relative(4));
    let verdict = found.report.verdict;
    assert_eq!(verdict.grade, Grade::Usable);
    let said = verdict.to_string();
    assert!(
        said.contains("tag36h11:3 is ") && said.contains("% smaller than given"),
        "{said}"
    );
}

#[test]
fn two_cameras_join_tags_that_neither_sees_together() {
    let two = thing_with_two_sides();
    let cameras = [[0.5, 0.0, 0.3], [-0.5, 0.0, 0.3]].map(|from| looking(from, [0.0, 0.0, 0.0]));
    let cameras = cameras.into_iter().enumerate().map(|(at, pose)| Camera {
        world_from_camera: Some(pose),
        ..rig().cameras()[at].clone()
    });
    let rig = Rig::new(cameras.collect()).unwrap();
    let mut noise = Random::new(7);
    let mut session = LearnSession::new(rig.clone(), plan(0..2)).unwrap();
    for at in 0..60 {
        let seconds = 0.1 * f64::from(at);
        let sway = Isometry3::new(
            Vector3::zeros(),
            Vector3::new(
                0.3 * (2.0 * seconds).sin(),
                0.4 * (1.3 * seconds).sin(),
                0.3 * seconds.sin(),
            ),
        );
        for camera in rig.cameras() {
            session.handle(&image(camera, &two, &sway, seconds, SHARP, &mut noise));
        }
    }
    let found = session.solve().unwrap();
    let (mm, deg) = errors(&found.object, &two);
    assert!(mm < 0.5 && deg < 0.3, "{mm} {deg}");
}

/// Two tags back to back.
fn thing_with_two_sides() -> ObjectModel {
    let side = |turn: f64| {
        Isometry3::new(Vector3::zeros(), Vector3::new(0.0, 0.0, turn))
            * Isometry3::new(
                Vector3::new(0.03, 0.0, 0.0),
                Vector3::new(0.0, std::f64::consts::FRAC_PI_2, 0.0),
            )
    };
    let tags: [(u32, f64, Pose); 2] = [
        (0, 0.038, side(0.0)),
        (1, 0.038, side(std::f64::consts::PI)),
    ];
    object("thing", tags.into_iter())
}

/// Four tags on a card, of which two are folded up by 20 degrees.
fn card() -> ObjectModel {
    let place = |id: u32| {
        let (x, y) = (0.05 * f64::from(id % 2), 0.05 * f64::from(id / 2));
        let fold = Vector3::new(0.35 * f64::from(id / 2), 0.0, 0.0);
        Isometry3::new(Vector3::new(x - 0.025, y - 0.025, 0.0), fold)
    };
    object("card", (0..4).map(|id| (id, 0.038, place(id))))
}

#[test]
fn views_from_the_front_only_are_solved_right() {
    let rig = Rig::new(vec![Camera {
        world_from_camera: Some(above(0.0, 0.5)),
        ..rig().cameras()[0].clone()
    }])
    .unwrap();
    for seed in 60..66 {
        let mut noise = Random::new(seed);
        let mut plan = plan(0..4);
        plan.object = "card".parse().unwrap();
        let mut session = LearnSession::new(blind(&rig), plan).unwrap();
        for at in 0..60 {
            let way = 0.3 * f64::from(at);
            let place = Vector3::new(0.05 * way.sin(), 0.04 * (1.3 * way).cos(), 0.0);
            let pose = Isometry3::new(place, Vector3::new(0.0, 0.0, 0.2 * way.sin()));
            session.handle(&image(
                &rig.cameras()[0],
                &card(),
                &pose,
                0.1 * f64::from(at),
                SHARP,
                &mut noise,
            ));
        }
        assert!(session.progress().complete < 1.0);
        let found = session.solve().unwrap();
        let (mm, deg) = errors(&found.object, &card());
        assert!(mm < 0.8 && deg < 0.7, "{seed}: {mm} mm, {deg} degrees");
    }
}

#[test]
fn stated_deviations_are_honest() {
    let (mut inside, mut all) = (0, 0);
    for seed in 100..160 {
        // The lens is off by as much as such lenses are.
        let mut noise = Random::new(seed + 1000);
        let factor = || 1.0 + FOCAL_SIGMA * noise.normal();
        let rig = with_focal_lengths_off(&blind(&one_camera()), factor);
        let mut session = LearnSession::new(rig, plan(0..7)).unwrap();
        turning(&thing(), 40, seed)
            .iter()
            .for_each(|image| session.handle(image));
        let found = session.solve().unwrap();
        let frame = thing().tags()[0].object_from_tag.unwrap().inverse();
        for at in 1..7 {
            let truth = frame * thing().tags()[at].object_from_tag.unwrap();
            let error = se3::difference(&found.object.tags()[at].object_from_tag.unwrap(), &truth);
            let stated = &found.report.tags[at];
            for axis in 0..3 {
                inside += usize::from(error[axis].abs() * 1e3 <= 2.0 * stated.sigma_axes_mm[axis]);
                inside += usize::from(
                    error[3 + axis].abs().to_degrees() <= 2.0 * stated.sigma_axes_deg[axis],
                );
                all += 2;
            }
        }
    }
    let part = inside as f64 / f64::from(all);
    assert!((0.9..=0.99).contains(&part), "{part}");
}
