//! What clients and servers of other tools send: requests of NatNet, answers of a broker of MQTT in pieces of any size,
//! times of NetworkTables.

#![no_main]

use sextant_fuzz as _;
use sextant_pose_streams::{MqttReader, NatNetRequest, nt4_time_answer};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = NatNetRequest::read(bytes);
    let _ = nt4_time_answer(bytes);
    let Some((&piece, bytes)) = bytes.split_first() else {
        return;
    };
    let mut reader = MqttReader::default();
    for piece in bytes.chunks(usize::from(piece) + 1) {
        reader.take(piece);
        loop {
            match reader.next_answer() {
                Ok(Some(_)) => {}
                Ok(None) => break,
                Err(_) => return,
            }
        }
    }
});
