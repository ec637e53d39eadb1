//! The clock of the fusion host is set while the machine runs.

use sextant_estimator::{Fusion, FusionOptions, Input, Output};
use sextant_site_model::ImageObservation;
use sextant_site_report::{ObjectEstimate, State};

use crate::scene::{Random, START_NS, cube, feed, fusion, path_at, position_error, rig, run};

const SECOND_NS: u64 = 1_000_000_000;
/// From capture to arrival, ns.
const DELAY_NS: u64 = 10_000_000;
/// When the clock is set, ns after the start.
const STEP_NS: u64 = SECOND_NS;

/// Two seconds of images of three cameras with the step between them; each estimate with its true capture time.
struct Site {
    fusion: Fusion,
    said: Vec<(u64, ObjectEstimate)>,
    notices: Vec<i64>,
}

impl Site {
    /// The host's clock is set by `by_ns`; `cameras_ns` is what the clock of a camera shows at a true time.
    fn run(by_ns: i64, cameras_ns: &dyn Fn(usize, u64) -> u64) -> Self {
        let (rig, object) = (rig(3), cube());
        let mut site = Self {
            fusion: fusion(&rig, &object, FusionOptions::default()),
            said: Vec::new(),
            notices: Vec::new(),
        };
        let mut has_stepped = false;
        for (index, image) in run(&rig, &object, 0.1, 3.0, &mut Random(4))
            .into_iter()
            .enumerate()
        {
            let true_ns = image.capture_ns;
            let arrival_ns = true_ns + DELAY_NS;
            let is_after = arrival_ns >= START_NS + STEP_NS;
            let now_ns = arrival_ns.saturating_add_signed(if is_after { by_ns } else { 0 });
            if is_after && !has_stepped {
                has_stepped = true;
                site.fusion.handle(now_ns, Input::ClockStep { by_ns });
            }
            let stamped = ImageObservation {
                capture_ns: cameras_ns(index % 3, true_ns),
                ..image
            };
            site.fusion.handle(now_ns, Input::Image(stamped));
            site.take_outputs(true_ns);
        }
        site
    }

    fn take_outputs(&mut self, true_ns: u64) {
        while let Some(output) = self.fusion.poll_output() {
            match output {
                Output::Pose(estimate) => self.said.push((true_ns, estimate)),
                Output::ClockStep { by_ns } => self.notices.push(by_ns),
                Output::Refused(cause) => panic!("{cause}"),
            }
        }
    }

    /// Poses of the last second are true and follow each image; there was one notice, and the object was lost once.
    fn assert_recovered(&self, by_ns: i64) {
        assert_eq!(self.notices, [by_ns]);
        let lost = self.said.iter().filter(|(_, one)| one.state == State::Lost);
        assert_eq!(lost.count(), 1);
        let last = self
            .said
            .iter()
            .filter(|(true_ns, _)| *true_ns >= START_NS + 2 * SECOND_NS);
        let tracked: Vec<_> = last
            .filter(|(_, one)| one.state == State::Tracking)
            .collect();
        assert!(tracked.len() >= 80, "{by_ns}: {}", tracked.len());
        for (true_ns, estimate) in tracked {
            let error_m = position_error(estimate, &path_at(*true_ns));
            assert!(error_m < 2e-3, "{by_ns}: {error_m}");
        }
    }
}

const STEPS_NS: [i64; 6] = [
    -3_600_000_000_000,
    -10_000_000_000,
    -700_000_000,
    -100_000_000,
    700_000_000,
    3_600_000_000_000,
];

#[test]
fn a_step_of_the_clock_that_all_share_starts_tracks_anew_with_one_notice() {
    for by_ns in STEPS_NS {
        let shared = |_: usize, true_ns: u64| {
            let is_after = true_ns >= START_NS + STEP_NS;
            true_ns.saturating_add_signed(if is_after { by_ns } else { 0 })
        };
        let site = Site::run(by_ns, &shared);
        site.assert_recovered(by_ns);
    }
}

#[test]
fn cameras_whose_own_clocks_were_not_set_are_fused_again() {
    for by_ns in [-400_000_000, 400_000_000] {
        Site::run(by_ns, &|_, true_ns| true_ns).assert_recovered(by_ns);
    }
}

#[test]
fn the_present_goes_back_with_the_clock_so_that_a_loss_is_said_in_time() {
    let (rig, object) = (rig(2), cube());
    let mut fusion = fusion(&rig, &object, FusionOptions::default());
    let images = run(&rig, &object, 0.1, 1.0, &mut Random(4));
    for image in &images {
        feed(&mut fusion, image.clone());
    }
    let by_ns = -(3600 * SECOND_NS as i64);
    let back = |ns: u64| ns.saturating_add_signed(by_ns);
    let last_ns = images[images.len() - 1].capture_ns;
    fusion.handle(back(last_ns), Input::ClockStep { by_ns });
    for image in &images {
        let capture_ns = back(image.capture_ns + SECOND_NS);
        feed(
            &mut fusion,
            ImageObservation {
                capture_ns,
                ..image.clone()
            },
        );
    }
    let due_ns = fusion.poll_timeout().unwrap();
    assert!(due_ns < back(last_ns + 3 * SECOND_NS));
    fusion.handle(due_ns, Input::Tick);
    let Some(Output::Pose(lost)) = fusion.poll_output() else {
        panic!("nothing is said");
    };
    assert_eq!(lost.state, State::Lost);
}
