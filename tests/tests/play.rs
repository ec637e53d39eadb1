//! A recording on the page: what a bridge has saved of a demo is played, and scrubbed in a real browser.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_test_needs as needs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};
use system_tests::{Demo, free_port, run_page_checks, send, sextant};

/// A program that is ended in any case.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        send(self.0.id(), libc::SIGINT);
        let _ = self.0.wait();
    }
}

fn next(lines: &mut impl BufRead) -> Value {
    let mut line = String::new();
    lines.read_line(&mut line).expect("text");
    serde_json::from_str(&line).expect("a line of JSON")
}

/// From the first pose to the last.
fn seconds_in(file: &Path) -> u64 {
    let recording = SiteRecording::read(file).expect("a recording");
    let times = || recording.poses.iter().map(|pose| pose.capture_ns);
    let span = times().max().unwrap_or(0) - times().min().unwrap_or(0);
    span / 1_000_000_000
}

#[test]
fn the_last_seconds_of_a_site_are_saved_and_played_on_the_page() {
    if needs::PLAY.is_skipped() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("last.mcap");
    let demo = Demo::start(&["--cameras", "2", "--objects", "1"]);
    let save = |arguments: &[&str]| {
        let mut command = sextant();
        command.arg("record").arg(&file).args(arguments);
        command.output().expect("sextant starts")
    };
    // There has to be something to be scrubbed through.
    while !file.exists() || seconds_in(&file) < 10 {
        let saved = save(&["--last", "30", "--page", &demo.page, "--force"]);
        assert!(saved.status.success(), "{saved:?}");
    }
    assert_eq!(
        save(&["--last", "30", "--page", &demo.page]).status.code(),
        Some(3)
    );
    demo.signal(libc::SIGINT);
    assert!(demo.wait().status.success());
    assert_eq!(
        save(&["--last", "5", "--page", "http://127.0.0.1:1"])
            .status
            .code(),
        Some(4)
    );

    let mut command = sextant();
    command
        .arg("play")
        .arg(&file)
        .args(["--json", "--no-browser", "--speed", "0.25", "--port"]);
    command.arg(free_port().to_string()).stdout(Stdio::piped());
    let mut player = Ended(command.spawn().expect("sextant starts"));
    let mut lines = BufReader::new(player.0.stdout.take().expect("a pipe"));
    let playing = next(&mut lines);
    assert_eq!(
        (&playing["event"], &playing["site"]),
        (&"playing".into(), &"demo".into())
    );
    let page = playing["page"].as_str().expect("an address");
    run_page_checks("play.mjs", &[page]);
    let played = next(&mut lines);
    assert_eq!(
        (&played["event"], &played["skipped"]),
        (&"played".into(), &0.into())
    );
}
