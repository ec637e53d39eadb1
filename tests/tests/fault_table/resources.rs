//! Shared memory, file handles and disks that run out.

use super::*;
use crate::camera_node::{CAMERA, DIE};
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_test_needs::{DISK_FULL, NO_SHARED_MEMORY};
use std::net::TcpStream;
use std::process::Command;

/// Connections that say nothing, more than a process of so few handles can take.
const HANDLES: usize = 64;
const CONNECTIONS: usize = 200;

/// A router that may open few files, and many connections on which nothing is sent. The members of the site are served
/// meanwhile.
#[test]
fn a_router_out_of_file_handles_goes_on() {
    const ROW: &str = "router out of file handles, by silent connections";
    let mut house = House::new(&scene());
    let endpoint = format!("tcp/127.0.0.1:{}", system_tests::free_port());
    let limited = format!("ulimit -n {HANDLES} && exec \"$@\"");
    house.router_in("router", &endpoint, &["sh", "-c", &limited, "sh"]);
    house.fusion("main", &[&endpoint]);
    let cameras = feed(&house, &ALL, &[&endpoint], now_ns());
    let witness = Witness::start(&house.keys, &[&endpoint]);
    await_tracking(&house, &[&endpoint], 1);
    let since = Instant::now();
    let address = endpoint.trim_start_matches("tcp/");
    let silent: Vec<_> = (0..CONNECTIONS)
        .filter_map(|_| TcpStream::connect(address).ok())
        .collect();
    let most_open = (0..50).map(|_| {
        std::thread::sleep(Duration::from_millis(10));
        house.open_files("router")
    });
    let most_open = most_open.max().unwrap_or_default();
    assert!(most_open + 4 > HANDLES, "{most_open} of {HANDLES} handles");
    std::thread::sleep(lasting(15, 3));
    drop(silent);
    let used = witness.used_since(since);
    Figure {
        row: ROW,
        what: "longest gap of those connected before",
        value: longest_gap_ms(&used, since),
        unit: "ms without a pose",
        at_most: 150.0,
    }
    .keep();
    let ended = Instant::now();
    let late = Witness::start(&house.keys, &[&endpoint]);
    let again = late.await_pose(ended, |pose| pose.state == State::Tracking);
    Figure {
        row: ROW,
        what: "a new subscriber is served after they have left",
        value: (again - ended).as_secs_f64() * 1e3,
        unit: "ms",
        at_most: 12_000.0,
    }
    .keep();
    assert_true(&house, &cameras, &witness.sights());
}

/// A camera node whose shared memory has no room for its images, until there is room.
#[test]
fn a_camera_out_of_shared_memory_says_so_and_recovers() {
    const ROW: &str = "camera out of shared memory";
    if NO_SHARED_MEMORY.is_skipped() {
        return;
    }
    let mut house = camera_node::house();
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let cameras = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    witness.await_pose(Instant::now(), |pose| pose.state == State::Tracking);
    let prefix = format!("r{}", std::process::id());
    let text = camera_node::write_files(&house, &router, &prefix);
    let (size, log) = (house.path("", "room"), house.path("", "camera.log"));
    // A file in the way leaves room for no image; a script of the mount's own takes it away when it is asked to.
    let shell = format!(
        "mount -t tmpfs -o size=2m tmpfs /dev/shm || exit; head -c 2080000 /dev/zero > /dev/shm/full; \
        (while kill -0 $$ 2> /dev/null && ! test -e '{room}'; do sleep 0.1; done; rm \
        /dev/shm/full) > /dev/null 2>&1 & exec \"$@\" 2> '{log}'",
        room = size.display(),
        log = log.display()
    );
    let since = Instant::now();
    let wrapper = ["unshare", "--mount", "sh", "-c", &shell, "sh"];
    house.node_in(CAMERA, "camera", &text, &wrapper);
    std::thread::sleep(lasting(10, 3));
    let said = std::fs::read_to_string(&log).unwrap_or_default();
    assert!(said.contains("no room in shared memory"), "{said}");
    assert!(
        !said.contains("panicked") && !said.contains("SIGBUS"),
        "{said}"
    );
    let freed = Instant::now();
    std::fs::write(&size, "").expect("a file");
    let again = witness.await_pose(freed, |pose| {
        pose.object.as_str() == DIE && pose.state == State::Tracking
    });
    Figure {
        row: ROW,
        what: "its poses after there is room",
        value: (again - freed).as_secs_f64() * 1e3,
        unit: "ms",
        at_most: 12_000.0,
    }
    .keep();
    let mut others = witness.used_since(since);
    others.retain(|one| one.pose.object.as_str() != DIE);
    Figure {
        row: ROW,
        what: "longest gap of the others",
        value: longest_gap_ms(&others, since),
        unit: "ms without a pose",
        at_most: 150.0,
    }
    .keep();
    assert_true(&house, &cameras, &others);
}

/// A recorder that writes into a file system of two mebibytes.
#[test]
fn a_recorder_whose_disk_is_full_says_so_and_keeps_what_it_has() {
    if DISK_FULL.is_skipped() {
        return;
    }
    let mut house = House::new(&scene());
    let router = house.router("router", &[]);
    house.fusion("main", &[&router]);
    let _feed = feed(&house, &ALL, &[&router], now_ns());
    let witness = Witness::start(&house.keys, &[&router]);
    await_tracking(&house, &[&router], 1);
    let (folder, kept) = (house.path("", "disk"), house.path("", "kept.mcap"));
    std::fs::create_dir(&folder).expect("a folder");
    let record = house.command(&router, &["record"]);
    let mut shell = Command::new("unshare");
    shell.args(["--mount", "sh", "-c"]);
    shell.arg(
        "mount -t tmpfs -o size=2m tmpfs \"$1\" || exit; disk=$1 kept=$2; shift 2; \"$@\" \
        \"$disk/site.mcap\"; code=$?; cp \"$disk/site.mcap\" \"$kept\"; exit $code",
    );
    shell.arg("sh").args([&folder, &kept]);
    shell.arg(record.get_program()).args(record.get_args());
    let since = Instant::now();
    let ended = shell
        .output()
        .expect("unshare runs: it comes with util-linux");
    let words = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code().is_some_and(|code| code != 0), "{words}");
    assert!(
        words.contains("disk is full") || words.contains("No space"),
        "{words}"
    );
    let ended_ns = now_ns();
    let recording = SiteRecording::read(&kept).expect("it opens");
    let last_ns = recording.poses.iter().map(|pose| pose.published_ns).max();
    Figure {
        row: "recorder's disk full",
        what: "lost at the end",
        value: ended_ns.saturating_sub(last_ns.expect("poses")) as f64 * 1e-6,
        unit: "ms, the end of the program included",
        at_most: 1000.0,
    }
    .keep();
    Figure {
        row: "recorder's disk full",
        what: "longest gap of live poses",
        value: longest_gap_ms(&witness.used_since(since), since),
        unit: "ms",
        at_most: 150.0,
    }
    .keep();
}
