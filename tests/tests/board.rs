//! A camera node on an emulated Cortex-A9 board: its package is installed with dpkg, systemd starts its units, capture
//! reads the driver `vivid` to whose output images of a tagged box are written, and a fusion node on this host, reached
//! over QUIC with certificates on both ends, makes a pose of what it sees. Units come back when killed and after a
//! reboot, capture survives a lost device and a change of the pixel format, and nothing is left after a purge.
//!
//! `cargo xtask board` runs it with what it needs; by itself it is ignored.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_proto::{ObjectPose, Observations, limits};
use sextant_recordings::read_picture;
use sextant_site_files::{read_object, read_rig};
use sextant_site_report::State;
use sextant_zenoh_bus::{Bus, DropRule, Profile, Subscription};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use system_tests::{Board, HOST, LockedSite, RAW_FORMATS, Scene, commands, raw_image, sextant};

/// Emulation is slow, and machines are shared.
const PATIENCE: Duration = Duration::from_secs(300);
const GUIDE: &str = "deploy/README.md";
const UNITS: &str = "sextant-capture@north sextant-detect@north";
const STATE: &str = "/var/lib/sextant";
/// Of memory, for 640x480 images.
const MOST_KB: usize = 6 << 10;
/// How far the pose may be off: one camera, at 0.6 m.
const TOLERANCE_M: f64 = 0.003;

#[test]
#[ignore = "takes minutes and an emulated board: cargo xtask board"]
fn a_board_sees_a_box_through_a_real_driver() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let picture = Picture::simulate(&folder.path().join("scene"));
    let site = Site::start(&picture);
    let payload = folder.path().join("payload");
    picture.write_payload(&payload, &site.locked);
    let mut board = Board::start(&given("IMAGE"), &payload, folder.path());

    install(&mut board);
    site.await_pose(&picture);
    takes_little_memory(&mut board);
    comes_back_after_kill(&mut board, &site);
    survives_a_lost_device(&mut board, &site);
    reads_every_format(&mut board, &site);
    board.reboot();
    site.await_pose(&picture);
    is_removed_and_purged(&mut board);
    runs_where_busybox_is_init(&mut board, &site);
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

/// What both parts hold of their own and share: all that must fit into RAM beside the program, which is read from its
/// file.
fn takes_little_memory(board: &mut Board) {
    let report = board.run("cat $(pgrep -x node-camera | sed 's|.*|/proc/&/smaps_rollup|')");
    let held = report.lines().filter_map(|line| {
        let (what, size) = line.split_once(':')?;
        let counts = matches!(what, "Pss_Anon" | "Pss_Shmem");
        let kilobytes: usize = size.trim().strip_suffix(" kB")?.parse().ok()?;
        counts.then(|| (what.to_owned(), kilobytes))
    });
    let held: Vec<(String, usize)> = held.collect();
    println!("memory of capture and detection, kB: {held:?}");
    assert_eq!(held.len(), 4, "{report}");
    let kilobytes: usize = held.iter().map(|(_, kilobytes)| kilobytes).sum();
    assert!(kilobytes < MOST_KB, "{held:?}");
}

fn comes_back_after_kill(board: &mut Board, site: &Site) {
    for unit in UNITS.split(' ') {
        board.run(&format!("systemctl kill --signal KILL {unit}"));
        board.until(&format!(
            "test $(systemctl show --property NRestarts --value {unit}) -ge 1 && systemctl is-active {unit}"
        ));
        site.await_images();
    }
}

/// Unbinding the driver is what pulling a plug is: open files stay, and everything on them fails. The kernel gives the
/// device its old number again only after the last of them is closed.
fn survives_a_lost_device(board: &mut Board, site: &Site) {
    board.run("systemctl stop vivid && echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind");
    board.run("test ! -e /dev/video0");
    board.until("! ls -l /proc/[0-9]*/fd | grep -q /dev/video");
    board.run("systemctl start vivid");
    site.await_images();
}

/// Capture goes on and follows its file; the camera shows the box in that one format alone. The last one is the first
/// again, as in the file that a person would copy.
fn reads_every_format(board: &mut Board, site: &Site) {
    for format in RAW_FORMATS.iter().chain(&RAW_FORMATS[..1]) {
        board.run(&format!(
            "sed -i 's/^format = .*/format = \"{format}\"/' {STATE}/camera-north.toml"
        ));
        board.run(&format!(
            "echo FORMAT={format} >/etc/vivid && systemctl restart vivid"
        ));
        site.await_images();
    }
    board.run("test $(systemctl show --property NRestarts --value sextant-capture@north) -eq 1");
}

fn is_removed_and_purged(board: &mut Board) {
    board.run("dpkg --remove sextant-camera");
    board.run(&format!("! systemctl is-active {UNITS}"));
    board.run(&format!("test -e {STATE}/camera-north.toml"));
    board.run("dpkg --purge sextant-camera");
    board.run(&format!(
        "test ! -e {STATE} && ! ls /etc/systemd/system/*/sextant-*"
    ));
}

/// In a root with nothing but BusyBox, the C library and the tarball in it, which is read-only when the node starts.
fn runs_where_busybox_is_init(board: &mut Board, site: &Site) {
    for line in [
        "mkdir -p /opt/root/bin /opt/root/lib /opt/root/dev /opt/root/mnt /opt/root/proc \
         /opt/root/run /opt/root/etc/sextant",
        "cp /usr/bin/busybox /opt/root/bin/ && chroot /opt/root /bin/busybox --install -s /bin",
        "cp -L /lib/ld-linux-armhf.so.3 /opt/root/lib/ && cd /lib/arm-linux-gnueabihf && cp -L \
         lib[cm].so.6 lib*.so.[0-2] /opt/root/lib/",
        "echo root:x:0:0::/:/bin/sh >/opt/root/etc/passwd",
        "mount --bind /opt/root /opt/root && mount -t tmpfs none /opt/root/run",
        "for folder in dev mnt proc; do mount --rbind /$folder /opt/root/$folder; done",
    ] {
        board.run(line);
    }
    for line in commands(GUIDE, "sh busybox") {
        let starts = line.ends_with(" start");
        if starts {
            board.run("mount -o remount,bind,ro /opt/root && ! touch /opt/root/written");
        }
        board.run(&format!("chroot /opt/root /bin/sh -c 'cd /mnt; {line}'"));
        if starts {
            site.await_images();
        }
    }
    board.run("! pgrep node-camera");
}

/// The host's side, and a reader of it.
struct Site {
    locked: LockedSite,
    screen: Bus,
}

impl Site {
    fn start(picture: &Picture) -> Self {
        let read = |name: &str| picture.folder.join(name);
        let rig = read_rig(&read("rig.toml")).expect("a rig");
        let object = read_object(&read("cuboid.toml")).expect("an object");
        let locked = LockedSite::start_scene(Profile::Site, Scene::from_models(rig, vec![object]));
        let screen = locked.open("screen");
        Self { locked, screen }
    }

    fn listen(&self, key: &str) -> Subscription {
        let listened = self
            .screen
            .subscribe(key, 64, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES);
        listened.expect("a subscription")
    }

    /// Images that show tags, taken from now on.
    fn await_images(&self) {
        let observations = self.listen(&self.locked.keys.all_observations());
        let deadline = Instant::now() + PATIENCE;
        let mut seen = 0;
        while seen < 5 {
            assert!(Instant::now() < deadline, "no image comes any more");
            let item = observations.recv_timeout(Duration::from_secs(1));
            let image = item.map(|item| item.decode::<Observations>().expect("a message"));
            seen += usize::from(image.is_some_and(|image| !image.tags.is_empty()));
        }
    }

    /// Fusion tracks the box, and where it is.
    fn await_pose(&self, picture: &Picture) {
        let poses = self.listen(&self.locked.keys.all_poses());
        let deadline = Instant::now() + PATIENCE;
        let mut last = None;
        while Instant::now() < deadline {
            let item = poses.recv_timeout(Duration::from_secs(1));
            let Some(pose) = item.map(|item| item.decode::<ObjectPose>().expect("a message"))
            else {
                continue;
            };
            let off = (0..3).map(|axis| (pose.position[axis] - picture.position[axis]).powi(2));
            if pose.state == State::Tracking && off.sum::<f64>().sqrt() < TOLERANCE_M {
                return;
            }
            last = Some(pose);
        }
        panic!(
            "not where it is, {:?}; the last pose: {last:?}",
            picture.position
        );
    }
}

/// A simulated image of a box before a camera at rest, with exact files.
struct Picture {
    folder: PathBuf,
    /// Where the box truly is.
    position: [f64; 3],
}

impl Picture {
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

    /// What the board is given: package, tarball, the node's configuration and keys, and the image that its camera is
    /// to see.
    fn write_payload(&self, folder: &Path, site: &LockedSite) {
        fs::create_dir_all(folder.join("keys")).expect("a folder");
        for what in ["DEB", "TARBALL"] {
            let file = given(what);
            let name = file.file_name().expect("a name");
            fs::copy(&file, folder.join(name)).expect("a file");
        }
        for key in fs::read_dir(site.keys_of("north")).expect("its keys") {
            let key = key.expect("a file");
            fs::copy(key.path(), folder.join("keys").join(key.file_name())).expect("a file");
        }
        let router = site.connect.replace("127.0.0.1", HOST);
        let configuration = format!(
            "site = \"lab\"\ncamera = \"north\"\n[source]\nkind = \"v4l2\"\n\
             device = \"/dev/sextant/cam-platform-vivid_0\"\nresolution = [640, 480]\n\
             format = \"GREY\"\n[network]\nconnect = [\"{router}\"]\n[security]\nprofile = \"site\"\nkeys = \"keys\"\n"
        );
        fs::write(folder.join("camera-north.toml"), configuration).expect("a file");
        let grey = self.grey();
        for format in RAW_FORMATS {
            let raw = raw_image(format, &grey);
            fs::write(folder.join(format!("{format}.raw")), raw).expect("a file");
        }
    }

    /// The first image of the recording.
    fn grey(&self) -> Vec<u8> {
        let images = fs::read_dir(self.folder.join("north/data")).expect("the recording");
        let images = images.map(|entry| entry.expect("a file").path());
        let first = images.min().expect("an image");
        read_picture(&first).expect("an image").pixels
    }
}
