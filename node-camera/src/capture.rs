//! The capture part: copies images from a source into shared memory. It has no network, and no reader can delay it.

#[cfg(test)]
mod allocation_tests;
mod controls_report;
mod file_changes;

use std::path::Path;

use anyhow::Context;
use sextant_iceoryx_images::{ImageHeader, ImagePublisher, ImagesError};
use sextant_process::{Exit, Shutdown, WithExit, fail_point, now_ns, watchdog};

use self::controls_report::ControlsReport;
use self::file_changes::{FileChanges, Wanted};
use crate::config::{CameraNodeConfig, SourceConfig};
use crate::settings_files::SettingsFiles;
use crate::source::{self, Capture, ImageSource, Next, Reconfigured, SourceError};

/// Captures until `shutdown` or the end of the source.
///
/// # Errors
/// A source that can't be opened or fails, shared memory that can't be had.
pub(crate) fn run(
    file: &Path,
    config: &CameraNodeConfig,
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    let mut source = source::open(
        &config.source,
        &config.camera,
        &config.shared_memory,
        shutdown,
    )?;
    let [width, height] = source.resolution();
    let bytes = usize::from(width) * usize::from(height);
    let stop = || shutdown.is_requested();
    let (place, camera) = (&config.shared_memory, config.camera.as_str());
    let images = match ImagePublisher::open_unless(place, camera, bytes, &stop) {
        Err(ImagesError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    tracing::info!(camera = %config.camera, width, height, "capturing");
    let files = SettingsFiles::new(config).exit_with(Exit::Input)?;
    let mut lender = SlotWriter {
        images,
        stream: now_ns(),
        resolution: [width, height],
        bytes,
        changes: FileChanges::new(file, &config.source, &files),
        report: ControlsReport::new(files),
    };
    lender
        .lend_all(source.as_mut(), shutdown)
        .with_context(|| format!("camera {}", config.camera))
}

struct SlotWriter {
    images: ImagePublisher,
    stream: u64,
    resolution: [u16; 2],
    bytes: usize,
    changes: FileChanges,
    report: ControlsReport,
}

impl SlotWriter {
    fn lend_all(
        &mut self,
        source: &mut dyn ImageSource,
        shutdown: &Shutdown,
    ) -> anyhow::Result<()> {
        let mut lent = 0;
        while !shutdown.is_requested() {
            match self.lend_next(source, shutdown, lent)? {
                Next::Image(_) => lent += 1,
                Next::Nothing => {}
                Next::End => {
                    tracing::info!(images = lent, "the recording has ended");
                    break;
                }
            }
        }
        Ok(())
    }

    /// Fills one slot in shared memory and publishes it. A source without an image gets the same slot, with its
    /// contents, at the next call.
    fn lend_next(
        &mut self,
        source: &mut dyn ImageSource,
        shutdown: &Shutdown,
        lent: u64,
    ) -> anyhow::Result<Next> {
        let mut blank = self.images.blank(self.bytes)?;
        loop {
            fail_point!("capture");
            watchdog::feed();
            if self.changes.is_due() {
                self.take_changes(source);
            }
            let (header, pixels) = blank.parts();
            let next = source
                .next(pixels, shutdown)
                .map_err(SourceError::into_failure)?;
            match next {
                Next::Image(capture) => {
                    *header = ImageHeader {
                        fallbacks: source.fallbacks(),
                        ..self.header(&capture, lent)
                    };
                    self.images.send(blank).map_err(as_unavailable)?;
                    return Ok(next);
                }
                Next::Nothing if !shutdown.is_requested() => {}
                Next::Nothing | Next::End => return Ok(next),
            }
        }
    }

    fn take_changes(&mut self, source: &mut dyn ImageSource) {
        if let Some(wanted) = self.changes.look() {
            let refusal = put_in_force(source, &wanted).err();
            let site = wanted.site.map_or([None; 3], |site| site.values());
            self.report.set(site, refusal);
        }
        self.report.update(source.controls());
    }

    fn header(&self, capture: &Capture, lent: u64) -> ImageHeader {
        let [width, height] = self.resolution;
        let captured = capture.sequence + 1;
        ImageHeader {
            stream: self.stream,
            sequence: capture.sequence,
            capture_ns: capture.capture_ns,
            received_ns: now_ns(),
            clock_error_ns: capture.clock_error_ns,
            clock_offset_ns: capture.clock_offset_ns,
            captured,
            dropped: captured.saturating_sub(lent + 1),
            exposure_ns: capture.exposure_ns,
            stride: u32::from(width),
            width,
            height,
            clock_source: capture.clock as u8,
            ..ImageHeader::default()
        }
    }
}

/// Puts what is wanted in force as far as that works without an end of the node.
///
/// # Errors
/// Cause and remedy where the source stays as it was.
fn put_in_force(source: &mut dyn ImageSource, wanted: &Wanted) -> Result<(), String> {
    if let Some(config) = &wanted.source {
        reconfigure(source, config)
            .inspect_err(|cause| tracing::warn!(cause, "[source] stays as it was"))?;
        tracing::info!("the settings of [source] have changed and are in force");
    }
    match wanted.refusal {
        Some(cause) => {
            tracing::warn!(cause, "the site has settings for this camera");
            Err(cause.to_owned())
        }
        None => Ok(()),
    }
}

fn reconfigure(source: &mut dyn ImageSource, config: &SourceConfig) -> Result<(), String> {
    match source.reconfigure(config) {
        Ok(Reconfigured::Done | Reconfigured::NeedsReopening) => Ok(()),
        Ok(Reconfigured::NeedsRestart) => Err(
            "the node has to be started again for what has changed in [source] of its file"
                .to_owned(),
        ),
        Err(cause) => Err(cause.to_string()),
    }
}

fn as_unavailable(cause: ImagesError) -> anyhow::Error {
    sextant_process::Failure::new(Exit::Unavailable, cause).into()
}
