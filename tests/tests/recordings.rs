//! A site is recorded; the recorder is killed; the file opens, and its replay gives the poses that were published live,
//! bit for bit.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_process::now_ns;
use sextant_recordings::mcap::reader::Ending;
use sextant_recordings::mcap::site_recording::SiteRecording;
use sextant_site_files::write_object;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Output, Stdio};
use std::time::{Duration, Instant};
use system_tests::{FusedSite, PATIENCE, Scene, send, sextant};

/// From one instant to the next.
const PERIOD: Duration = Duration::from_micros(33_333);

/// A running `sextant record`. Dropping it kills it.
struct Recorder {
    process: Child,
    output: BufReader<ChildStdout>,
}

impl Recorder {
    /// Starts it and waits until it says that it records.
    fn start(site: &FusedSite, file: &Path) -> Self {
        let mut process = sextant()
            .args([
                "record",
                "--json",
                "--site",
                "lab",
                "--connect",
                &site.connect,
            ])
            .arg(file)
            .stdout(Stdio::piped())
            .spawn()
            .expect("sextant starts");
        let output = BufReader::new(process.stdout.take().expect("a pipe"));
        let mut recorder = Self { process, output };
        assert_eq!(recorder.line()["event"], "recording");
        recorder
    }

    fn line(&mut self) -> Value {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("text");
        serde_json::from_str(&line).unwrap_or_else(|cause| panic!("{cause}: {line}"))
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if matches!(self.process.try_wait(), Ok(None)) {
            let _ = self.process.kill();
        }
        let _ = self.process.wait();
    }
}

/// Lets the cameras see for so many instants at 30 Hz, the objects where they are so long after the first one.
///
/// The motion has the pace of the clock: one that is faster is a fault, whose poses are rightly held back.
fn look(site: &mut FusedSite, scene: &mut Scene, instants: std::ops::Range<u32>) {
    let begin_ns = now_ns();
    let begun = Instant::now();
    for instant in instants.clone() {
        let elapsed = PERIOD * (instant - instants.start);
        std::thread::sleep(elapsed.saturating_sub(begun.elapsed()));
        let time_ns = begin_ns + elapsed.as_nanos() as u64;
        let seconds = (PERIOD * instant).as_secs_f64();
        for camera in 0..scene.rig.cameras().len() {
            site.publish(&scene.observe(camera, seconds, time_ns));
        }
    }
}

/// The recording so far, once it is as wanted.
fn recorded(file: &Path, wanted: impl Fn(&SiteRecording) -> bool) -> SiteRecording {
    let deadline = Instant::now() + PATIENCE;
    loop {
        let recording = SiteRecording::read(file).expect("it opens at any time");
        if wanted(&recording) {
            return recording;
        }
        assert!(
            Instant::now() < deadline,
            "never recorded: {} poses",
            recording.poses.len()
        );
        std::thread::yield_now();
    }
}

fn replay(file: &Path, out: &Path) -> Value {
    let output = sextant()
        .args(["replay", "--json"])
        .arg(file)
        .arg("--out")
        .arg(out)
        .output()
        .expect("sextant runs");
    assert!(output.status.success(), "{}", said(&output));
    serde_json::from_slice(&output.stdout).expect("a line of JSON")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn n_inputs(recording: &SiteRecording) -> usize {
    let batches = recording.inputs.values().flatten();
    batches.map(|batch| batch.inputs.len()).sum()
}

fn scene() -> Scene {
    Scene::new(3, &["box", "cube"])
}

#[test]
fn a_killed_recording_replays_to_the_poses_that_were_published_live() {
    let mut scene = scene();
    let mut site = FusedSite::start(&scene.rig, &scene.objects[..1], "");
    let [file, out, again]: [PathBuf; 3] =
        ["site.mcap", "poses.jsonl", "again.jsonl"].map(|name| site.path(name));
    let mut recorder = Recorder::start(&site, &file);
    look(&mut site, &mut scene, 0..40);
    // Another object comes while the site runs.
    let object = site.path("cube.toml");
    write_object(&object, &scene.objects[1]).expect("the folder can be written");
    let set = site.run_command(&["config", "set", "object", &object.display().to_string()]);
    assert!(set.status.success(), "{}", said(&set));
    look(&mut site, &mut scene, 40..80);
    // 240 images, the rig, the objects, and the objects after the change.
    let whole = recorded(&file, |recording| {
        recording.poses.len() >= 200 && n_inputs(recording) >= 243
    });
    assert!(matches!(whole.ending, Ending::Cut { .. }));
    recorder.process.kill().expect("it runs");
    let _ = recorder.process.wait();
    let killed = SiteRecording::read(&file).expect("it opens");
    assert!(killed.poses.len() >= whole.poses.len());

    let summary = replay(&file, &out);
    let live = &summary["live"];
    assert_eq!(live["different"], 0, "{summary}");
    assert!(
        live["identical"].as_u64().is_some_and(|n| n >= 200),
        "{summary}"
    );
    let notices = summary["notices"].to_string();
    assert!(notices.contains("was not closed"), "{notices}");
    assert!(!notices.contains("differ"), "{notices}");
    assert_eq!(replay(&file, &again), summary);
    let read = |path| std::fs::read(path).expect("the poses are written");
    assert_eq!(read(&out), read(&again));
}

#[test]
fn a_recording_that_begins_late_replays_alike_each_time_and_says_so() {
    let mut scene = scene();
    let mut site = FusedSite::start(&scene.rig, &scene.objects, "");
    look(&mut site, &mut scene, 0..10);
    let file = site.path("site.mcap");
    let mut recorder = Recorder::start(&site, &file);
    look(&mut site, &mut scene, 10..40);
    recorded(&file, |recording| n_inputs(recording) >= 80);
    send(recorder.process.id(), libc::SIGINT);
    let end = recorder.line();
    assert_eq!(
        (&end["event"], &end["dropped"]),
        (&"recorded".into(), &0.into())
    );
    assert!(recorder.process.wait().expect("it ends").success());
    let recording = SiteRecording::read(&file).expect("it opens");
    assert_eq!(recording.ending, Ending::Closed);
    assert_eq!(recording.rejected, 0);

    let [out, again] = ["poses.jsonl", "again.jsonl"].map(|name| site.path(name));
    let summary = replay(&file, &out);
    assert!(
        summary["notices"]
            .to_string()
            .contains("inputs of the fusion node"),
        "{summary}"
    );
    assert_eq!(replay(&file, &again), summary);
    let read = |path| std::fs::read(path).expect("the poses are written");
    assert_eq!(read(&out), read(&again));

    let refused = site.run_command(&["record", &file.display().to_string()]);
    assert_eq!(refused.status.code(), Some(3));
    assert!(
        said(&refused).contains("replace it with --force"),
        "{}",
        said(&refused)
    );
    assert_eq!(SiteRecording::read(&file).expect("it is whole"), recording);
}
