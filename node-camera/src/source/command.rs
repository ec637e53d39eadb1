//! A camera behind a program: `rpicam-vid`, `ffmpeg`, `gst-launch-1.0` or any other that writes images to its standard
//! output. When such an image was taken is unknown: its time is that of its arrival, less a latency where the file
//! gives one.
//!
//! - `program`: the process and its pipes. `frames`: images out of bytes. `jpeg_stream`: where JPEGs begin and end.

mod frames;
mod jpeg_stream;
pub(crate) mod program;
mod row_length;
#[cfg(test)]
mod tests;

use std::io::ErrorKind;
use std::time::{Duration, Instant};

use sextant_process::{Exit, Shutdown, now_ns};

use self::frames::FrameReader;
use self::program::{Ended, Output, Program};
use self::row_length::{ShearCheck, row_length};
use super::backlog::{Backlog, LOOK};
use super::host_clock::{HostClock, Stamped, Taken};
use super::{ImageSource, Next, SourceError, checked_resolution};
use crate::config::{CommandConfig, StreamFormat};

/// How long one call waits at most.
const LONGEST_WAIT: Duration = Duration::from_millis(200);
/// How long a stream may take to say its size.
const SIZE_WAIT: Duration = Duration::from_secs(20);

/// The images of one run of a program.
#[derive(Debug)]
pub(super) struct ProgramImages {
    /// None once it has ended.
    program: Option<Program>,
    reader: FrameReader,
    resolution: [u16; 2],
    /// When the first bytes of the image came that is being read, ns since the Unix epoch; none where it waited during
    /// a standstill.
    begun_ns: Option<u64>,
    backlog: Backlog,
    /// When the last bytes came.
    read_ns: u64,
}

/// What came of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Progress {
    /// An image, whose first bytes came then; none for one that waited during a standstill of this process.
    Image(Option<u64>),
    /// None yet.
    Nothing,
    /// It ended.
    Ended(Ended),
}

impl ProgramImages {
    /// Starts the program, and waits until the size of its images is known. `hear` gets its lines of standard error.
    pub(super) fn start(
        words: &[String],
        format: StreamFormat,
        resolution: Option<[u32; 2]>,
        row_length: usize,
        shutdown: &Shutdown,
        hear: &mut dyn FnMut(&str),
    ) -> Result<Self, SourceError> {
        let size = resolution.map(|size| size.map(|length| length as usize));
        let mut images = Self {
            program: Some(Program::start(words)?),
            reader: FrameReader::new(format, size, row_length),
            resolution: [0; 2],
            begun_ns: None,
            backlog: Backlog::default(),
            read_ns: 0,
        };
        let deadline = Instant::now() + SIZE_WAIT;
        while images.reader.size().is_none() {
            if let Some(Ended { words, .. }) = images.take(&mut [], shutdown, LONGEST_WAIT, hear)? {
                return Err(SourceError::new(Exit::Unavailable, words));
            }
            if shutdown.is_requested() || Instant::now() > deadline {
                let message = format!("{} wrote no image", words[0]);
                return Err(SourceError::new(Exit::Unavailable, message));
            }
        }
        let [width, height] = images.reader.size().unwrap_or_default();
        images.resolution = checked_resolution(width, height)
            .map_err(|error| SourceError::new(Exit::Input, format!("{}: {error}", words[0])))?;
        Ok(images)
    }

    pub(super) fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    /// Waits for the next image, at most for `timeout`.
    ///
    /// # Errors
    /// A stream of another format.
    pub(super) fn next(
        &mut self,
        pixels: &mut [u8],
        shutdown: &Shutdown,
        timeout: Duration,
        hear: &mut dyn FnMut(&str),
    ) -> Result<Progress, SourceError> {
        let deadline = Instant::now() + timeout;
        loop {
            let begun_ns = self.begun_ns;
            match self.reader.complete(pixels) {
                Some(Ok(())) => {
                    self.backlog.image_ended();
                    // What is there of the next image came with the end of this one.
                    if self.reader.is_within_image() {
                        self.begin_image();
                    }
                    if let Some(program) = &mut self.program {
                        // What it says of an image comes before the image.
                        program.listen(hear);
                    }
                    return Ok(Progress::Image(begun_ns));
                }
                Some(Err(cause)) => {
                    tracing::warn!(%cause, "an image is damaged; it is passed over");
                    continue;
                }
                None => {}
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() || shutdown.is_requested() {
                return Ok(Progress::Nothing);
            }
            if let Some(ended) = self.take(pixels, shutdown, left, hear)? {
                return Ok(Progress::Ended(ended));
            }
        }
    }

    /// Waits for output and takes it; returns how the program ended, if it did.
    fn take(
        &mut self,
        pixels: &mut [u8],
        shutdown: &Shutdown,
        timeout: Duration,
        hear: &mut dyn FnMut(&str),
    ) -> Result<Option<Ended>, SourceError> {
        let Some(program) = &mut self.program else {
            let words = "the program has ended".to_owned();
            let is_success = true;
            return Ok(Some(Ended { is_success, words }));
        };
        let failed = |cause: std::io::Error| {
            SourceError::new(Exit::Unavailable, format!("the program's output: {cause}"))
        };
        let begun = Instant::now();
        let output = program
            .wait(shutdown, timeout.min(LOOK), hear)
            .map_err(failed)?;
        self.backlog.looked(begun, Instant::now());
        if output == Output::Nothing {
            return Ok(None);
        }
        let is_begun = self.reader.is_within_image();
        let count = match program.read(self.reader.room(pixels)) {
            Ok(0) => {
                let program = self.program.take();
                return Ok(program.map(|program| program.end(hear)));
            }
            Ok(count) => count,
            Err(cause)
                if matches!(cause.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) =>
            {
                return Ok(None);
            }
            Err(cause) => return Err(failed(cause)),
        };
        self.read_ns = now_ns();
        if !is_begun {
            self.begin_image();
        }
        let filled = self.reader.filled(count);
        filled.map_err(|cause| {
            SourceError::new(Exit::Input, format!("the program writes {cause}"))
        })?;
        Ok(None)
    }
}

impl ProgramImages {
    /// The first bytes of an image were read.
    fn begin_image(&mut self) {
        let is_known = self.backlog.is_time_known(Instant::now());
        self.begun_ns = is_known.then_some(self.read_ns);
    }
}

/// The camera, for one run of its program.
#[derive(Debug)]
pub(crate) struct CommandCamera {
    images: ProgramImages,
    latency_ns: Option<u64>,
    sequence: u64,
    clock: HostClock,
    /// None where rows are padded, or not raw.
    shear: Option<ShearCheck>,
    /// Images dropped in a row.
    dropped: u64,
}

/// Starts the program.
pub(crate) fn open(
    config: &CommandConfig,
    shutdown: &Shutdown,
) -> Result<Box<dyn ImageSource>, SourceError> {
    let words = config.run.words().unwrap_or_default();
    let stated_width = config.resolution.map_or(0, |[width, _]| width as usize);
    let program = words.first().map_or("", String::as_str);
    let row_length = row_length(program, config.format, stated_width, config.row_length);
    let images = ProgramImages::start(
        &words,
        config.format,
        config.resolution,
        row_length,
        shutdown,
        &mut log,
    )?;
    let is_raw = matches!(config.format, StreamFormat::Grey | StreamFormat::Yuv420);
    let is_guessed = config.row_length.is_none() && row_length == stated_width;
    let [width, height] = images.resolution();
    tracing::info!(program = words.first(), width, height, "camera");
    Ok(Box::new(CommandCamera {
        images,
        latency_ns: config.latency_ms.map(|ms| (ms * 1e6) as u64),
        sequence: 0,
        clock: HostClock::default(),
        shear: (is_raw && is_guessed).then(ShearCheck::default),
        dropped: 0,
    }))
}

impl CommandCamera {
    /// Refuses a picture that is sheared.
    fn check_rows(&mut self, pixels: &[u8]) -> Result<(), SourceError> {
        let width = usize::from(self.images.resolution()[0]);
        let Some(length) = self
            .shear
            .as_mut()
            .and_then(|shear| shear.look(pixels, width))
        else {
            return Ok(());
        };
        let message = format!(
            "the program's rows seem to be {length} bytes long, not {width}: write `row_length = \
             {length}` in [source], or `row_length = {width}` if they are not"
        );
        Err(SourceError::new(Exit::Input, message))
    }
}

fn log(line: &str) {
    tracing::info!("program: {line}");
}

impl ImageSource for CommandCamera {
    fn resolution(&self) -> [u16; 2] {
        self.images.resolution()
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        let progress = self.images.next(pixels, shutdown, LONGEST_WAIT, &mut log)?;
        match progress {
            Progress::Image(arrived_ns) => {
                let sequence = self.sequence;
                self.sequence += 1;
                self.check_rows(pixels)?;
                if self.shear.as_ref().is_some_and(ShearCheck::is_suspicious) {
                    return Ok(Next::Nothing);
                }
                // A number that is left out counts as an image that was lost.
                let Some(arrived_ns) = arrived_ns else {
                    self.dropped += 1;
                    return Ok(Next::Nothing);
                };
                if self.dropped > 0 {
                    tracing::warn!(
                        images = self.dropped,
                        "images that waited while this process was stalled have no known capture time and were dropped"
                    );
                    self.dropped = 0;
                }
                Ok(Next::Image(self.clock.capture(Taken {
                    sequence,
                    capture_ns: arrived_ns.saturating_sub(self.latency_ns.unwrap_or(0)),
                    exposure_ns: 0,
                    stamped: match self.latency_ns {
                        Some(_) => Stamped::OnArrivalLessLatency,
                        None => Stamped::OnArrival,
                    },
                })))
            }
            Progress::Nothing => Ok(Next::Nothing),
            Progress::Ended(Ended { words, .. }) => Err(SourceError::new(Exit::Unavailable, words)),
        }
    }
}
