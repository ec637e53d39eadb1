//! A refined calibration is proposed from ordinary use, applied from the command line, and reverted.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_geometry::{Pose, se3};
use sextant_process::now_ns;
use sextant_proto::{Notice, Proposal};
use sextant_site_files::{parse_rig, read_rig};
use sextant_site_model::{Camera, Rig};
use std::path::Path;
use std::process::Output;
use std::time::{Duration, Instant};
use system_tests::{FusedSite, PATIENCE, Scene};

/// Tolerance for poses that were written as text and sent in messages.
const ROUNDING: f64 = 1e-12;

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

/// The rig as measured by hand: each camera is off by millimetres and a third of a degree.
fn measured(rig: &Rig) -> Rig {
    let off = |(index, camera): (usize, &Camera)| {
        let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
        let step = [0.004, -0.003, 0.002 * sign, 0.005 * sign, 0.003, -0.004];
        Camera {
            world_from_camera: camera
                .world_from_camera
                .map(|pose| se3::perturb(&pose, &(step.into()))),
            ..camera.clone()
        }
    };
    Rig::new(rig.cameras().iter().enumerate().map(off).collect()).expect("a rig")
}

fn poses(rig: &Rig) -> Vec<Pose> {
    let cameras = rig.cameras().iter();
    cameras.filter_map(|one| one.world_from_camera).collect()
}

/// Largest difference of camera poses relative to the first camera, m or rad.
fn apart(one: &Rig, other: &Rig) -> f64 {
    let ways = |rig: &Rig| {
        let poses = poses(rig);
        let ways = poses.iter().map(|pose| poses[0].inverse() * pose);
        ways.collect::<Vec<Pose>>()
    };
    let pairs = ways(one).into_iter().zip(ways(other));
    let off = pairs.map(|(one, other)| se3::difference(&one, &other).amax());
    off.fold(0.0, f64::max)
}

fn same(one: &Rig, other: &Rig) -> bool {
    let pairs = poses(one).into_iter().zip(poses(other));
    let mut off = pairs.map(|(one, other)| se3::difference(&one, &other).amax());
    off.all(|off| off < ROUNDING)
}

struct Site {
    fused: FusedSite,
    scene: Scene,
}

impl Site {
    fn command(&self, words: &[&str]) -> Output {
        self.fused.run_command(words)
    }

    fn succeed(&self, words: &[&str]) -> String {
        let output = self.command(words);
        assert!(output.status.success(), "{words:?}: {}", said(&output));
        said(&output)
    }

    fn in_force(&self) -> Rig {
        let text = self.succeed(&["config", "get", "rig"]);
        parse_rig(Path::new("rig.toml"), &text).expect("a rig")
    }

    /// Lets the cameras see the moving object until a refined calibration is proposed.
    fn until_proposed(&mut self) -> Proposal {
        let proposals = self.fused.listen(&self.fused.keys.all_proposals());
        let start_ns = now_ns();
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            let now_ns = now_ns();
            let seconds = (now_ns - start_ns) as f64 * 1e-9;
            for camera in 0..self.scene.rig.cameras().len() {
                let image = self.scene.observe(camera, seconds, now_ns);
                self.fused.publish(&image);
            }
            let item = proposals.recv_timeout(Duration::from_millis(25));
            let proposal = item.map(|item| item.decode::<Proposal>().expect("a proposal"));
            if let Some(proposal) = proposal.filter(|proposal| !proposal.is_empty()) {
                return proposal;
            }
        }
        panic!("nothing is proposed");
    }
}

#[test]
fn a_refined_calibration_is_proposed_applied_kept_and_taken_back() {
    let scene = Scene::new(3, &["cube"]);
    let configured = measured(&scene.rig);
    let fused = FusedSite::start(&configured, &scene.objects, "keep_changes = true");
    let mut site = Site { fused, scene };
    for (words, cause) in [
        (
            &["config", "apply-refinement"][..],
            "no refined calibration is proposed",
        ),
        (&["config", "revert"], "no change is known"),
        (&["config", "revert", "rig"], "no change of the rig"),
        (
            &["config", "revert", "object", "cube"],
            "no change of object cube",
        ),
    ] {
        let output = site.command(words);
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        assert!(said(&output).contains(cause), "{}", said(&output));
    }

    let proposal = site.until_proposed();
    assert!(proposal.n_images >= 8 && proposal.after_px < 0.5 * proposal.before_px);
    site.fused.await_status(|status| {
        let mut notices = status.notices.iter();
        notices.any(|notice| matches!(notice, Notice::RefinementProposed { .. }))
    });
    let shown = site.succeed(&["config", "apply-refinement", "--dry-run", "--json"]);
    let shown: serde_json::Value = serde_json::from_str(&shown).expect("one line of JSON");
    assert!(
        shown["held_back"]["n_images"].as_u64() >= Some(8),
        "{shown}"
    );
    let changes = shown["changes"].as_array().expect("a list");
    let north = changes.iter().find(|one| one["what"] == "camera cam1");
    let by_m = north.and_then(|one| one["by"]["position_m"].as_f64());
    assert!(by_m > Some(0.001), "{shown}");
    assert!(same(&site.in_force(), &configured));

    let applied = site.succeed(&["config", "apply-refinement"]);
    assert!(
        applied.contains("camera cam1: ") && applied.contains(" mm, "),
        "{applied}"
    );
    assert!(
        applied.contains("config/models taken and kept in its files"),
        "{applied}"
    );
    let refined = site.in_force();
    let [before, after] = [&configured, &refined].map(|rig| apart(rig, &site.scene.rig));
    assert!(after < 0.3 * before, "{after} of {before}");
    let file = site.fused.path("rig.toml");
    assert!(same(&read_rig(&file).expect("the file"), &refined));

    site.succeed(&["config", "revert"]);
    assert!(same(&site.in_force(), &configured));
    assert!(same(&read_rig(&file).expect("the file"), &configured));
    site.succeed(&["config", "revert", "rig"]);
    assert!(same(&site.in_force(), &refined));

    let Site { fused, scene } = site;
    let fused = fused.restarted();
    let site = Site { fused, scene };
    let dry = site.succeed(&["config", "revert", "--dry-run"]);
    assert!(dry.contains("camera cam1: "), "{dry}");
    site.succeed(&["config", "revert"]);
    assert!(same(&site.in_force(), &configured));
}
