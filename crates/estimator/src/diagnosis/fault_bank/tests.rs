//! Which suspect is found, by what views tell.

use super::*;
use crate::measurement::pose_innovation::PoseInnovation;
use nalgebra::{Matrix6, UnitQuaternion, Vector3};
use sextant_geometry::Pose;
use sextant_tag_families::Family;

const ALL: Applicability = Applicability {
    camera: true,
    clock: true,
    tag: true,
};

fn tag(id: u32) -> Tag {
    let family = Family::Tag36h11;
    (0, TagId { family, id })
}

fn centre(camera: usize) -> Vector3<f64> {
    let angle = camera as f64;
    Vector3::new(angle.cos(), angle.sin(), 0.7)
}

fn world_from_tag(id: u32, round: u32) -> Pose {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * (f64::from(round) * 0.05));
    let pose = Pose::from_parts(Vector3::new(0.01 * f64::from(round), 0.0, 0.0).into(), turn);
    pose * Pose::translation(0.05 * f64::from(id), 0.03, 0.0)
}

/// A view whose tag is displaced by so much in its camera's eyes (dt, dr about the tag's link, world axes), with a noise of
/// half a millimetre.
fn view(camera: usize, id: u32, round: u32, displaced: Vector6<f64>) -> PoseInnovation {
    let scale = 1.0 / 0.0005_f64.powi(2);
    let arm = 0.02_f64.powi(2);
    let diagonal = Vector6::new(1.0, 1.0, 0.1, arm, arm, arm) * scale;
    let information = Matrix6::from_diagonal(&diagonal);
    let square = 8.0 + displaced.dot(&(information * displaced));
    let weight = 20.0 / (12.0 + square);
    let world_from_tag = world_from_tag(id, round);
    PoseInnovation {
        information: information * weight,
        gradient: -(information * displaced) * weight,
        square: square * weight,
        weight,
        world_from_link: world_from_tag,
        twist: Vector6::new(0.3, 0.1, 0.0, 0.0, 0.0, 0.5),
        world_from_tag,
        centre: centre(camera),
        camera_variance: Vector6::zeros(),
        tag_variance: Vector6::zeros(),
    }
}

/// What has been told, of which the last of a second has been decided.
fn marginalised(
    mut fault_bank: FaultBank,
    displaced: impl Fn(usize, u32, u32) -> Vector6<f64>,
) -> FaultBank {
    for round in 0..30 {
        for camera in 0..3 {
            for id in 0..3 {
                let one = view(camera, id, round, displaced(camera, id, round));
                fault_bank.take(camera, tag(id), &one, ALL);
            }
        }
        fault_bank.judge(u64::from(round) * 33_000_000 + 1_000_000_000);
    }
    fault_bank
}

/// The cause that is beyond doubt by evidence.
fn told_by_evidence(
    displaced: impl Fn(usize, u32, u32) -> Vector6<f64>,
) -> Option<FaultHypothesis> {
    let fault_bank = marginalised(FaultBank::default(), displaced);
    let open: Vec<(usize, Tag)> = fault_bank.cells.keys().copied().collect();
    let causes = fault_bank.sorted_causes(&open);
    let first = causes.first().map(|(cause, _)| *cause);
    first.filter(|_| fault_bank.stands_out(&causes, &open))
}

#[test]
fn where_nothing_is_displaced_nothing_is_found() {
    assert_eq!(told_by_evidence(|_, _, _| Vector6::zeros()), None);
}

#[test]
fn what_one_camera_sees_elsewhere_is_the_camera() {
    let moved = told_by_evidence(|camera, id, round| {
        // Turned about its centre, all that it sees turns the other way.
        let turn = Vector3::z() * -0.017;
        let arm = world_from_tag(id, round).translation.vector - centre(camera);
        let step = turn.cross(&arm);
        let displaced = Vector6::new(step.x, step.y, step.z, 0.0, 0.0, turn.z);
        displaced * f64::from(u8::from(camera == 1))
    });
    assert_eq!(moved, Some(FaultHypothesis::Camera(1)));
}

#[test]
fn what_all_cameras_see_elsewhere_is_the_tag() {
    let slipped = told_by_evidence(|_, id, round| {
        let step = world_from_tag(id, round).rotation * Vector3::new(0.003, 0.001, 0.0);
        Vector6::new(step.x, step.y, step.z, 0.0, 0.0, 0.0) * f64::from(u8::from(id == 2))
    });
    assert_eq!(slipped, Some(FaultHypothesis::Place(tag(2))));
}

/// A tag as if it were larger.
fn larger(larger: u32) -> impl Fn(usize, u32, u32) -> Vector6<f64> {
    move |camera, id, round| {
        let away = world_from_tag(id, round).translation.vector - centre(camera);
        let step = away * -0.02;
        Vector6::new(step.x, step.y, step.z, 0.0, 0.0, 0.0) * f64::from(u8::from(id == larger))
    }
}

#[test]
fn evidence_names_but_the_size_of_a_tag_that_is_admitted() {
    let found_among = |sizes: Vec<Tag>| -> Vec<FaultHypothesis> {
        let mut fault_bank = FaultBank::default();
        let loud = false;
        fault_bank.admit(NamingPolicy { sizes, loud });
        marginalised(fault_bank, larger(2)).found().collect()
    };
    assert_eq!(found_among(vec![tag(1)]), []);
    assert_eq!(found_among(vec![tag(2)]), [FaultHypothesis::Size(tag(2))]);
}

#[test]
fn what_seems_nearer_to_all_cameras_is_larger() {
    let larger = told_by_evidence(larger(0));
    assert_eq!(larger, Some(FaultHypothesis::Size(tag(0))));
}

#[test]
fn what_lags_behind_its_motion_is_a_clock() {
    let late = told_by_evidence(|camera, _, _| {
        let lag = Vector6::new(0.3, 0.1, 0.0, 0.0, 0.0, 0.5) * -0.02;
        lag * f64::from(u8::from(camera == 2))
    });
    assert_eq!(late, Some(FaultHypothesis::Clock(2)));
}

#[test]
fn wrong_views_that_nothing_foretells_are_no_fault() {
    let wrong = |camera: usize, id: u32, round: u32| {
        let number = f64::from(round * 9 + id) + camera as f64 * 3.0;
        let step = Vector3::new((number * 7.1).sin(), (number * 5.3).sin(), 0.0) * 0.1;
        let is_wrong = f64::from(u8::from(camera == 0 && (round + id).is_multiple_of(3)));
        Vector6::new(step.x, step.y, 0.0, 0.0, 0.0, 0.0) * is_wrong
    };
    assert_eq!(told_by_evidence(wrong), None);
}
