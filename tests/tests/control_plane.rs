//! A link that stays open while nothing is answered any more is noticed, so that the node's watchdog is no longer fed.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_zenoh_bus::{Bus, BusOptions, ControlProbe, Mode};
use std::time::{Duration, Instant};
use system_tests::{FaultProxy, Faults, PATIENCE, free_port};

/// So long that a dead link is not closed during the test.
const LEASE_MS: u32 = 60_000;
const KEY: &str = "sextant/v1/lab/alive/*/*";

fn seconds(number: u64) -> Duration {
    Duration::from_secs(number)
}

#[test]
fn a_router_that_answers_no_more_is_noticed() {
    let endpoint = format!("tcp/127.0.0.1:{}", free_port());
    let open = |mode, options: BusOptions| {
        let options = BusOptions {
            mode,
            lease_ms: LEASE_MS,
            ..options
        };
        Bus::open(&options).expect("a session")
    };
    let _router = open(Mode::Router, BusOptions::router_on(&endpoint));
    let proxy = FaultProxy::start(&endpoint);
    let client = open(Mode::Client, BusOptions::client_of(&proxy.endpoint));
    let start = Instant::now();
    let mut probe = ControlProbe::new(KEY, start);
    assert!(probe.is_answered(&client, start));
    // The question of second 10 is answered: at second 20 it is 10 s old.
    assert!(probe.is_answered(&client, start + seconds(10)));
    let deadline = Instant::now() + PATIENCE;
    while !probe.is_answered(&client, start + seconds(20)) {
        assert!(Instant::now() < deadline, "never answered");
        std::thread::sleep(Duration::from_millis(10));
    }
    proxy.set(Faults {
        is_frozen: true,
        ..Faults::default()
    });
    assert!(client.is_connected(), "the link seems to be well");
    assert!(!probe.is_answered(&client, start + seconds(40)));
    // Its question stays without an answer.
    std::thread::sleep(seconds(3));
    assert!(!probe.is_answered(&client, start + seconds(41)));
    assert!(client.is_connected());
}
