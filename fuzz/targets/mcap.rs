//! MCAP files: any bytes, and the messages of whatever can be read.

#![no_main]

use sextant_fuzz as _;
use sextant_proto::AnyMessage;
use sextant_recordings::mcap::reader::McapReader;
use std::io::Cursor;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let length = bytes.len() as u64;
    let Ok(mut reader) = McapReader::begin(Cursor::new(bytes), length, Path::new("any.mcap"))
    else {
        return;
    };
    while let Ok(Some(message)) = reader.next_message() {
        let _ = AnyMessage::decode(&message.data);
    }
});
