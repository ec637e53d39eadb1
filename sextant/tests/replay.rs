//! `sextant replay` and `sextant detect` on a recording: same poses whichever way, same bytes whenever.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{Recording, refused, sextant, stdout};
use serde_json::{Value, json};
use sextant_geometry::PoseParts;
use std::fs;
use std::path::Path;

const IMAGES: u64 = 20;

fn rows(text: &str) -> Vec<Value> {
    let rows = text.lines().map(|line| serde_json::from_str(line).unwrap());
    rows.collect()
}

/// `detections.jsonl` of every camera, from what `sextant detect --json` says, with the documented keys and no other.
fn write_detections(recording: &Recording, into: &Path) {
    for camera in 0..2 {
        let name = recording.camera(camera);
        let csv = fs::read_to_string(recording.path(name).join("data.csv")).unwrap();
        let mut text = String::new();
        for row in csv.lines().skip(1) {
            let [t_ns, file, arrival_ns] = row.split(',').collect::<Vec<_>>()[..] else {
                panic!("{row}")
            };
            let picture = recording.path(name).join("data").join(file);
            let output = sextant()
                .args(["detect", "--json"])
                .arg(picture)
                .output()
                .unwrap();
            let said = &rows(&stdout(&output))[0];
            let tags = said["detections"].as_array().unwrap().iter().map(|tag| {
                let [family, id] = [&tag["family"], &tag["id"]];
                let [corners, covariance] = [&tag["corners"], &tag["corner_covariance"]];
                let between = &tag["corner_cross_covariance"];
                json!({
                    "family": family, "id": id, "corners": corners,
                    "corner_covariance": covariance, "corner_cross_covariance": between,
                })
            });
            let numbers = [t_ns, arrival_ns].map(|number| number.parse::<u64>().unwrap());
            let line = json!({"t_ns": numbers[0], "arrival_ns": numbers[1], "detections": tags.collect::<Vec<_>>()});
            text += &format!("{line}\n");
        }
        fs::create_dir_all(into.join(name)).unwrap();
        fs::write(into.join(name).join("detections.jsonl"), text).unwrap();
    }
}

#[test]
fn pictures_and_their_detections_give_the_same_bytes() {
    let recording = Recording::new(IMAGES);
    let from_pictures = stdout(&recording.replay(recording.root(), &[]));
    assert!(rows(&from_pictures).len() >= IMAGES as usize);

    let other = tempfile::tempdir().unwrap();
    write_detections(&recording, other.path());
    assert_eq!(stdout(&recording.replay(other.path(), &[])), from_pictures);

    let written = tempfile::tempdir().unwrap();
    let mut detect = sextant();
    detect
        .args(["detect", "--threads", "2", "--dataset"])
        .arg(recording.root());
    stdout(&detect.arg("--out").arg(written.path()).output().unwrap());
    assert_eq!(
        stdout(&recording.replay(written.path(), &[])),
        from_pictures
    );
}

#[test]
fn poses_are_near_the_truth_and_in_order() {
    let recording = Recording::new(IMAGES);
    let rows = rows(&stdout(&recording.replay(recording.root(), &[])));
    let times: Vec<u64> = rows
        .iter()
        .map(|row| row["t_ns"].as_u64().unwrap())
        .collect();
    assert!(times.is_sorted());
    let object = &recording.scenario.objects[0];
    for row in rows.iter().skip(5) {
        let truth = PoseParts::from(&object.world_from_object(row["t_ns"].as_u64().unwrap()));
        let position = row["position"].as_array().unwrap();
        let off = position.iter().zip(truth.position);
        let off: f64 = off.map(|(p, t)| (p.as_f64().unwrap() - t).powi(2)).sum();
        assert!(off.sqrt() < 0.005, "{} m off: {row}", off.sqrt());
        assert_eq!(row["covariance"].as_array().unwrap().len(), 36);
        assert_eq!(row["object"], recording.object.as_str());
    }
}

#[test]
fn neither_a_second_run_nor_threads_nor_the_order_of_arrival_change_a_byte() {
    let recording = Recording::new(IMAGES);
    let first = stdout(&recording.replay(recording.root(), &[]));
    for threads in ["1", "3"] {
        let again = recording.replay(recording.root(), &["--threads", threads]);
        assert_eq!(stdout(&again), first);
    }
    // The other camera first at every instant, and by more.
    for camera in 0..2 {
        let csv = recording.path(recording.camera(camera)).join("data.csv");
        let text = fs::read_to_string(&csv).unwrap();
        let swapped = text
            .lines()
            .map(|row| match row.split(',').collect::<Vec<_>>()[..] {
                [time, file, _] if !row.starts_with('#') => {
                    let arrival =
                        time.parse::<u64>().unwrap() + 9_000_000 - 3_000_000 * camera as u64;
                    format!("{time},{file},{arrival}\n")
                }
                _ => format!("{row}\n"),
            });
        let swapped: String = swapped.collect();
        assert_ne!(swapped, text);
        fs::write(&csv, swapped).unwrap();
    }
    assert_eq!(stdout(&recording.replay(recording.root(), &[])), first);
}

#[test]
fn files_of_poses_are_json_lines_or_tum_text() {
    let recording = Recording::new(6);
    let lines = stdout(&recording.replay(recording.root(), &[]));
    let out = tempfile::tempdir().unwrap();
    let file = |name: &str| out.path().join(name).display().to_string();
    let jsonl = file("poses.jsonl");
    stdout(&recording.replay(recording.root(), &["--out", &jsonl]));
    assert_eq!(fs::read_to_string(&jsonl).unwrap(), lines);

    let tum = file("poses.tum");
    let said = stdout(&recording.replay(recording.root(), &["--json", "--out", &tum]));
    let tum = fs::read_to_string(&tum).unwrap();
    assert_eq!(tum.lines().count(), lines.lines().count());
    assert!(tum.lines().all(|line| line.split(' ').count() == 8));
    assert_eq!(rows(&said)[0]["objects"][0]["poses"], lines.lines().count());

    let nameless = recording.replay(recording.root(), &["--out", &file("poses")]);
    refused(
        &nameless,
        2,
        "let it end with .jsonl, .tum, .c3d, .usda or .glb",
    );
}

#[test]
fn poses_are_compared_with_a_reference_in_numbers_and_pictures() {
    let recording = Recording::new(6);
    let out = tempfile::tempdir().unwrap();
    let file = |name: &str| out.path().join(name).display().to_string();
    let [poses, again, plots] = ["poses.jsonl", "again.jsonl", "plots"].map(file);
    stdout(&recording.replay(recording.root(), &["--out", &poses]));
    let compared = [
        "--json",
        "--out",
        &again,
        "--against",
        &poses,
        "--plots",
        &plots,
    ];
    let said = stdout(&recording.replay(recording.root(), &compared));
    let against = &rows(&said)[0]["against"];
    assert_eq!(against[0], "none");
    let object = &against[1][0];
    assert_eq!(object["object"], recording.object.as_str());
    assert_eq!(
        (&object["position_mm"]["max"], &object["within_95"]),
        (&0.0.into(), &1.0.into())
    );
    let plot = Path::new(&plots).join(format!("{}.png", recording.object));
    assert!(fs::read(plot).unwrap().starts_with(b"\x89PNG"));

    let unknown = ["--out", &again, "--against", "truth.what"];
    refused(
        &recording.replay(recording.root(), &unknown),
        3,
        "the name says no format",
    );
    fs::write(file("bad.tum"), "# seconds\n1 2 3\n").unwrap();
    let bad = ["--out", &again, "--against", &file("bad.tum")];
    refused(&recording.replay(recording.root(), &bad), 3, "bad.tum:2");
}

#[test]
fn in_real_time_the_poses_are_the_same() {
    let recording = Recording::new(6);
    let fast = stdout(&recording.replay(recording.root(), &[]));
    let slow = stdout(&recording.replay(recording.root(), &["--realtime"]));
    let sorted = |text: &str| {
        let mut lines: Vec<&str> = text.lines().collect();
        lines.sort_unstable();
        lines.join("\n")
    };
    assert_eq!(sorted(&slow), sorted(&fast));
}

#[test]
fn detect_says_one_line_an_image_in_the_order_given() {
    let recording = Recording::new(3);
    let folder = recording.path(recording.camera(0)).join("data");
    let mut pictures = crate::recording::files_below(&folder);
    pictures.reverse();
    let detect = |threads: &str| {
        let mut command = sextant();
        command.args(["detect", "--json", "--threads", threads, "--reps", "2"]);
        rows(&stdout(&command.args(&pictures).output().unwrap()))
    };
    let said = detect("1");
    let names: Vec<&str> = said
        .iter()
        .map(|row| row["file"].as_str().unwrap())
        .collect();
    let given: Vec<_> = pictures.iter().map(|path| path.to_str().unwrap()).collect();
    assert_eq!(names, given);
    assert!(said.iter().all(|row| row["ms"].as_f64().unwrap() > 0.0));
    let keys: Vec<&String> = said[0]["detections"][0]
        .as_object()
        .unwrap()
        .keys()
        .collect();
    assert_eq!(
        keys,
        [
            "corner_covariance",
            "corner_cross_covariance",
            "corners",
            "family",
            "hamming",
            "id",
            "margin"
        ]
    );
    let detections = |rows: &[Value]| {
        rows.iter()
            .map(|r| r["detections"].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(detections(&detect("3")), detections(&said));
}

#[test]
fn detect_follows_tags_from_picture_to_picture() {
    let recording = Recording::new(4);
    let folder = recording.path(recording.camera(0)).join("data");
    let pictures = crate::recording::files_below(&folder);
    let detect = |how: &[&str]| {
        let mut command = sextant();
        command.args(["detect", "--json"]).args(how);
        rows(&stdout(&command.args(&pictures).output().unwrap()))
    };
    let ids = |row: &Value| -> Vec<u64> {
        let tags = row["detections"].as_array().unwrap();
        tags.iter().map(|tag| tag["id"].as_u64().unwrap()).collect()
    };
    let (each, followed) = (detect(&[]), detect(&["--tracking"]));
    assert_eq!(each[0]["tracking"], Value::Null);
    assert_eq!(followed[0]["tracking"]["share"], 1.0);
    assert!(ids(&each[0]).len() > 1);
    for (each, followed) in each.iter().zip(&followed).skip(1) {
        assert_eq!(ids(each), ids(followed));
        let report = &followed["tracking"];
        assert!(report["share"].as_f64().unwrap() <= 1.0);
        let found = report["followed"].as_u64().unwrap() + report["discovered"].as_u64().unwrap();
        assert_eq!(found as usize, ids(followed).len());
    }
}
