//! Recorded images on the network, as the previews that a camera node publishes.

use node_camera::{JpegMaker, PreviewConfig};
use sextant_proto::{Keys, Preview};
use sextant_recordings::compressed_image::{self, RecordedImage};
use sextant_recordings::decode_picture;
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{Bus, Publisher, Qos};
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;
use std::time::{Duration, Instant};

/// Between two previews of a camera, as of a camera node by default.
const PERIOD: Duration = Duration::from_millis(200);

/// Makes and publishes previews.
pub struct Previews<'a> {
    bus: &'a Bus,
    keys: Keys,
    jpeg: JpegMaker,
    cameras: BTreeMap<CameraId, CameraPreviews>,
}

struct CameraPreviews {
    publisher: Publisher<Preview>,
    due: Instant,
    sequence: u64,
}

/// What became of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PreviewOutcome {
    Published,
    /// Too early after the last one, or nobody looks.
    Omitted,
    /// It is no image.
    Invalid,
}

impl<'a> Previews<'a> {
    pub fn new(bus: &'a Bus, keys: Keys) -> Self {
        let PreviewConfig {
            quality, max_width, ..
        } = PreviewConfig::default();
        Self {
            bus,
            keys,
            jpeg: JpegMaker::new(quality, max_width),
            cameras: BTreeMap::new(),
        }
    }

    /// Publishes a recorded image of a camera, five a second at most.
    ///
    /// # Errors
    /// What the network refuses.
    pub fn put(&mut self, camera: &CameraId, message: &[u8]) -> anyhow::Result<PreviewOutcome> {
        if !self.cameras.contains_key(camera) {
            let previews = CameraPreviews {
                publisher: self
                    .bus
                    .publisher(&self.keys.preview(camera), Qos::Preview)?,
                due: Instant::now(),
                sequence: 0,
            };
            self.cameras.insert(camera.clone(), previews);
        }
        let Some(previews) = self.cameras.get_mut(camera) else {
            return Ok(PreviewOutcome::Omitted);
        };
        let now = Instant::now();
        if now < previews.due || !previews.publisher.has_subscribers() {
            return Ok(PreviewOutcome::Omitted);
        }
        previews.due = now + PERIOD;
        let image = compressed_image::decode(camera, message);
        let Some(mut preview) = image.and_then(|image| preview(&mut self.jpeg, image)) else {
            return Ok(PreviewOutcome::Invalid);
        };
        preview.sequence = previews.sequence;
        previews.sequence += 1;
        previews.publisher.put(&preview)?;
        Ok(PreviewOutcome::Published)
    }
}

fn preview(jpeg: &mut JpegMaker, image: RecordedImage) -> Option<Preview> {
    let grey = decode_picture(Cursor::new(&image.png), Path::new("PNG")).ok()?;
    let width = u16::try_from(grey.width).ok()?;
    let height = u16::try_from(grey.height).ok()?;
    Some(Preview {
        camera: image.camera,
        sequence: 0,
        capture_ns: image.capture_ns,
        resolution: [width, height],
        jpeg: jpeg.encode(&grey.pixels, width, height, grey.width).ok()?,
    })
}
