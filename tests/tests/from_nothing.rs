//! From nothing to poses in one frame, by the commands of `docs/ten-minutes.md` and by nothing else: what is printed is
//! rendered before simulated cameras, and everything from the pictures on is the program that a person runs.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_geometry::{Intrinsics, Lens, Pose, se3};
use sextant_simulator::{Path as Way, Wave};
use sextant_site_files::read_object;
use sextant_site_model::ObjectModel;
use std::path::Path;
use system_tests::{Shots, Studio, looking_at, sextant};

const GUIDE: &str = include_str!("../../docs/ten-minutes.md");
const CAMERAS: [&str; 3] = ["north", "east", "south"];

/// Each camera has a lens of its own.
fn lens(k: usize) -> Lens {
    let by = k as f64;
    let numbers = Intrinsics {
        fx: 610.0 + 7.0 * by,
        fy: 611.0 + 7.0 * by,
        cx: 322.0 - 4.0 * by,
        cy: 236.0 + 3.0 * by,
    };
    Lens::brown_conrady(numbers, [-0.12 - 0.02 * by, 0.05, 4e-4, -3e-4, 0.0]).expect("a lens")
}

/// Where it hangs over the table.
fn place(k: usize) -> Pose {
    let around = 0.4 + 2.1 * k as f64;
    let from = [
        0.62 * around.cos(),
        0.62 * around.sin(),
        0.85 + 0.05 * k as f64,
    ];
    looking_at(from, [0.0, 0.0, 0.1])
}

fn studio() -> Studio {
    Studio::with_cameras(
        CAMERAS
            .iter()
            .enumerate()
            .map(|(k, id)| (*id, lens(k), place(k))),
    )
}

/// One camera before which something is held: it looks down from a metre.
fn before(k: usize) -> Studio {
    let above = looking_at([0.0, 0.0, 1.0], [0.0, 0.0, 0.0]);
    Studio::with_cameras([(CAMERAS[k], lens(k), above)])
}

/// Runs the program as a person does; it has to succeed.
fn run(folder: &Path, line: &str) -> String {
    let output = sextant()
        .current_dir(folder)
        .args(line.split_whitespace())
        .output()
        .expect("sextant runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "sextant {line}\n{said}{complained}"
    );
    said
}

fn is_in_the_guide(line: &str) {
    assert!(
        GUIDE.contains(&format!("    sextant {line}\n")),
        "the guide does not say: {line}"
    );
}

/// Runs a line of the guide.
fn guided(folder: &Path, line: &str) -> String {
    is_in_the_guide(line);
    run(folder, line)
}

/// Runs a procedure of the guide over recorded images; it must not call its own result poor.
fn procedure(folder: &Path, line: &str, camera: &str, recording: &str) {
    is_in_the_guide(line);
    let line = line.replace("--camera north", &format!("--camera {camera}"));
    let line = line.replace("--live", recording);
    let said = run(folder, &line);
    println!("sextant {line}\n{said}");
    assert!(!said.contains("; poor"), "sextant {line}\n{said}");
}

fn way(period_s: f64, [x, y, z]: [Wave; 3], [yaw, pitch, roll]: [Wave; 3]) -> Way {
    Way {
        period_s,
        turns: 0,
        position: [x, y, z],
        yaw,
        pitch,
        roll,
        joints: Vec::new(),
        events: Vec::new(),
    }
}

fn swing(mean: f64, order: u32, amplitude: f64, phase: f64) -> Wave {
    Wave::still(mean).and(order, amplitude, phase)
}

/// The board everywhere in the picture, near, tilted to all sides.
fn held_before_the_lens() -> Way {
    let position = [
        swing(0.0, 3, 0.13, 0.0),
        swing(0.0, 5, 0.09, 0.7),
        swing(0.66, 7, 0.06, 0.2),
    ];
    let turn = [
        swing(0.0, 1, 0.4, 0.0),
        swing(0.0, 4, 0.6, 0.3),
        swing(0.0, 6, 0.6, 1.0),
    ];
    way(30.0, position, turn)
}

/// Through what all cameras see.
fn carried_through_the_room() -> Way {
    let position = [
        swing(0.0, 3, 0.22, 0.0),
        swing(0.0, 4, 0.2, 0.9),
        swing(0.22, 5, 0.14, 0.4),
    ];
    let turn = [
        swing(0.0, 2, 1.2, 0.0),
        swing(0.0, 7, 0.35, 0.6),
        swing(0.0, 6, 0.35, 1.4),
    ];
    way(12.0, position, turn)
}

/// Every side to the camera, from near.
fn turned_before_a_camera() -> Way {
    let position = [
        swing(0.0, 5, 0.03, 0.0),
        swing(0.0, 4, 0.02, 0.9),
        swing(0.68, 3, 0.03, 0.4),
    ];
    let turn = [
        swing(0.0, 1, 1.0, 0.0),
        swing(0.0, 2, 1.3, 0.6),
        swing(0.0, 1, 3.3, 0.2),
    ];
    way(20.0, position, turn)
}

/// Another way than any that was calibrated with.
fn held_back() -> Way {
    let position = [
        swing(0.02, 1, 0.15, 0.3),
        swing(-0.03, 2, 0.12, 1.9),
        swing(0.16, 3, 0.06, 1.1),
    ];
    let turn = [
        swing(0.7, 1, 0.9, 0.5),
        swing(0.0, 2, 0.5, 1.3),
        swing(0.2, 3, 0.4, 0.1),
    ];
    way(6.0, position, turn)
}

fn printed(folder: &Path, file: &str) -> ObjectModel {
    read_object(&folder.join(file)).expect("what was printed")
}

fn place_of(model: &ObjectModel, tag: u32) -> Pose {
    let mut tags = model.tags().iter();
    let tag = tags.find(|own| own.tag.id == tag).expect("a printed tag");
    tag.object_from_tag.unwrap_or_default()
}

/// Root mean square errors of the poses, millimetres and degrees, and how many there are.
fn errors(poses: &str, truth: impl Fn(u64) -> Pose) -> (f64, f64, usize) {
    let (mut position, mut attitude, mut n) = (0.0, 0.0, 0);
    for line in poses.lines() {
        let line: Value = serde_json::from_str(line).expect("a line of JSON");
        let numbers =
            |key: &str| -> Vec<f64> { serde_json::from_value(line[key].clone()).expect("numbers") };
        let (p, q) = (numbers("position"), numbers("orientation"));
        let turn = nalgebra::Quaternion::new(q[3], q[0], q[1], q[2]);
        let found = Pose::from_parts(
            nalgebra::Translation3::new(p[0], p[1], p[2]),
            nalgebra::UnitQuaternion::from_quaternion(turn),
        );
        let error = se3::difference(&found, &truth(line["t_ns"].as_u64().expect("a time")));
        position += error.fixed_rows::<3>(0).norm_squared();
        attitude += error.fixed_rows::<3>(3).norm_squared();
        n += 1;
    }
    let rms = |sum: f64| (sum / f64::from(n.max(1))).sqrt();
    (rms(position) * 1e3, rms(attitude).to_degrees(), n as usize)
}

fn print(at: &Path) {
    guided(at, "print board --first 100");
    guided(
        at,
        "print board --columns 2 --rows 2 --size 0.072 --first 200 --id wand --out wand.pdf",
    );
    guided(
        at,
        "print tags --ids 300 --size 0.12 --id floor --out floor.pdf",
    );
    guided(at, "print cube --first 0");
}

fn calibrate_lenses(at: &Path) {
    let recording = at.join("lenses");
    let board = printed(at, "board.toml");
    let shots = Shots {
        images: 30,
        rate_hz: 1.0,
    };
    for (k, id) in CAMERAS.iter().enumerate() {
        let held = before(k).and_sheet(&board, held_before_the_lens());
        held.record(&recording, shots);
        procedure(
            at,
            "calibrate lens --live --board board.toml --camera north --rig rig.toml",
            id,
            "lenses",
        );
    }
}

fn calibrate_the_rig(at: &Path, on_the_floor: &Pose) {
    let floor = with_place(&printed(at, "floor.toml"));
    let room = studio()
        .and_sheet(&printed(at, "wand.toml"), carried_through_the_room())
        .and_sheet(&floor, Way::at_rest(on_the_floor));
    let shots = Shots {
        images: 80,
        rate_hz: 6.7,
    };
    room.record(&at.join("walk"), shots);
    procedure(
        at,
        "calibrate rig --live --rig rig.toml --object wand.toml --origin tag:300 --origin-size 0.12",
        "",
        "walk",
    );
}

/// The floor's tag lies beside, and is not the cube's.
fn learn(at: &Path, cube: &ObjectModel) {
    let floor = with_place(&printed(at, "floor.toml"));
    let table = Way::at_rest(&Pose::translation(0.0, 0.0, 0.004));
    let turned = before(0)
        .and_cube(cube, 0.06, turned_before_a_camera())
        .and_sheet(&floor, table);
    let shots = Shots {
        images: 100,
        rate_hz: 5.0,
    };
    turned.record(&at.join("turning"), shots);
    procedure(
        at,
        "learn --live --rig rig.toml --camera north --size 0.04 --id cube --origin tag:0 --out cube.toml",
        "north",
        "turning",
    );
}

/// The poses of the cube on a path that was held back.
fn track(at: &Path, cube: &ObjectModel) -> String {
    let tracked = studio().and_cube(cube, 0.06, held_back());
    let shots = Shots {
        images: 90,
        rate_hz: 30.0,
    };
    tracked.record(&at.join("play"), shots);
    run(
        at,
        "replay play --rig rig.toml --object cube.toml --out poses.jsonl",
    );
    std::fs::read_to_string(at.join("poses.jsonl")).expect("poses")
}

#[test]
fn what_was_printed_ends_as_poses_in_one_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    print(at);
    let cube = printed(at, "cube.toml");
    let on_the_floor = Pose::translation(0.05, -0.04, 0.004);
    calibrate_lenses(at);
    calibrate_the_rig(at, &on_the_floor);
    learn(at, &cube);
    let (mm, deg, n) = errors(&track(at, &cube), |t_ns| {
        let cube_from_tag = place_of(&cube, 0);
        on_the_floor.inverse() * held_back().world_from_object(t_ns) * cube_from_tag
    });
    println!("{n} poses, {mm:.2} mm, {deg:.3} degrees");
    assert!(n >= 85, "{n} poses");
    assert!(mm < 1.5 && deg < 0.3, "{mm} mm, {deg} degrees");
}

/// A single printed tag has no place in its file; here it lies in the middle of its sheet.
fn with_place(model: &ObjectModel) -> ObjectModel {
    let mut tags = model.tags().to_vec();
    tags[0].object_from_tag = Some(Pose::identity());
    ObjectModel::new(model.id().clone(), tags).expect("an object")
}
