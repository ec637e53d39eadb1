//! What goes wrong while a site runs is named right and in time, and as nothing else: two cubes that move, four
//! cameras.

use nalgebra::{UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input, Output};
use sextant_geometry::Pose;
use sextant_site_model::{
    Camera, ImageObservation, ObjectId, ObjectModel, ObjectTag, Rig, TagCorners,
};
use sextant_site_report::Fault;

use crate::scene::{Eye, PERIOD_NS, Random, START_NS, camera_id, cube, path, rig, tag_id};

/// Seconds after the start at which something goes wrong, and how long it is watched from then on.
const CHANGE_S: f64 = 2.0;
const WATCHED_S: f64 = 4.0;
const SIGMA_PX: f64 = 0.05;

fn id(name: &str) -> ObjectId {
    ObjectId::new(name).unwrap()
}

/// The cube with other tags.
fn twin_cube(name: &str, first_tag: u32) -> ObjectModel {
    let tag = |tag: &ObjectTag| ObjectTag {
        tag: tag_id(first_tag + tag.tag.id),
        ..tag.clone()
    };
    ObjectModel::new(id(name), cube().tags().iter().map(tag).collect())
        .unwrap()
        .exact()
}

/// The site as the machine believes it to be, or as it is.
#[derive(Clone)]
struct Site {
    rig: Rig,
    a: ObjectModel,
    b: ObjectModel,
}

fn site() -> Site {
    Site {
        rig: rig(4),
        a: twin_cube("a", 0),
        b: twin_cube("b", 10),
    }
}

/// World from object: a, b.
fn poses_at(seconds: f64) -> [Pose; 2] {
    let apart = |y: f64| Pose::translation(0.0, y, 0.0);
    [
        apart(0.12) * path(seconds),
        apart(-0.12) * path(seconds + 7.0),
    ]
}

impl Site {
    fn image(
        &self,
        camera: usize,
        seed: u64,
        seconds: f64,
        random: &mut Random,
    ) -> ImageObservation {
        let time_ns = START_NS + (seconds * 1e9) as u64;
        let mut both = poses_at(seconds + seed as f64 * 1.7).into_iter();
        let mut see = |object: &ObjectModel| {
            let (rig, sigma_px) = (&self.rig, SIGMA_PX);
            let eye = Eye {
                rig,
                object,
                sigma_px,
            };
            eye.image(camera, time_ns, &both.next().unwrap(), random)
        };
        let mut image = see(&self.a);
        image.tags.extend(see(&self.b).tags);
        image
    }
}

/// Watches a site that turns from what the machine believes into another: the faults named, each with the seconds from
/// the change to its first naming. `spoil` does what a model can't say to an image.
fn named(truth: &Site, seed: u64, spoil: impl Fn(&mut ImageObservation)) -> Vec<(f64, Fault)> {
    watched(&site(), truth, seed, spoil, CHANGE_S + WATCHED_S).0
}

/// The same of a site that the machine believes to be `before`, which it is again in the end; and the faults at
/// `end_s`.
fn watched(
    before: &Site,
    truth: &Site,
    seed: u64,
    spoil: impl Fn(&mut ImageObservation),
    end_s: f64,
) -> (Vec<(f64, Fault)>, Vec<Fault>) {
    let mut random = Random(seed);
    let objects = vec![before.a.clone(), before.b.clone()];
    let mut fusion = Fusion::new(before.rig.clone(), objects, FusionOptions::default()).unwrap();
    let mut named: Vec<(f64, Fault)> = Vec::new();
    let rounds = (end_s * 1e9) as u64 / PERIOD_NS;
    let cameras = before.rig.cameras().len();
    let images = (0..rounds).flat_map(|round| (0..cameras).map(move |camera| (round, camera)));
    for (round, camera) in images {
        let after_ns = round * PERIOD_NS + camera as u64 * PERIOD_NS / cameras as u64;
        let seconds = after_ns as f64 * 1e-9;
        let image = if (CHANGE_S..CHANGE_S + WATCHED_S).contains(&seconds) {
            let mut image = truth.image(camera, seed, seconds, &mut random);
            spoil(&mut image);
            image
        } else {
            before.image(camera, seed, seconds, &mut random)
        };
        fusion.handle(image.capture_ns + 10_000_000, Input::Image(image));
        while let Some(Output::Pose(_)) = fusion.poll_output() {}
        for fault in fusion.faults() {
            match named.iter_mut().find(|(_, known)| is_same(known, &fault)) {
                Some((_, known)) => *known = fault,
                None => named.push((seconds - CHANGE_S, fault)),
            }
        }
    }
    (named, fusion.faults())
}

/// Sizes are estimates, the last of which counts.
fn is_same(a: &Fault, b: &Fault) -> bool {
    match (a, b) {
        (Fault::TagSize { tag: a, .. }, Fault::TagSize { tag: b, .. }) => a == b,
        _ => a == b,
    }
}

fn nothing(_: &mut ImageObservation) {}

/// One fault, within so many seconds of the change.
fn assert_only(
    named: &[(f64, Fault)],
    within_s: f64,
    is_right: impl Fn(&Fault) -> bool,
    case: &str,
) {
    let right = |(at_s, fault): &(f64, Fault)| is_right(fault) && (0.0..=within_s).contains(at_s);
    assert!(
        named.len() == 1 && named.iter().all(right),
        "{case}: {named:?}"
    );
}

fn with_tag(object: &ObjectModel, tag: u32, change: impl Fn(&mut ObjectTag)) -> ObjectModel {
    let mut tags = object.tags().to_vec();
    change(tags.iter_mut().find(|one| one.tag == tag_id(tag)).unwrap());
    ObjectModel::new(object.id().clone(), tags).unwrap().exact()
}

/// The site with its second camera turned by a degree.
fn bumped(before: &Site, about: Vector3<f64>) -> Site {
    let mut cameras: Vec<Camera> = before.rig.cameras().to_vec();
    let turn = UnitQuaternion::from_scaled_axis(about * 1f64.to_radians());
    let bump = Pose::from_parts(Vector3::zeros().into(), turn);
    cameras[1].world_from_camera = cameras[1].world_from_camera.map(|pose| pose * bump);
    Site {
        rig: Rig::new(cameras).unwrap().exact(),
        ..before.clone()
    }
}

/// The site with the first tag of its first object slipped.
fn slipped(before: &Site, x: f64, y: f64, z: f64) -> Site {
    let slipped = |tag: &mut ObjectTag| {
        tag.object_from_tag = tag
            .object_from_tag
            .map(|pose| pose * Pose::translation(x, y, z));
    };
    Site {
        a: with_tag(&before.a, 0, slipped),
        ..before.clone()
    }
}

#[test]
fn a_camera_bumped_by_a_degree_is_named_within_two_seconds() {
    let about = [
        Vector3::x(),
        Vector3::y(),
        Vector3::z() * 3.0,
        -Vector3::y(),
    ];
    for (seed, about) in (1..).zip(about) {
        let truth = bumped(&site(), about);
        let moved = Fault::CameraMoved {
            camera: camera_id(1),
        };
        let found = named(&truth, seed, nothing);
        assert_only(
            &found,
            2.0,
            |fault| *fault == moved,
            &format!("seed {seed}"),
        );
    }
}

#[test]
fn a_tag_that_slips_by_3_mm_is_named_within_two_and_a_half_seconds() {
    let by = [
        (0.003, 0.0, 0.0),
        (0.0, 0.003, 0.001),
        (-0.002, -0.002, 0.0),
    ];
    for (seed, by) in (1..).zip(by) {
        let truth = slipped(&site(), by.0, by.1, by.2);
        let misplaced = Fault::TagMisplaced {
            object: id("a"),
            tag: tag_id(0),
        };
        let found = named(&truth, seed, nothing);
        assert_only(
            &found,
            2.5,
            |fault| *fault == misplaced,
            &format!("seed {seed}"),
        );
    }
}

#[test]
fn of_two_cameras_it_is_said_that_one_was_moved() {
    let before = Site {
        rig: Rig::new(rig(4).cameras()[..2].to_vec()).unwrap().exact(),
        ..site()
    };
    let [a, b] = [0, 1].map(camera_id);
    let disagree = Fault::CamerasDisagree { a, b: b.clone() };
    // What it sees jumps.
    let moved = Fault::CameraMoved { camera: b };
    for (seed, about) in [(1, Vector3::x()), (2, Vector3::y())] {
        let truth = bumped(&before, about);
        let (found, _) = watched(&before, &truth, seed, nothing, CHANGE_S + WATCHED_S);
        let case = format!("seed {seed}");
        let is_right = |fault: &Fault| *fault == disagree || *fault == moved;
        assert_only(&found, 2.5, is_right, &case);
    }
}

#[test]
fn a_camera_and_a_tag_that_are_wrong_at_once_are_both_named() {
    let truth = slipped(&bumped(&site(), Vector3::y()), 0.003, 0.0, 0.0);
    let (camera, object, tag) = (camera_id(1), id("a"), tag_id(0));
    for seed in 1..3 {
        let found = named(&truth, seed, nothing);
        let both = [
            Fault::CameraMoved {
                camera: camera.clone(),
            },
            Fault::TagMisplaced {
                object: object.clone(),
                tag,
            },
        ];
        assert_eq!(found.len(), 2, "seed {seed}: {found:?}");
        assert!(
            found.iter().all(|(_, fault)| both.contains(fault)),
            "seed {seed}: {found:?}"
        );
    }
}

#[test]
fn a_fault_is_over_when_it_is_mended() {
    let before = site();
    let end_s = CHANGE_S + WATCHED_S + 3.0;
    for truth in [
        bumped(&before, Vector3::y()),
        slipped(&before, 0.0, 0.003, 0.0),
    ] {
        let (found, left) = watched(&before, &truth, 3, nothing, end_s);
        assert_eq!((found.len(), left), (1, vec![]), "{found:?}");
    }
}

#[test]
fn a_tag_larger_or_smaller_by_2_percent_is_named_within_three_seconds() {
    for (seed, ratio) in (1..).zip([1.02, 0.98, 1.02]) {
        let truth = Site {
            a: with_tag(&site().a, 0, |tag| tag.size_m *= ratio),
            ..site()
        };
        let is_right = |fault: &Fault| match fault {
            Fault::TagSize {
                object,
                tag,
                ratio: said,
            } => *object == id("a") && *tag == tag_id(0) && (said - ratio).abs() < 0.005,
            _ => false,
        };
        let found = named(&truth, seed, nothing);
        assert_only(&found, 3.0, is_right, &format!("seed {seed}"));
    }
}

#[test]
fn a_tag_in_one_image_twice_is_named_at_once() {
    for seed in 1..4 {
        let twice = |image: &mut ImageObservation| {
            if image.camera == camera_id(2) {
                let second = image.tags.first().map(|first| TagCorners {
                    corners: first
                        .corners
                        .map(|corner| corner + nalgebra::Vector2::new(90.0, -70.0)),
                    ..first.clone()
                });
                image.tags.extend(second);
            }
        };
        let found = named(&site(), seed, twice);
        let is_twin = |fault: &Fault| matches!(fault, Fault::DuplicateTag { camera, .. } if *camera == camera_id(2));
        let is_stray = |fault: &Fault| matches!(fault, Fault::TagElsewhere { on: None, .. });
        assert!(
            found
                .iter()
                .all(|(_, fault)| is_twin(fault) || is_stray(fault)),
            "seed {seed}: {found:?}"
        );
        assert!(
            found
                .iter()
                .any(|(at_s, fault)| is_twin(fault) && *at_s < 0.1),
            "seed {seed}: {found:?}"
        );
    }
}

/// The print of one of a's tags has got onto b, in place of b's own.
#[test]
fn a_tag_of_one_object_on_another_is_named_with_both_within_two_seconds() {
    for seed in 1..4 {
        let shared = tag_id(0);
        let relabelled = |tag: &ObjectTag| match tag.tag.id {
            10 => ObjectTag {
                tag: shared,
                ..tag.clone()
            },
            _ => tag.clone(),
        };
        let truth = Site {
            b: ObjectModel::new(id("b"), site().b.tags().iter().map(relabelled).collect())
                .unwrap()
                .exact(),
            a: with_tag(&site().a, 0, |tag| tag.tag = tag_id(99)),
            ..site()
        };
        let elsewhere = Fault::TagElsewhere {
            object: id("a"),
            tag: shared,
            on: Some(id("b")),
        };
        let found = named(&truth, seed, nothing);
        assert_only(
            &found,
            2.0,
            |fault| *fault == elsewhere,
            &format!("seed {seed}"),
        );
    }
}

/// Both objects bear it, as if their sheets had been printed alike.
#[test]
fn two_objects_that_share_a_tag_are_named_within_two_seconds() {
    for seed in 1..4 {
        let relabelled = |tag: &ObjectTag| match tag.tag.id {
            13 => ObjectTag {
                tag: tag_id(3),
                ..tag.clone()
            },
            _ => tag.clone(),
        };
        let truth = Site {
            b: ObjectModel::new(id("b"), site().b.tags().iter().map(relabelled).collect())
                .unwrap()
                .exact(),
            ..site()
        };
        let found = named(&truth, seed, nothing);
        let is_right = |fault: &Fault| match fault {
            Fault::TagElsewhere { object, tag, on } => {
                *object == id("a") && *tag == tag_id(3) && *on == Some(id("b"))
            }
            Fault::DuplicateTag { tag, .. } => *tag == tag_id(3),
            _ => false,
        };
        assert!(
            found.iter().all(|(_, fault)| is_right(fault)),
            "seed {seed}: {found:?}"
        );
        assert!(
            found.iter().any(|(at_s, _)| *at_s < 2.0),
            "seed {seed}: {found:?}"
        );
    }
}

#[test]
fn a_sound_site_of_two_objects_has_no_faults() {
    for seed in 1..4 {
        assert_eq!(named(&site(), seed, nothing), []);
    }
}
