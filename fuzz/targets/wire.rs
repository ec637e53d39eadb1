//! Payloads of the wire contract. What is accepted can be sent again.

#![no_main]

use sextant_fuzz as _;
use sextant_proto::AnyMessage;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(message) = AnyMessage::decode(bytes) {
        // As JSON, as tools print it.
        let _ = sextant_recordings::foxglove::messages(&message, 0);
    }
});
