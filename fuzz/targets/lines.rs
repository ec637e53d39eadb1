//! Texts in JSON: lines of `detections.jsonl`, and what a viewer of Foxglove's protocol sends.

#![no_main]

use sextant_fuzz as _;
use sextant_recordings::DetectionsLine;
use sextant_recordings::foxglove::websocket::ClientRequest;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = ClientRequest::parse(text);
    if let Ok(line) = DetectionsLine::parse(text) {
        assert!(
            line.detections.iter().all(|tag| tag
                .corners
                .iter()
                .flatten()
                .all(|pixel| pixel.is_finite()))
        );
    }
});
