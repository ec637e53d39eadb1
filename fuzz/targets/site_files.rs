//! Rig and object files, calibrations of other tools. What is accepted can be written and is read again.

#![no_main]

use sextant_fuzz as _;
use sextant_site_files::{object_toml, parse_foreign, parse_object, parse_rig, rig_toml};
use std::path::Path;

libfuzzer_sys::fuzz_target!(|text: &str| {
    let toml = Path::new("any.toml");
    if let Ok(rig) = parse_rig(toml, text) {
        parse_rig(toml, &rig_toml(&rig)).expect("a written rig is read");
    }
    if let Ok(object) = parse_object(toml, text) {
        parse_object(toml, &object_toml(&object)).expect("a written object is read");
    }
    if let Ok((_, rig)) = parse_foreign(Path::new("any.yaml"), text) {
        parse_rig(toml, &rig_toml(&rig)).expect("a converted rig is read");
    }
});
