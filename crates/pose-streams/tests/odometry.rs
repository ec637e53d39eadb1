//! MAVLink frames against those of an independent implementation: `odometry.txt`, which `odometry.py` makes with
//! pymavlink.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use sextant_pose_streams::{LocalFrame, MavlinkSender, Sender};
use sextant_proto::ObjectPose;
use sextant_site_model::ObjectId;
use sextant_site_report::State;
use std::f64::consts::FRAC_PI_2;

/// That of `odometry.py`.
fn pose() -> ObjectPose {
    let [w, x, y, z]: [f64; 4] = [0.8, 0.16, -0.32, 0.48];
    let norm = (w * w + x * x + y * y + z * z).sqrt();
    let covariance = |place: usize| {
        let (row, column) = (place / 6, place % 6);
        let more = if row == column { 1e-2 } else { 0.0 };
        (1 + row + column) as f64 * 1e-4 + more
    };
    ObjectPose {
        object: ObjectId::new("drone").unwrap(),
        epoch: 1,
        sequence: 1,
        capture_ns: 1_800_000_000_123_456_789,
        published_ns: 1_800_000_000_123_456_789,
        state: State::Tracking,
        position: [1.5, -2.25, 0.75],
        orientation: [x, y, z, w].map(|part| part / norm),
        covariance: std::array::from_fn(covariance),
        twist: [0.5, -0.25, 0.125, 1.0, 2.0, -3.0],
        cameras: 2,
        tags: 3,
        rms_px: 0.1,
    }
}

#[test]
fn frames_have_the_bytes_of_pymavlink() {
    let mut sender = MavlinkSender::new(Sender {
        system: 7,
        component: 197,
    });
    let east_is_x = LocalFrame::Ned {
        north_rad: FRAC_PI_2,
    };
    let ours = [
        sender.heartbeat(),
        sender.odometry(&pose(), &LocalFrame::Frd, 3),
        sender.odometry(&pose(), &east_is_x, 0),
    ];
    let theirs = include_str!("odometry.txt").lines();
    assert_eq!(theirs.clone().count(), ours.len());
    for (ours, theirs) in ours.iter().zip(theirs) {
        let ours: String = ours.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(ours, theirs);
    }
}
