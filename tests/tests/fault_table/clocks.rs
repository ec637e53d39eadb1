//! The clock of the fusion host.

use super::*;

/// What a fusion node sees when its host's clock is set: the stamps of all cameras are off at once, until the clock is set right again.
#[test]
fn a_fusion_host_whose_clock_is_set_says_so_and_goes_on() {
    const ROW: &str = "clock of the fusion host set by 5 s against all cameras";
    for by_s in [5, -5] {
        let mut house = House::new(&scene());
        let router = house.router("router", &[]);
        house.fusion("main", &[&router]);
        let cameras = feed(&house, &ALL, &[&router], now_ns());
        let witness = Witness::start(&house.keys, &[&router]);
        await_tracking(&house, &[&router], 1);
        let since = Instant::now();
        cameras.set_clock(-by_s * 1_000_000_000);
        let is_named = |status: &FusionStatus| {
            let findings = status.faults.iter().map(ToString::to_string);
            let notices = status.notices.iter().map(ToString::to_string);
            let words: Vec<String> = findings.chain(notices).collect();
            words.iter().any(|words| words.contains("clock"))
        };
        await_main(&house, &router, is_named);
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
        let used = witness.used_since(back);
        assert_true(&house, &cameras, &used);
    }
}
