//! Objects with unknown tags.

use crate::scene::*;
use nalgebra::{Isometry3, Vector3};
use sextant_calibrator::{
    DiscoveryPlan, DiscoverySession, Gauge, Grade, LearnError, LearnedObject,
};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{Camera, ImageObservation, ObjectModel, Rig};
use sextant_tag_families::Family;
use std::f64::consts::TAU;

fn one_camera() -> Rig {
    let camera = Camera {
        world_from_camera: Some(looking([-0.4, 0.35, 0.5], [0.0, 0.0, 0.0])),
        ..rig().cameras()[0].clone()
    };
    Rig::new(vec![camera]).unwrap()
}

/// Two tags that hang on a wall behind.
fn wall() -> ObjectModel {
    let place = |x: f64| Isometry3::new(Vector3::new(x, 0.0, -0.15), Vector3::new(0.0, 0.0, 0.4));
    object(
        "wall",
        [(40, 0.05, place(-0.12)), (41, 0.05, place(0.12))].into_iter(),
    )
}

/// A book that somebody leafs through beside it: it slides and turns in its own way.
fn book(seconds: f64) -> (ObjectModel, Pose) {
    let place = |x: f64| Isometry3::translation(x, 0.0, 0.0);
    let tags = [(50, 0.04, place(-0.03)), (51, 0.04, place(0.03))];
    let turn = Vector3::new(
        0.3 * (1.9 * seconds).sin(),
        0.0,
        0.4 * (1.1 * seconds).sin(),
    );
    let at = Vector3::new(0.1 + 0.05 * (1.4 * seconds).sin(), 0.16, 0.0);
    (object("book", tags.into_iter()), Isometry3::new(at, turn))
}

struct Room {
    has_book: bool,
    turns: bool,
}

fn images(model: &ObjectModel, n: u32, room: &Room, seed: u64) -> Vec<ImageObservation> {
    let rig = one_camera();
    let camera = &rig.cameras()[0];
    let mut noise = Random::new(seed);
    let mut images = Vec::new();
    for at in 0..n {
        let seconds = 0.1 * f64::from(at);
        let pose = turned(if room.turns { seconds } else { 1.0 });
        let mut see = |model: &ObjectModel, pose: &Pose| {
            image(camera, model, pose, seconds, SHARP, &mut noise)
        };
        let mut all = see(model, &pose);
        all.tags.extend(see(&wall(), &Pose::identity()).tags);
        if room.has_book {
            let (book, pose) = book(seconds);
            all.tags.extend(see(&book, &pose).tags);
        }
        images.push(all);
    }
    images
}

const ALONE: Room = Room {
    has_book: false,
    turns: true,
};

fn plan() -> DiscoveryPlan {
    DiscoveryPlan {
        object: "thing".parse().unwrap(),
        families: vec![Family::Tag36h11],
        size_m: Some(0.038),
        sizes: Vec::new(),
        around: None,
        cameras: Vec::new(),
        gauge: Gauge::Tag(tag(0)),
    }
}

fn session(plan: DiscoveryPlan, images: &[ImageObservation]) -> DiscoverySession {
    let mut session = DiscoverySession::new(blind(&one_camera()), plan).unwrap();
    images.iter().for_each(|image| session.handle(image));
    session
}

fn discovered(
    plan: DiscoveryPlan,
    images: &[ImageObservation],
) -> Result<LearnedObject, LearnError> {
    session(plan, images).solve()
}

fn assert_is_learned(found: &ObjectModel, truth: &ObjectModel) {
    assert_eq!(found.tags().len(), truth.tags().len());
    let relative = |model: &ObjectModel, at: usize| {
        let pose = |at: usize| model.tags()[at].object_from_tag.unwrap();
        pose(0).inverse() * pose(at)
    };
    for at in 1..truth.tags().len() {
        assert_eq!(found.tags()[at].tag, truth.tags()[at].tag);
        let error = se3::difference(&relative(found, at), &relative(truth, at));
        let mm = error.fixed_rows::<3>(0).norm() * 1e3;
        assert!(mm < 0.6, "{}: {mm} mm", found.tags()[at].tag);
    }
}

fn named(ids: impl Iterator<Item = u32>) -> Vec<String> {
    ids.map(|id| tag(id).to_string()).collect()
}

#[test]
fn what_moves_as_one_is_the_object_and_what_stands_still_is_not() {
    let session = session(plan(), &images(&thing(), 90, &ALONE, 1));
    assert!(
        session.progress().complete >= 1.0,
        "{}",
        session.progress().hint
    );
    assert_eq!(session.sketch().len(), 7);
    let learned = session.solve().unwrap();
    assert_is_learned(&learned.object, &thing());
    let found = learned.report.found.unwrap();
    assert_eq!((found.object, found.still), (named(0..7), named(40..42)));
    assert!(found.others.is_empty() && found.loose.is_empty());
    assert_eq!(
        learned.report.verdict.grade,
        Grade::Good,
        "{}",
        learned.report.verdict
    );
}

#[test]
fn sizes_follow_from_the_one_that_is_stated() {
    let sizes = |id: u32| [0.038, 0.038, 0.05, 0.038, 0.03, 0.042, 0.038][id as usize];
    let truth = changed(&thing(), |tag| tag.size_m = sizes(tag.tag.id));
    let plan = DiscoveryPlan {
        size_m: None,
        sizes: vec![(tag(3), 0.038)],
        ..plan()
    };
    let learned = discovered(plan, &images(&truth, 90, &ALONE, 2)).unwrap();
    assert_is_learned(&learned.object, &truth);
    for tag in learned.object.tags() {
        let off = tag.size_m / sizes(tag.tag.id) - 1.0;
        assert!(off.abs() < 3e-3, "{}: {off}", tag.tag);
    }
    assert_eq!(learned.report.solved_sizes.len(), 6);
}

#[test]
fn a_tag_of_another_size_than_most_is_found_out() {
    let truth = changed(&thing(), |tag| {
        if tag.tag.id == 5 {
            tag.size_m = 0.03;
        }
    });
    let learned = discovered(plan(), &images(&truth, 90, &ALONE, 3)).unwrap();
    let [(name, size_m)] = learned.report.solved_sizes.as_slice() else {
        panic!("{:?}", learned.report.solved_sizes);
    };
    assert!(*name == tag(5).to_string() && (size_m / 0.03 - 1.0).abs() < 3e-3);
}

#[test]
fn without_any_size_the_tags_are_compared_and_one_is_asked_for() {
    let plan = DiscoveryPlan {
        size_m: None,
        ..plan()
    };
    let session = session(plan, &images(&thing(), 60, &ALONE, 4));
    assert!(session.progress().complete < 1.0);
    let refused = session.solve().unwrap_err().to_string();
    assert!(
        refused.contains("move as one and are equally large"),
        "{refused}"
    );
    assert!(
        refused.contains("measure the black square of one"),
        "{refused}"
    );
}

#[test]
fn of_several_things_that_move_one_has_to_be_named() {
    let room = Room {
        has_book: true,
        turns: true,
    };
    let images = images(&thing(), 90, &room, 5);
    let refused = discovered(plan(), &images).unwrap_err().to_string();
    assert!(
        refused.contains("Several things move") && refused.contains("tag36h11:50 and tag36h11:51"),
        "{refused}"
    );
    let around = DiscoveryPlan {
        around: Some(tag(4)),
        ..plan()
    };
    let learned = discovered(around, &images).unwrap();
    assert_is_learned(&learned.object, &thing());
    assert_eq!(learned.report.found.unwrap().others, [named(50..52)]);
}

#[test]
fn what_nobody_turns_is_no_object() {
    let room = Room {
        has_book: false,
        turns: false,
    };
    let session = session(plan(), &images(&thing(), 60, &room, 6));
    assert!(session.progress().hint.contains("turn it slowly"));
    let refused = session.solve().unwrap_err().to_string();
    assert!(refused.contains("none of them moved"), "{refused}");
    let nothing = discovered(plan(), &[]).unwrap_err().to_string();
    assert!(nothing.contains("none shows a tag"), "{nothing}");
}

#[test]
fn a_tag_that_is_carried_beside_is_not_glued_on() {
    let mut images = images(&thing(), 90, &ALONE, 7);
    let rig = one_camera();
    let mut noise = Random::new(8);
    let card = object("card", [(60, 0.03, Pose::identity())].into_iter());
    for (at, all) in images.iter_mut().enumerate() {
        let turn = 0.1 * at as f64 / 4.0 * TAU;
        let place = Vector3::new(-0.05 + 0.05 * turn.sin(), -0.15 + 0.03 * turn.cos(), 0.0);
        let pose = Isometry3::new(place, Vector3::new(0.0, 0.0, 0.0));
        let seen = image(
            &rig.cameras()[0],
            &card,
            &pose,
            0.1 * at as f64,
            SHARP,
            &mut noise,
        );
        all.tags.extend(seen.tags);
    }
    let learned = discovered(plan(), &images).unwrap();
    let found = learned.report.found.unwrap();
    assert_eq!((found.object, found.loose), (named(0..7), named(60..61)));
}
