//! `sextant demo` as a newcomer runs it: it is accurate, it stays within its memory, it ends clean however it is ended.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_process::memory::pss_bytes;
use system_tests::{Demo, Traces, sextant};

const MIB: u64 = 1 << 20;

/// Resident memory (proportional share) that each kind of process may take at most.
const MEMORY: &[(&str, u64)] = &[
    ("capture", 25 * MIB),
    ("detect", 25 * MIB),
    ("fusion", 40 * MIB),
    ("viewer", 60 * MIB),
];

/// Images that come later than this, in ms, are near the end of fusion's window: beyond it poses are foreseen, not
/// seen.
const LIVE_MS: f64 = 400.0;

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

/// What a demo with these arguments says at its end, once the machine is not too busy with other work to follow live.
fn live_summary(arguments: &[&str]) -> Value {
    let mut latencies = Vec::new();
    for _ in 0..3 {
        let demo = Demo::start(arguments);
        let id = demo.id();
        let ended = demo.wait();
        assert!(ended.status.success(), "{:?}", ended.status);
        assert!(Traces::demo(id).is_none(), "{:?}", Traces::demo(id));
        let latency_ms = number(&ended.summary["latency_ms"]["p99"]);
        if latency_ms < LIVE_MS {
            return ended.summary;
        }
        latencies.push(latency_ms);
    }
    panic!(
        "this machine is too busy for a live demo: 99 % within {latencies:?} ms, at most {LIVE_MS} are asked"
    );
}

#[test]
fn a_demo_is_accurate_and_leaves_nothing_behind() {
    let summary = live_summary(&["--duration", "8"]);
    let cameras = summary["cameras"].as_array().expect("cameras");
    let objects = summary["objects"].as_array().expect("objects");
    assert_eq!((cameras.len(), objects.len()), (4, 3), "{summary}");
    for camera in cameras {
        assert!(
            number(&camera["captured"]) > 0.0 && number(&camera["detected"]) > 0.0,
            "{summary}"
        );
        assert!(
            number(&camera["captured"]) >= number(&camera["detected"]) + number(&camera["dropped"]),
            "{summary}"
        );
    }
    for object in objects {
        assert!(number(&object["position_rms_mm"]) < 3.0, "{summary}");
        assert!(number(&object["attitude_rms_deg"]) < 1.0, "{summary}");
    }
}

#[test]
fn an_arm_is_one_object_among_others_and_judged_by_its_links() {
    let summary = live_summary(&[
        "--arm",
        "--objects",
        "1",
        "--cameras",
        "3",
        "--duration",
        "6",
    ]);
    let objects = summary["objects"].as_array().expect("objects");
    let ids: Vec<&str> = objects
        .iter()
        .filter_map(|one| one["id"].as_str())
        .collect();
    assert_eq!(
        ids,
        ["arm.base", "arm.fore", "arm.upper", "cuboid"],
        "{summary}"
    );
    for object in objects {
        assert!(number(&object["position_rms_mm"]) < 6.0, "{summary}");
        // A link of which few images show a single tag first is uncertain, and says so.
        let stated_deg = 2.0 * number(&object["attitude_sigma_deg"]);
        let most_deg = stated_deg.max(3.0);
        assert!(number(&object["attitude_rms_deg"]) < most_deg, "{summary}");
    }
}

#[test]
fn every_process_stays_within_its_memory() {
    let demo = Demo::start(&["--cameras", "2"]);
    for (name, id) in &demo.processes {
        let (_, limit) = MEMORY
            .iter()
            .find(|(kind, _)| name.starts_with(kind))
            .expect("a known kind of process");
        let used = pss_bytes(*id).expect("the process lives");
        assert!(used <= *limit, "{name} takes {used} bytes");
    }
    demo.signal(libc::SIGINT);
    assert!(demo.wait().status.success());
}

#[test]
fn two_demos_side_by_side_do_not_meet() {
    let first = Demo::start(&["--cameras", "1", "--objects", "1"]);
    let second = Demo::start(&[
        "--cameras",
        "2",
        "--objects",
        "2",
        "--duration",
        "2",
        "--site",
        "other",
    ]);
    let second = second.wait();
    assert!(second.status.success());
    assert_eq!(second.summary["objects"].as_array().map(Vec::len), Some(2));
    first.signal(libc::SIGTERM);
    let first = first.wait();
    assert!(first.status.success());
    assert_eq!(first.summary["objects"].as_array().map(Vec::len), Some(1));
}

#[test]
fn the_death_of_a_child_ends_the_demo_with_a_fault() {
    let demo = Demo::start(&["--cameras", "1", "--objects", "1"]);
    let id = demo.id();
    let (_, fusion) = demo
        .processes
        .iter()
        .find(|(name, _)| name == "fusion")
        .expect("a fusion node");
    system_tests::send(*fusion, libc::SIGKILL);
    assert_eq!(demo.wait().status.code(), Some(1));
    assert!(Traces::demo(id).is_none(), "{:?}", Traces::demo(id));
}

#[test]
fn what_a_killed_demo_leaves_the_next_one_removes() {
    let killed = Demo::start(&["--cameras", "1", "--objects", "1"]);
    let id = killed.id();
    for (_, process) in &killed.processes {
        system_tests::send(*process, libc::SIGKILL);
    }
    killed.signal(libc::SIGKILL);
    assert!(!killed.wait().status.success());
    assert!(!Traces::demo(id).is_none(), "a killed demo can't clean up");
    let next = Demo::start(&["--cameras", "1", "--objects", "1", "--duration", "1"]);
    assert!(next.wait().status.success());
    assert!(Traces::demo(id).is_none(), "{:?}", Traces::demo(id));
}

#[test]
fn a_port_in_use_is_named_with_its_remedy() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = taken.local_addr().expect("an address").port().to_string();
    let output = sextant()
        .args(["demo", "--no-browser", "--port", &port])
        .output()
        .expect("sextant runs");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(4), "{message}");
    assert!(
        message.contains(&port) && message.contains("--port"),
        "{message}"
    );
}
