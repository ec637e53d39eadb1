//! Picture files of recordings.

#![no_main]

use sextant_fuzz as _;
use sextant_recordings::decode_picture;
use std::io::Cursor;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(image) = decode_picture(Cursor::new(bytes), Path::new("any")) {
        assert_eq!(image.pixels.len(), image.width * image.height);
    }
});
