//! Routers that die, and links between routers that are cut.

use super::*;

/// Half of the cameras and one fusion node behind each of two routers, whose link is cut for a minute and mended.
#[test]
fn both_halves_of_a_divided_site_are_served_and_one_publisher_remains() {
    const ROW: &str = "half of the site cut off, then back";
    let (site, statuses, publisher) = DividedSite::start(House::new(&scene()));
    let (house, [left, _]) = (&site.house, &site.routers);
    let witnesses = (site.routers)
        .each_ref()
        .map(|router| Witness::start(&house.keys, &[router]));
    let first = statuses[HALVES[publisher]].epoch.expect("it publishes");
    let since = Instant::now();
    site.link.set(cut());
    witnesses[1 - publisher].await_pose(since, |pose| pose.epoch > first);
    std::thread::sleep(lasting(60, 3));
    for (witness, what) in witnesses.iter().zip(["first half", "other half"]) {
        Figure {
            row: ROW,
            what,
            value: longest_gap_ms(&witness.used_since(since), since),
            unit: "ms without a pose",
            at_most: 300.0,
        }
        .keep();
    }
    let healed = Instant::now();
    site.link.set(Faults::default());
    let statuses = house.await_statuses(&[left], one_publishes);
    let second = statuses[HALVES[1 - publisher]].epoch;
    let second = second.expect("the newer epoch stays");
    let one = Instant::now();
    for (witness, what) in witnesses
        .iter()
        .zip(["first half, healing", "other half, healing"])
    {
        witness.await_pose(one, |pose| pose.epoch == second);
        let mut late = witness.used_since(one).into_iter();
        assert!(late.all(|sight| sight.pose.epoch == second));
        let all = witness.sights();
        assert_epochs_increase(&all);
        assert_true(house, &site.feeds[0], &all);
        assert_fresh(&all);
        Figure {
            row: ROW,
            what,
            value: longest_gap_ms(&witness.used_since(healed), healed),
            unit: "ms without a pose",
            at_most: 1000.0,
        }
        .keep();
    }
}

/// Everything is behind the first of two routers, and goes on behind the second.
#[test]
fn a_site_goes_on_when_a_router_dies() {
    let mut house = House::new(&scene());
    let first = house.router("first", &[]);
    let second = house.router("second", &[&first]);
    house.fusion("main", &[&first, &second]);
    house.fusion("spare", &[&second, &first]);
    let feed = feed(&house, &ALL, &[&first, &second], now_ns());
    let witness = Witness::start(&house.keys, &[&second]);
    await_tracking(&house, &[&second], 2);
    let since = Instant::now();
    house.kill("first");
    witness.await_pose(since + Duration::from_secs(3), |pose| {
        pose.state == State::Tracking
    });
    let statuses = house.await_statuses(&[&second], one_publishes);
    assert!(
        statuses.contains_key("main"),
        "it is behind the other router"
    );
    let used = witness.used_since(since);
    Figure {
        row: "kill -9 of a router, the second goes on",
        what: "kill -9",
        value: longest_gap_ms(&used, since),
        unit: "ms without a pose",
        at_most: 1000.0,
    }
    .keep();
    assert_epochs_increase(&witness.sights());
    assert_true(&house, &feed, &witness.sights());
}
