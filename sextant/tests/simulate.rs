//! `sextant simulate`: a recording with the files of a person and the truth beside them.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{refused, sextant, stdout};
use nalgebra::Vector3;
use serde_json::Value;
use sextant_simulator::Scenario;
use sextant_site_files::{read_object, read_rig, read_toml};
use std::fs;
use std::path::Path;
use std::process::Output;

fn simulate(folder: &Path, arguments: &[&str]) -> Output {
    sextant()
        .arg("simulate")
        .args(arguments)
        .arg("--out")
        .arg(folder)
        .output()
        .unwrap()
}

/// Median distance of replayed poses from the true ones, m.
fn median_error(folder: &Path, rig: &str, object: &str) -> f64 {
    let output = sextant()
        .args(["replay", "--json"])
        .arg(folder)
        .arg("--rig")
        .arg(folder.join(rig))
        .arg("--object")
        .arg(folder.join(object))
        .output()
        .unwrap();
    let truth = fs::read_to_string(folder.join("cuboid.tum")).unwrap();
    let truth: Vec<(&str, Vector3<f64>)> = truth
        .lines()
        .map(|line| {
            let (seconds, numbers) = line.split_once(' ').unwrap();
            let numbers: Vec<f64> = numbers.split(' ').map(|n| n.parse().unwrap()).collect();
            (seconds, Vector3::new(numbers[0], numbers[1], numbers[2]))
        })
        .collect();
    let mut errors = Vec::new();
    for line in stdout(&output).lines() {
        let pose: Value = serde_json::from_str(line).unwrap();
        let Some(t_ns) = pose["t_ns"].as_u64() else {
            continue;
        };
        let seconds = format!("{}.{:09}", t_ns / 1_000_000_000, t_ns % 1_000_000_000);
        let (_, position) = truth.iter().find(|(at, _)| *at == seconds).unwrap();
        let estimate: [f64; 3] = serde_json::from_value(pose["position"].clone()).unwrap();
        errors.push((Vector3::from(estimate) - position).norm());
    }
    assert!(errors.len() > 10, "{} poses", errors.len());
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

#[test]
fn the_files_are_off_and_the_truth_is_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().join("site");
    let arguments = ["--objects", "1", "--seed", "3", "--seconds", "0.5"];
    stdout(&simulate(&folder, &arguments));
    let rig = |name: &str| read_rig(&folder.join(name)).unwrap();
    let (written, built) = (rig("rig.toml"), rig("rig.true.toml"));
    for (written, built) in written.cameras().iter().zip(built.cameras()) {
        let place = |camera: &sextant_site_model::Camera| {
            camera.world_from_camera.unwrap().translation.vector
        };
        let moved = (place(written) - place(built)).norm();
        assert!((1e-4..0.02).contains(&moved), "{moved}");
        let focal = written.lens.intrinsics().fx / built.lens.intrinsics().fx;
        assert!(focal != 1.0 && (focal - 1.0).abs() < 0.02, "{focal}");
    }
    let object = |name: &str| read_object(&folder.join(name)).unwrap();
    let (written, built) = (object("cuboid.toml"), object("cuboid.true.toml"));
    let scale = built.tags()[0].size_m / written.tags()[0].size_m;
    assert!(scale != 1.0 && (scale - 1.0).abs() < 0.02, "{scale}");
    // The images show what the true files say, not what the written ones do.
    let right = median_error(&folder, "rig.true.toml", "cuboid.true.toml");
    let off = median_error(&folder, "rig.toml", "cuboid.toml");
    assert!(right < 3e-4 && off > 1e-3, "{right} {off}");
}

#[test]
fn a_scenario_file_says_what_is_simulated() {
    let root = tempfile::tempdir().unwrap();
    let (first, second) = (root.path().join("a"), root.path().join("b"));
    let files_only = ["--cameras", "1", "--objects", "1", "--seconds", "0"];
    stdout(&simulate(&first, &files_only));
    let file = first.join("scenario.toml");
    let mut scenario: Scenario = read_toml(&file).unwrap();
    scenario.cameras[0].jpeg_quality = Some(50);
    scenario.cameras[0].clock.offset_ns = 5_000_000;
    scenario.cameras[0].network.delay_ms = 7.0;
    sextant_site_files::write_toml(&file, &scenario).unwrap();
    stdout(&simulate(
        &second,
        &[file.to_str().unwrap(), "--seconds", "0.1"],
    ));
    let table = fs::read_to_string(second.join(&scenario.cameras[0].id).join("data.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip(1)
        .map(|l| l.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 3, "{table}");
    let [stamp_ns, arrival_ns] = [0, 2].map(|column| rows[0][column].parse::<u64>().unwrap());
    // Half of the exposure and the delay, less the offset of the stamp.
    assert_eq!(arrival_ns - stamp_ns, 2_000_000 + 7_000_000 - 5_000_000);
}

#[test]
fn mistakes_are_reported_with_file_and_key_and_nothing_is_overwritten() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("site");
    let files_only = ["--cameras", "1", "--objects", "1", "--seconds", "0"];
    stdout(&simulate(&folder, &files_only));
    refused(&simulate(&folder, &files_only), 3, "give a new one");
    let file = folder.join("scenario.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(
        &file,
        text.replace("noise = ", "jpeg_quality = 0\nnoise = "),
    )
    .unwrap();
    let other = root.path().join("other");
    let output = simulate(&other, &[file.to_str().unwrap()]);
    let expected =
        "scenario.toml: jpeg_quality of camera \"north\" is 0, but must be from 1 to 100";
    refused(&output, 3, expected);
}
