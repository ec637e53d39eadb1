//! Pictures for people: a thread of low priority with a borrow of its own, so that it can hold up neither capture nor
//! detection. It encodes only while there is a subscriber, and only once the router has received the last picture: on a
//! narrow link an observation waits for one picture at most.

mod jpeg;

use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use sextant_iceoryx_images::{ImageSubscriber, ImagesError, LentImage};
use sextant_process::{Shutdown, background, fail_point};
use sextant_proto::{Keys, Preview};
use sextant_zenoh_bus::{Bus, Publisher, Qos};

pub use self::jpeg::JpegMaker;
use crate::config::CameraNodeConfig;

/// The longest sleep: how late a wish to stop is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// Before pictures are tried again after an error: doubled each time in a row, up to the second.
const RETRY_DELAYS: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(30)];

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
            if let Err(cause) = background::lower_this_thread() {
                tracing::warn!(%cause, "previews have the priority of detection");
            }
            keep_trying(shutdown, RETRY_DELAYS, || show(config, bus, shutdown));
        })?;
    Ok(Some(thread))
}

/// Works until it ends without an error, or `shutdown`.
fn keep_trying(
    shutdown: &Shutdown,
    [first, longest]: [Duration; 2],
    mut work: impl FnMut() -> anyhow::Result<()>,
) {
    let mut delay = first;
    loop {
        let started = Instant::now();
        let Err(cause) = work() else { return };
        if started.elapsed() >= longest {
            delay = first;
        }
        tracing::warn!(again_in = ?delay, "no pictures: {cause:#}");
        if shutdown.wait(delay) {
            return;
        }
        delay = (delay * 2).min(longest);
    }
}

fn show(config: &CameraNodeConfig, bus: &Bus, shutdown: &Shutdown) -> anyhow::Result<()> {
    let key = Keys::for_site(config.site.clone()).preview(&config.camera);
    let publisher: Publisher<Preview> = bus.publisher(&key, Qos::Preview)?;
    let stop = || shutdown.is_requested();
    let (place, camera) = (&config.shared_memory, config.camera.as_str());
    let mut images = match ImageSubscriber::open_unless(place, camera, &stop) {
        Err(ImagesError::Abandoned { .. }) => return Ok(()),
        opened => opened?,
    };
    let mut jpeg = JpegMaker::new(config.preview.quality, config.preview.max_width);
    let period = Duration::from_secs_f64(1.0 / config.preview.rate_hz);
    let holders = config.holders()?;
    while !shutdown.wait(period) {
        fail_point!("preview");
        if !publisher.has_subscribers() {
            continue;
        }
        if !bus.await_delivery(&holders)? {
            tracing::warn!("a picture was held back: the link to the router is full");
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_tried_again_after_each_error_until_the_process_ends() {
        let shutdown = Shutdown::manual().unwrap();
        let mut tries = 0;
        keep_trying(&shutdown, [Duration::ZERO; 2], || {
            tries += 1;
            match tries {
                1..=2 => anyhow::bail!("no place for another reader"),
                _ => Ok(()),
            }
        });
        assert_eq!(tries, 3);
        keep_trying(&shutdown, RETRY_DELAYS, || {
            shutdown.request();
            anyhow::bail!("an error at the end")
        });
    }
}
