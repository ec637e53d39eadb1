//! Pictures for people: a thread of low priority with a borrow of its own, so that it can hold up neither capture nor
//! detection. It encodes only while somebody looks.

mod jpeg;

use std::thread::{Scope, ScopedJoinHandle};
use std::time::Duration;

use sextant_iceoryx_images::{ImageSubscriber, LentImage};
use sextant_process::{Shutdown, background, fail_point};
use sextant_proto::{Keys, Preview};
use sextant_zenoh_bus::{Bus, Publisher, Qos};

use self::jpeg::JpegMaker;
use crate::config::CameraNodeConfig;

/// The longest sleep: how late a wish to stop is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(100);

/// Starts the thread, unless the configuration wants no pictures.
pub(crate) fn start<'scope>(
    scope: &'scope Scope<'scope, '_>,
    config: &'scope CameraNodeConfig,
    bus: &'scope Bus,
    shutdown: &'scope Shutdown,
) -> std::io::Result<Option<ScopedJoinHandle<'scope, ()>>> {
    if config.preview.rate_hz <= 0.0 {
        return Ok(None);
    }
    let thread = std::thread::Builder::new()
        .name("preview".into())
        .spawn_scoped(scope, move || {
            if let Err(cause) = show(config, bus, shutdown) {
                tracing::warn!("no pictures any more: {cause:#}");
            }
        })?;
    Ok(Some(thread))
}

fn show(config: &CameraNodeConfig, bus: &Bus, shutdown: &Shutdown) -> anyhow::Result<()> {
    background::lower_this_thread()?;
    let key = Keys::of(config.site.clone()).preview(&config.camera);
    let publisher: Publisher<Preview> = bus.publisher(&key, Qos::Preview)?;
    let mut images = ImageSubscriber::open(&config.shared_memory, config.camera.as_str())?;
    let mut jpeg = JpegMaker::new(config.preview.quality, config.preview.max_width);
    let period = Duration::from_secs_f64(1.0 / config.preview.rate_hz);
    while !shutdown.wait(period) {
        fail_point!("preview");
        if !publisher.has_subscribers() {
            continue;
        }
        if let Some(image) = images.wait(LONGEST_WAIT)? {
            let picture = picture(config, &mut jpeg, &image)?;
            drop(image);
            publisher.put(&picture)?;
        }
    }
    Ok(())
}

fn picture(
    config: &CameraNodeConfig,
    jpeg: &mut JpegMaker,
    image: &LentImage<'_>,
) -> anyhow::Result<Preview> {
    let header = image.header();
    Ok(Preview {
        camera: config.camera.clone(),
        sequence: header.sequence,
        capture_ns: header.capture_ns,
        resolution: [header.width, header.height],
        jpeg: jpeg.encode(
            image.pixels(),
            header.width,
            header.height,
            header.stride as usize,
        )?,
    })
}
