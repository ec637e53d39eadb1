//! Pictures of a moving object by rolling shutters, blurred by their exposure and stamped with its start: replayed with
//! what the rig file can say of that, and without.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{Recording, stdout};
use serde_json::Value;
use sextant_geometry::PoseParts;
use sextant_simulator::Scenario;
use sextant_site_files::{read_rig, write_rig};
use sextant_site_model::{Exposure, Rig, Stamp};
use std::fs;

const IMAGES: u64 = 24;
/// From the first row to the last 14.4 ms.
const LINE_DELAY_S: f64 = 3e-5;
const EXPOSURE_NS: u64 = 6_000_000;
/// From the start of an image to the middle of its middle row.
const HALF_NS: u64 = (EXPOSURE_NS + 479 * 30_000) / 2;

/// Two cameras whose shutters roll, one from below, and an object that goes at up to half a metre a second.
fn swift_scene() -> Scenario {
    let mut scenario = Scenario::demo(2, 1, 7);
    scenario.objects[0].path.period_s *= 0.25;
    for (camera, line_delay_s) in scenario
        .cameras
        .iter_mut()
        .zip([LINE_DELAY_S, -LINE_DELAY_S])
    {
        camera.line_delay_s = line_delay_s;
        camera.exposure_ns = EXPOSURE_NS;
    }
    scenario
}

/// As most drivers stamp them: with the start of the first row's exposure.
fn stamp_with_the_start(recording: &Recording) {
    for camera in 0..2 {
        let csv = recording.path(recording.camera(camera)).join("data.csv");
        let text = fs::read_to_string(&csv).unwrap();
        let restamped = text.lines().map(|row| match row.split_once(',') {
            Some((time, rest)) if !row.starts_with('#') => {
                format!("{},{rest}\n", time.parse::<u64>().unwrap() - HALF_NS)
            }
            _ => format!("{row}\n"),
        });
        fs::write(&csv, restamped.collect::<String>()).unwrap();
    }
}

/// Rms and largest distance in mm from where the object was at the time that the poses state.
fn off_mm(recording: &Recording, rig: &Rig) -> (f64, f64) {
    write_rig(&recording.path("rig.toml"), rig).unwrap();
    let text = stdout(&recording.replay(recording.root(), &[]));
    let object = &recording.scenario.objects[0];
    let offs = text.lines().skip(8).map(|line| {
        let row: Value = serde_json::from_str(line).unwrap();
        let truth = PoseParts::from(&object.world_from_object(row["t_ns"].as_u64().unwrap()));
        let position = row["position"].as_array().unwrap().iter();
        let off = position.zip(truth.position);
        let off: f64 = off.map(|(p, t)| (p.as_f64().unwrap() - t).powi(2)).sum();
        off.sqrt() * 1e3
    });
    let offs: Vec<f64> = offs.collect();
    assert!(offs.len() > IMAGES as usize / 2, "{}", offs.len());
    let square = offs.iter().map(|off| off * off).sum::<f64>() / offs.len() as f64;
    (square.sqrt(), offs.iter().copied().fold(0.0, f64::max))
}

#[test]
fn rolling_shutters_and_stamps_of_the_start_cost_nothing_where_the_rig_says_so() {
    let recording = Recording::render_all(swift_scene(), IMAGES);
    stamp_with_the_start(&recording);
    let silent = read_rig(&recording.path("rig.toml")).unwrap();
    let mut cameras = silent.cameras().to_vec();
    cameras[0].line_delay_s = Some(LINE_DELAY_S);
    cameras[1].line_delay_s = Some(-LINE_DELAY_S);
    let rolling = Rig::new(cameras.clone()).unwrap();
    for camera in &mut cameras {
        camera.exposure = Some(Exposure {
            length_s: EXPOSURE_NS as f64 * 1e-9,
            stamp: Stamp::Start,
        });
    }
    let whole = Rig::new(cameras).unwrap();

    let said = off_mm(&recording, &whole);
    let unsaid = off_mm(&recording, &silent);
    let without_stamp = off_mm(&recording, &rolling);
    println!(
        "mm, rms and largest: {said:?}; without the stamp {without_stamp:?}; with nothing said {unsaid:?}"
    );
    assert!(said.0 < 1.0 && said.1 < 3.0, "{said:?}");
    assert!(without_stamp.0 > 4.0 * said.0, "{without_stamp:?}");
    assert!(unsaid.0 > 4.0 * said.0, "{unsaid:?}");
}
