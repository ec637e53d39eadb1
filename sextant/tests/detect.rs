//! `sextant detect`: corners through a lens, and what a rig must say for that.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{Recording, refused, sextant, stdout};
use nalgebra::Vector3;
use serde_json::Value;
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_simulator::{ObservedTag, Observer, Path, Random, Scenario, Visibility};
use std::f64::consts::PI;

/// A cube at rest close below a camera whose lens bends its edges by pixels.
fn near_a_wide_lens() -> Scenario {
    let intrinsics = Intrinsics {
        fx: 520.0,
        fy: 520.0,
        cx: 322.0,
        cy: 236.0,
    };
    let mut scenario = Scenario::demo(1, 1, 7);
    let camera = &mut scenario.cameras[0];
    camera.lens = Lens::brown_conrady(intrinsics, [-0.3, 0.1, 0.002, -0.001, 0.0]).unwrap();
    camera.world_from_camera =
        Pose::translation(0.0, 0.0, 0.28) * Pose::rotation(Vector3::x() * PI);
    camera.exposure_ns = 0;
    scenario.objects[0].path = Path::at_rest(&Pose::translation(0.09, 0.06, 0.0));
    scenario
}

/// Greatest error of any tag's corners in what the program says.
fn worst_error(said: &str, truth: &[ObservedTag]) -> f64 {
    let line: Value = serde_json::from_str(said.lines().next().unwrap()).unwrap();
    let mut worst = 0.0_f64;
    for tag in truth {
        let detections = line["detections"].as_array().unwrap();
        let found = detections.iter().find(|found| found["id"] == tag.id);
        let corners = found.unwrap()["corners"].as_array().unwrap();
        for (corner, expected) in corners.iter().zip(&tag.corners) {
            let [x, y] = [0, 1].map(|axis| corner[axis].as_f64().unwrap());
            worst = worst.max((x - expected.x).hypot(y - expected.y));
        }
    }
    worst
}

#[test]
fn tags_are_fitted_through_the_lens_of_the_rigs_camera() {
    let recording = Recording::render_all(near_a_wide_lens(), 1);
    let facing = Visibility {
        min_edge_px: 60.0,
        ..Visibility::default()
    };
    let mut observer = Observer::new(&recording.scenario, facing).unwrap();
    let truth = observer.observe(0, 1_000_000_000, 0.0, &mut Random::new(1));
    assert!(!truth.is_empty());
    let image = recording.first_image(0);
    let detect = |more: &[&str]| {
        let mut command = sextant();
        command.args(["detect", "--json"]).args(more).arg(&image);
        command.output().unwrap()
    };
    let rig = recording.path("rig.toml");
    let rig = rig.to_str().unwrap();
    let without = worst_error(&stdout(&detect(&[])), &truth);
    let with = detect(&["--rig", rig, "--camera", recording.camera(0)]);
    let with = worst_error(&stdout(&with), &truth);
    assert!(with < 0.05, "{with} px with the lens");
    assert!(
        with < without / 5.0,
        "{with} px with the lens, {without} without"
    );
    let elsewhere = detect(&["--rig", rig, "--camera", "elsewhere"]);
    refused(&elsewhere, 3, "there is no camera \"elsewhere\"");
}
