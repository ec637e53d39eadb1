//! Clocks that jump, by milliseconds or by years, are found out, named, and spoil no pose.

use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::Pose;
use sextant_site_model::ImageObservation;
use sextant_site_report::{Fault, State};

use crate::scene::{
    Eye, PERIOD_NS, Random, START_NS, camera_id, cube, fusion, path_at, poses, position_error, rig,
};

const UNKNOWN: u64 = ImageObservation::CLOCK_ERROR_UNKNOWN;
/// The camera whose clock is off.
const WRONG: usize = 1;

/// Some cameras, of which one has another clock.
#[derive(Clone, Copy)]
struct Watch {
    cameras: usize,
    /// What the cameras state of their clocks' errors.
    stated_ns: u64,
    /// Seconds after the start from which on the clock is off, and how long to look.
    since_s: f64,
    seconds: f64,
    /// Seconds of the offset, and its growth a second.
    offset_s: f64,
    drift: f64,
    /// Whether arrivals are known, or images are taken in by their stamps.
    arrivals: Arrivals,
    /// Noise of corners, and how fast the path is gone along.
    sigma_px: f64,
    pace: f64,
    seed: u64,
}

#[derive(Clone, Copy, PartialEq)]
enum Arrivals {
    Known,
    AsStamped,
}

const FOUR: Watch = Watch {
    cameras: 4,
    stated_ns: UNKNOWN,
    since_s: 0.0,
    seconds: 5.0,
    offset_s: 0.0,
    drift: 0.0,
    arrivals: Arrivals::Known,
    sigma_px: 0.05,
    pace: 1.0,
    seed: 1,
};

/// What came of it.
struct Outcome {
    fusion: Fusion,
    /// Seconds from the beginning of the fault until the clock was named.
    named_s: Option<f64>,
    /// Faults of other names, as they were said.
    misnamed: Vec<Fault>,
    /// Metres, largest error of a tracked pose in the last two seconds, and their count.
    worst: f64,
    poses: usize,
}

fn watch(watch: &Watch) -> Outcome {
    let (rig, object, mut random) = (rig(watch.cameras), cube(), Random(watch.seed));
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: watch.sigma_px,
    };
    let mut outcome = Outcome {
        fusion: fusion(&rig, &object, FusionOptions::default()),
        named_s: None,
        misnamed: Vec::new(),
        worst: 0.0,
        poses: 0,
    };
    for (arrival_ns, seconds, image) in images(watch, &eye, &mut random) {
        outcome.fusion.handle(arrival_ns, Input::Image(image));
        let counts = seconds > watch.seconds - 2.0;
        outcome.note(seconds - watch.since_s, counts.then_some(watch.pace));
    }
    outcome
}

/// Where the cube is if it goes along its path at that pace.
fn at_pace(pace: f64, time_ns: u64) -> Pose {
    let after_ns = (time_ns - START_NS) as f64 * pace;
    path_at(START_NS + after_ns as u64)
}

/// Images with arrival and the seconds since the start at which they were taken, by arrival.
fn images(watch: &Watch, eye: &Eye<'_>, random: &mut Random) -> Vec<(u64, f64, ImageObservation)> {
    let mut images = Vec::new();
    for round in 0..(watch.seconds * 30.0) as u64 {
        for camera in 0..watch.cameras {
            let begin_ns = 100_000_000 + watch.seed * 777_777_777;
            let after_ns = round * PERIOD_NS + camera as u64 * 7_123_457;
            let (seconds, true_ns) = (after_ns as f64 * 1e-9, START_NS + begin_ns + after_ns);
            let off_s = if camera == WRONG && seconds >= watch.since_s {
                watch.offset_s + watch.drift * (seconds - watch.since_s)
            } else {
                0.0
            };
            let stamp_ns = true_ns.strict_add_signed((off_s * 1e9) as i64);
            let mut image = eye.image(camera, stamp_ns, &at_pace(watch.pace, true_ns), random);
            image.clock_error_ns = watch.stated_ns;
            let arrival_ns = match watch.arrivals {
                Arrivals::Known => true_ns,
                Arrivals::AsStamped => stamp_ns,
            };
            images.push((arrival_ns + 10_000_000, seconds, image));
        }
    }
    images.sort_by_key(|(arrival_ns, _, _)| *arrival_ns);
    images
}

#[derive(PartialEq)]
enum Kind {
    Clock,
    Other,
}

fn kind(fault: &Fault) -> Kind {
    match fault {
        Fault::ClockOff { camera, .. } | Fault::Untimely { camera, .. }
            if *camera == camera_id(WRONG) =>
        {
            Kind::Clock
        }
        _ => Kind::Other,
    }
}

impl Outcome {
    /// What is said now; poses count of a path at that pace.
    fn note(&mut self, since_s: f64, counts: Option<f64>) {
        for fault in self.fusion.faults() {
            match kind(&fault) {
                Kind::Clock => self.named_s = self.named_s.or(Some(since_s)),
                Kind::Other => self.misnamed.push(fault),
            }
        }
        for estimate in poses(&mut self.fusion) {
            if let Some(pace) = counts.filter(|_| estimate.state == State::Tracking) {
                let off = position_error(&estimate, &at_pace(pace, estimate.capture_ns));
                self.worst = self.worst.max(off);
                self.poses += 1;
            }
        }
    }

    fn offset_s(&self) -> Option<f64> {
        let offsets = self.fusion.clock_offsets();
        offsets.get(&camera_id(WRONG)).map(|found| found.offset_s)
    }

    /// The offset is named within two seconds and as nothing else, known, and allowed for.
    fn assert_found(&self, truth_s: f64, case: &str) {
        assert_eq!(self.misnamed, [], "{case}");
        let named_s = self.named_s.unwrap_or(f64::INFINITY);
        assert!(named_s <= 2.0, "{case}: named after {named_s} s");
        let off_s = self
            .offset_s()
            .map_or(f64::INFINITY, |found| found - truth_s);
        assert!(off_s.abs() < 0.002, "{case}: {off_s} s");
        assert!(self.worst < 2e-3, "{case}: {} m", self.worst);
        let clock_is_off = |fault: &Fault| matches!(fault, Fault::ClockOff { .. });
        assert!(self.fusion.faults().iter().all(clock_is_off), "{case}");
    }
}

#[test]
fn any_offset_is_named_within_two_seconds_and_allowed_for() {
    for offset_s in [
        0.005, 0.05, 0.08, -0.08, 0.2, -0.2, 0.4, -0.4, 0.7, 3.0, -3.0,
    ] {
        for (cameras, seed) in [(2, 1), (3, 2), (4, 3)] {
            let found = watch(&Watch {
                cameras,
                seed,
                offset_s,
                ..FOUR
            });
            let case = format!("{offset_s} s, {cameras} cameras");
            found.assert_found(offset_s, &case);
            assert!(found.poses > 50 * cameras, "{case}: {}", found.poses);
        }
    }
}

/// A board without a battery starts its clock in 1970.
#[test]
fn a_clock_off_by_years_is_set_right() {
    let years_s = -1.7e9 + 12_345.6;
    let found = watch(&Watch {
        offset_s: years_s,
        ..FOUR
    });
    found.assert_found(years_s, "years");
}

#[test]
fn the_motion_overrules_what_a_camera_reports_of_its_clock() {
    for (offset_s, cameras) in [
        (0.03, 4),
        (0.05, 2),
        (0.2, 3),
        (-0.4, 2),
        (-0.2, 4),
        (3.0, 3),
    ] {
        {
            let found = watch(&Watch {
                cameras,
                stated_ns: 0,
                offset_s,
                ..FOUR
            });
            found.assert_found(offset_s, &format!("{offset_s} s, {cameras} cameras"));
        }
    }
}

#[test]
fn offsets_are_found_in_recordings_without_times_of_arrival() {
    for offset_s in [0.08, -0.2] {
        let found = watch(&Watch {
            offset_s,
            arrivals: Arrivals::AsStamped,
            ..FOUR
        });
        found.assert_found(offset_s, &format!("{offset_s} s"));
    }
}

#[test]
fn a_clock_that_jumps_is_named_and_is_forgotten_when_it_is_set_right() {
    let since_s = 4.0;
    for (seed, offset_s) in [(1, 0.25), (2, -0.6), (3, 2.0)] {
        let jump = Watch {
            since_s,
            offset_s,
            seed,
            seconds: 9.0,
            stated_ns: 1_000_000,
            ..FOUR
        };
        watch(&jump).assert_found(offset_s, &format!("{offset_s} s"));
    }
}

#[test]
fn a_drifting_clock_is_followed_beyond_what_a_filter_estimates() {
    let found = watch(&Watch {
        cameras: 3,
        offset_s: 0.028,
        drift: 50e-6,
        seconds: 80.0,
        ..FOUR
    });
    found.assert_found(0.028 + 80.0 * 50e-6, "50 ppm");
    assert!(found.worst < 1e-3, "{}", found.worst);
}

/// Where nothing moves the motion can't tell, but arrivals do.
#[test]
fn a_camera_whose_images_come_untimely_is_named_without_any_motion() {
    for (offset_s, is_ahead) in [(3.0, true), (-3.0, false)] {
        let (rig, object, mut random) = (rig(3), cube(), Random(5));
        let eye = Eye {
            rig: &rig,
            object: &object,
            sigma_px: 0.05,
        };
        let mut fusion = fusion(&rig, &object, FusionOptions::default());
        let mut reported = Vec::new();
        for round in 0..180 {
            for camera in 0..3 {
                let true_ns = START_NS + round * PERIOD_NS + camera as u64 * 7_000_000;
                let off_s = if camera == WRONG { offset_s } else { 0.0 };
                let stamp_ns = true_ns.strict_add_signed((off_s * 1e9) as i64);
                let image = eye.image(camera, stamp_ns, &path_at(START_NS), &mut random);
                fusion.handle(true_ns + 10_000_000, Input::Image(image));
                reported.extend(fusion.faults().into_iter().map(|fault| (round, fault)));
            }
        }
        let is_right = |fault: &Fault| match fault {
            Fault::Untimely { camera, age_s } => {
                *camera == camera_id(WRONG) && (*age_s < 0.0) == is_ahead
            }
            _ => false,
        };
        assert!(
            reported.iter().all(|(_, fault)| is_right(fault)),
            "{reported:?}"
        );
        assert!(
            reported.first().is_some_and(|(round, _)| *round < 60),
            "{reported:?}"
        );
    }
}

/// Images that come before they were taken would make all others late. Where nothing moves they are let in in the end.
#[test]
fn a_camera_ahead_of_its_arrivals_is_kept_away_until_it_is_found_out_or_all_is_still() {
    let ahead = Watch {
        offset_s: 0.3,
        ..FOUR
    };
    let named_s = watch(&ahead).named_s;
    assert!(named_s.is_some_and(|named_s| named_s < 0.7), "{named_s:?}");
    let (rig, object, mut random) = (rig(4), cube(), Random(9));
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    for (arrival_ns, _, image) in images(&ahead, &eye, &mut random) {
        let camera = (0..4).find(|index| camera_id(*index) == image.camera);
        let still = path_at(START_NS);
        let image = eye.image(camera.unwrap(), image.capture_ns, &still, &mut random);
        fusion.handle(arrival_ns, Input::Image(image));
    }
    let counts = fusion.statistics().cameras[&camera_id(WRONG)];
    assert!(counts.used_tags > 20 && counts.ahead > 100, "{counts:?}");
}

/// Images that come late may be of a clock that is behind, until it is found that it is not.
#[test]
fn a_slow_camera_whose_clock_is_right_is_gone_back_for_once_that_is_known() {
    let (rig, object, mut random) = (rig(4), cube(), Random(9));
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: 0.05,
    };
    let mut images = images(&FOUR, &eye, &mut random);
    for (arrival_ns, _, image) in &mut images {
        *arrival_ns += u64::from(image.camera == camera_id(WRONG)) * 300_000_000;
    }
    images.sort_by_key(|(arrival_ns, _, _)| *arrival_ns);
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    for (arrival_ns, _, image) in images {
        fusion.handle(arrival_ns, Input::Image(image));
        assert_eq!(fusion.faults(), []);
    }
    let counts = fusion.statistics().cameras[&camera_id(WRONG)];
    assert!((1..30).contains(&counts.late), "{counts:?}");
}

/// Differences are all that the motion tells: clocks that state the same error must not walk off together.
#[test]
fn clocks_that_agree_stay_where_they_are_whatever_they_state() {
    let found = watch(&Watch {
        stated_ns: 1_000_000,
        seconds: 20.0,
        ..FOUR
    });
    assert_eq!(found.misnamed, []);
    assert_eq!(found.named_s, None);
    for (camera, clock) in found.fusion.clock_offsets() {
        assert!(clock.offset_s.abs() < 2e-4, "{camera}: {clock:?}");
    }
}
