//! A camera node on an emulated Cortex-A9 board: its package is installed with dpkg, systemd starts its units, capture reads the driver `vivid`
//! to whose output an image of a tagged box is written, a fusion node on this host makes a pose of what it sees, and units come back when killed.
//!
//! `cargo xtask board` runs it with what it needs; by itself it is ignored. It has not been seen to pass. What is known to work, each step by hand: the
//! board boots and takes commands, reaches this host over TCP, and `vivid` takes the image. Installing the package and all that follows is not known to.
//! Not covered: other pixel formats than GREY, a lost device, a reboot, removal on the board, the tarball for BusyBox, encryption.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_estimator::State;
use sextant_proto::{ObjectPose, Observations};
use sextant_recordings::read_grey_png;
use sextant_site_files::{read_object, read_rig};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use system_tests::{Board, FusedSite, commands, sextant};

/// Emulation is slow, and machines are shared.
const PATIENCE: Duration = Duration::from_secs(300);
const GUIDE: &str = "deploy/README.md";
const UNITS: &str = "sextant-capture@north sextant-detect@north";
/// How far the pose may be off: one camera, at 0.6 m.
const TOLERANCE_M: f64 = 0.003;

#[test]
#[ignore = "takes minutes and an emulated board: cargo xtask board"]
fn a_board_sees_a_box_through_a_real_driver() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = Scene::simulate(&folder.path().join("scene"));
    let site = scene.site();
    let payload = folder.path().join("payload");
    scene.write_payload(&payload, &site.connect);
    let mut board = Board::start(&given("IMAGE"), &payload, folder.path());

    install(&mut board);
    scene.await_pose(&site);
    comes_back_after_kill(&mut board, &site);
}

/// The path that `cargo xtask board` gives.
fn given(what: &str) -> PathBuf {
    let name = format!("SEXTANT_BOARD_{what}");
    let path = std::env::var_os(&name).unwrap_or_else(|| panic!("{name}: run cargo xtask board"));
    PathBuf::from(path)
}

fn install(board: &mut Board) {
    board.run("systemctl enable --now vivid");
    for line in commands(GUIDE, "sh board") {
        board.run(&format!("cd /mnt; {line}"));
    }
}

fn comes_back_after_kill(board: &mut Board, site: &FusedSite) {
    for unit in UNITS.split(' ') {
        board.run(&format!("systemctl kill --signal KILL {unit}"));
        board.until(&format!(
            "test $(systemctl show --property NRestarts --value {unit}) -ge 1 && systemctl is-active {unit}"
        ));
        await_images(site);
    }
}

/// Images that were taken from now on.
fn await_images(site: &FusedSite) {
    let observations = site.listen(&site.keys.all_observations());
    let deadline = Instant::now() + PATIENCE;
    let mut seen = 0;
    while seen < 5 {
        assert!(Instant::now() < deadline, "no image comes any more");
        let item = observations.recv_timeout(Duration::from_secs(1));
        let image = item.map(|item| item.decode::<Observations>().expect("a message"));
        seen += usize::from(image.is_some_and(|image| !image.tags.is_empty()));
    }
}

/// A box before a camera at rest, with exact files.
struct Scene {
    folder: PathBuf,
    /// Where the box truly is.
    position: [f64; 3],
}

impl Scene {
    fn simulate(folder: &Path) -> Self {
        let simulate = ["simulate", "--exact", "--cameras", "1", "--objects", "1"];
        let status = sextant()
            .args(simulate)
            .args(["--seconds", "0.1", "--out"])
            .arg(folder)
            .status()
            .expect("sextant runs");
        assert!(status.success(), "sextant simulate: {status}");
        let path = fs::read_to_string(folder.join("cuboid.tum")).expect("the true path");
        let first = path.split_whitespace().skip(1).take(3);
        let numbers: Vec<f64> = first.map(|word| word.parse().expect("a number")).collect();
        Self {
            folder: folder.to_owned(),
            position: numbers.try_into().expect("a position"),
        }
    }

    fn site(&self) -> FusedSite {
        let rig = read_rig(&self.folder.join("rig.toml")).expect("a rig");
        let object = read_object(&self.folder.join("cuboid.toml")).expect("an object");
        FusedSite::start(&rig, &[object], "")
    }

    /// What the board is given: package, the node's configuration and the image that its camera is to see.
    fn write_payload(&self, folder: &Path, router: &str) {
        fs::create_dir(folder).expect("a folder");
        let deb = given("DEB");
        let name = deb.file_name().expect("a package's name");
        fs::copy(&deb, folder.join(name)).expect("a file");
        let router = router.replace("127.0.0.1", "10.0.2.2");
        let configuration = format!(
            "site = \"lab\"\ncamera = \"north\"\n[source]\nkind = \"v4l2\"\ndevice = \"/dev/sextant/cam-platform-vivid_0\"\nresolution = [640, 480]\nformat = \"GREY\"\n[network]\nconnect = [\"{router}\"]\n"
        );
        fs::write(folder.join("camera-north.toml"), configuration).expect("a file");
        let pictures = fs::read_dir(self.folder.join("north/data")).expect("the recording");
        let mut pictures: Vec<_> = pictures
            .map(|entry| entry.expect("a file").path())
            .collect();
        pictures.sort();
        let picture = read_grey_png(&pictures[0]).expect("a picture");
        fs::write(folder.join("GREY.raw"), &picture.pixels).expect("a file");
    }

    /// Fusion tracks the box, and where it is.
    fn await_pose(&self, site: &FusedSite) {
        let poses = site.listen(&site.keys.all_poses());
        let deadline = Instant::now() + PATIENCE;
        let mut last = None;
        while Instant::now() < deadline {
            let item = poses.recv_timeout(Duration::from_secs(1));
            let Some(pose) = item.map(|item| item.decode::<ObjectPose>().expect("a message"))
            else {
                continue;
            };
            let off = (0..3).map(|axis| (pose.position[axis] - self.position[axis]).powi(2));
            if pose.state == State::Tracking && off.sum::<f64>().sqrt() < TOLERANCE_M {
                return;
            }
            last = Some(pose);
        }
        panic!(
            "not where it is, {:?}; the last pose: {last:?}",
            self.position
        );
    }
}
