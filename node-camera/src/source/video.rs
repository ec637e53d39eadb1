//! A video file, decoded by ffmpeg and played as it was taken: each image is handed over, and stamped, when it falls
//! due by this host's clock.
//!
//! ffmpeg's filter `showinfo` writes the time stamp of each image to standard error before the image leaves; its time
//! base stands in a line of its own before the first.

use std::collections::VecDeque;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use sextant_iceoryx_images::ClockSource;
use sextant_process::{Exit, Shutdown, now_ns};

use super::command::{ProgramImages, Progress};
use super::{Capture, ImageSource, Next, SourceError};
use crate::config::{StreamFormat, VideoConfig};

/// How long one call waits at most.
const LONGEST_WAIT: Duration = Duration::from_millis(200);
/// Beyond this an image is too late: the video goes on from now, ns.
const LATEST_NS: u64 = 500_000_000;
/// Time stamps that ffmpeg may be ahead of its images; it decodes some at once.
const MOST_STAMPS: usize = 1024;
/// Where a video's time stamps say nothing of its images' distance, ns.
const USUAL_PERIOD_NS: u64 = 33_333_333;

/// The video, playing.
#[derive(Debug)]
pub(crate) struct VideoPlayer {
    config: VideoConfig,
    arguments: Vec<String>,
    images: ProgramImages,
    stamps: Stamps,
    resolution: [u16; 2],
    sequence: u64,
    /// Wire time of the video's time zero in this round, ns; none before its first image.
    start_ns: Option<u64>,
    /// An image that was read and waits for its time.
    due: Option<u64>,
    /// Video time of the last image, and the time between it and the one before, ns.
    last: [u64; 2],
}

impl VideoPlayer {
    /// Starts ffmpeg on a file.
    ///
    /// # Errors
    /// A machine without ffmpeg; a file that it cannot decode.
    pub(crate) fn open(config: &VideoConfig, shutdown: &Shutdown) -> Result<Self, SourceError> {
        if let Err(cause) = std::fs::File::open(&config.file) {
            let message = format!("{}: {cause}", config.file.display());
            return Err(SourceError::new(Exit::Input, message));
        }
        let arguments = arguments(&config.file, sync_option()?);
        let mut stamps = Stamps::default();
        let images = decode(&arguments, &mut stamps, shutdown)?;
        Ok(Self {
            config: config.clone(),
            arguments,
            resolution: images.resolution(),
            images,
            stamps,
            sequence: 0,
            start_ns: config.start_ns,
            due: None,
            last: [0, USUAL_PERIOD_NS],
        })
    }

    /// The next image's capture time, once it is in `pixels`.
    fn read(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Read, SourceError> {
        let stamps = &mut self.stamps;
        let mut hear = |line: &str| stamps.hear(line);
        let progress = self
            .images
            .next(pixels, shutdown, LONGEST_WAIT, &mut hear)?;
        match progress {
            Progress::Image(_) => {
                let [last, period] = self.last;
                let at_ns = match self.stamps.take_ns() {
                    Some(at_ns) if at_ns > last || self.sequence == 0 => at_ns,
                    _ => last + period,
                };
                if self.sequence > 0 && at_ns > last {
                    self.last[1] = at_ns - last;
                }
                self.last[0] = at_ns;
                let start_ns = *self.start_ns.get_or_insert(now_ns().saturating_sub(at_ns));
                Ok(Read::Image(start_ns.saturating_add(at_ns)))
            }
            Progress::Nothing => Ok(Read::Nothing),
            Progress::Ended(ended) if ended.is_success => Ok(Read::End),
            Progress::Ended(ended) => {
                let message = format!("{}: {}", self.config.file.display(), ended.words);
                Err(SourceError::new(Exit::Input, message))
            }
        }
    }

    /// Begins anew, one period after the last image.
    fn repeat(&mut self, shutdown: &Shutdown) -> Result<(), SourceError> {
        self.stamps = Stamps::default();
        self.images = decode(&self.arguments, &mut self.stamps, shutdown)?;
        let [last, period] = self.last;
        self.start_ns = self
            .start_ns
            .map(|start_ns| start_ns.saturating_add(last).saturating_add(period));
        self.last = [0, period];
        Ok(())
    }

    /// How long until the image is due. A machine that is too slow for the video plays it slower.
    fn wait(&mut self, due_ns: u64) -> Duration {
        let now_ns = now_ns();
        let late_ns = now_ns.saturating_sub(due_ns);
        if late_ns > LATEST_NS && self.config.start_ns.is_none() {
            tracing::warn!("this machine is too slow for the video; it is played slower");
            self.start_ns = self
                .start_ns
                .map(|start_ns| start_ns.saturating_add(late_ns));
            self.due = Some(now_ns);
        }
        Duration::from_nanos(due_ns.saturating_sub(now_ns))
    }
}

enum Read {
    Image(u64),
    Nothing,
    End,
}

impl ImageSource for VideoPlayer {
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        let due_ns = match self.due {
            Some(due_ns) => due_ns,
            None => match self.read(pixels, shutdown)? {
                Read::Image(due_ns) => *self.due.insert(due_ns),
                Read::Nothing => return Ok(Next::Nothing),
                Read::End if self.config.repeat && self.sequence > 0 => {
                    self.repeat(shutdown)?;
                    return Ok(Next::Nothing);
                }
                Read::End => return Ok(Next::End),
            },
        };
        let wait = self.wait(due_ns);
        if shutdown.wait(wait.min(LONGEST_WAIT)) || wait > LONGEST_WAIT {
            return Ok(Next::Nothing);
        }
        let sequence = self.sequence;
        self.sequence += 1;
        Ok(Next::Image(Capture {
            sequence,
            capture_ns: self.due.take().unwrap_or(due_ns),
            exposure_ns: 0,
            clock: ClockSource::Recorded,
            clock_error_ns: 0,
            clock_offset_ns: 0,
        }))
    }
}

fn decode(
    arguments: &[String],
    stamps: &mut Stamps,
    shutdown: &Shutdown,
) -> Result<ProgramImages, SourceError> {
    let mut hear = |line: &str| stamps.hear(line);
    let started = ProgramImages::start(arguments, StreamFormat::Y4m, None, 0, shutdown, &mut hear);
    started.map_err(|cause| SourceError::new(Exit::Input, cause.to_string()))
}

/// Every image of the first video, once, as grey, with its time stamp said.
fn arguments(file: &Path, sync: &str) -> Vec<String> {
    let file = format!("file:{}", file.display());
    let words = [
        "ffmpeg",
        "-hide_banner",
        "-nostdin",
        "-nostats",
        "-loglevel",
        "info",
        "-i",
        &file,
        "-map",
        "0:v:0",
        "-vf",
        "showinfo=checksum=0",
        sync,
        "passthrough",
        "-pix_fmt",
        "gray",
        "-strict",
        "-1",
        "-f",
        "yuv4mpegpipe",
        "pipe:1",
    ];
    words.map(str::to_owned).into()
}

/// The option by which this ffmpeg neither doubles nor drops images: it was renamed in version 5.1.
///
/// # Errors
/// A machine without ffmpeg.
pub(crate) fn sync_option() -> Result<&'static str, SourceError> {
    let output = Command::new("ffmpeg").arg("-version").output();
    let output = output.map_err(|cause| {
        let message = format!(
            "a video needs ffmpeg, which cannot be started: {cause}; install it (Debian: apt install ffmpeg)"
        );
        SourceError::new(Exit::Input, message)
    })?;
    Ok(sync_option_of(&String::from_utf8_lossy(&output.stdout)))
}

fn sync_option_of(version: &str) -> &'static str {
    let number = version
        .strip_prefix("ffmpeg version ")
        .map(|rest| rest.trim_start_matches('n'));
    let mut parts = number.unwrap_or_default().split(['.', '-', ' ']);
    let mut part = || parts.next().and_then(|part| part.parse::<u32>().ok());
    match (part(), part()) {
        (Some(major), minor) if (major, minor.unwrap_or(0)) < (5, 1) => "-vsync",
        _ => "-fps_mode",
    }
}

/// The time stamps that ffmpeg said, of images that have not come yet.
#[derive(Debug, Default)]
struct Stamps {
    /// Numerator and denominator of a unit in seconds.
    time_base: Option<[u64; 2]>,
    /// In units; none for an image without one.
    waiting: VecDeque<Option<u64>>,
}

impl Stamps {
    fn hear(&mut self, line: &str) {
        if !line.starts_with("[Parsed_showinfo") {
            tracing::debug!("ffmpeg: {line}");
            return;
        }
        if let Some(base) = word_after(line, "config in time_base:") {
            let mut numbers = base.trim_end_matches(',').split('/').map(str::parse);
            if let (Some(Ok(numerator)), Some(Ok(denominator @ 1..))) =
                (numbers.next(), numbers.next())
            {
                self.time_base = Some([numerator, denominator]);
            }
        } else if word_after(line, " n:").is_some()
            && let Some(stamp) = word_after(line, " pts:")
        {
            if self.waiting.len() == MOST_STAMPS {
                self.waiting.pop_front();
            }
            self.waiting.push_back(stamp.parse().ok());
        }
    }

    /// Video time of the next image, ns.
    fn take_ns(&mut self) -> Option<u64> {
        let units = u128::from(self.waiting.pop_front()??);
        let [numerator, denominator] = self.time_base?.map(u128::from);
        u64::try_from(units * numerator * 1_000_000_000 / denominator).ok()
    }
}

fn word_after<'a>(line: &'a str, mark: &str) -> Option<&'a str> {
    let (_, rest) = line.split_once(mark)?;
    rest.split_ascii_whitespace().next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_stamps_are_read_off_what_ffmpeg_says() {
        let mut stamps = Stamps::default();
        for line in [
            "Input #0, mov,mp4, from 'tags.mp4':",
            "[Parsed_showinfo_0 @ 0x5581] config in time_base: 1/15360, frame_rate: 30/1",
            "[Parsed_showinfo_0 @ 0x5581] config out time_base: 0/0, frame_rate: 0/0",
            "[Parsed_showinfo_0 @ 0x5581] n:   0 pts:      0 pts_time:0       duration:    512 fmt:yuv420p",
            "[Parsed_showinfo_0 @ 0x5581] color_range:tv color_space:bt709",
            "[Parsed_showinfo_0 @ 0x5581] n:   1 pts:    512 pts_time:0.0333333 pos:1",
            "[Parsed_showinfo_0 @ 0x5581] n:   2 pts:NOPTS pts_time:NOPTS pos:1",
            "[Parsed_showinfo_0 @ 0x5581] n:   3 pts:15360 pts_time:1 pos:1",
        ] {
            stamps.hear(line);
        }
        let taken: Vec<_> = (0..5).map(|_| stamps.take_ns()).collect();
        assert_eq!(
            taken,
            [Some(0), Some(33_333_333), None, Some(1_000_000_000), None]
        );
    }

    #[test]
    fn stamps_without_images_are_not_kept() {
        let mut stamps = Stamps::default();
        (0..5000).for_each(|_| stamps.hear("[Parsed_showinfo_0 @ 0] n: 1 pts: 7 pts_time:1"));
        assert_eq!(stamps.waiting.len(), MOST_STAMPS);
    }

    #[test]
    fn the_option_is_that_of_the_version() {
        for (version, option) in [
            ("ffmpeg version 4.4.2-0ubuntu0.22.04.1 Copyright", "-vsync"),
            ("ffmpeg version 5.0 Copyright", "-vsync"),
            ("ffmpeg version 5.1.6-0+deb12u1 Copyright", "-fps_mode"),
            ("ffmpeg version n7.1 Copyright", "-fps_mode"),
            ("ffmpeg version N-117-gabc Copyright", "-fps_mode"),
        ] {
            assert_eq!(sync_option_of(version), option, "{version}");
        }
    }
}
