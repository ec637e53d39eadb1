//! Poses on their way to other tools: a router of the test's, poses that it publishes, and the real program.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::posing_site::{PATIENCE, Site};
use crate::recording::{refused, sextant, stderr, stdout};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

#[test]
fn poses_come_as_text_in_three_formats() {
    let mut site = Site::open();
    let mut echo =
        |format| stdout(&site.run(&["echo", "cube", "--count", "3", "--format", format]));
    let json = echo("json");
    let lines: Vec<Value> = json
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(lines.len(), 3, "{json}");
    assert_eq!(lines[0]["object"], "cube");
    assert_eq!(lines[0]["position"], serde_json::json!([1.0, 2.0, 3.0]));
    assert_eq!(lines[0]["covariance"].as_array().unwrap().len(), 36);
    let csv = echo("csv");
    assert!(csv.starts_with("t_ns,object,state,x,y,z,"), "{csv}");
    assert_eq!(csv.lines().count(), 4, "{csv}");
    let tum = echo("tum");
    let fields: Vec<&str> = tum.lines().next().unwrap().split(' ').collect();
    assert_eq!(fields.len(), 8, "{tum}");
    let (_, decimals) = fields[0].split_once('.').unwrap();
    assert_eq!(decimals.len(), 9, "{tum}");
}

#[test]
fn poses_go_to_a_file_and_a_full_disk_is_reported() {
    let mut site = Site::open();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("poses.csv");
    let echo = ["echo", "--format", "csv", "--count", "2", "--out"];
    let said = stdout(&site.run(&[&echo[..], &[file.to_str().unwrap()]].concat()));
    assert_eq!(said, "");
    assert_eq!(std::fs::read_to_string(&file).unwrap().lines().count(), 3);
    let full = site.run(&[&echo[..], &["/dev/full"]].concat());
    refused(
        &full,
        1,
        "/dev/full: cannot write on; the 0 lines before are complete",
    );
    let nowhere = site.run(&[&echo[..], &["/proc/none/poses.csv"]].concat());
    refused(&nowhere, 3, "--out: /proc/none/poses.csv: ");
    let again = [&echo[..], &[file.to_str().unwrap()]].concat();
    refused(&site.run(&again), 3, "the file exists; choose another name");
    stdout(&site.run(&[&again[..], &["--force"]].concat()));
    assert_eq!(std::fs::read_to_string(&file).unwrap().lines().count(), 3);
}

#[test]
fn who_waits_for_an_unknown_object_reads_which_there_are() {
    let mut site = Site::open();
    site.announce(&["cube", "tray"]);
    for format in [&["--format", "json"][..], &[]] {
        let mut command = site.command(&["echo", "cub", "--duration", "6"]);
        let output = command.args(format).output().unwrap();
        let words = stderr(&output);
        assert!(
            words.contains("the site has the objects cube, tray"),
            "{words}"
        );
        assert_eq!(stdout(&output), "");
    }
}

#[test]
fn a_reader_that_has_enough_ends_the_echo_quietly() {
    let mut site = Site::open();
    let mut command = site.command(&["echo", "--format", "json"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = child.spawn().unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    let first = std::thread::spawn(move || {
        let mut line = String::new();
        reader.read_line(&mut line).unwrap();
        line
    });
    let deadline = Instant::now() + PATIENCE;
    while child.try_wait().unwrap().is_none() {
        assert!(Instant::now() < deadline, "it does not end");
        site.publish();
        std::thread::sleep(Duration::from_millis(10));
    }
    assert!(first.join().unwrap().starts_with("{\"t_ns\""));
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]));
}

#[test]
fn osc_messages_reach_their_receiver() {
    let mut site = Site::open();
    let (datagram, summary) = site.datagrams(&["osc", "--axes", "unity"], |_| true);
    assert!(datagram.starts_with(b"/sextant/cube/pose\0\0,fffffff\0\0\0\0"));
    // Unity's x is to the right, where Sextant's y is to the left.
    let x = &datagram[32..36];
    assert_eq!(x, (-2.0_f32).to_be_bytes());
    assert!(summary["sent"].as_u64() >= Some(1), "{summary}");
    let arguments = ["osc", "--layout", "vrchat", "--object", "cube"];
    site.datagrams(&arguments, |d| {
        d.starts_with(b"/tracking/trackers/1/rotation\0")
    });
    let arguments = ["osc", "--layout", "vmt", "--object", "cube"];
    site.datagrams(&arguments, |d| {
        d.starts_with(b"/VMT/Room/Unity\0,iiffffffff\0")
    });
}

#[test]
fn mavlink_odometry_reaches_its_autopilot_beside_heartbeats() {
    let mut site = Site::open();
    let id = |frame: &[u8]| u32::from_le_bytes([frame[7], frame[8], frame[9], 0]);
    let arguments = ["mavlink", "--object", "cube", "--sysid", "9"];
    let (frame, summary) = site.datagrams(&arguments, |frame| id(frame) == 331);
    assert_eq!((frame[0], frame[5], frame[6]), (0xfd, 9, 197));
    // y of the frame forward, right, down.
    assert_eq!(frame[10 + 12..][..4], (-2.0_f32).to_le_bytes());
    assert!(summary["sent"].as_u64() >= Some(1), "{summary}");
    site.datagrams(&arguments, |frame| id(frame) == 0);
}

#[test]
fn stages_and_studios_get_trackers_and_cameras() {
    let mut site = Site::open();
    let arguments = ["freed", "--object", "cube", "--camera", "9"];
    let (message, summary) = site.datagrams(&arguments, |_| true);
    assert_eq!((message.len(), &message[..2]), (29, &[0xd1, 9][..]));
    // Two metres to the left, one forward, three up, in 1/64 mm.
    let places = [-128_000, 64_000, 192_000_i32].map(|n| n.to_be_bytes()[1..].to_vec());
    assert_eq!(message[11..20], places.concat());
    assert!(summary["sent"].as_u64() >= Some(1), "{summary}");
    let arguments = ["opentrackio", "--object", "cube", "--source", "7"];
    let (sample, _) = site.datagrams(&arguments, |_| true);
    assert!(sample.starts_with(b"OTrk\0\x01"));
    let json: Value = serde_json::from_slice(&sample[16..]).unwrap();
    let place = &json["transforms"][0]["translation"];
    assert_eq!(*place, serde_json::json!({"x": -2, "y": 1, "z": 3}));
    let (packet, _) = site.datagrams(&["psn"], |packet| packet.starts_with(b"\x55\x67"));
    let position = [-2_f32, 3.0, 1.0].map(f32::to_le_bytes).concat();
    assert_eq!(packet[32..44], position);
    site.datagrams(&["psn"], |packet| packet.ends_with(b"\0\0\x04\0cube"));
}

#[test]
fn what_would_surprise_is_refused_before_anything_is_sent() {
    let run = |arguments: &[&str]| sextant().args(arguments).output().unwrap();
    for (arguments, cause) in [
        (&["osc", "--to", "239.0.0.1:9000"][..], "multicast"),
        (
            &["osc", "--to", "127.0.0.1:1", "--layout", "vrchat"],
            "--object",
        ),
        (
            &["osc", "--to", "127.0.0.1:1", "--address", "/pose"],
            "--object",
        ),
        (
            &["osc", "--to", "127.0.0.1:1", "--address", "pose"],
            "begins with",
        ),
        (
            &["mavlink", "--to", "udp:255.255.255.255:1", "--object", "a"],
            "broadcast",
        ),
        (
            &[
                "mavlink",
                "--to",
                "127.0.0.1:1",
                "--object",
                "a",
                "--rate",
                "0",
            ],
            "0.1 to 1000",
        ),
        (&["echo", "--format", "tum"], "one object only"),
        (
            &["echo", "--format", "csv", "a b"],
            "--format is for objects",
        ),
        (&["echo", "a", "b"], "several objects are for --format"),
    ] {
        refused(&run(arguments), 2, cause);
    }
}
