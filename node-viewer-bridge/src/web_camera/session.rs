//! One browser's messages: checked, converted to this host's time, counted. Knows no socket and no clock.
//!
//! Drop rules: messages beyond [`Budget`], of another camera, damaged, of an impossible time, or before the clocks were
//! compared are dropped and counted; [`MOST_REFUSED`] in a row end the session.

use super::clock::{ClockComparison, HostTime, RoundTrip};
use super::registry::Outgoing;
use serde::{Deserialize, Serialize};
use sextant_process::ClockQuality as HostClock;
use sextant_proto::{
    CameraNotice, CameraStatus, ClockQuality, ClockSource, DecodeError, MessageKind, Observations,
    Preview, decode, limits,
};
use sextant_site_model::CameraId;
use sextant_tag_families::Family;
use std::collections::{BTreeSet, VecDeque};

/// Longest message: a picture.
pub(crate) const MAX_BYTES: usize = MessageKind::Preview.max_bytes();
/// Messages without one that is accepted after which a session ends.
const MOST_REFUSED: u32 = 1000;
/// Between round trips in the beginning, how many those are, and the time between later ones.
const FIRST_PING_NS: u64 = 100_000_000;
const FIRST_PINGS: u64 = 8;
const PING_NS: u64 = 1_000_000_000;
/// Round trips under way that are remembered.
const MOST_PINGS: usize = 16;
/// An image may be so old when it arrives, or so new.
const OLDEST_NS: u64 = 10_000_000_000;
const NEWEST_NS: u64 = 1_000_000_000;
/// A browser that has sent no image for so long is reported.
const SILENT_NS: u64 = 2_000_000_000;
/// Standard deviation of the time from exposure to arrival in browsers that do not state the time of capture.
const UNKNOWN_LATENCY_NS: u64 = 80_000_000;

/// Now, by this host's clocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Now {
    /// Wire time.
    pub(crate) wire_ns: u64,
    pub(crate) monotonic_ns: u64,
    /// How far the wire time can be trusted.
    pub(crate) clock: HostClock,
}

/// Text messages from the browser.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
enum BrowserMessage {
    Pong {
        n: u64,
        received_us: u64,
        sent_us: u64,
    },
}

/// Text messages to the browser, specified in `PROTOCOL.md`.
#[derive(Debug, Serialize, PartialEq)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum BridgeMessage<'a> {
    /// The camera is on the network.
    Joined {
        camera: &'a CameraId,
        site: &'a str,
    },
    Ping {
        n: u64,
    },
    /// Camera statistics, once a second.
    Report {
        /// Estimated error of the browser's clock, ms; none before the first round trip.
        clock_error_ms: Option<f64>,
        published: u64,
        refused: u64,
        /// Why the last one was.
        cause: Option<&'a str>,
        /// Whether a page of the site is open, which shows pictures.
        watched: bool,
        in_rig: bool,
        /// What the site finds wrong with this camera, in words.
        faults: BTreeSet<String>,
        /// Those of the site's tags.
        families: BTreeSet<Family>,
    },
}

/// What the site knows of a camera.
#[derive(Debug, Default)]
pub(crate) struct KnownOfCamera {
    pub(crate) in_rig: bool,
    /// In words.
    pub(crate) faults: BTreeSet<String>,
    /// Those of the site's tags.
    pub(crate) families: BTreeSet<Family>,
}

/// Why a message is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
enum Refused {
    #[error("more messages than a camera may send")]
    Budget,
    #[error("no message of a camera")]
    Kind,
    #[error("a message of another camera")]
    Camera,
    #[error("an image of an impossible time")]
    Time,
    #[error("the clocks were not compared yet")]
    Clock,
    #[error("no JPEG file")]
    NoJpeg,
    #[error("no such text")]
    Text,
}

/// One browser.
#[derive(Debug)]
pub(crate) struct Session {
    camera: CameraId,
    clock: ClockComparison,
    budget: Budget,
    /// Numbers and times of round trips under way.
    pings: VecDeque<(u64, u64)>,
    n_pings: u64,
    ping_due_ns: u64,
    published: u64,
    refused: u64,
    refused_in_a_row: u32,
    cause: Option<String>,
    /// When the last image came, monotonic; at first when the session began.
    image_ns: u64,
}

impl Session {
    pub(crate) fn new(camera: CameraId, monotonic_ns: u64) -> Self {
        Self {
            image_ns: monotonic_ns,
            camera,
            clock: ClockComparison::default(),
            budget: Budget::full(monotonic_ns),
            pings: VecDeque::new(),
            n_pings: 0,
            ping_due_ns: monotonic_ns,
            published: 0,
            refused: 0,
            refused_in_a_row: 0,
            cause: None,
        }
    }

    /// A message in the network's own encoding: what is to be published.
    pub(crate) fn handle_bytes(&mut self, now: &Now, bytes: &[u8]) -> Option<Outgoing> {
        let result = match self.budget.take(now.monotonic_ns, bytes.len()) {
            true => self.read(now, bytes),
            false => Err(Refused::Budget.to_string()),
        };
        match result {
            Ok(outgoing) => {
                if matches!(outgoing, Outgoing::Observations(_)) {
                    self.published += 1;
                    self.image_ns = now.monotonic_ns;
                }
                self.refused_in_a_row = 0;
                Some(outgoing)
            }
            Err(cause) => {
                self.refuse(cause);
                None
            }
        }
    }

    fn refuse(&mut self, cause: String) {
        self.refused += 1;
        self.refused_in_a_row += 1;
        self.cause = Some(cause);
    }

    /// Whether the browser sends nothing but what is refused.
    pub(crate) fn is_hopeless(&self) -> bool {
        self.refused_in_a_row > MOST_REFUSED
    }

    fn read(&self, now: &Now, bytes: &[u8]) -> Result<Outgoing, String> {
        let damaged = |cause: DecodeError| cause.to_string();
        let is_kind = |kind: MessageKind| bytes.get(2) == Some(&(kind as u8));
        let outgoing = if is_kind(MessageKind::Observations) {
            let message = decode(bytes).map_err(damaged)?;
            self.observations(now, message).map(Outgoing::Observations)
        } else if is_kind(MessageKind::CameraStatus) {
            let message = decode(bytes).map_err(damaged)?;
            self.status(now, message)
                .map(|status| Outgoing::Status(Box::new(status)))
        } else if is_kind(MessageKind::Preview) {
            let message = decode(bytes).map_err(damaged)?;
            self.preview(now, message).map(Outgoing::Preview)
        } else {
            Err(Refused::Kind)
        };
        outgoing.map_err(|cause| cause.to_string())
    }

    fn observations(&self, now: &Now, mut message: Observations) -> Result<Observations, Refused> {
        self.check_camera(&message.camera)?;
        let capture = self.host_time(now, message.capture_ns)?;
        message.capture_ns = capture.at_ns;
        message.clock = stated(now, capture, message.clock.source);
        let timing = &mut message.timing;
        for time in [&mut timing.received_ns, &mut timing.detected_ns] {
            *time = self.clock.host_time(*time).map_or(0, |time| time.at_ns);
            *time = (*time).min(limits::MAX_TIME_NS);
        }
        timing.published_ns = now.wire_ns;
        Ok(message)
    }

    fn status(&self, now: &Now, mut message: CameraStatus) -> Result<CameraStatus, Refused> {
        self.check_camera(&message.camera)?;
        message.clock = match self.clock.host_time(self.there(now)) {
            Some(time) => stated(now, time, ClockSource::FreeRunning),
            None => ClockQuality::default(),
        };
        message.notices.clear();
        message.notices.extend(self.notice());
        message.notices.extend(self.silence(now));
        Ok(message)
    }

    fn preview(&self, now: &Now, mut message: Preview) -> Result<Preview, Refused> {
        self.check_camera(&message.camera)?;
        message.capture_ns = self.host_time(now, message.capture_ns)?.at_ns;
        let is_jpeg = message.jpeg.starts_with(&[0xff, 0xd8]);
        is_jpeg.then_some(message).ok_or(Refused::NoJpeg)
    }

    fn check_camera(&self, camera: &CameraId) -> Result<(), Refused> {
        (*camera == self.camera)
            .then_some(())
            .ok_or(Refused::Camera)
    }

    /// A time of the browser that can be one of an image that arrives now.
    fn host_time(&self, now: &Now, there_ns: u64) -> Result<HostTime, Refused> {
        let time = self.clock.host_time(there_ns).ok_or(Refused::Clock)?;
        let possible = now.wire_ns.saturating_sub(OLDEST_NS)..now.wire_ns.saturating_add(NEWEST_NS);
        possible
            .contains(&time.at_ns)
            .then_some(time)
            .ok_or(Refused::Time)
    }

    /// About now by the browser's clock.
    fn there(&self, now: &Now) -> u64 {
        self.clock
            .host_time(now.wire_ns)
            .map_or(now.wire_ns, |time| {
                now.wire_ns.saturating_mul(2).saturating_sub(time.at_ns)
            })
    }

    /// A browser that is there and sends no images: another program has taken its camera, or the system has paused it.
    fn silence(&self, now: &Now) -> Option<CameraNotice> {
        let silent_ns = now.monotonic_ns.saturating_sub(self.image_ns);
        (silent_ns >= SILENT_NS).then_some(CameraNotice::NoImage {
            silent_s: silent_ns as f64 * 1e-9,
        })
    }

    fn notice(&self) -> Option<CameraNotice> {
        let cause = self.cause.as_ref()?;
        let words = format!("{} messages refused, the last: {cause}", self.refused);
        Some(CameraNotice::ImageRefused {
            detail: limits::clipped(&words, limits::MAX_DETAIL_BYTES),
        })
    }

    /// A text: the answer to a round trip.
    pub(crate) fn handle_text(&mut self, now: &Now, text: &str) {
        if !self.budget.take(now.monotonic_ns, text.len()) {
            return self.refuse(Refused::Budget.to_string());
        }
        let Ok(BrowserMessage::Pong {
            n,
            received_us,
            sent_us,
        }) = serde_json::from_str(text)
        else {
            return self.refuse(Refused::Text.to_string());
        };
        // Ignores a pong without a matching ping.
        let Some(place) = self.pings.iter().position(|(number, _)| *number == n) else {
            return;
        };
        if let Some((_, sent_ns)) = self.pings.remove(place) {
            self.clock.handle(&RoundTrip {
                sent_ns,
                received_there_ns: received_us.saturating_mul(1000),
                sent_there_ns: sent_us.saturating_mul(1000),
                received_ns: now.wire_ns,
            });
        }
    }

    /// When the next round trip is due, by the monotonic clock.
    pub(crate) fn ping_due_ns(&self) -> u64 {
        self.ping_due_ns
    }

    /// The question of a round trip that begins now.
    pub(crate) fn ping(&mut self, now: &Now) -> BridgeMessage<'static> {
        self.n_pings += 1;
        let pause_ns = match self.n_pings < FIRST_PINGS {
            true => FIRST_PING_NS,
            false => PING_NS,
        };
        self.ping_due_ns = now.monotonic_ns.saturating_add(pause_ns);
        if self.pings.len() == MOST_PINGS {
            self.pings.pop_front();
        }
        self.pings.push_back((self.n_pings, now.wire_ns));
        BridgeMessage::Ping { n: self.n_pings }
    }

    /// Camera statistics.
    pub(crate) fn report(
        &self,
        now: &Now,
        watched: bool,
        known: KnownOfCamera,
    ) -> BridgeMessage<'_> {
        let time = self.clock.host_time(self.there(now));
        BridgeMessage::Report {
            clock_error_ms: time.map(|time| time.error_ns as f64 / 1e6),
            published: self.published,
            refused: self.refused,
            cause: self.cause.as_deref(),
            watched,
            in_rig: known.in_rig,
            faults: known.faults,
            families: known.families,
        }
    }
}

/// What is known of a converted time. A clock that was compared is as disciplined as this host's.
fn stated(now: &Now, time: HostTime, source: ClockSource) -> ClockQuality {
    let error_ns = now.clock.error_ns.saturating_add(time.error_ns);
    let (source, latency_ns) = match (source, now.clock.synchronised) {
        (ClockSource::Arrival, _) => (ClockSource::Arrival, UNKNOWN_LATENCY_NS),
        (_, true) => (ClockSource::Ntp, 0),
        (_, false) => (ClockSource::FreeRunning, 0),
    };
    ClockQuality {
        source,
        error_ns: error_ns.saturating_add(latency_ns).min(limits::MAX_TIME_NS),
    }
}

/// Messages and bytes that a browser may send: as many a second, and as many at once.
#[derive(Debug)]
struct Budget {
    messages: f64,
    bytes: f64,
    at_ns: u64,
}

impl Budget {
    const MESSAGES_A_SECOND: f64 = 200.0;
    const BYTES_A_SECOND: f64 = 2e6;

    fn full(at_ns: u64) -> Self {
        Self {
            messages: Self::MESSAGES_A_SECOND,
            bytes: Self::BYTES_A_SECOND,
            at_ns,
        }
    }

    /// Whether there is room for a message.
    fn take(&mut self, now_ns: u64, bytes: usize) -> bool {
        let elapsed_s = now_ns.saturating_sub(self.at_ns) as f64 * 1e-9;
        self.at_ns = now_ns;
        let refilled = |left: f64, rate: f64| (left + rate * elapsed_s).min(rate);
        self.messages = refilled(self.messages, Self::MESSAGES_A_SECOND);
        self.bytes = refilled(self.bytes, Self::BYTES_A_SECOND);
        let has_room = self.messages >= 1.0 && self.bytes >= bytes as f64;
        if has_room {
            self.messages -= 1.0;
            self.bytes -= bytes as f64;
        }
        has_room
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{CameraControls, Timing, encode};

    const START_NS: u64 = 1_800_000_000_000_000_000;
    const AHEAD_NS: u64 = 5_000_000_000;

    fn now_at(ms: u64) -> Now {
        Now {
            wire_ns: START_NS + ms * 1_000_000,
            monotonic_ns: ms * 1_000_000,
            clock: HostClock {
                synchronised: true,
                error_ns: 100_000,
            },
        }
    }

    fn camera() -> CameraId {
        CameraId::new("pocket").unwrap()
    }

    /// A session with a browser whose clock is ahead, after one round trip of 2 ms.
    fn session() -> Session {
        let mut session = Session::new(camera(), 0);
        let ping = session.ping(&now_at(0));
        assert_eq!(ping, BridgeMessage::Ping { n: 1 });
        let there_us = (START_NS + AHEAD_NS) / 1000 + 1000;
        let pong =
            format!(r#"{{"type":"pong","n":1,"received_us":{there_us},"sent_us":{there_us}}}"#);
        session.handle_text(&now_at(2), &pong);
        session
    }

    fn observations(camera: &str, there_ns: u64) -> Vec<u8> {
        encode(&Observations {
            camera: CameraId::new(camera).unwrap(),
            sequence: 1,
            capture_ns: there_ns,
            exposure_ns: 0,
            clock: ClockQuality {
                source: ClockSource::FreeRunning,
                error_ns: 0,
            },
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        })
        .unwrap()
    }

    /// The browser is there, and its camera has stopped: another app has it.
    #[test]
    fn a_browser_without_images_is_reported_until_it_sends_one() {
        let mut session = session();
        let notices = |session: &mut Session, ms| {
            let Some(Outgoing::Status(status)) = session.handle_bytes(&now_at(ms), &status())
            else {
                panic!()
            };
            status.notices
        };
        let image = |ms: u64| observations("pocket", START_NS + AHEAD_NS + ms * 1_000_000);
        session.handle_bytes(&now_at(1000), &image(990)).unwrap();
        assert_eq!(notices(&mut session, 2900), []);
        let silent = CameraNotice::NoImage { silent_s: 2.5 };
        assert_eq!(notices(&mut session, 3500), [silent]);
        session.handle_bytes(&now_at(3600), &image(3590)).unwrap();
        assert_eq!(notices(&mut session, 3700), []);
    }

    fn status() -> Vec<u8> {
        encode(&CameraStatus {
            camera: camera(),
            version: "1".to_owned(),
            host: "phone".to_owned(),
            captured: 1,
            detected: 1,
            dropped: 0,
            rate_hz: 30.0,
            detect_ms: [1.0, 2.0],
            clock: ClockQuality::default(),
            uptime_s: 1,
            published: 1,
            fallbacks: 0,
            brightness: 100.0,
            controls: CameraControls::default(),
            notices: vec![CameraNotice::NotInRig],
        })
        .unwrap()
    }

    #[test]
    fn times_become_this_hosts_with_their_error() {
        let mut session = session();
        let now = now_at(100);
        let bytes = observations("pocket", now.wire_ns + AHEAD_NS);
        let Some(Outgoing::Observations(message)) = session.handle_bytes(&now, &bytes) else {
            panic!("{session:?}");
        };
        assert!(message.capture_ns.abs_diff(now.wire_ns) < 1_000_000);
        assert_eq!(message.clock.source, ClockSource::Ntp);
        assert!((100_000..2_000_000).contains(&message.clock.error_ns));
        assert_eq!(message.timing.published_ns, now.wire_ns);
    }

    #[test]
    fn an_undisciplined_host_and_unknown_capture_times_are_stated() {
        let session = session();
        let mut now = now_at(100);
        let time = session.clock.host_time(now.wire_ns + AHEAD_NS).unwrap();
        let arrival = stated(&now, time, ClockSource::Arrival);
        assert_eq!(arrival.source, ClockSource::Arrival);
        assert!(arrival.error_ns >= UNKNOWN_LATENCY_NS);
        now.clock.synchronised = false;
        let free = stated(&now, time, ClockSource::FreeRunning);
        assert_eq!(free.source, ClockSource::FreeRunning);
    }

    #[test]
    fn bad_messages_are_refused_with_their_cause_and_counted() {
        let mut early = Session::new(camera(), 0);
        let now = now_at(100);
        let there = now.wire_ns + AHEAD_NS;
        assert_eq!(
            early.handle_bytes(&now, &observations("pocket", there)),
            None
        );
        assert_eq!(
            early.cause.as_deref(),
            Some("the clocks were not compared yet")
        );
        let mut session = session();
        let mut damaged = observations("pocket", there);
        damaged.truncate(9);
        for (bytes, cause) in [
            (observations("north", there), "another camera"),
            (observations("pocket", START_NS / 2), "impossible time"),
            (
                observations("pocket", there + 60_000_000_000),
                "impossible time",
            ),
            (damaged, "damaged"),
            (vec![], "no message of a camera"),
            (
                vec![0x53, 1, MessageKind::RigConfig as u8, 0],
                "no message of a camera",
            ),
        ] {
            assert_eq!(session.handle_bytes(&now, &bytes), None);
            let reported = session.cause.clone().unwrap();
            assert!(reported.contains(cause), "{reported} {cause}");
        }
        assert_eq!(session.refused, 6);
        session.handle_text(&now, "{}");
        assert_eq!(session.refused, 7);
        let Some(Outgoing::Status(status)) = session.handle_bytes(&now, &status()) else {
            panic!("{session:?}");
        };
        let words = status.notices[0].to_string();
        assert!(words.contains("7 messages refused"), "{words}");
        assert_eq!(status.notices.len(), 1);
    }

    #[test]
    fn a_picture_is_a_jpeg() {
        let mut session = session();
        let now = now_at(100);
        let mut picture = Preview {
            camera: camera(),
            sequence: 1,
            capture_ns: now.wire_ns + AHEAD_NS,
            resolution: [640, 480],
            jpeg: vec![0xff, 0xd8, 1],
        };
        let sent = session.handle_bytes(&now, &encode(&picture).unwrap());
        assert!(matches!(sent, Some(Outgoing::Preview(_))));
        picture.jpeg = b"<svg>".to_vec();
        assert_eq!(session.handle_bytes(&now, &encode(&picture).unwrap()), None);
    }

    #[test]
    fn a_flood_is_dropped_and_ends_the_session() {
        let mut session = session();
        let now = now_at(100);
        let bytes = observations("pocket", now.wire_ns + AHEAD_NS);
        let accepted = (0..1000).filter(|_| session.handle_bytes(&now, &bytes).is_some());
        assert!((100..=200).contains(&accepted.count()));
        let later = now_at(1100);
        let bytes = observations("pocket", later.wire_ns + AHEAD_NS);
        assert!(session.handle_bytes(&later, &bytes).is_some());
        (0..=MOST_REFUSED).for_each(|_| session.handle_text(&later, "?"));
        assert!(session.is_hopeless());
    }

    #[test]
    fn round_trips_without_an_answer_are_forgotten() {
        let mut session = Session::new(camera(), 0);
        for i in 0..100 {
            session.ping(&now_at(i));
        }
        assert_eq!(session.pings.len(), MOST_PINGS);
        let pong = r#"{"type":"pong","n":1,"received_us":1,"sent_us":1}"#;
        session.handle_text(&now_at(100), pong);
        assert_eq!(session.clock.host_time(START_NS), None);
        assert_eq!(session.refused, 0);
    }
}
