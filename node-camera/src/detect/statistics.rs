//! Statistics of a camera node: images received, detected and dropped, and detection times.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use sextant_apriltag::Image;
use sextant_iceoryx_images::ImageHeader;
use sextant_process::host::host_name;
use sextant_proto::{CameraNotice, CameraStatus, ClockQuality, limits};
use sextant_site_mirror::limits::SILENCE_NS;
use sextant_site_model::CameraId;

use super::models::SiteState;
use super::observe;

/// Detections that the times and the rate are taken over: a few seconds.
const WINDOW: usize = 128;
/// Longest window of a rate, s.
const WINDOW_S: f64 = 3.0;

/// Mean grey level, 0 to 255, of every 16th pixel of every 16th row.
fn brightness(image: &Image<'_>) -> f32 {
    let rows = (0..image.height()).step_by(16).map(|y| image.row(y));
    let pixels = rows.flat_map(|row| row.iter().step_by(16));
    let (sum, count) = pixels.fold((0u32, 0u32), |(sum, count), pixel| {
        (sum + u32::from(*pixel), count + 1)
    });
    sum as f32 / count.max(1) as f32
}

/// Counts and recent detections.
#[derive(Debug)]
pub(super) struct Statistics {
    camera: CameraId,
    host: String,
    started: Instant,
    /// Captured by earlier runs of the capturing part.
    earlier: u64,
    stream: u64,
    stream_captured: u64,
    detected: u64,
    /// Messages handed to the network.
    pub(super) published: u64,
    clock: ClockQuality,
    last_image: Instant,
    window: VecDeque<(Instant, u64)>,
    sorted: Vec<u64>,
    refusal: Option<String>,
    /// Images that the CPU made in place of the accelerator.
    fallbacks: u64,
    /// Mean grey level of the last image.
    brightness: f32,
    /// Hosts that run a camera of the same name.
    pub(super) others: Vec<String>,
}

impl Statistics {
    /// Empty statistics.
    pub(super) fn new(camera: CameraId) -> Self {
        Self {
            camera,
            host: limits::clipped(&host_name(), limits::MAX_NAME_BYTES),
            started: Instant::now(),
            earlier: 0,
            stream: 0,
            stream_captured: 0,
            detected: 0,
            published: 0,
            clock: ClockQuality::default(),
            last_image: Instant::now(),
            window: VecDeque::with_capacity(WINDOW),
            sorted: Vec::with_capacity(WINDOW),
            refusal: None,
            fallbacks: 0,
            brightness: 0.0,
            others: Vec::new(),
        }
    }

    /// An image came.
    pub(super) fn image(&mut self, header: &ImageHeader) {
        if header.stream != self.stream {
            self.earlier += self.stream_captured;
            self.stream = header.stream;
        }
        self.stream_captured = header.captured;
        self.fallbacks = header.fallbacks;
        self.clock = observe::clock(header);
        self.last_image = Instant::now();
    }

    /// It went through the detector.
    pub(super) fn detected(&mut self, image: &Image<'_>, detecting_ns: u64) {
        self.brightness = brightness(image);
        self.detected += 1;
        if self.window.len() == WINDOW {
            self.window.pop_front();
        }
        self.window.push_back((Instant::now(), detecting_ns));
    }

    /// It, or its message, was refused.
    pub(super) fn refuse(&mut self, cause: &str) {
        if self.refusal.as_deref() != Some(cause) {
            tracing::warn!(cause, "an image is refused");
            self.refusal = Some(cause.to_owned());
        }
    }

    fn captured(&self) -> u64 {
        self.earlier + self.stream_captured
    }

    /// The account as a message, with what the site wants.
    pub(super) fn status(&mut self, site: SiteState<'_>) -> CameraStatus {
        CameraStatus {
            camera: self.camera.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            host: self.host.clone(),
            captured: self.captured(),
            detected: self.detected,
            dropped: self.captured().saturating_sub(self.detected),
            rate_hz: self.rate_hz(),
            detect_ms: self.detect_ms(),
            clock: self.clock,
            uptime_s: self.started.elapsed().as_secs(),
            published: self.published,
            fallbacks: self.fallbacks,
            brightness: self.brightness,
            controls: site.controls,
            notices: self.notices(site.notice),
        }
    }

    fn rate_hz(&self) -> f32 {
        let recent = self
            .window
            .iter()
            .filter(|(at, _)| at.elapsed().as_secs_f64() <= WINDOW_S);
        let (count, first) = recent.fold((0u32, None), |(count, first), (at, _)| {
            (count + 1, first.or(Some(*at)))
        });
        match first {
            Some(first) if count > 1 => {
                (f64::from(count - 1) / first.elapsed().as_secs_f64().max(1e-3)) as f32
            }
            _ => 0.0,
        }
    }

    /// Median and 99th percentile of the window, ms.
    fn detect_ms(&mut self) -> [f32; 2] {
        self.sorted.clear();
        self.sorted.extend(self.window.iter().map(|(_, ns)| *ns));
        self.sorted.sort_unstable();
        let Some(last) = self.sorted.len().checked_sub(1) else {
            return [0.0; 2];
        };
        [last / 2, last * 99 / 100].map(|rank| (self.sorted[rank] as f64 / 1e6) as f32)
    }

    fn notices(&self, model_notice: Option<&CameraNotice>) -> Vec<CameraNotice> {
        let silent = self.last_image.elapsed();
        let silent_s = silent.as_secs_f64();
        let is_silent = silent > Duration::from_nanos(SILENCE_NS);
        let silence = is_silent.then_some(CameraNotice::NoImage { silent_s });
        let refusal = self
            .refusal
            .as_ref()
            .map(|cause| CameraNotice::ImageRefused {
                detail: limits::clipped(cause, limits::MAX_DETAIL_BYTES),
            });
        let others = self.others.iter().map(|host| CameraNotice::NameTaken {
            host: limits::clipped(host, limits::MAX_NAME_BYTES),
        });
        let single = [model_notice.cloned(), refusal, silence];
        let all = single.into_iter().flatten().chain(others);
        all.take(limits::MAX_CAMERA_NOTICES).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(stream: u64, captured: u64) -> ImageHeader {
        ImageHeader {
            stream,
            captured,
            ..ImageHeader::default()
        }
    }

    fn statistics(images: &[(u64, u64)]) -> Statistics {
        let mut statistics = Statistics::new(CameraId::new("north").unwrap());
        for (stream, captured) in images {
            statistics.image(&header(*stream, *captured));
            statistics.detected(&black(), 2_000_000);
        }
        statistics
    }

    fn black() -> Image<'static> {
        Image::new(&[0; 256], 16, 16, 16).unwrap()
    }

    fn counts(images: &[(u64, u64)]) -> (u64, u64, u64) {
        let status = statistics(images).status(SiteState::default());
        (status.captured, status.detected, status.dropped)
    }

    #[test]
    fn captured_is_detected_and_dropped() {
        assert_eq!(counts(&[]), (0, 0, 0));
        assert_eq!(counts(&[(7, 1), (7, 2), (7, 3)]), (3, 3, 0));
        assert_eq!(counts(&[(7, 4), (7, 6)]), (6, 2, 4));
    }

    #[test]
    fn a_new_run_of_the_capturing_part_adds_up() {
        assert_eq!(counts(&[(7, 1), (7, 2), (9, 1), (9, 3)]), (5, 4, 1));
    }

    #[test]
    fn times_are_median_and_99th_percentile() {
        let mut statistics = statistics(&[(1, 1)]);
        (1..=100).for_each(|ms| statistics.detected(&black(), ms * 1_000_000));
        assert_eq!(statistics.detect_ms(), [50.0, 99.0]);
    }

    #[test]
    fn images_that_the_cpu_took_over_are_counted() {
        let mut statistics = statistics(&[(1, 1)]);
        assert_eq!(statistics.status(SiteState::default()).fallbacks, 0);
        statistics.image(&ImageHeader {
            fallbacks: 31,
            ..header(1, 2)
        });
        assert_eq!(statistics.status(SiteState::default()).fallbacks, 31);
    }

    #[test]
    fn brightness_is_the_mean_grey_level() {
        let pixels: Vec<u8> = (0..64 * 48)
            .map(|i| if i % 64 < 32 { 100 } else { 200 })
            .collect();
        let mut statistics = statistics(&[]);
        statistics.detected(&Image::new(&pixels, 64, 48, 64).unwrap(), 1);
        assert_eq!(statistics.status(SiteState::default()).brightness, 150.0);
    }

    #[test]
    fn a_status_keeps_its_contract() {
        let mut statistics = statistics(&[(1, 1)]);
        statistics.refuse(&"x".repeat(1000));
        statistics.others = vec!["h".repeat(100); 100];
        let status = statistics.status(SiteState {
            notice: Some(&CameraNotice::NotInRig),
            ..SiteState::default()
        });
        assert_eq!(status.notices[0], CameraNotice::NotInRig);
        assert_eq!(status.notices.len(), limits::MAX_CAMERA_NOTICES);
        sextant_proto::encode(&status).unwrap();
    }
}
