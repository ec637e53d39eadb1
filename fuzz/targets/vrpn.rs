//! What clients of VRPN send, in pieces of any size, and their datagrams.

#![no_main]

use sextant_fuzz as _;
use sextant_pose_streams::{Axes, VrpnConnection, VrpnTrackers, requested_port};

/// Answers a client no more than this for each byte that it sends: a pong for a ping.
const MOST_ANSWERED: usize = 4;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = requested_port(bytes);
    let Some((&piece, bytes)) = bytes.split_first() else {
        return;
    };
    let trackers = VrpnTrackers::new(Axes::ZUp);
    let mut connection = VrpnConnection::default();
    let cookie = VrpnTrackers::cookie();
    let descriptions = connection.take(&cookie, &trackers, 0);
    assert!(descriptions.is_ok());
    for piece in bytes.chunks(usize::from(piece) + 1) {
        match connection.take(piece, &trackers, 0) {
            Ok(answer) => assert!(answer.len() <= MOST_ANSWERED * bytes.len()),
            Err(_) => return,
        }
    }
});
