//! The page's wizards in a real browser, against the simulator: a lens, then the rig, then an object, each from the
//! form to a result in force on the running site and kept in files.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_proto::{Keys, encode};
use sextant_site_files::{former_of, read_object, read_rig, write_rig};
use sextant_site_model::{Camera, CameraId, ObjectModel, ObjectTag, Rig};
use sextant_test_needs as needs;
use sextant_zenoh_bus::{Bus, BusOptions, Qos, RawPublisher};
use std::fs;
use std::net::TcpListener;
use std::path::Path;
use std::process::Child;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;
use system_tests::{
    BOARD, FIRST_OF_CUBE, FusedSite, Workshop, changed, run_page_checks, send, sextant,
};

/// Simulated time goes so much faster: a step of the scene, and what it takes here.
const STEP_S: f64 = 1.0 / 12.0;
const PACE: Duration = Duration::from_millis(8);

/// Cameras and objects before anything is calibrated: usual lenses, wrong places but for the first, no tag placed.
fn before(truth: &Workshop) -> (Rig, ObjectModel) {
    let usual = Intrinsics {
        fx: 560.0,
        fy: 560.0,
        cx: 319.5,
        cy: 239.5,
    };
    let rig = truth.rig();
    let cameras = rig.cameras().iter().enumerate().map(|(at, camera)| Camera {
        lens: match camera.id.as_str() {
            "middle" => Lens::pinhole(usual).expect("a lens"),
            _ => camera.lens,
        },
        world_from_camera: match at {
            0 => camera.world_from_camera,
            _ => Some(Pose::identity()),
        },
        ..camera.clone()
    });
    let cube = truth.cube();
    let tags = cube.tags().iter().map(|tag| ObjectTag {
        object_from_tag: None,
        ..tag.clone()
    });
    (
        Rig::new(cameras.collect()).expect("a rig"),
        changed("cube", tags.collect()),
    )
}

/// The cameras of the workshop, on the network until dropped.
struct Cameras {
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Cameras {
    fn start(connect: &str) -> Self {
        let bus = Bus::open(&BusOptions::client_of(connect)).expect("the router answers");
        let (stop, stopped) = channel::<()>();
        let run = move || {
            let mut workshop = Workshop::default();
            let publishers = publishers(&bus, &workshop.rig());
            let mut step = 0_u64;
            while stopped.recv_timeout(PACE) == Err(RecvTimeoutError::Timeout) {
                let now_ns = sextant_process::now_ns();
                let images = workshop.observe(step as f64 * STEP_S, step, now_ns);
                for (publisher, image) in publishers.iter().zip(&images) {
                    let payload = encode(image).expect("a message");
                    publisher.put(&payload).expect("the network takes it");
                }
                step += 1;
            }
            bus.close();
        };
        Self {
            stop: Some(stop),
            thread: Some(std::thread::spawn(run)),
        }
    }
}

impl Drop for Cameras {
    fn drop(&mut self) {
        drop(self.stop.take());
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn publishers(bus: &Bus, rig: &Rig) -> Vec<RawPublisher> {
    let keys = Keys::new("lab").expect("an id");
    let open =
        |camera: &Camera| bus.raw_publisher(&keys.observations(&camera.id), Qos::Observation);
    let opened = rig.cameras().iter().map(open);
    opened.collect::<Result<_, _>>().expect("publishers")
}

/// A viewer bridge that keeps results in its folder. Dropping it ends it.
struct Viewer {
    child: Child,
    url: String,
}

impl Viewer {
    fn start(folder: &Path, connect: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let listen = listener.local_addr().expect("an address");
        drop(listener);
        let text = format!(
            "site = \"lab\"\nlisten = \"{listen}\"\nfolder = \".\"\n[network]\nconnect = [\"{connect}\"]\n"
        );
        fs::write(folder.join("viewer.toml"), text).expect("the folder can be written");
        let mut command = sextant();
        command
            .args(["viewer", "--config"])
            .arg(folder.join("viewer.toml"));
        Self {
            child: command.spawn().expect("sextant starts"),
            url: format!("http://{listen}"),
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        send(self.child.id(), libc::SIGTERM);
        let _ = self.child.wait();
    }
}

fn position_error_mm(found: Option<Pose>, truth: Option<Pose>) -> f64 {
    let (found, truth) = (found.expect("a pose"), truth.expect("a pose"));
    1e3 * (found.translation.vector - truth.translation.vector).norm()
}

/// The cameras stand where they do, and the lens is what it is.
fn check_rig(file: &Path, truth: &Rig) {
    let found = read_rig(file).expect("a rig file");
    for (camera, truly) in found.cameras().iter().zip(truth.cameras()) {
        let off = position_error_mm(camera.world_from_camera, truly.world_from_camera);
        assert!(off < 2.0, "camera {} is {off:.2} mm off", camera.id);
    }
    let middle = CameraId::new("middle").expect("an id");
    let [found, truly] =
        [&found, truth].map(|rig| rig.camera(&middle).expect("a camera").lens.intrinsics().fx);
    assert!(
        (found / truly - 1.0).abs() < 2e-3,
        "fx {found:.2} instead of {truly:.2}"
    );
}

/// The tags sit as far from one another as they do.
fn check_object(file: &Path, truth: &ObjectModel) {
    let found = read_object(file).expect("an object file");
    let place = |object: &ObjectModel, at: usize| {
        object.tags()[at]
            .object_from_tag
            .expect("a place")
            .translation
            .vector
    };
    for at in 1..truth.tags().len() {
        let [found, truly] =
            [&found, truth].map(|object| (place(object, at) - place(object, 0)).norm());
        assert!(
            (found - truly).abs() < 5e-4,
            "{at}: {found} instead of {truly}"
        );
    }
}

#[test]
fn a_lens_a_rig_and_an_object_are_calibrated_from_the_page() {
    if needs::WIZARDS.is_skipped() {
        return;
    }
    let truth = Workshop::default();
    let (rig, cube) = before(&truth);
    let site = FusedSite::start(&rig, &[cube], "keep_changes = true");
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_rig(&folder.path().join("rig.toml"), &rig).expect("the folder can be written");
    let viewer = Viewer::start(folder.path(), &site.connect);
    let cameras = Cameras::start(&site.connect);
    let board = format!(
        "{},{},{},{}",
        BOARD.columns,
        BOARD.rows,
        BOARD.size_m * 1e3,
        BOARD.first
    );
    let tags = format!("{FIRST_OF_CUBE}-{}", FIRST_OF_CUBE + 5);
    run_page_checks(
        "wizards.mjs",
        &[
            &viewer.url,
            "--lens",
            "middle",
            "--board",
            &board,
            "--carried",
            "cube",
            "--learn",
            "cube",
            "--tags",
            &tags,
            "--size",
            "48",
        ],
    );
    drop((cameras, viewer));
    // Kept by the bridge, in force on the fusion node, and kept by that too.
    for rig_file in [folder.path().join("rig.toml"), site.path("rig.toml")] {
        check_rig(&rig_file, &truth.rig());
        assert!(former_of(&rig_file).exists(), "{}", rig_file.display());
    }
    for object_file in [
        folder.path().join("objects/cube.toml"),
        site.path("cube.toml"),
    ] {
        check_object(&object_file, &truth.cube());
    }
}
