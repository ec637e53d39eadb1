//! Clocks that are set while a site runs: of a board, of all boards, of the fusion host.

use super::*;
use sextant_proto::Notice;
use system_tests::SteppedClock;

const STEPS_S: [i64; 2] = [5, -5];

/// Whether a finding or notice of a fusion node names this.
fn names(status: &FusionStatus, word: &str) -> bool {
    let findings = status.faults.iter().map(ToString::to_string);
    let notices = status.notices.iter().map(ToString::to_string);
    findings.chain(notices).any(|words| words.contains(word))
}

/// The fusion node's process sees another wall clock from one moment to the next, and later the former one.
#[test]
fn a_fusion_host_whose_clock_is_set_says_so_and_goes_on() {
    const ROW: &str = "clock of the fusion host set by 5 s";
    for by_s in STEPS_S {
        let clock = SteppedClock::new();
        let mut house = House::new(&scene());
        let router = house.router("router", &[]);
        let wrapper = clock.wrapper();
        house.fusion_in(
            "main",
            &[&router],
            "",
            &wrapper.each_ref().map(String::as_str),
        );
        let cameras = feed(&house, &ALL, &[&router], now_ns());
        let witness = Witness::start(&house.keys, &[&router]);
        await_tracking(&house, &[&router], 1);
        for (to_s, step_s, what) in [(by_s, by_s, "set"), (0, -by_s, "set right again")] {
            let since = Instant::now();
            clock.set(to_s * 1_000_000_000);
            await_main(&house, &router, |status| {
                let mut notices = status.notices.iter();
                notices.any(|one| matches!(one, Notice::ClockStepped { by_s } if (by_s - step_s as f64).abs() < 0.5))
            });
            Figure {
                row: ROW,
                what: &format!("{by_s:+} s, {what}, named after"),
                value: since.elapsed().as_secs_f64() * 1e3,
                unit: "ms",
                at_most: 2000.0,
            }
            .keep();
            std::thread::sleep(lasting(10, 2));
            let used = witness.used_since(since);
            assert_true(&house, &cameras, &used);
            if to_s < 0 {
                // Images that are stamped more than a second ahead of the host's clock are left out until it is right
                // again.
                continue;
            }
            let last = used.last().expect("a pose");
            assert!(last.at.elapsed() < Duration::from_secs(1), "poses go on");
            Figure {
                row: ROW,
                what: &format!("{by_s:+} s, {what}, longest gap"),
                value: longest_gap_ms(&used, since),
                unit: "ms without a pose",
                at_most: 1000.0,
            }
            .keep();
        }
    }
}

/// The stamps of all cameras are off at once, until their clocks are set right again.
#[test]
fn cameras_whose_clocks_are_all_set_are_named_and_go_on() {
    const ROW: &str = "clocks of all boards set by 5 s";
    for by_s in STEPS_S {
        let mut house = House::new(&scene());
        let router = house.router("router", &[]);
        house.fusion("main", &[&router]);
        let cameras = feed(&house, &ALL, &[&router], now_ns());
        let witness = Witness::start(&house.keys, &[&router]);
        await_tracking(&house, &[&router], 1);
        let since = Instant::now();
        cameras.set_clock(-by_s * 1_000_000_000);
        await_main(&house, &router, |status| names(status, "clock"));
        Figure {
            row: ROW,
            what: &format!("{by_s:+} s named after"),
            value: since.elapsed().as_secs_f64() * 1e3,
            unit: "ms",
            // A second to be sure, and a second from one status to the next.
            at_most: 2200.0,
        }
        .keep();
        std::thread::sleep(lasting(5, 2));
        let back = Instant::now();
        cameras.set_clock(0);
        let tracks = |pose: &sextant_proto::ObjectPose| {
            let age_ns = now_ns().saturating_sub(pose.capture_ns);
            pose.state == State::Tracking && age_ns < 1_000_000_000
        };
        let again = witness.await_pose(back, tracks);
        Figure {
            row: ROW,
            what: &format!("{by_s:+} s, poses after it is right again"),
            value: (again - back).as_secs_f64() * 1e3,
            unit: "ms",
            at_most: 5000.0,
        }
        .keep();
        // Images that were under way when the clocks were set right have the stamps, and their poses the time, of the
        // clocks before.
        let used = witness.used_since(back + Duration::from_millis(100));
        assert_true(&house, &cameras, &used);
    }
}

/// The clock of one camera's board is set by five seconds, and set right again.
#[test]
fn a_board_whose_clock_is_set_is_named_and_taken_again() {
    const ROW: &str = "clock of a board set by 5 s";
    for by_s in STEPS_S {
        let mut house = House::new(&scene());
        let router = house.router("router", &[]);
        house.fusion("main", &[&router]);
        let start_ns = now_ns();
        let others = feed(&house, &[0, 1, 2], &[&router], start_ns);
        let board = feed(&house, &[3], &[&router], start_ns);
        let witness = Witness::start(&house.keys, &[&router]);
        await_tracking(&house, &[&router], 1);
        let since = Instant::now();
        board.set_clock(by_s * 1_000_000_000);
        await_main(&house, &router, |status| names(status, "cam3"));
        Figure {
            row: ROW,
            what: &format!("{by_s:+} s named after"),
            value: since.elapsed().as_secs_f64() * 1e3,
            unit: "ms",
            at_most: 2000.0,
        }
        .keep();
        board.set_clock(0);
        await_main(&house, &router, |status| {
            !names(status, "cam3") && status.cameras[3].rate_hz > 25.0
        });
        let used = witness.used_since(since);
        Figure {
            row: ROW,
            what: "longest gap of poses",
            value: longest_gap_ms(&used, since),
            unit: "ms",
            at_most: 300.0,
        }
        .keep();
        assert_true(&house, &others, &used);
    }
}
