//! `sextant learn`: a thing turned before a camera gives the places of its tags.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::carried::{before, cap, record, rig, without_poses};
use crate::recording::{refused, sextant, stdout};
use serde_json::Value;
use sextant_geometry::{Pose, se3};
use sextant_site_files::{read_object, write_rig};
use sextant_site_model::{ObjectId, ObjectModel};
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// A folder with `rig.toml` and what its first camera sees of the cap's tags that count, turned before it.
fn turned(counts: impl Fn(u32) -> bool, images: u32) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let rig = rig();
    write_rig(&folder.path().join("rig.toml"), &without_poses(&rig)).unwrap();
    let tags = cap().tags().to_vec().into_iter();
    let seen = tags.filter(|tag| counts(tag.tag.id)).collect();
    let seen = ObjectModel::new(ObjectId::new("cap").unwrap(), seen).unwrap();
    let camera = &rig.cameras()[0];
    let turning = (images, |seconds| before(camera, seconds));
    record(
        &folder.path().join("turning"),
        camera,
        &seen,
        turning.0,
        turning.1,
    );
    folder
}

fn learn(folder: &Path, more: &[&str]) -> Output {
    let mut command = sextant();
    command.current_dir(folder).args(["learn", "turning"]);
    command.args(["--rig", "rig.toml", "--id", "cap", "--out", "cap.toml"]);
    command.args(more).output().unwrap()
}

const TAGS: [&str; 4] = ["--tags", "0,1,2,3,4,5", "--size", "0.04"];

/// Places relative to the first tag: three tenths of a millimetre, three tenths of a degree.
fn assert_right(found: &ObjectModel) {
    let relative = |object: &ObjectModel, at: usize| -> Pose {
        let place = |at: usize| object.tags()[at].object_from_tag.unwrap();
        place(0).inverse() * place(at)
    };
    for at in 1..6 {
        let error = se3::difference(&relative(found, at), &relative(&cap(), at));
        assert!(error.fixed_rows::<3>(0).norm() < 3e-4, "{at}: {error}");
        let attitude = error.fixed_rows::<3>(3).norm().to_degrees();
        assert!(attitude < 0.3, "{at}: {error}");
    }
}

#[test]
fn turning_a_thing_gives_the_places_of_its_tags() {
    let folder = turned(|_| true, 90);
    let folder = folder.path();
    let output = learn(folder, &[TAGS.as_slice(), &["--json"]].concat());
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(report["verdict"]["grade"], "good", "{report}");
    assert_eq!(report["tags"].as_array().unwrap().len(), 6);
    let file = folder.join("cap.toml");
    assert_right(&read_object(&file).unwrap());
    assert!(!folder.join("cap.toml.former").exists());

    let first = fs::read_to_string(&file).unwrap();
    let output = learn(folder, &[TAGS.as_slice(), &["--origin", "tag:2"]].concat());
    assert!(stdout(&output).contains("cap.toml: "));
    let again = read_object(&file).unwrap();
    assert_right(&again);
    let origin = again.tags()[2].object_from_tag.unwrap();
    assert!(se3::log(&origin).norm() < 1e-9, "{origin}");
    let former = fs::read_to_string(folder.join("cap.toml.former")).unwrap();
    assert_eq!(former, first);
}

#[test]
fn a_tag_that_no_image_shows_is_left_out_and_named() {
    let folder = turned(|id| id != 4, 20);
    let folder = folder.path();
    refused(&learn(folder, &TAGS), 4, "36h11:4");
    let text = fs::read_to_string(folder.join("cap.toml")).unwrap();
    assert!(
        text.contains("id = 0\n") && !text.contains("id = 4\n"),
        "{text}"
    );
}

#[test]
fn wrong_input_is_named_and_nothing_is_written() {
    let folder = turned(|id| id != 4, 20);
    let folder = folder.path();
    let refuses = |more: &[&str], expected: &str| refused(&learn(folder, more), 3, expected);
    refuses(&[TAGS.as_slice(), &["--strict"]].concat(), "36h11:4");
    refuses(&["--tags", "0,1"], "the size of tag 0 is unknown");
    refuses(&["--from", "none.toml"], "none.toml");
    let of = |camera: &'static str| [TAGS.as_slice(), &["--camera", camera]].concat();
    refuses(&of("south"), "the rig has no camera \"south\"");
    refuses(&of("north"), "there is no folder of camera \"north\"");
    let detections = folder.join("turning/east/detections.jsonl");
    fs::write(&detections, "{\"t_ns\": 1, \"detections\": []}\n").unwrap();
    refuses(&TAGS, "none shows");
    fs::write(&detections, "{\"t_ns\": 1,").unwrap();
    refuses(&TAGS, "detections.jsonl");
    assert!(!folder.join("cap.toml").exists());
}
