//! After its first images the capturing part takes nothing from the heap for another one, but for what iceoryx2 takes
//! to lend a slot (a small box).

use super::*;
use allocation_counter::measure;
use sextant_iceoryx_images::ClockSource;
use sextant_iceoryx_images::{IceoryxOptions, ImageSubscriber};
use std::time::Duration;

const RESOLUTION: [u16; 2] = [64, 48];

/// Always has an image; how sources make theirs is tested beside them.
struct Blank(u64);

impl ImageSource for Blank {
    fn resolution(&self) -> [u16; 2] {
        RESOLUTION
    }

    fn next(&mut self, pixels: &mut [u8], _: &Shutdown) -> Result<Next, SourceError> {
        self.0 += 1;
        pixels.fill(self.0 as u8);
        Ok(Next::Image(Capture {
            sequence: self.0,
            capture_ns: self.0,
            exposure_ns: 0,
            clock: ClockSource::Unknown,
            clock_error_ns: 0,
            clock_offset_ns: 0,
        }))
    }
}

#[test]
fn an_image_costs_no_memory_but_for_its_loan() {
    let folder = tempfile::tempdir().unwrap();
    let place = IceoryxOptions {
        root: folder.path().join("i"),
        prefix: format!("{:x}a", std::process::id()),
    };
    let bytes = RESOLUTION.map(usize::from).iter().product();
    let mut reader = ImageSubscriber::open(&place, "north").unwrap();
    let files = SettingsFiles::in_folder(folder.path());
    let mut writer = SlotWriter {
        images: ImagePublisher::open(&place, "north", bytes).unwrap(),
        stream: 1,
        resolution: RESOLUTION,
        bytes,
        changes: FileChanges::new(
            &folder.path().join("camera.toml"),
            &SourceConfig::images(""),
            &files,
        ),
        report: ControlsReport::new(files),
    };
    let (mut source, shutdown) = (Blank(0), Shutdown::manual().unwrap());
    for lent in 0..50 {
        let loan = measure(|| drop(writer.images.blank(bytes).unwrap()));
        let lending = measure(|| {
            writer.lend_next(&mut source, &shutdown, lent).unwrap();
        });
        let borrowing = measure(|| {
            let image = reader.wait(Duration::from_secs(10)).unwrap().unwrap();
            assert_eq!(image.header().sequence, lent + 1);
        });
        if lent >= 5 {
            let counts = [lending, borrowing].map(|info| info.count_total);
            assert_eq!(counts, [loan.count_total, 0], "image {lent}");
        }
    }
}
