//! Links of single cameras: cut, lossy, slow.

use super::*;

/// One camera behind a link that stalls with its connection open, so that images pile up in it.
#[test]
fn a_camera_that_was_cut_off_brings_no_stale_images() {
    const ROW: &str = "camera cut off, then back";
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let proxy = FaultProxy::start(&router);
    let start_ns = now_ns();
    let others = feed(&house, &[0, 1, 2], &[&router], start_ns);
    let _cut = feed(&house, &[3], &[&proxy.endpoint], start_ns);
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    let rate = |status: &FusionStatus, camera: usize| f64::from(status.cameras[camera].rate_hz);
    let is_back = |status: &FusionStatus| rate(status, 3) > 25.0;
    await_main(&house, &router, is_back);
    proxy.set(Faults {
        is_frozen: true,
        ..Faults::default()
    });
    std::thread::sleep(lasting(10, 4));
    let during = await_main(&house, &router, |status| rate(status, 3) == 0.0);
    let slowest = (0..3)
        .map(|camera| rate(&during, camera))
        .fold(f64::MAX, f64::min);
    Figure {
        row: ROW,
        what: "rate of the others",
        value: 100.0 * (1.0 - slowest / 30.0).max(0.0),
        unit: "% less",
        at_most: 2.0,
    }
    .keep();
    let before = during.cameras[3].last_capture_ns;
    let back = Instant::now();
    proxy.set(Faults::default());
    await_main(&house, &router, |status| {
        let last_ns = status.cameras[3].last_capture_ns;
        last_ns > before && now_ns().saturating_sub(last_ns) < 1_500_000_000
    });
    Figure {
        row: ROW,
        what: "back in the status after",
        value: back.elapsed().as_secs_f64() * 1e3,
        unit: "ms",
        at_most: 2000.0,
    }
    .keep();
    await_main(&house, &router, is_back);
    let all = witness.sights();
    assert_true(&house, &others, &all);
    assert_fresh(&all);
}

#[test]
fn a_lossy_camera_costs_no_coverage_where_others_see() {
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let proxy = FaultProxy::start(&router);
    let start_ns = now_ns();
    let others = feed(&house, &[0, 1, 2], &[&router], start_ns);
    let _lossy = feed(&house, &[3], &[&proxy.endpoint], start_ns);
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    proxy.set(Faults {
        loss: 0.2,
        jitter: Duration::from_millis(200),
        ..Faults::default()
    });
    let since = Instant::now();
    std::thread::sleep(lasting(30, 4));
    let used = witness.used_since(since);
    let tracked = used.iter().filter(|one| one.pose.state == State::Tracking);
    Figure {
        row: "20 % loss, 200 ms jitter on one camera",
        what: "poses that are not tracking",
        value: 100.0 * (1.0 - tracked.count() as f64 / used.len() as f64),
        unit: "%",
        at_most: 0.5,
    }
    .keep();
    Figure {
        row: "20 % loss, 200 ms jitter on one camera",
        what: "longest gap",
        value: longest_gap_ms(&used, since),
        unit: "ms",
        at_most: 150.0,
    }
    .keep();
    assert_true(&house, &others, &used);
    assert_fresh(&used);
}
