//! The bus between real sessions over TCP on loopback: what is put arrives, late joiners get the latest, the dead are
//! noticed, and a client waits for its router and finds it again. Every wait is for a condition, with a deadline that
//! only a broken build reaches.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use sextant_proto::{DecodeError, ObjectTruth};
use sextant_site_model::ObjectId;
use sextant_zenoh_bus::{
    Bus, BusError, BusOptions, DropRule, Payload, Presence, Qos, Security, Subscription,
};

use zenoh::Wait;

const PATIENCE: Duration = Duration::from_secs(60);
const MAX_BYTES: usize = 1000;

fn router() -> Bus {
    Bus::open(&BusOptions::router_on("tcp/127.0.0.1:0")).unwrap()
}

fn client_of(router: &Bus) -> Bus {
    Bus::open(&BusOptions::client_of(&router.endpoints()[0])).unwrap()
}

fn until(what: &str, mut condition: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !condition() {
        assert!(Instant::now() < deadline, "never happened: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Puts until something arrives: a subscription reaches its publisher some time after both exist.
fn put_until_received(bus: &Bus, key: &str, subscription: &Subscription) -> Vec<u8> {
    let publisher = bus.raw_publisher(key, Qos::Observation).unwrap();
    let mut received = None;
    until("a message arrives", || {
        publisher.put(b"hello").unwrap();
        received = subscription.recv_timeout(Duration::from_millis(20));
        received.is_some()
    });
    received.unwrap().bytes().unwrap().to_vec()
}

#[test]
fn a_name_has_one_holder_and_the_second_hears_on_which_host() {
    let router = router();
    let options = BusOptions {
        lease_ms: 500,
        ..BusOptions::client_of(&router.endpoints()[0])
    };
    let (first, second) = (Bus::open(&options).unwrap(), Bus::open(&options).unwrap());
    let never = || false;
    let held = first
        .hold_name("a/holder/camera/north", "desk", &never)
        .unwrap();
    let other = second
        .hold_name("a/holder/camera/south", "bench", &never)
        .unwrap();
    assert!(held.is_some() && other.is_some());
    let refusal = second
        .hold_name("a/holder/camera/north", "bench", &never)
        .unwrap_err();
    let words = refusal.to_string();
    assert!(
        words.starts_with("camera north runs on host desk already"),
        "{words}"
    );
    let stopped = second.hold_name("a/holder/camera/north", "bench", &|| true);
    assert!(stopped.unwrap().is_none());
    drop(held);
    let succeeded = second.hold_name("a/holder/camera/north", "bench", &never);
    assert!(succeeded.unwrap().is_some());
}

#[test]
fn of_two_that_want_a_name_at_once_one_has_it() {
    let router = router();
    let clients = [client_of(&router), client_of(&router)];
    for round in 0..10 {
        let key = format!("a/holder/camera/c{round}");
        let is_held = AtomicBool::new(false);
        let stop = || is_held.load(Ordering::SeqCst);
        let hold = |client: &Bus| {
            let held = client.hold_name(&key, "desk", &stop).unwrap();
            if held.is_some() {
                assert!(!is_held.swap(true, Ordering::SeqCst), "held twice");
            }
            held
        };
        std::thread::scope(|scope| {
            let holders = clients
                .each_ref()
                .map(|client| scope.spawn(|| hold(client)));
            // Both are kept until both have been answered.
            let held = holders.map(|holder| holder.join().unwrap());
            assert_eq!(held.iter().flatten().count(), 1);
        });
    }
}

#[test]
fn who_took_a_name_while_the_network_was_parted_is_noticed() {
    let router = router();
    let (client, parted) = (client_of(&router), client_of(&router));
    let held = client.hold_name("a/holder/camera/north", "desk", &|| false);
    let mut held = held.unwrap().unwrap();
    assert!(held.others().is_empty());
    let token = parted.alive("a/holder/camera/north/77/bench").unwrap();
    until("the other is seen", || held.others() == ["bench"]);
    drop(token);
    until("the other is gone", || held.others().is_empty());
}

#[test]
fn what_one_client_puts_the_other_receives() {
    let router = router();
    let (sender, receiver) = (client_of(&router), client_of(&router));
    let subscription = receiver
        .subscribe("a/*/c", 8, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    assert_eq!(
        put_until_received(&sender, "a/b/c", &subscription),
        b"hello"
    );
}

#[test]
fn a_signed_message_says_who_sent_it() {
    let router = router();
    let (sender, receiver) = (client_of(&router), client_of(&router));
    let subscription = receiver
        .subscribe("a/b", 8, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    let truth = ObjectTruth {
        object: ObjectId::new("cube").unwrap(),
        capture_ns: 1,
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        position_error_m: 0.0,
        attitude_error_rad: 0.0,
    };
    let publisher = sender.publisher::<ObjectTruth>("a/b", Qos::Status).unwrap();
    let signed = publisher.signed("ann@desk");
    let mut received = None;
    until("a message arrives", || {
        signed.put(&truth).unwrap();
        received = subscription.recv_timeout(Duration::from_millis(20));
        received.is_some()
    });
    assert_eq!(received.unwrap().sender.as_deref(), Some("ann@desk"));
    put_until_received(&sender, "a/b", &subscription);
    let publisher = sender.raw_publisher("a/b", Qos::Status).unwrap();
    publisher.put(b"hello").unwrap();
    let item = subscription.recv_timeout(PATIENCE).unwrap();
    assert_eq!(
        (item.bytes(), item.sender.as_deref()),
        (Some(&b"hello"[..]), None)
    );
}

#[test]
fn peers_talk_without_a_router() {
    let listening = BusOptions {
        mode: sextant_zenoh_bus::Mode::Peer,
        listen: vec!["tcp/127.0.0.1:0".into()],
        ..BusOptions::default()
    };
    let one = Bus::open(&listening).unwrap();
    let connecting = BusOptions {
        connect: Some(one.endpoints().to_vec()),
        listen: Vec::new(),
        ..listening
    };
    let two = Bus::open(&connecting).unwrap();
    let subscription = two
        .subscribe("a/**", 8, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    assert_eq!(put_until_received(&one, "a/b", &subscription), b"hello");
}

#[test]
fn a_message_that_is_too_long_is_announced_and_not_copied() {
    let router = router();
    let subscription = router
        .subscribe("a", 8, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    let publisher = router.raw_publisher("a", Qos::Observation).unwrap();
    publisher.put(&[0; MAX_BYTES]).unwrap();
    publisher.put(&[0; MAX_BYTES + 1]).unwrap();
    assert_eq!(
        subscription.recv_timeout(PATIENCE).unwrap().payload,
        Payload::Bytes(vec![0; MAX_BYTES])
    );
    assert_eq!(
        subscription.recv_timeout(PATIENCE).unwrap().payload,
        Payload::TooLong(MAX_BYTES + 1)
    );
}

#[test]
fn nobody_is_asked_to_make_what_nobody_wants() {
    let router = router();
    let publisher = router.raw_publisher("a", Qos::Preview).unwrap();
    assert!(!publisher.has_subscribers());
    let client = client_of(&router);
    let subscription = client
        .subscribe("a", 1, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    until("the publisher hears of its subscriber", || {
        publisher.has_subscribers()
    });
    drop(subscription);
    until("the publisher hears that it left", || {
        !publisher.has_subscribers()
    });
}

#[test]
fn a_late_joiner_gets_the_latest_values_sorted_by_key() {
    let router = router();
    let early = client_of(&router);
    let (b, a) = (
        early.raw_latest("x/b", Qos::Config).unwrap(),
        early.raw_latest("x/a", Qos::Config).unwrap(),
    );
    let silent = early.raw_latest("x/c", Qos::Config).unwrap();
    for value in [b"1", b"2"] {
        b.put(value).unwrap();
        a.put(value).unwrap();
    }
    let late = client_of(&router);
    let mut values = Vec::new();
    until("both values are there", || {
        values = late
            .latest("x/*", MAX_BYTES, Duration::from_secs(2))
            .unwrap();
        values.len() == 2
    });
    assert_eq!(
        values
            .iter()
            .map(|item| item.key.as_str())
            .collect::<Vec<_>>(),
        ["x/a", "x/b"]
    );
    assert!(values.iter().all(|item| item.bytes() == Some(b"2")));
    drop(silent);
}

#[test]
fn values_of_a_storage_are_no_latest_values() {
    let router = router();
    let node = client_of(&router);
    let live = node.raw_latest("x/live", Qos::Config).unwrap();
    live.put(b"live").unwrap();
    let queries = Arc::new(AtomicUsize::new(0));
    let _storage = storage_of(&router, &["x/ended", "x/live"], Arc::clone(&queries));
    let late = client_of(&router);
    let mut values = Vec::new();
    until("both answer", || {
        queries.store(0, Ordering::SeqCst);
        values = late.latest("x/*", MAX_BYTES, PATIENCE).unwrap();
        queries.load(Ordering::SeqCst) > 0 && !values.is_empty()
    });
    assert_eq!(values.len(), 1, "{values:?}");
    assert_eq!(values[0].key, "x/live");
    assert_eq!(values[0].bytes(), Some(&b"live"[..]));
}

/// A session that answers as zenoh's storages do: with time stamps.
fn storage_of(router: &Bus, keys: &'static [&str], queries: Arc<AtomicUsize>) -> impl Sized {
    let mut config = zenoh::Config::default();
    let endpoints = format!("{:?}", router.endpoints());
    for (key, value) in [
        ("mode", "\"client\""),
        ("connect/endpoints", &endpoints),
        ("scouting/multicast/enabled", "false"),
    ] {
        config.insert_json5(key, value).unwrap();
    }
    let session = zenoh::open(config).wait().unwrap();
    let stamp = session.new_timestamp();
    let queryable = session.declare_queryable("x/**").callback(move |query| {
        queries.fetch_add(1, Ordering::SeqCst);
        for key in keys {
            query.reply(*key, "stored").timestamp(stamp).wait().unwrap();
        }
    });
    (queryable.wait().unwrap(), session)
}

#[test]
fn a_watch_sees_those_there_before_it_and_their_end() {
    let router = router();
    let node = client_of(&router);
    let token = node.alive("s/alive/camera/north").unwrap();
    let watch = router.watch_alive("s/alive/**").unwrap();
    let key = "s/alive/camera/north".to_owned();
    assert_eq!(
        watch.recv_timeout(PATIENCE),
        Some(Presence::Joined(key.clone()))
    );
    drop(token);
    assert_eq!(watch.recv_timeout(PATIENCE), Some(Presence::Left(key)));
}

#[test]
fn a_token_ends_with_its_session() {
    let router = router();
    let node = client_of(&router);
    let watch = router.watch_alive("s/alive/**").unwrap();
    let _token = node.alive("s/alive/fusion/one").unwrap();
    assert!(matches!(
        watch.recv_timeout(PATIENCE),
        Some(Presence::Joined(_))
    ));
    node.close();
    assert!(matches!(
        watch.recv_timeout(PATIENCE),
        Some(Presence::Left(_))
    ));
}

#[test]
fn a_port_in_use_is_named() {
    let router = router();
    let error = Bus::open(&BusOptions::router_on(&router.endpoints()[0])).unwrap_err();
    assert!(matches!(error, BusError::InUse { .. }), "{error}");
}

#[test]
fn a_client_without_a_router_waits_until_it_is_stopped() {
    let free_port = std::net::TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    let options = BusOptions::client_of(&format!("tcp/127.0.0.1:{free_port}"));
    let asked = AtomicBool::new(false);
    let (open, stop) = (Security::default(), || asked.swap(true, Ordering::SeqCst));
    let error = Bus::open_unless(&options, &open, &stop).unwrap_err();
    assert!(matches!(error, BusError::Abandoned { .. }), "{error}");
}

#[test]
fn a_client_finds_a_router_that_starts_later_and_one_that_returns() {
    let port = std::net::TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    let endpoint = format!("tcp/127.0.0.1:{port}");
    let early = std::thread::spawn({
        let options = BusOptions::client_of(&endpoint);
        move || Bus::open(&options).unwrap()
    });
    let first = Bus::open(&BusOptions::router_on(&endpoint)).unwrap();
    let client = early.join().unwrap();
    let subscription = client
        .subscribe("a", 8, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    let latest = client.raw_latest("b", Qos::Config).unwrap();
    latest.put(b"kept").unwrap();
    assert_eq!(put_until_received(&first, "a", &subscription), b"hello");

    first.close();
    until("the client notices", || !client.is_connected());
    let second = Bus::open(&BusOptions::router_on(&endpoint)).unwrap();
    until("the client returns", || client.is_connected());
    while subscription.try_recv().is_some() {}
    assert_eq!(put_until_received(&second, "a", &subscription), b"hello");
    until("the latest value is there again", || {
        second
            .latest("b", MAX_BYTES, Duration::from_secs(1))
            .unwrap()
            .len()
            == 1
    });
}

#[test]
fn a_message_keeps_its_contract_on_both_ends() {
    let router = router();
    let truth = ObjectTruth {
        object: ObjectId::new("cube").unwrap(),
        capture_ns: 1,
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        position_error_m: 0.0,
        attitude_error_rad: 0.0,
    };
    let subscription = router
        .subscribe("a", 8, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    let publisher = router.publisher::<ObjectTruth>("a", Qos::Pose).unwrap();
    let broken = ObjectTruth {
        position: [f64::NAN; 3],
        ..truth.clone()
    };
    assert!(matches!(
        publisher.put(&broken),
        Err(BusError::Message { .. })
    ));
    publisher.put(&truth).unwrap();
    let item = subscription.recv_timeout(PATIENCE).unwrap();
    assert_eq!(item.decode::<ObjectTruth>().unwrap(), truth);
    router
        .raw_publisher("a", Qos::Pose)
        .unwrap()
        .put(&[0; MAX_BYTES + 1])
        .unwrap();
    let item = subscription.recv_timeout(PATIENCE).unwrap();
    assert_eq!(
        item.decode::<ObjectTruth>(),
        Err(DecodeError::TooLong(MAX_BYTES + 1))
    );
}

#[test]
fn two_sites_on_one_host_do_not_hear_each_other() {
    let (here, there) = (router(), router());
    let elsewhere = there
        .subscribe("a", 8, DropRule::Oldest, MAX_BYTES)
        .unwrap();
    let subscription = here.subscribe("a", 8, DropRule::Oldest, MAX_BYTES).unwrap();
    put_until_received(&here, "a", &subscription);
    assert_eq!(elsewhere.counts().received, 0);
}
