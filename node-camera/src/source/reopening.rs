//! A source that is opened anew when no image comes any more: a driver may lose its camera without an error.

use std::time::{Duration, Instant};

use sextant_process::{Exit, Shutdown};

use super::{Capture, ImageSource, Next, SourceError};

/// Periods without an image after which the camera has stalled.
const MISSED_PERIODS: u32 = 30;
/// The least time without an image that counts as a stall: drivers hand images over in bursts.
const SHORTEST: Duration = Duration::from_secs(1);
/// How long the first image may take; doubled each time that the camera was opened in vain, up to the second.
const FIRST_IMAGE: [Duration; 2] = [Duration::from_secs(5), Duration::from_secs(60)];
/// Share of a new interval between images in the period.
const SMOOTHING: u32 = 8;

/// The source and how to open it again.
pub(crate) struct Reopening<O> {
    open: O,
    /// None only between closing and opening: no device is open twice.
    source: Option<Box<dyn ImageSource>>,
    resolution: [u16; 2],
    stall: Stall,
    /// Number of the first image since the source was opened.
    first: u64,
    /// Number of the next image.
    next: u64,
}

impl<O: FnMut() -> Result<Box<dyn ImageSource>, SourceError>> Reopening<O> {
    /// Opens the source for the first time. `period` is the time between two images, where it is known.
    pub(crate) fn new(mut open: O, period: Option<Duration>) -> Result<Self, SourceError> {
        let source = open()?;
        Ok(Self {
            open,
            resolution: source.resolution(),
            source: Some(source),
            stall: Stall::new(period, FIRST_IMAGE, Instant::now()),
            first: 0,
            next: 0,
        })
    }

    fn reopen(&mut self) -> Result<(), SourceError> {
        let patience_s = self.stall.patience().as_secs_f64();
        tracing::warn!("no image for {patience_s:.1} s; opening the camera anew");
        self.source = None;
        let source = (self.open)()?;
        if source.resolution() != self.resolution {
            let message = "the camera has another resolution after it was opened anew";
            return Err(SourceError::new(Exit::Unavailable, message));
        }
        self.source = Some(source);
        self.first = self.next;
        self.stall.opened(Instant::now());
        Ok(())
    }
}

impl<O: FnMut() -> Result<Box<dyn ImageSource>, SourceError>> ImageSource for Reopening<O> {
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        let Some(source) = &mut self.source else {
            return Err(SourceError::new(Exit::Unavailable, "the camera is closed"));
        };
        match source.next(pixels, shutdown)? {
            Next::Image(capture) => {
                self.stall.image(Instant::now());
                let sequence = self.first + capture.sequence;
                self.next = sequence + 1;
                Ok(Next::Image(Capture {
                    sequence,
                    ..capture
                }))
            }
            Next::Nothing => {
                if self.stall.is_over_due(Instant::now()) && !shutdown.is_requested() {
                    self.reopen()?;
                }
                Ok(Next::Nothing)
            }
            Next::End => Ok(Next::End),
        }
    }

    fn fallbacks(&self) -> u64 {
        self.source.as_ref().map_or(0, |source| source.fallbacks())
    }
}

/// When a camera has been silent for too long.
#[derive(Debug)]
struct Stall {
    /// Mean time between images.
    period: Option<Duration>,
    /// How long the first image may take, and the most that this grows to.
    first_image: [Duration; 2],
    /// Since when there was no image.
    silent_since: Instant,
    has_image: bool,
}

impl Stall {
    fn new(period: Option<Duration>, first_image: [Duration; 2], now: Instant) -> Self {
        Self {
            period,
            first_image,
            silent_since: now,
            has_image: false,
        }
    }

    fn image(&mut self, now: Instant) {
        let interval = now.saturating_duration_since(self.silent_since);
        if self.has_image {
            let before = self.period.unwrap_or(interval);
            self.period = Some((before * (SMOOTHING - 1) + interval) / SMOOTHING);
        }
        self.has_image = true;
        self.silent_since = now;
    }

    fn opened(&mut self, now: Instant) {
        if !self.has_image {
            let [wait, longest] = self.first_image;
            self.first_image[0] = (wait * 2).min(longest);
        }
        self.has_image = false;
        self.silent_since = now;
    }

    fn patience(&self) -> Duration {
        let missed = self
            .period
            .map_or(SHORTEST, |period| period * MISSED_PERIODS);
        if self.has_image {
            missed.max(SHORTEST)
        } else {
            missed.max(self.first_image[0])
        }
    }

    fn is_over_due(&self, now: Instant) -> bool {
        now.saturating_duration_since(self.silent_since) >= self.patience()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_iceoryx_images::ClockSource;

    const PERIOD: Duration = Duration::from_millis(100);

    #[test]
    fn a_camera_has_stalled_after_thirty_missed_periods() {
        let start = Instant::now();
        let mut stall = Stall::new(None, FIRST_IMAGE, start);
        assert!(!stall.is_over_due(start + Duration::from_secs(4)));
        assert!(stall.is_over_due(start + Duration::from_secs(5)));
        (0..100).for_each(|image| stall.image(start + PERIOD * image));
        let last = start + PERIOD * 99;
        assert!(!stall.is_over_due(last + PERIOD * (MISSED_PERIODS - 1)));
        assert!(stall.is_over_due(last + PERIOD * (MISSED_PERIODS + 1)));
    }

    #[test]
    fn a_camera_that_is_opened_in_vain_gets_ever_more_time() {
        let start = Instant::now();
        let mut stall = Stall::new(Some(PERIOD), FIRST_IMAGE, start);
        let given: Vec<u64> = (0..6)
            .map(|_| {
                stall.opened(start);
                stall.patience().as_secs()
            })
            .collect();
        assert_eq!(given, [10, 20, 40, 60, 60, 60]);
        stall.image(start);
        assert_eq!(stall.patience(), PERIOD * MISSED_PERIODS);
    }

    /// Gives two images and then nothing more.
    struct Stalling(u64);

    impl ImageSource for Stalling {
        fn resolution(&self) -> [u16; 2] {
            [16, 16]
        }

        fn next(&mut self, _: &mut [u8], _: &Shutdown) -> Result<Next, SourceError> {
            if self.0 == 2 {
                return Ok(Next::Nothing);
            }
            self.0 += 1;
            Ok(Next::Image(Capture {
                sequence: self.0 - 1,
                capture_ns: 1,
                exposure_ns: 0,
                clock: ClockSource::Ntp,
                clock_error_ns: 0,
                clock_offset_ns: 0,
            }))
        }
    }

    #[test]
    fn a_stalled_camera_is_opened_again_and_its_images_are_counted_on() {
        let shutdown = Shutdown::manual().unwrap();
        let mut opened = 0;
        let open = || {
            opened += 1;
            match opened {
                4 => Err(SourceError::new(Exit::Unavailable, "it was unplugged")),
                _ => Ok(Box::new(Stalling(0)) as Box<dyn ImageSource>),
            }
        };
        let mut camera = Reopening::new(open, None).unwrap();
        let mut sequences = Vec::new();
        let end = loop {
            match camera.next(&mut [], &shutdown) {
                Ok(Next::Image(capture)) => sequences.push(capture.sequence),
                // As if the time for it had passed.
                Ok(_) => camera.stall.silent_since -= camera.stall.patience(),
                Err(end) => break end,
            }
        };
        assert_eq!(sequences, [0, 1, 2, 3, 4, 5]);
        assert!(end.to_string().contains("unplugged"));
    }

    #[test]
    fn nothing_is_opened_while_the_process_ends() {
        let shutdown = Shutdown::manual().unwrap();
        let mut opened = 0;
        let mut camera = Reopening::new(
            || {
                opened += 1;
                Ok(Box::new(Stalling(2)) as Box<dyn ImageSource>)
            },
            None,
        )
        .unwrap();
        camera.stall.silent_since -= camera.stall.patience();
        shutdown.request();
        assert_eq!(camera.next(&mut [], &shutdown).unwrap(), Next::Nothing);
        drop(camera);
        assert_eq!(opened, 1);
    }
}
