//! A site with a camera that is a millimetre off, shown to the thread; what it finds is put in force, recorded, taken back.

use super::*;
use crate::changes::{Decision, Desk};
use crate::refinements::{Record, change_of};
use nalgebra::{Isometry3, Matrix2, Point3, Vector3};
use sextant_estimator::{Camera, ObjectModel, ObjectTag, Rig, TagCorners, TagId};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_proto::Keys;
use sextant_site_files::parse_rig;
use sextant_tag_families::Family;
use std::path::Path;

fn rig(off: &Pose) -> Rig {
    let numbers = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    let camera = |(at, id): (usize, &str)| {
        let angle = 0.8 * at as f64;
        let from = Point3::new(1.5 * angle.cos(), 1.5 * angle.sin(), 1.2);
        let pose = Isometry3::face_towards(&from, &Point3::origin(), &-Vector3::z());
        Camera {
            id: CameraId::new(id).unwrap(),
            resolution: [640, 480],
            lens: Lens::pinhole(numbers).unwrap(),
            world_from_camera: Some(if at == 2 { pose * off } else { pose }),
        }
    };
    Rig::new(
        ["a", "b", "c"]
            .into_iter()
            .enumerate()
            .map(camera)
            .collect(),
    )
    .unwrap()
}

/// Four tags in a square.
fn object() -> ObjectModel {
    let tag = |id: u32| ObjectTag {
        tag: TagId {
            family: Family::Tag36h11,
            id,
        },
        size_m: 0.1,
        object_from_tag: Some(Pose::translation(
            0.12 * f64::from(id % 2),
            0.12 * f64::from(id / 2),
            0.0,
        )),
    };
    ObjectModel::new("plate".parse().unwrap(), (0..4).map(tag).collect()).unwrap()
}

/// What a camera sees at a time, with a little of everything as noise.
fn image(camera: &Camera, object: &ObjectModel, seconds: f64) -> ImageObservation {
    let wave = |period: f64, phase: f64| (seconds / period + phase).sin();
    let place = Isometry3::new(
        Vector3::new(
            0.4 * wave(5.1, 0.0),
            0.4 * wave(6.7, 1.0),
            0.2 * wave(4.3, 2.0),
        ),
        Vector3::new(0.4 * wave(3.9, 0.5), 0.4 * wave(4.7, 1.5), wave(8.3, 0.0)),
    );
    let camera_from_object = camera.world_from_camera.unwrap().inverse() * place;
    let tags = object.tags().iter().enumerate().map(|(at, tag)| {
        let camera_from_tag = camera_from_object * tag.object_from_tag.unwrap();
        let mut number = 0.0;
        let corners = tag_corners_in_tag(tag.size_m).map(|corner| {
            number += 1.0;
            let shake =
                1e4 * seconds + 7.3 * at as f64 + 1.9 * number + camera_from_tag.translation.x;
            let noise = nalgebra::Vector2::new((13.0 * shake).sin(), (17.0 * shake).cos());
            camera.lens.project(&(camera_from_tag * corner)).unwrap() + 0.1 * noise
        });
        TagCorners {
            tag: tag.tag,
            corners,
            corner_covariance: [Matrix2::zeros(); 4],
            corner_cross_covariance: [Matrix2::zeros(); 6],
        }
    });
    ImageObservation {
        camera: camera.id.clone(),
        capture_ns: 1_000_000_000 + (seconds * 1e9) as u64,
        clock_error_ns: 0,
        exposure_ns: 0,
        tags: tags.collect(),
    }
}

fn first_change(refining: &Refining, truth: &Rig) -> Change {
    for moment in 0..90 {
        for frame in [0.0, 0.03, 0.06, 0.09] {
            for camera in truth.cameras() {
                let seen = image(camera, &object(), 2.0 * f64::from(moment) + frame);
                let words = refining.words.as_ref().unwrap();
                words.send(Word::Image(seen)).unwrap();
            }
        }
    }
    // What ends the last moment; the thread looks after every word.
    loop {
        match refining
            .findings
            .recv_timeout(Duration::from_secs(120))
            .unwrap()
        {
            Finding::Better(change) => return change,
            Finding::TooLittle | Finding::Fine | Finding::NotBetter { .. } => {}
            other @ Finding::TooFar { .. } => panic!("{other}"),
        }
    }
}

fn models(off: &Pose) -> Models {
    Models {
        rig: rig(off),
        objects: vec![object()],
    }
}

#[test]
fn a_change_is_found_recorded_and_can_be_taken_back() {
    let before = models(&Isometry3::new(
        Vector3::new(0.0008, -0.0006, 0.0),
        Vector3::new(0.0, 0.0005, 0.0),
    ));
    let options = RefinementOptions::default();
    let refining = Refining::start(&before, options, Duration::ZERO).unwrap();
    let truth = rig(&Pose::identity());
    let found = first_change(&refining, &truth);
    let folder = tempfile::tempdir().unwrap();
    let record = Record::in_folder(folder.path().join("refinements"));
    let former = record.write(&found, &before, 5_000_000).unwrap();
    let mut desk = Desk::new(Keys::new("lab").unwrap(), before.clone(), None);
    let made = desk.make(change_of(&found, &before).unwrap()).unwrap();
    assert!(matches!(made, Decision::Take(..)));

    let pose = |rig: &Rig| {
        rig.cameras()[2]
            .world_from_camera
            .unwrap()
            .translation
            .vector
    };
    let error = |rig: &Rig| (pose(rig) - pose(&truth)).norm();
    assert!(
        error(&desk.models().rig) < 0.5 * error(&before.rig),
        "{found:?}"
    );

    let text = std::fs::read_to_string(&former).unwrap();
    let back = parse_rig(Path::new("former"), &text).unwrap();
    assert_eq!(error(&back), error(&before.rig));
    let lines = std::fs::read_to_string(folder.path().join("refinements/record.jsonl")).unwrap();
    let line: serde_json::Value = serde_json::from_str(lines.trim_end()).unwrap();
    assert_eq!(line["what"], "camera c");
    let px = |when: &str| line["held_back"][when].as_f64().unwrap();
    assert!(px("after_px") < px("before_px"), "{line}");
}

#[test]
fn nothing_is_shown_while_something_is_wrong_and_clocks_are_set_right() {
    let site = models(&Pose::identity());
    let hour = Duration::from_secs(3600);
    let mut refining = Refining::start(&site, RefinementOptions::default(), hour).unwrap();
    let moved = Fault::CameraMoved {
        camera: CameraId::new("a").unwrap(),
    };
    let late = ClockOffset {
        offset_s: 0.004,
        sigma_s: 0.0001,
    };
    let clocks = BTreeMap::from([(CameraId::new("b").unwrap(), late)]);
    let seen = image(&site.rig.cameras()[1], &object(), 1.0);
    refining.take_health(&[moved], clocks.clone());
    refining.show(&seen);
    assert!(!refining.health.is_sound && refining.dropped() == 0);
    refining.take_health(&[], clocks);
    let right = refining.health.set_right(&seen);
    assert_eq!(seen.capture_ns - right.capture_ns, 4_000_000);
}

#[test]
fn what_must_not_be_lost_waits_until_there_is_room_and_nobody_waits_for_it() {
    let site = models(&Pose::identity());
    let (words, heard) = sync_channel(1);
    let (_, findings) = sync_channel(1);
    let mut refining = Refining {
        words: Some(words),
        waiting: VecDeque::new(),
        findings,
        thread: None,
        dropped: 0,
        health: Health {
            is_sound: true,
            ..Health::default()
        },
    };
    let seen = image(&site.rig.cameras()[0], &object(), 1.0);
    refining.show(&seen);
    refining.refused();
    refining.take_models(&site);
    refining.show(&seen);
    assert_eq!(refining.dropped(), 1);
    assert!(matches!(heard.try_recv(), Ok(Word::Image(_))));
    refining.show(&seen);
    assert!(matches!(heard.try_recv(), Ok(Word::Models(_))));
    refining.show(&seen);
    assert!(matches!(heard.try_recv(), Ok(Word::Image(_))));
    assert_eq!(refining.dropped(), 2);
}
