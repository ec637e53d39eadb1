//! `sextant calibrate rig`: a board carried in front of three cameras gives their poses with standard deviations.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::carried::{board, record, rig, through_the_room, without_poses};
use crate::recording::{refused, sextant, stdout};
use serde_json::Value;
use sextant_geometry::{Pose, se3};
use sextant_site_files::{read_rig, write_object, write_rig};
use sextant_site_model::{Camera, Prior, Rig};
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// A folder with `rig.toml` without poses, `board.toml`, and `walk` as the cameras of that rig would see it.
fn walked(rig: &Rig, images: u32) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_rig(&folder.path().join("rig.toml"), &without_poses(rig)).unwrap();
    write_object(&folder.path().join("board.toml"), &board()).unwrap();
    for camera in rig.cameras() {
        let walk = (images, through_the_room);
        record(
            &folder.path().join("walk"),
            camera,
            &board(),
            walk.0,
            walk.1,
        );
    }
    folder
}

fn calibrate(folder: &Path, more: &[&str]) -> Output {
    let mut command = sextant();
    command
        .current_dir(folder)
        .args(["calibrate", "rig", "walk"]);
    command.args(["--rig", "rig.toml", "--object", "board.toml"]);
    command.args(more).output().unwrap()
}

fn text_of(folder: &Path, file: &str) -> String {
    fs::read_to_string(folder.join(file)).unwrap()
}

fn pose_of(camera: &Camera) -> Pose {
    camera.world_from_camera.unwrap()
}

/// Checks every camera relative to the first: half a millimetre, a fiftieth of a degree, and its standard deviation.
fn assert_right(found: &Rig, truth: &Rig) {
    let relative =
        |rig: &Rig, at: usize| pose_of(&rig.cameras()[0]).inverse() * pose_of(&rig.cameras()[at]);
    for at in 1..truth.cameras().len() {
        let error = se3::difference(&relative(found, at), &relative(truth, at));
        let (position, attitude) = (error.fixed_rows::<3>(0), error.fixed_rows::<3>(3));
        assert!(position.norm() < 5e-4, "{error}");
        assert!(attitude.norm() < 0.02_f64.to_radians(), "{error}");
        let sigma = found.cameras()[at].pose_prior.given().unwrap();
        assert!(position.norm() < 6.0 * sigma.position_m, "{sigma:?}");
        assert!(attitude.norm() < 6.0 * sigma.orientation_rad, "{sigma:?}");
        assert!(sigma.position_m < 5e-4 && sigma.orientation_rad < 5e-4);
    }
}

#[test]
fn a_walk_gives_the_poses_and_how_well_they_are_known() {
    let truth = rig();
    let folder = walked(&truth, 240);
    let folder = folder.path();
    let before = text_of(folder, "rig.toml");
    let output = calibrate(folder, &["--json"]);
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(report["verdict"]["grade"], "good", "{report}");
    assert_eq!(report["reference"], "east");
    let found = read_rig(&folder.join("rig.toml")).unwrap();
    assert_eq!(pose_of(&found.cameras()[0]), Pose::identity());
    assert_eq!(found.cameras()[0].pose_prior, Prior::Exact);
    assert_right(&found, &truth);
    assert_eq!(text_of(folder, "rig.toml.former"), before);

    let before = text_of(folder, "rig.toml");
    let text = stdout(&calibrate(folder, &["--origin", "camera:north"]));
    assert!(text.contains("relative to camera north"), "{text}");
    let again = read_rig(&folder.join("rig.toml")).unwrap();
    let [first, reference, ..] = again.cameras() else {
        panic!("{again:?}")
    };
    assert_eq!(reference.pose_prior, Prior::Exact);
    assert!(first.pose_prior.given().unwrap().position_m > 0.0);
    assert_eq!(text_of(folder, "rig.toml.former"), before);
}

#[test]
fn wrong_input_is_named_and_nothing_is_written() {
    let truth = rig();
    let folder = walked(&truth, 3);
    let folder = folder.path();
    let before = text_of(folder, "rig.toml");
    let refuses = |more: &[&str], expected: &str| refused(&calibrate(folder, more), 3, expected);
    refuses(&["--origin", "camera:south"], "camera south");
    refuses(&["--origin", "tag:3"], "is on the object that is carried");

    let nothing = "{\"t_ns\": 1, \"detections\": []}\n";
    let west = folder.join("walk/west/detections.jsonl");
    let seen = fs::read_to_string(&west).unwrap();
    fs::write(&west, nothing).unwrap();
    refuses(&[], "camera west ");
    fs::write(&west, seen.replacen("t_ns", "when", 1)).unwrap();
    refuses(&[], "detections.jsonl");
    fs::create_dir_all(folder.join("walk/attic")).unwrap();
    fs::write(folder.join("walk/attic/detections.jsonl"), nothing).unwrap();
    fs::write(&west, seen).unwrap();
    refuses(&[], "the rig has no camera \"attic\"");
    fs::remove_dir_all(folder.join("walk/attic")).unwrap();
    fs::remove_file(folder.join("board.toml")).unwrap();
    refuses(&[], "board.toml");
    assert_eq!(text_of(folder, "rig.toml"), before);
    assert!(!folder.join("rig.toml.former").exists());
}
