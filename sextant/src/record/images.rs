//! Images of this host's cameras from shared memory, as PNG, each camera in a thread of its own with low priority.

use super::inbox::{Content, Entry, Inbox};
use sextant_iceoryx_images::{IceoryxOptions, ImageHeader, ImageSubscriber, ImagesError};
use sextant_process::background;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_recordings::compressed_image::RecordedImage;
use sextant_recordings::{GreyImage, grey_png};
use sextant_site_model::CameraId;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{Builder, JoinHandle};

/// Most cameras: each has a thread.
const MOST_CAMERAS: usize = 64;

/// The readers of images. Dropping it ends them.
pub struct ImageReaders {
    place: IceoryxOptions,
    inbox: Arc<Inbox>,
    stop: Arc<AtomicBool>,
    counts: Arc<ImageCounts>,
    threads: BTreeMap<CameraId, JoinHandle<()>>,
}

/// Counts of all cameras.
#[derive(Debug, Default)]
pub struct ImageCounts {
    /// Images received.
    pub received: AtomicU64,
    /// Images that came faster than they could be compressed.
    pub missed: AtomicU64,
}

impl ImageReaders {
    /// No reader yet; images meet at `place`.
    pub fn new(place: IceoryxOptions, inbox: Arc<Inbox>) -> Self {
        Self {
            place,
            inbox,
            stop: Arc::default(),
            counts: Arc::default(),
            threads: BTreeMap::new(),
        }
    }

    /// Begins to read the images of a camera; whether it is a new one.
    ///
    /// # Errors
    /// When no thread can be had.
    pub fn start(&mut self, camera: &CameraId) -> std::io::Result<bool> {
        if self.threads.contains_key(camera) || self.threads.len() >= MOST_CAMERAS {
            return Ok(false);
        }
        let reader = Reader {
            camera: camera.clone(),
            inbox: Arc::clone(&self.inbox),
            stop: Arc::clone(&self.stop),
            counts: Arc::clone(&self.counts),
            last: None,
        };
        let place = self.place.clone();
        let thread = Builder::new().name("images".into()).spawn(move || {
            let camera = reader.camera.clone();
            if let Err(error) = background::lower_this_thread() {
                eprintln!("the priority of camera {camera}'s images: {error}");
            }
            if let Err(error) = reader.run(&place) {
                eprintln!("no images of camera {camera}: {error}");
            }
        })?;
        self.threads.insert(camera.clone(), thread);
        Ok(true)
    }

    /// Cameras that are read.
    pub fn cameras(&self) -> Vec<String> {
        self.threads.keys().map(ToString::to_string).collect()
    }

    /// Counts of images since the start.
    pub fn counts(&self) -> &ImageCounts {
        &self.counts
    }
}

impl Drop for ImageReaders {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        for thread in std::mem::take(&mut self.threads).into_values() {
            // A panic has ended the process already.
            let _ = thread.join();
        }
    }
}

struct Reader {
    camera: CameraId,
    inbox: Arc<Inbox>,
    stop: Arc<AtomicBool>,
    counts: Arc<ImageCounts>,
    /// Stream and sequence of the last image.
    last: Option<(u64, u64)>,
}

impl Reader {
    fn run(mut self, place: &IceoryxOptions) -> Result<(), ImagesError> {
        let stop = Arc::clone(&self.stop);
        let stopped = move || stop.load(Ordering::Relaxed);
        let opened = ImageSubscriber::open_unless(place, self.camera.as_str(), &stopped);
        let mut images = match opened {
            Err(ImagesError::Abandoned { .. }) => return Ok(()),
            opened => opened?,
        };
        while !self.stop.load(Ordering::Relaxed) {
            let Some(lent) = images.wait(SHUTDOWN_POLL)? else {
                continue;
            };
            let header = *lent.header();
            let image = grey_image(&header, lent.pixels());
            drop(lent);
            self.take(&header, &image);
        }
        Ok(())
    }

    fn take(&mut self, header: &ImageHeader, image: &GreyImage) {
        self.counts.received.fetch_add(1, Ordering::Relaxed);
        if let Some((stream, sequence)) = self.last.replace((header.stream, header.sequence))
            && stream == header.stream
        {
            let missed = header.sequence.saturating_sub(sequence + 1);
            self.counts.missed.fetch_add(missed, Ordering::Relaxed);
        }
        match grey_png(image) {
            Ok(png) => {
                let entry = Entry {
                    arrival_ns: header.received_ns,
                    content: Content::Image(RecordedImage {
                        camera: self.camera.clone(),
                        capture_ns: header.capture_ns,
                        png,
                    }),
                };
                entry.push_to(&self.inbox);
            }
            Err(error) => eprintln!("an image of camera {}: {error}", self.camera),
        }
    }
}

/// The pixels without the padding of rows.
fn grey_image(header: &ImageHeader, pixels: &[u8]) -> GreyImage {
    let [width, height] = [header.width, header.height].map(usize::from);
    let rows = pixels.chunks(header.stride as usize).take(height);
    GreyImage {
        width,
        height,
        pixels: rows
            .flat_map(|row| &row[..width.min(row.len())])
            .copied()
            .collect(),
    }
}
