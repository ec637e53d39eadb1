//! A recorded camera: the pictures of a folder in the EuRoC layout, at their own pace or one after the other.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use sextant_iceoryx_images::ClockSource;
use sextant_process::{Exit, Shutdown, now_ns};
use sextant_recordings::{CameraRecording, Dataset, Frame, Row, read_picture};
use sextant_site_model::CameraId;

use super::common_start::CommonStart;
use super::{Capture, ImageSource, Next, SourceError, checked_resolution};
use crate::config::Pace;

/// How long one call waits at most.
const LONGEST_WAIT: Duration = Duration::from_millis(200);

/// How to play.
#[derive(Debug, Clone)]
pub(crate) struct Play {
    pub(crate) pace: Pace,
    pub(crate) repeat: bool,
    pub(crate) start_ns: Option<u64>,
    /// File that the nodes of this host share which play this recording without a `start_ns`.
    pub(crate) shared: Option<PathBuf>,
}

/// The player.
pub(crate) struct Player {
    rows: Vec<(u64, PathBuf)>,
    play: Play,
    resolution: [u16; 2],
    /// Time stamp minus recorded time stamp, ns.
    shift_ns: i64,
    /// This host's time minus time stamp, ns: when each is played. None until the first image.
    play_shift_ns: Option<i64>,
    /// Held while this node plays together with others.
    common: Option<CommonStart>,
    /// Time stamp of the first image of any camera, ns.
    earliest_ns: u64,
    /// Length of the recording of all cameras in time, ns: how much later everything is in the next round.
    length_ns: u64,
    sequence: u64,
    next: usize,
    is_read: bool,
}

impl Player {
    /// The camera's folder in a recording. Reads the first picture, which all others must agree with in size.
    pub(crate) fn open(folder: &Path, camera: &CameraId, play: Play) -> anyhow::Result<Self> {
        let dataset = Dataset::open(folder)?;
        let Some(recording) = dataset
            .cameras()
            .iter()
            .find(|recording| recording.camera == *camera)
        else {
            bail!(
                "{}: there is no camera {camera}; name one of its folders",
                folder.display()
            );
        };
        let rows = pictures(recording)
            .with_context(|| format!("{}: camera {camera}", folder.display()))?;
        let Some((_, first)) = rows.first() else {
            bail!("{}: camera {camera} has no picture", folder.display());
        };
        let picture = read_picture(first)?;
        let resolution = checked_resolution(picture.width, picture.height)
            .with_context(|| first.display().to_string())?;
        let firsts = dataset.cameras().iter();
        let firsts = firsts.filter_map(|camera| Some(camera.rows.first()?.capture_ns));
        let earliest_ns = firsts.min().unwrap_or(0);
        let start_ns = play.start_ns;
        let shift_ns = start_ns.map_or(0, |start| start.wrapping_sub(earliest_ns) as i64);
        let play_shift_ns = play.start_ns.map(|_| 0);
        let length_ns = length_ns(&dataset);
        Ok(Self {
            rows,
            play,
            resolution,
            shift_ns,
            play_shift_ns,
            common: None,
            earliest_ns,
            length_ns,
            sequence: 0,
            next: 0,
            is_read: false,
        })
    }

    /// The time stamp of the next image.
    fn stamp_ns(&self) -> Option<u64> {
        self.rows
            .get(self.next)
            .map(|(recorded_ns, _)| recorded_ns.saturating_add_signed(self.shift_ns))
    }

    fn read(&self, pixels: &mut [u8]) -> Result<(), SourceError> {
        let Some((_, file)) = self.rows.get(self.next) else {
            return Ok(());
        };
        let picture =
            read_picture(file).map_err(|cause| SourceError::new(Exit::Input, cause.to_string()))?;
        if checked_resolution(picture.width, picture.height) != Ok(self.resolution)
            || picture.pixels.len() != pixels.len()
        {
            let [width, height] = self.resolution;
            let message = format!(
                "{}: {}x{} pixels, but the first picture has {width}x{height}; a camera's pictures have one size",
                file.display(),
                picture.width,
                picture.height
            );
            return Err(SourceError::new(Exit::Input, message));
        }
        pixels.copy_from_slice(&picture.pixels);
        Ok(())
    }

    /// Begins to play at recorded pace, or goes on where the other nodes of this host are in the recording.
    fn begin(&mut self, now_ns: u64) -> io::Result<()> {
        if self.play.pace == Pace::AsFastAsPossible || self.play_shift_ns.is_some() {
            return Ok(());
        }
        let mut start_ns = now_ns;
        if let Some(shared) = &self.play.shared {
            let mut common = CommonStart::join(shared, now_ns)?;
            let is_over = now_ns.saturating_sub(common.start_ns()) >= self.length_ns;
            if is_over && !self.play.repeat {
                common.begin(now_ns)?;
            }
            start_ns = common.start_ns();
            self.common = Some(common);
        }
        self.play_shift_ns = Some(start_ns.wrapping_sub(self.earliest_ns) as i64);
        self.seek(now_ns.saturating_sub(start_ns));
        Ok(())
    }

    /// Goes to the first image that is not over so long after the start.
    fn seek(&mut self, elapsed_ns: u64) {
        let (rounds, rest_ns) = match self.play.repeat {
            true => (elapsed_ns / self.length_ns, elapsed_ns % self.length_ns),
            false => (0, elapsed_ns),
        };
        let from_ns = self.earliest_ns.saturating_add(rest_ns);
        let shift_ns = rounds.saturating_mul(self.length_ns);
        self.shift_ns = self.shift_ns.saturating_add_unsigned(shift_ns);
        self.next = self.rows.partition_point(|(at_ns, _)| *at_ns < from_ns);
        if self.next == self.rows.len() && self.play.repeat {
            self.next = 0;
            self.shift_ns = self.shift_ns.saturating_add_unsigned(self.length_ns);
        }
    }

    /// How long until the next image is due; zero when it is late, or at no pace.
    fn wait(&self, stamp_ns: u64) -> Duration {
        let due_ns = self
            .play_shift_ns
            .map(|ns| stamp_ns.saturating_add_signed(ns));
        let due_ns = due_ns.filter(|_| self.play.pace == Pace::Recorded);
        Duration::from_nanos(due_ns.unwrap_or(0).saturating_sub(now_ns()))
    }

    fn advance(&mut self) {
        self.is_read = false;
        self.sequence += 1;
        self.next += 1;
        if self.next == self.rows.len() && self.play.repeat {
            self.next = 0;
            self.shift_ns = self.shift_ns.saturating_add_unsigned(self.length_ns);
        }
    }
}

impl ImageSource for Player {
    fn resolution(&self) -> [u16; 2] {
        self.resolution
    }

    fn next(&mut self, pixels: &mut [u8], shutdown: &Shutdown) -> Result<Next, SourceError> {
        self.begin(now_ns()).map_err(|cause| {
            let place = self.play.shared.clone().unwrap_or_default();
            SourceError::new(Exit::Unavailable, format!("{}: {cause}", place.display()))
        })?;
        let Some(stamp_ns) = self.stamp_ns() else {
            return Ok(Next::End);
        };
        if !self.is_read {
            self.read(pixels)?;
            self.is_read = true;
        }
        let wait = self.wait(stamp_ns);
        if shutdown.wait(wait.min(LONGEST_WAIT)) || wait > LONGEST_WAIT {
            return Ok(Next::Nothing);
        }
        let capture = Capture {
            sequence: self.sequence,
            capture_ns: stamp_ns,
            exposure_ns: 0,
            clock: ClockSource::Recorded,
            clock_error_ns: 0,
            clock_offset_ns: stamp_ns.wrapping_sub(now_ns()) as i64,
        };
        self.advance();
        Ok(Next::Image(capture))
    }
}

fn pictures(recording: &CameraRecording) -> anyhow::Result<Vec<(u64, PathBuf)>> {
    let picture = |row: &Row| match &row.frame {
        Frame::Picture(file) => Ok((row.capture_ns, file.clone())),
        Frame::Detections(_) => {
            bail!("it holds detections, not pictures; `sextant replay` takes those")
        }
    };
    recording.rows.iter().map(picture).collect()
}

/// From the first image of any camera to one mean period after the last; at least 1 ns.
fn length_ns(dataset: &Dataset) -> u64 {
    let ends = dataset.cameras().iter().filter_map(|camera| {
        let (first, last) = (camera.rows.first()?, camera.rows.last()?);
        let span = last.capture_ns.saturating_sub(first.capture_ns);
        let periods = camera.rows.len().saturating_sub(1).max(1) as u64;
        Some((first.capture_ns, last.capture_ns, span / periods))
    });
    let (first, last, period) = ends.fold((u64::MAX, 0, 1), |all, one| {
        (all.0.min(one.0), all.1.max(one.1), all.2.max(one.2))
    });
    last.saturating_sub(first).saturating_add(period)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_recordings::{GreyImage, write_grey_png};
    use std::fs;

    /// A recording of three pictures, 10 ms apart, the n-th filled with n.
    fn recording() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        record(folder.path(), "north", 3);
        folder
    }

    fn record(folder: &Path, camera: &str, n: u8) {
        let camera = folder.join(camera);
        fs::create_dir_all(camera.join("data")).unwrap();
        let mut csv = String::from("#timestamp [ns],filename\n");
        for number in 0..n {
            let image = GreyImage {
                width: 20,
                height: 16,
                pixels: vec![number; 320],
            };
            write_grey_png(&camera.join(format!("data/{number}.png")), &image).unwrap();
            csv += &format!(
                "{},{number}.png\n",
                1_000_000_000 + u64::from(number) * 10_000_000
            );
        }
        fs::write(camera.join("data.csv"), csv).unwrap();
    }

    fn player(folder: &tempfile::TempDir, play: Play) -> Player {
        Player::open(folder.path(), &CameraId::new("north").unwrap(), play).unwrap()
    }

    fn play_all(player: &mut Player, most: usize) -> Vec<(u64, u64, u8)> {
        let shutdown = Shutdown::manual().unwrap();
        let mut pixels = vec![0; 320];
        let mut played = Vec::new();
        while played.len() < most {
            match player.next(&mut pixels, &shutdown).unwrap() {
                Next::Image(capture) => {
                    played.push((capture.sequence, capture.capture_ns, pixels[0]))
                }
                Next::Nothing => {}
                Next::End => break,
            }
        }
        played
    }

    const FAST: Play = Play {
        pace: Pace::AsFastAsPossible,
        repeat: false,
        start_ns: None,
        shared: None,
    };

    #[test]
    fn a_recording_is_played_once_with_its_own_stamps() {
        let folder = recording();
        let expected = [
            (0, 1_000_000_000, 0),
            (1, 1_010_000_000, 1),
            (2, 1_020_000_000, 2),
        ];
        assert_eq!(play_all(&mut player(&folder, FAST), 9), expected);
        let recorded_pace = Play {
            pace: Pace::Recorded,
            ..FAST
        };
        assert_eq!(play_all(&mut player(&folder, recorded_pace), 9), expected);
    }

    #[test]
    fn a_repeated_recording_goes_on_ascending() {
        let folder = recording();
        let played = play_all(
            &mut player(
                &folder,
                Play {
                    repeat: true,
                    ..FAST
                },
            ),
            7,
        );
        assert_eq!(played[3], (3, 1_030_000_000, 0));
        assert_eq!(played[6], (6, 1_060_000_000, 0));
    }

    #[test]
    fn a_start_shifts_the_stamps_to_it() {
        let folder = recording();
        let start = now_ns();
        let played = play_all(
            &mut player(
                &folder,
                Play {
                    pace: Pace::Recorded,
                    start_ns: Some(start),
                    ..FAST
                },
            ),
            9,
        );
        assert_eq!(played[2], (2, start + 20_000_000, 2));
        assert!(now_ns() >= start + 20_000_000);
    }

    /// As two nodes that are started one after the other by hand.
    #[test]
    fn nodes_that_begin_one_after_the_other_play_the_same_moment() {
        let folder = tempfile::tempdir().unwrap();
        record(folder.path(), "north", 100);
        record(folder.path(), "south", 99);
        for repeat in [false, true] {
            let open = |camera: &str| {
                let play = Play {
                    pace: Pace::Recorded,
                    shared: Some(folder.path().join("start")),
                    repeat,
                    ..FAST
                };
                Player::open(folder.path(), &CameraId::new(camera).unwrap(), play).unwrap()
            };
            let (mut north, mut south) = (open("north"), open("south"));
            let n = if repeat { 130 } else { 30 };
            let last = play_all(&mut north, n)[n - 1];
            assert_eq!(last.0, n as u64 - 1);
            let first = play_all(&mut south, 1)[0];
            assert!(first.0 == 0 && first.1 > last.1, "{first:?} {last:?}");
            // Neither is ahead of the clock.
            let begun_ns = north.common.as_ref().unwrap().start_ns();
            let at_ns = begun_ns + (first.1 - 1_000_000_000);
            assert!(now_ns() >= at_ns);
        }
    }

    #[test]
    fn a_picture_of_another_size_and_a_missing_camera_are_reported() {
        let folder = recording();
        let odd = GreyImage {
            width: 16,
            height: 20,
            pixels: vec![0; 320],
        };
        write_grey_png(&folder.path().join("north/data/1.png"), &odd).unwrap();
        let mut player = player(&folder, FAST);
        let shutdown = Shutdown::manual().unwrap();
        let mut pixels = vec![0; 320];
        player.next(&mut pixels, &shutdown).unwrap();
        let error = player.next(&mut pixels, &shutdown).unwrap_err().to_string();
        assert!(error.contains("1.png: 16x20 pixels"), "{error}");
        let other = Player::open(folder.path(), &CameraId::new("south").unwrap(), FAST);
        assert!(other.err().unwrap().to_string().contains("no camera south"));
    }
}
