//! `sextant replay` of an arm with two joints: links and joints near the truth, as sure as they say, within their
//! limits.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::arm_recording::{Arm, LINKS};
use nalgebra::{Matrix6, Vector6};
use serde_json::Value;
use sextant_geometry::{Pose, PoseParts, se3};

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let numbers: Vec<f64> = value
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_f64().unwrap())
        .collect();
    numbers.try_into().unwrap()
}

fn pose(value: &Value) -> Pose {
    let parts = PoseParts {
        position: numbers(&value["position"]),
        orientation: numbers(&value["orientation"]),
    };
    parts.to_pose().unwrap()
}

fn covariance(value: &Value) -> Matrix6<f64> {
    Matrix6::from_row_slice(&numbers::<36>(&value["covariance"]))
}

fn t_ns(row: &Value) -> u64 {
    row["t_ns"].as_u64().unwrap()
}

/// Seconds after the recording's start.
fn seconds(row: &Value) -> f64 {
    t_ns(row) as f64 * 1e-9 - 1.0
}

fn link_error(arm: &Arm, row: &Value, link: usize) -> Vector6<f64> {
    se3::difference(
        &pose(&row["links"][link]),
        &arm.world_from_link(link, t_ns(row)),
    )
}

/// Per degree of freedom.
fn nees(arm: &Arm, row: &Value, link: usize) -> f64 {
    let off = link_error(arm, row, link);
    let factor = covariance(&row["links"][link]).cholesky().unwrap();
    off.dot(&factor.solve(&off)) / 6.0
}

fn joint_value(row: &Value, joint: usize) -> f64 {
    row["joints"][joint]["value"].as_f64().unwrap()
}

/// Root mean square of links' positions in m, of joints in rad, and the mean NEES of links.
fn figures(arm: &Arm, rows: &[Value]) -> ([f64; 3], [f64; 2], [f64; 3]) {
    let mean = |of: &dyn Fn(&Value) -> f64| rows.iter().map(of).sum::<f64>() / rows.len() as f64;
    let square =
        |link: usize, row: &Value| link_error(arm, row, link).fixed_rows::<3>(0).norm_squared();
    let off =
        |joint: usize, row: &Value| joint_value(row, joint) - arm.joint_values(t_ns(row))[joint];
    (
        [0, 1, 2].map(|link| mean(&|row| square(link, row)).sqrt()),
        [0, 1].map(|joint| mean(&|row| off(joint, row).powi(2)).sqrt()),
        [0, 1, 2].map(|link| mean(&|row| nees(arm, row, link))),
    )
}

fn settled(rows: Vec<Value>) -> Vec<Value> {
    rows.into_iter().filter(|row| seconds(row) > 0.3).collect()
}

#[test]
fn links_and_joints_are_where_they_are() {
    let arm = Arm::new(4, 11);
    arm.write_corners(90, 0.1, |_, _| true);
    let rows = settled(arm.replay());
    assert!(rows.len() > 300, "{}", rows.len());
    for row in &rows {
        assert_eq!(
            (&row["object"], &row["state"]),
            (&"arm".into(), &"tracking".into())
        );
        let names = |list: &str, key: &str| {
            let list = row[list].as_array().unwrap().iter();
            list.map(|one| one[key].as_str().unwrap().to_owned())
                .collect::<Vec<_>>()
        };
        assert_eq!(names("links", "link"), LINKS);
        assert_eq!(names("joints", "joint"), ["shoulder", "elbow"]);
        assert_eq!(row["links"][0]["position"], row["position"]);
        // The elbow touches both of its limits.
        assert!(joint_value(row, 1).abs() <= 1.0, "{row}");
    }
    let (links, joints, _) = figures(&arm, &rows);
    assert!(links.iter().all(|rms| *rms < 0.3e-3), "{links:?}");
    assert!(joints.iter().all(|rms| *rms < 3e-3), "{joints:?}");
}

/// The errors of one run are correlated over its few seconds, so there are several runs.
#[test]
fn links_are_as_far_off_as_they_say() {
    const RUNS: u64 = 6;
    let mut sums = [0.0; 3];
    for seed in 11..11 + RUNS {
        let arm = Arm::new(4, seed);
        arm.write_corners(90, 0.1, |_, _| true);
        let (_, _, nees) = figures(&arm, &settled(arm.replay()));
        sums = [0, 1, 2].map(|link| sums[link] + nees[link]);
    }
    let nees = sums.map(|sum| sum / RUNS as f64);
    assert!(
        nees.iter().all(|nees| (0.7..1.4).contains(nees)),
        "{nees:?}"
    );
}

#[test]
fn a_hidden_forearm_is_known_less_well_until_it_shows_again() {
    let arm = Arm::new(4, 12);
    arm.write_corners(75, 0.1, |link, seconds| {
        link < 2 || !(1.0..1.7).contains(&seconds)
    });
    let rows = settled(arm.replay());
    let sigma = |row: &Value| covariance(&row["links"][2]).trace().sqrt();
    let worst = |from: f64, to: f64| {
        let span = rows.iter().filter(|row| (from..to).contains(&seconds(row)));
        span.map(sigma).fold(0.0, f64::max)
    };
    let (before, hidden, after) = (worst(0.3, 0.99), worst(1.0, 1.69), worst(1.8, 9.0));
    assert!(
        hidden > 20.0 * before && after < 2.0 * before,
        "{before} {hidden} {after}"
    );
    for row in &rows {
        assert!(joint_value(row, 1).abs() <= 1.0, "{row}");
        assert!(
            nees(&arm, row, 2) < 8.0,
            "{} s: {}",
            seconds(row),
            nees(&arm, row, 2)
        );
        assert!(nees(&arm, row, 0) < 8.0);
    }
}

#[test]
fn the_arm_is_followed_in_pictures() {
    let arm = Arm::new(3, 13);
    arm.write_pictures(24);
    let rows = settled(arm.replay());
    assert!(rows.len() > 30, "{}", rows.len());
    let (links, joints, nees) = figures(&arm, &rows);
    println!("pictures: links {links:?} m, joints {joints:?} rad, NEES {nees:?}");
    assert!(links.iter().all(|rms| *rms < 1.5e-3), "{links:?}");
    assert!(joints.iter().all(|rms| *rms < 0.01), "{joints:?}");
}
