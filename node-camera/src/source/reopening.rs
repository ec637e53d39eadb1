//! A source that is opened anew: when it fails, as a camera does that is unplugged, and when no image comes any more,
//! since a driver may lose its camera without an error.

use std::time::{Duration, Instant};

use sextant_process::{Exit, Shutdown};
use sextant_proto::CameraControls;

use super::{Capture, ImageSource, Next, Reconfigured, SourceError};
use crate::config::SourceConfig;

/// Periods without an image after which the camera has stalled.
const MISSED_PERIODS: u32 = 30;
/// The least time without an image that counts as a stall: drivers hand images over in bursts.
const SHORTEST: Duration = Duration::from_secs(1);
/// How long the first image may take; doubled each time that the camera was opened in vain, up to the second.
const FIRST_IMAGE: [Duration; 2] = [Duration::from_secs(5), Duration::from_secs(60)];
/// Share of a new interval between images in the period.
const SMOOTHING: u32 = 8;
/// Before a source that failed is opened again; doubled each time in a row, up to the second.
const DELAYS: [Duration; 2] = [Duration::from_millis(500), Duration::from_secs(10)];
/// A source that ran so long did not fail in a row.
const GOOD_RUN: Duration = Duration::from_secs(30);
/// How long one call waits at most while the source is closed.
const LONGEST_WAIT: Duration = Duration::from_millis(200);

/// The source and how to open it again.
pub(crate) struct Reopening<O> {
    config: SourceConfig,
    open: O,
    state: ReopeningState,
    resolution: [u16; 2],
    stall: Stall,
    delay: Duration,
    opened: Instant,
    /// Number of the first image since the source was opened.
    first: u64,
    /// Number of the next image.
    next: u64,
}

enum ReopeningState {
    Open(Box<dyn ImageSource>),
    /// Closed, to be opened again then.
    Closed(Instant),
}

impl<O: FnMut(&SourceConfig) -> Result<Box<dyn ImageSource>, SourceError>> Reopening<O> {
    /// Opens the source for the first time. `period` is the time between two images, where it is known.
    pub(crate) fn new(
        config: &SourceConfig,
        mut open: O,
        period: Option<Duration>,
    ) -> Result<Self, SourceError> {
        let source = open(config)?;
        Ok(Self {
            config: config.clone(),
            open,
            resolution: source.resolution(),
            state: ReopeningState::Open(source),
            stall: Stall::new(period, FIRST_IMAGE, Instant::now()),
            delay: DELAYS[0],
            opened: Instant::now(),
            first: 0,
            next: 0,
        })
    }

    /// Closes the source, to be opened again after `delay`.
    fn close(&mut self, delay: Duration) {
        // Dropped before anything is opened: no device is open twice.
        self.state = ReopeningState::Closed(Instant::now() + delay);
    }

    /// Closes a source that failed, unless nothing can come of opening it again.
    fn fail(&mut self, cause: SourceError) -> Result<Next, SourceError> {
        if cause.exit != Exit::Unavailable {
            return Err(cause);
        }
        if self.opened.elapsed() >= GOOD_RUN {
            self.delay = DELAYS[0];
        }
        let again_in = self.delay;
        tracing::warn!(%cause, ?again_in, "the source failed; it is opened again");
        self.close(again_in);
        self.delay = (again_in * 2).min(DELAYS[1]);
        Ok(Next::Nothing)
    }

    fn reopen(&mut self) -> Result<Next, SourceError> {
        let source = match (self.open)(&self.config) {
            Ok(source) => source,
            Err(cause) => return self.fail(cause),
        };
        if source.resolution() != self.resolution {
            let message = "the source has another resolution after it was opened anew";
            return Err(SourceError::new(Exit::Unavailable, message));
        }
        self.take(source);
        Ok(Next::Nothing)
    }

    /// Opens the source with other settings at once, so that a camera that cannot have them goes on with its own. One
    /// that is out of reach gets them when it is back.
    fn reopen_with(&mut self, config: &SourceConfig) -> Result<(), SourceError> {
        self.close(Duration::ZERO);
        match (self.open)(config) {
            Ok(source) if source.resolution() == self.resolution => {
                self.take(source);
                Ok(())
            }
            Ok(_) => Err(SourceError::new(
                Exit::Unavailable,
                "the source has another resolution with these settings",
            )),
            Err(cause) if cause.exit == Exit::Unavailable => Ok(()),
            Err(cause) => Err(cause),
        }
    }

    fn take(&mut self, source: Box<dyn ImageSource>) {
        self.state = ReopeningState::Open(source);
        self.first = self.next;
        self.opened = Instant::now();
        self.stall.opened(self.opened);
    }

    fn nothing(&mut self, shutdown: &Shutdown) -> Next {
        if self.stall.is_over_due(Instant::now()) && !shutdown.is_requested() {
            let patience_s = self.stall.patience().as_secs_f64();
            tracing::warn!("no image for {patience_s:.1} s; opening the source anew");
            self.close(Duration::ZERO);
        }
        Next::Nothing
    }
}

impl<O: FnMut(&SourceConfig) -> Result<Box<dyn ImageSource>, SourceError>> ImageSource
    for Reopening<O>
{
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        let source = match &mut self.state {
            ReopeningState::Open(source) => source,
            ReopeningState::Closed(until) => {
                let left = until.saturating_duration_since(Instant::now());
                if shutdown.wait(left.min(LONGEST_WAIT)) || left > LONGEST_WAIT {
                    return Ok(Next::Nothing);
                }
                return self.reopen();
            }
        };
        match source.next(pixels, shutdown) {
            Ok(Next::Image(capture)) => {
                self.stall.image(Instant::now());
                let sequence = self.first + capture.sequence;
                self.next = sequence + 1;
                Ok(Next::Image(Capture {
                    sequence,
                    ..capture
                }))
            }
            Ok(Next::Nothing) => Ok(self.nothing(shutdown)),
            Ok(Next::End) => Ok(Next::End),
            Err(_) if shutdown.is_requested() => Ok(Next::Nothing),
            Err(cause) => self.fail(cause),
        }
    }

    fn fallbacks(&self) -> u64 {
        match &self.state {
            ReopeningState::Open(source) => source.fallbacks(),
            ReopeningState::Closed(_) => 0,
        }
    }

    fn controls(&self) -> Option<CameraControls> {
        match &self.state {
            ReopeningState::Open(source) => source.controls(),
            ReopeningState::Closed(_) => None,
        }
    }

    fn reconfigure(&mut self, config: &SourceConfig) -> Result<Reconfigured, SourceError> {
        let outcome = match &mut self.state {
            ReopeningState::Open(source) => source.reconfigure(config)?,
            ReopeningState::Closed(_) => Reconfigured::NeedsReopening,
        };
        if outcome == Reconfigured::NeedsReopening {
            self.reopen_with(config)?;
        }
        if outcome != Reconfigured::NeedsRestart {
            self.config = config.clone();
            return Ok(Reconfigured::Done);
        }
        Ok(outcome)
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

    fn anything() -> SourceConfig {
        SourceConfig::images("recording")
    }

    /// Gives two images and then what `after` says.
    struct TwoImages {
        given: u64,
        then: Result<Next, Exit>,
    }

    impl TwoImages {
        fn and_then(then: Result<Next, Exit>) -> Result<Box<dyn ImageSource>, SourceError> {
            Ok(Box::new(Self { given: 0, then }))
        }
    }

    impl ImageSource for TwoImages {
        fn resolution(&self) -> [u16; 2] {
            [16, 16]
        }

        fn next(&mut self, _: &mut [u8], _: &Shutdown) -> Result<Next, SourceError> {
            if self.given == 2 {
                return self
                    .then
                    .map_err(|exit| SourceError::new(exit, "it was unplugged"));
            }
            self.given += 1;
            Ok(Next::Image(Capture {
                sequence: self.given - 1,
                capture_ns: 1,
                exposure_ns: 0,
                clock: ClockSource::Ntp,
                clock_error_ns: 0,
                clock_offset_ns: 0,
            }))
        }
    }

    /// The numbers of the images up to the end, with all waits cut short.
    fn sequences<O>(mut camera: Reopening<O>) -> (Vec<u64>, SourceError)
    where
        O: FnMut(&SourceConfig) -> Result<Box<dyn ImageSource>, SourceError>,
    {
        let shutdown = Shutdown::manual().unwrap();
        let mut sequences = Vec::new();
        loop {
            match camera.next(&mut [], &shutdown) {
                Ok(Next::Image(capture)) => sequences.push(capture.sequence),
                Ok(_) => {
                    camera.stall.silent_since -= camera.stall.patience();
                    if let ReopeningState::Closed(until) = &mut camera.state {
                        *until = Instant::now();
                    }
                }
                Err(end) => return (sequences, end),
            }
        }
    }

    #[test]
    fn a_stalled_camera_is_opened_again_and_its_images_are_counted_on() {
        let mut opened = 0;
        let open = |_: &SourceConfig| {
            opened += 1;
            match opened {
                4 => Err(SourceError::new(Exit::Input, "no such format")),
                _ => TwoImages::and_then(Ok(Next::Nothing)),
            }
        };
        let (sequences, end) = sequences(Reopening::new(&anything(), open, None).unwrap());
        assert_eq!(sequences, [0, 1, 2, 3, 4, 5]);
        assert!(end.to_string().contains("no such format"));
    }

    #[test]
    fn an_unplugged_camera_is_opened_again_until_it_is_back() {
        let mut opened = 0;
        let open = |_: &SourceConfig| {
            opened += 1;
            match opened {
                2..=5 => Err(SourceError::new(Exit::Unavailable, "it is not there")),
                7 => Err(SourceError::new(Exit::Input, "enough")),
                _ => TwoImages::and_then(Err(Exit::Unavailable)),
            }
        };
        let camera = Reopening::new(&anything(), open, None).unwrap();
        let (sequences, end) = sequences(camera);
        assert_eq!(sequences, [0, 1, 2, 3]);
        assert_eq!(end.to_string(), "enough");
    }

    /// Takes another folder only by being opened anew.
    struct Choosy;

    impl ImageSource for Choosy {
        fn resolution(&self) -> [u16; 2] {
            [16, 16]
        }

        fn next(&mut self, _: &mut [u8], _: &Shutdown) -> Result<Next, SourceError> {
            Ok(Next::Nothing)
        }

        fn reconfigure(&mut self, _: &SourceConfig) -> Result<Reconfigured, SourceError> {
            Ok(Reconfigured::NeedsReopening)
        }
    }

    #[test]
    fn settings_that_a_camera_cannot_have_leave_it_as_it_was() {
        let mut opened = Vec::new();
        let open = |config: &SourceConfig| {
            opened.push(config.clone());
            if *config == SourceConfig::images("impossible") {
                return Err(SourceError::new(Exit::Input, "no such rate"));
            }
            Ok(Box::new(Choosy) as Box<dyn ImageSource>)
        };
        let mut camera = Reopening::new(&anything(), open, None).unwrap();
        let other = SourceConfig::images("other");
        assert_eq!(camera.reconfigure(&other).unwrap(), Reconfigured::Done);
        let refused = camera.reconfigure(&SourceConfig::images("impossible"));
        assert_eq!(refused.unwrap_err().to_string(), "no such rate");
        let shutdown = Shutdown::manual().unwrap();
        camera.next(&mut [], &shutdown).unwrap();
        drop(camera);
        assert_eq!(opened.last(), Some(&other));
    }

    #[test]
    fn delays_grow_while_a_source_fails() {
        let unavailable = || SourceError::new(Exit::Unavailable, "gone");
        let open = |_: &SourceConfig| TwoImages::and_then(Ok(Next::Nothing));
        let mut camera = Reopening::new(&anything(), open, None).unwrap();
        let mut delays = Vec::new();
        for _ in 0..6 {
            delays.push(camera.delay.as_millis());
            camera.fail(unavailable()).unwrap();
        }
        assert_eq!(delays, [500, 1000, 2000, 4000, 8000, 10_000]);
        camera.opened -= GOOD_RUN;
        camera.fail(unavailable()).unwrap();
        assert_eq!(camera.delay, DELAYS[0] * 2);
    }

    #[test]
    fn nothing_is_opened_while_the_process_ends() {
        let shutdown = Shutdown::manual().unwrap();
        let mut opened = 0;
        let open = |_: &SourceConfig| {
            opened += 1;
            TwoImages::and_then(Ok(Next::Nothing))
        };
        let mut camera = Reopening::new(&anything(), open, None).unwrap();
        for _ in 0..2 {
            camera.next(&mut [], &shutdown).unwrap();
        }
        camera.stall.silent_since -= camera.stall.patience();
        shutdown.request();
        for _ in 0..3 {
            assert_eq!(camera.next(&mut [], &shutdown).unwrap(), Next::Nothing);
        }
        drop(camera);
        assert_eq!(opened, 1);
    }
}
