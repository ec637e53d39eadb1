//! A day of use: the memory of the estimator does not grow.

use super::*;
use sextant_estimator::{Fusion, FusionOptions, Input, Output};
use sextant_proto::{decode, encode};
use sextant_site_model::ImageObservation;
use sextant_site_report::ObjectEstimate;

const ROW: &str = "24 h of 8 cameras in simulated time, objects coming and going";
const N_CAMERAS: usize = 8;
const RATE_HZ: u64 = 1;
const HOUR_S: u64 = 3600;
/// An object is away for the last third of each of its rounds, which differ.
const ROUNDS_S: [u64; 3] = [90, 210, 330];

fn is_here(object: usize, seconds: u64) -> bool {
    let round_s = ROUNDS_S[object];
    seconds % round_s < round_s * 2 / 3
}

/// Whether it has been here, or away, for a while.
fn is_settled(object: usize, seconds: u64) -> bool {
    let state = |s: u64| is_here(object, s);
    (seconds.saturating_sub(10)..=seconds).all(|s| state(s) == state(seconds))
}

/// Resident memory of this process, MiB, and its open files.
fn resources() -> (f64, usize) {
    let text = std::fs::read_to_string("/proc/self/statm").expect("Linux");
    let pages = text.split_whitespace().nth(1).and_then(|n| n.parse().ok());
    let pages: f64 = pages.expect("a number");
    let files = std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count);
    (pages * 4096.0 / 1048576.0, files)
}

/// The machine, and what was counted of its poses.
struct Day {
    scene: Scene,
    machine: Fusion,
    start_ns: u64,
    /// Newest tracked pose of each object, simulated seconds.
    tracked_s: [f64; 3],
    /// Longest time without a tracked pose of an object that was seen, s.
    longest_gap_s: f64,
    wrong: usize,
}

impl Day {
    fn new() -> Self {
        let scene = Scene::new(N_CAMERAS, &["box", "cube", "die"]);
        let options = FusionOptions::default();
        let machine = Fusion::new(scene.rig.clone(), scene.objects.clone(), options);
        Self {
            scene,
            machine: machine.expect("models"),
            start_ns: 1_800_000_000_000_000_000,
            tracked_s: [0.0; 3],
            longest_gap_s: 0.0,
            wrong: 0,
        }
    }

    /// An image of each camera in turn, as messages that a network would carry.
    fn pass(&mut self, from_s: u64, to_s: u64) {
        let a_second = RATE_HZ * N_CAMERAS as u64;
        for turn in from_s * a_second..to_s * a_second {
            let at_ns = self.start_ns + turn * (1_000_000_000 / a_second);
            self.image((turn % N_CAMERAS as u64) as usize, at_ns);
        }
    }

    fn image(&mut self, camera: usize, at_ns: u64) {
        let seconds = (at_ns - self.start_ns) as f64 * 1e-9;
        let objects = self.scene.objects.clone();
        let here = objects.iter().enumerate();
        let here: Vec<_> = here
            .filter(|(k, _)| is_here(*k, seconds as u64))
            .map(|(k, object)| (object, system_tests::place(k, seconds)))
            .collect();
        let seen = self.scene.see(camera, &here, at_ns);
        let message = decode(&encode(&seen).expect("a message")).expect("the same");
        let now_ns = at_ns + 5_000_000;
        let image = Input::Image(ImageObservation::from(&message));
        self.machine.handle(now_ns, image);
        while let Some(output) = self.machine.poll_output() {
            let Output::Pose(pose) = output else {
                panic!("{output:?}");
            };
            let numbers = pose.covariance.iter().chain(&pose.twist);
            assert!(numbers.copied().all(f64::is_finite), "{pose:?}");
            self.judge(&pose, seconds);
        }
        for k in 0..objects.len() {
            self.note_gap(k, seconds);
        }
    }

    fn judge(&mut self, pose: &ObjectEstimate, seconds: f64) {
        let k = self
            .scene
            .objects
            .iter()
            .position(|one| *one.id() == pose.object);
        let k = k.expect("an object of the scene");
        if pose.state != State::Tracking {
            return;
        }
        self.tracked_s[k] = seconds;
        let at_s = (pose.capture_ns as f64 - self.start_ns as f64) * 1e-9;
        let truth = system_tests::place(k, at_s).translation.vector;
        let error_m = (truth - pose.world_from_object.translation.vector).norm();
        self.wrong += usize::from(error_m > 0.02);
    }

    /// Not counted while the object is away, or has just come.
    fn note_gap(&mut self, object: usize, seconds: f64) {
        let whole = seconds as u64;
        if is_here(object, whole) && is_settled(object, whole) {
            let gap_s = seconds - self.tracked_s[object];
            self.longest_gap_s = self.longest_gap_s.max(gap_s);
        }
    }
}

#[test]
fn a_day_of_use_leaves_memory_flat_and_objects_tracked() {
    let mut day = Day::new();
    // Everything that learns has learnt something, and rings are full.
    let (first_s, end_s) = if is_full() {
        (HOUR_S, 24 * HOUR_S)
    } else {
        (300, 900)
    };
    let begun = Instant::now();
    day.pass(0, first_s);
    let (memory_mib, files) = resources();
    let mut most_mib = memory_mib;
    for from_s in (first_s..end_s).step_by(60) {
        day.pass(from_s, (from_s + 60).min(end_s));
        most_mib = most_mib.max(resources().0);
    }
    let speed = end_s as f64 / begun.elapsed().as_secs_f64();
    println!("{end_s} s, {speed:.0} times as fast as they pass; {memory_mib:.1} MiB");
    for (what, value, unit, at_most) in [
        (
            "growth of memory after the first hour",
            most_mib - memory_mib,
            "MiB",
            4.0,
        ),
        (
            "open files more",
            resources().1.abs_diff(files) as f64,
            "",
            0.0,
        ),
        ("poses tracked and wrong", day.wrong as f64, "", 0.0),
        (
            "longest gap of what is seen",
            day.longest_gap_s * 1e3,
            "ms",
            1000.0,
        ),
    ] {
        Figure {
            row: ROW,
            what,
            value,
            unit,
            at_most,
        }
        .keep();
    }
    assert_eq!(day.wrong, 0);
}
