//! From print to lens: the board that `sextant print` describes, held before a known lens, gives that lens in rig.toml.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod recording;

use nalgebra::{Point2, Point3, UnitQuaternion, Vector3};
use recording::{refused, sextant, stdout};
use serde_json::{Value, json};
use sextant_estimator::ObjectModel;
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_site_files::{read_object, read_rig};
use std::fs;
use std::path::Path;

fn truth() -> Lens {
    let numbers = Intrinsics {
        fx: 598.0,
        fy: 601.0,
        cx: 314.0,
        cy: 246.0,
    };
    Lens::brown_conrady(numbers, [-0.25, 0.08, 0.0005, -0.0003, 0.0]).unwrap()
}

/// A number between -1 and 1 that depends on nothing but its place.
fn wave(at: usize, kind: usize) -> f64 {
    ((at * 37 + kind * 101) as f64 * 0.754_877_666).sin()
}

/// `detections.jsonl` of images of the board, tilted up to `tilt` radians.
fn write_images(folder: &Path, board: &ObjectModel, tilt: f64) {
    let lens = truth();
    let mut text = String::new();
    for at in 0..30 {
        let turn = Vector3::new(tilt * wave(at, 1), tilt * wave(at, 2), 0.3 * wave(at, 3));
        let facing = UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
        let depth = 0.4 + 0.1 * wave(at, 4);
        let place = Vector3::new(0.1 * wave(at, 5), 0.08 * wave(at, 6), depth);
        let pose = Pose::from_parts(
            place.into(),
            UnitQuaternion::from_scaled_axis(turn) * facing,
        );
        let tags = board.tags().iter().filter_map(|tag| {
            let see = |corner: Point3<f64>| {
                let pixel = lens.project(&(pose * tag.object_from_tag.unwrap() * corner))?;
                let inside = (0.0..639.0).contains(&pixel.x) && (0.0..479.0).contains(&pixel.y);
                inside.then_some(pixel)
            };
            let corners = tag_corners_in_tag(tag.size_m).map(see);
            let [Some(a), Some(b), Some(c), Some(d)] = corners else {
                return None;
            };
            let noisy = |p: Point2<f64>, k: usize| {
                let noise = |axis| 0.1 * wave(at * 1000 + tag.tag.id as usize, 10 + 2 * k + axis);
                [p.x + noise(0), p.y + noise(1)]
            };
            let corners = [noisy(a, 0), noisy(b, 1), noisy(c, 2), noisy(d, 3)];
            Some(json!({"family": tag.tag.family, "id": tag.tag.id, "corners": corners}))
        });
        let tags: Vec<Value> = tags.collect();
        text += &format!(
            "{}\n",
            json!({"t_ns": 1_000_000_000 + at, "detections": tags})
        );
    }
    fs::create_dir_all(folder.join("north")).unwrap();
    fs::write(folder.join("north/detections.jsonl"), text).unwrap();
}

fn calibrate(folder: &Path) -> std::process::Command {
    let mut command = sextant();
    command.current_dir(folder).args([
        "calibrate",
        "lens",
        "images",
        "--board",
        "board.toml",
        "--camera",
        "north",
        "--rig",
        "rig.toml",
    ]);
    command
}

fn printed_board(folder: &Path) -> ObjectModel {
    let output = sextant()
        .current_dir(folder)
        .args(["print", "board"])
        .output()
        .unwrap();
    stdout(&output);
    read_object(&folder.join("board.toml")).unwrap()
}

#[test]
fn a_printed_board_gives_the_lens_and_leaves_the_rest_of_the_rig() {
    let folder = tempfile::tempdir().unwrap();
    let board = printed_board(folder.path());
    write_images(&folder.path().join("images"), &board, 0.7);
    let former = "[[camera]]\nid = \"north\"\nresolution = [640, 480]\nlens = { model = \"pinhole\", fx = 500.0, fy = 500.0, cx = 320.0, cy = 240.0 }\n\
        world_from_camera = { position = [1.0, 2.0, 3.0], orientation = [0.0, 0.0, 0.0, 1.0] }\n";
    fs::write(folder.path().join("rig.toml"), former).unwrap();

    let output = calibrate(folder.path())
        .args(["--json", "--report", "report"])
        .output()
        .unwrap();
    let report: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(report["verdict"]["grade"], "good", "{report}");
    assert_eq!(report["lens"]["model"], "brown-conrady");

    let rig = read_rig(&folder.path().join("rig.toml")).unwrap();
    let camera = &rig.cameras()[0];
    let (found, truth) = (camera.lens.intrinsics(), truth().intrinsics());
    assert!((found.fx / truth.fx - 1.0).abs() < 1e-3, "{found:?}");
    assert!(
        (found.cx - truth.cx).hypot(found.cy - truth.cy) < 1.0,
        "{found:?}"
    );
    assert_eq!(
        camera.world_from_camera,
        Some(Pose::translation(1.0, 2.0, 3.0))
    );
    assert_eq!(
        fs::read_to_string(folder.path().join("rig.toml.former")).unwrap(),
        former
    );
    for file in ["residuals.png", "uncertainty.png", "lens.json"] {
        assert!(folder.path().join("report").join(file).is_file(), "{file}");
    }
}

#[test]
fn a_set_that_gives_no_lens_writes_nothing_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let board = printed_board(folder.path());
    write_images(&folder.path().join("images"), &board, 0.0);
    let try_with = |more: &[&str], expected: &str| {
        let output = calibrate(folder.path()).args(more).output().unwrap();
        refused(&output, 3, expected);
    };
    try_with(&[], "the size of the pictures");
    try_with(&["--resolution", "640x480"], "seen from the front only");
    try_with(&["--resolution", "320x240"], "another resolution");
    assert!(!folder.path().join("rig.toml").exists());
}
