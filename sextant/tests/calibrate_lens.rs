//! From print to lens: the board that `sextant print` describes, held before a known lens, gives that lens in rig.toml.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{refused, sextant, stderr, stdout};
use nalgebra::{Point2, Point3, UnitQuaternion, Vector3};
use serde_json::{Value, json};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_recordings::{GreyImage, write_grey_png};
use sextant_site_files::{read_object, read_rig};
use sextant_site_model::ObjectModel;
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
    // Its tags face the camera, whichever way its frame looks.
    let tag_from_board = board.tags()[0].object_from_tag.unwrap().rotation.inverse();
    let mut text = String::new();
    for at in 0..30 {
        let turn = Vector3::new(tilt * wave(at, 1), tilt * wave(at, 2), 0.3 * wave(at, 3));
        let facing = UnitQuaternion::from_scaled_axis(Vector3::x() * std::f64::consts::PI);
        let facing = facing * tag_from_board;
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
    let former = "[[camera]]\nid = \"north\"\nresolution = [640, 480]\n\
        lens = { model = \"pinhole\", fx = 500.0, fy = 500.0, cx = 320.0, cy = 240.0 }\n\
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

/// The same tags as `write_images` needs them, from a board of another tool.
fn board(folder: &Path, name: &str, text: &str) -> ObjectModel {
    fs::write(folder.join(name), text).unwrap();
    read_object(&folder.join(name)).unwrap()
}

#[test]
fn a_charuco_board_of_the_other_layout_is_named_so() {
    let folder = tempfile::tempdir().unwrap();
    let text = "squaresX: 8\nsquaresY: 6\nsquareLength: 0.03\nmarkerLength: 0.022\ndictionary: DICT_4X4_50\n";
    let legacy = format!("{text}legacyPattern: true\n");
    for (seen, given, expected) in [
        (legacy.as_str(), text, "add `legacyPattern: true`"),
        (text, legacy.as_str(), "remove `legacyPattern`"),
    ] {
        let seen = board(folder.path(), "seen.yaml", seen);
        fs::write(folder.path().join("board.yaml"), given).unwrap();
        write_images(&folder.path().join("images"), &seen, 0.7);
        let output = sextant()
            .current_dir(folder.path())
            .args(["calibrate", "lens", "images", "--board", "board.yaml"])
            .args([
                "--camera",
                "north",
                "--rig",
                "rig.toml",
                "--resolution",
                "640x480",
            ])
            .output()
            .unwrap();
        refused(&output, 3, expected);
        assert!(!folder.path().join("rig.toml").exists());
    }
}

/// Grey of a chessboard with squares of `size` metres, or of the wall behind it, where a ray meets it.
fn chessboard_grey(camera_from_board: &Pose, ray: Vector3<f64>, size: f64) -> f64 {
    let board_from_camera = camera_from_board.inverse();
    let (eye, way) = (
        board_from_camera.translation.vector,
        board_from_camera.rotation * ray,
    );
    let at = (eye - way * (eye.z / way.z)) / size;
    let within = |by: f64| (-by..6.0 + by).contains(&at.x) && (-by..5.0 + by).contains(&at.y);
    match () {
        () if !within(2.0) => 110.0,
        () if within(1.0) && (at.x.floor() + at.y.floor()).rem_euclid(2.0) == 0.0 => 30.0,
        () => 215.0,
    }
}

/// Pictures of a chessboard of 7 x 6 inner corners and squares of 25 mm; every other one shows only a part of it.
fn write_pictures(folder: &Path) {
    const RAYS: usize = 4;
    let lens = truth();
    fs::create_dir_all(folder).unwrap();
    for at in 0..16 {
        let turn = Vector3::new(0.6 * wave(at, 1), 0.6 * wave(at, 2), 0.3 * wave(at, 3));
        let rotation = UnitQuaternion::from_scaled_axis(turn);
        let middle = rotation * Vector3::new(0.075, 0.0625, 0.0);
        let depth = if at % 2 == 0 { 0.26 } else { 0.15 };
        let place = Vector3::new(0.04 * wave(at, 5), 0.03 * wave(at, 6), depth) - middle;
        let pose = Pose::from_parts(place.into(), rotation);
        let mut pixels = Vec::new();
        for y in 0..480 {
            for x in 0..640 {
                let mut sum = 0.0;
                for ray in 0..RAYS * RAYS {
                    let [right, down] = [ray % RAYS, ray / RAYS].map(|i| (i as f64 - 1.5) / 2.0);
                    let pixel = Point2::new(f64::from(x) + right, f64::from(y) + down);
                    let ray = lens.unproject(&pixel);
                    sum += ray.map_or(110.0, |ray| chessboard_grey(&pose, ray, 0.025));
                }
                pixels.push((sum / (RAYS * RAYS) as f64).round() as u8);
            }
        }
        let image = GreyImage {
            width: 640,
            height: 480,
            pixels,
        };
        write_grey_png(&folder.join(format!("view{at:02}.png")), &image).unwrap();
    }
}

#[test]
fn a_folder_of_pictures_of_a_plain_chessboard_gives_the_lens() {
    let folder = tempfile::tempdir().unwrap();
    write_pictures(&folder.path().join("images"));
    let text = "id = \"board\"\nkind = \"chessboard\"\ncolumns = 7\nrows = 6\nsize = 0.025\n";
    fs::write(folder.path().join("board.toml"), text).unwrap();
    let output = calibrate(folder.path()).output().unwrap();
    let said = stdout(&output);
    assert!(said.contains("16 of 16 images"), "{said}");
    let rig = read_rig(&folder.path().join("rig.toml")).unwrap();
    let (found, truth) = (rig.cameras()[0].lens.intrinsics(), truth().intrinsics());
    assert!((found.fx / truth.fx - 1.0).abs() < 1e-3, "{found:?}");
    assert!(
        (found.cx - truth.cx).hypot(found.cy - truth.cy) < 0.5,
        "{found:?}"
    );

    // The file of another board, a picture of another camera, and a live site.
    let other = text.replace("columns = 7", "columns = 5");
    fs::write(folder.path().join("board.toml"), other).unwrap();
    let output = calibrate(folder.path()).output().unwrap();
    assert_eq!(output.status.code(), Some(3));
    let said = stderr(&output);
    assert!(
        said.contains("7 x 6 inner corners instead of 5 x 6"),
        "{said}"
    );
    fs::write(folder.path().join("board.toml"), text).unwrap();
    let odd = GreyImage {
        width: 320,
        height: 240,
        pixels: vec![9; 320 * 240],
    };
    write_grey_png(&folder.path().join("images/view99.png"), &odd).unwrap();
    refused(
        &calibrate(folder.path()).output().unwrap(),
        3,
        "view99.png: 320x240 pixels",
    );
    let mut live = sextant();
    live.current_dir(folder.path())
        .args(["calibrate", "lens", "--live", "--board", "board.toml"]);
    live.args(["--camera", "north", "--rig", "rig.toml"]);
    refused(&live.output().unwrap(), 3, "not for plain chessboards");
}
