//! `sextant doctor` and the faults that users have, each prepared with real files and processes: the finding names the
//! cause, and what to do.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use serde_json::Value;
use sextant_proto::{CameraControls, CameraStatus, ClockQuality, NodeId, NodeKind, encode};
use sextant_zenoh_bus::Qos;
use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Output;
use system_tests::{FusedSite, Scene, free_port, keys, sextant};

/// A finding with its verdict that has these words, and its remedy these.
fn names(output: &Output, about: &str, verdict: &str, words: &str, remedy: &str) {
    let text = String::from_utf8_lossy(&output.stdout);
    let findings: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let has = |finding: &Value, key: &str, part: &str| {
        finding[key]
            .as_str()
            .is_some_and(|text| text.contains(part))
    };
    let is_named = findings.iter().any(|finding| {
        finding["about"] == about
            && finding["verdict"] == verdict
            && has(finding, "words", words)
            && has(finding, "remedy", remedy)
    });
    assert!(is_named, "{about}, {verdict}: {words}; {remedy}\n{text}");
}

/// Without a site: nobody listens on port 1.
fn doctor(arguments: &[&str], files: &[&Path]) -> Output {
    let mut command = sextant();
    command
        .args(["doctor", "--json", "--connect", "tcp/127.0.0.1:1"])
        .args(arguments)
        .args(files);
    command.output().expect("sextant runs")
}

/// A folder of files.
struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let file = self.0.path().join(name);
        fs::write(&file, text).expect("a file");
        file
    }
}

const VIDEO: &str =
    "source = { kind = \"v4l2\", device = \"/dev/video-none\", resolution = [640, 480] }\n";

#[test]
fn a_router_out_of_reach() {
    let output = doctor(&[], &[]);
    names(
        &output,
        "router",
        "warning",
        "no router answers at tcp/127.0.0.1:1",
        "firewall",
    );
}

#[test]
fn a_key_in_a_file_that_is_misspelt() {
    let file = Files::new();
    let camera = file.write("camera.toml", "site = \"a\"\ncamera = \"b\"\nsorce = 1\n");
    let output = doctor(&[], &[&camera]);
    names(&output, "file", "fault", "did you mean `source`?", "mend");
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn a_camera_that_is_not_there() {
    let files = Files::new();
    let text = format!("site = \"a\"\ncamera = \"b\"\n{VIDEO}");
    let camera = files.write("camera.toml", &text);
    let output = doctor(&[], &[&camera]);
    names(
        &output,
        "source",
        "fault",
        "/dev/video-none",
        "sextant camera --probe",
    );
}

#[test]
fn a_port_that_another_program_holds() {
    let files = Files::new();
    let holder = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = holder.local_addr().expect("an address").port();
    let text = format!("site = \"a\"\nlisten = \"127.0.0.1:{port}\"\n");
    // It takes the connection and says nothing of a bridge.
    let answers = std::thread::spawn(move || drop(holder.accept()));
    let viewer = files.write("viewer.toml", &text);
    let output = doctor(&[], &[&viewer]);
    answers.join().expect("the holder ends");
    names(
        &output,
        "page",
        "fault",
        &format!("port {port} is in use"),
        "viewer.toml",
    );
}

#[test]
fn a_folder_that_cannot_be_written() {
    let files = Files::new();
    let text = format!(
        "site = \"a\"\nlisten = \"127.0.0.1:{}\"\nfolder = \"/proc/sextant\"\n",
        free_port()
    );
    let viewer = files.write("viewer.toml", &text);
    let output = doctor(&[], &[&viewer]);
    names(
        &output,
        "folder",
        "fault",
        "/proc/sextant can't be written",
        "another folder",
    );
}

#[test]
fn a_folder_of_shared_memory_that_others_may_write() {
    let files = Files::new();
    let shared = files.0.path().join("sextant");
    fs::create_dir(&shared).expect("a folder");
    fs::set_permissions(&shared, fs::Permissions::from_mode(0o777)).expect("permissions");
    let mut command = sextant();
    command
        .args(["doctor", "--json", "--connect", "tcp/127.0.0.1:1"])
        .env("XDG_RUNTIME_DIR", files.0.path());
    let output = command.output().expect("sextant runs");
    names(
        &output,
        "folder",
        "fault",
        "sextant",
        "remove what another user left",
    );
}

#[test]
fn keys_of_another_role() {
    let files = Files::new();
    let authority = files.0.path().join("authority");
    for arguments in [
        &["init", "--site", "lab"][..],
        &["add", "b", "--role", "viewer"],
    ] {
        assert!(keys(arguments, &authority).status.success());
    }
    let text = format!(
        "site = \"lab\"\ncamera = \"b\"\n{VIDEO}[network]\nconnect = [\"quic/127.0.0.1:1\"]\n\
         [security]\nprofile = \"site\"\nkeys = \"authority/b\"\n"
    );
    let camera = files.write("camera.toml", &text);
    names(&doctor(&[], &[&camera]), "file", "fault", "viewer", "mend");
    // And keys of another site on the command line.
    let other = authority.join("b");
    let output = doctor(
        &["--site", "other", "--keys", other.to_str().expect("a path")],
        &[],
    );
    names(&output, "keys", "fault", "lab", "sextant keys");
}

#[test]
fn two_objects_with_one_tag() {
    let scene = Scene::new(2, &["box", "cup"]);
    let files = Files::new();
    let file = |name: &str| files.0.path().join(name);
    sextant_site_files::write_object(&file("box.toml"), &scene.objects[0]).expect("a file");
    let text = fs::read_to_string(file("box.toml")).expect("a file");
    let cup = files.write("cup.toml", &text.replace("\"box\"", "\"cup\""));
    let output = doctor(&[], &[&file("box.toml"), &cup]);
    names(&output, "files", "fault", "cup", "mend one of them");
}

#[test]
fn a_site_of_another_name() {
    let scene = Scene::new(2, &["box"]);
    let site = FusedSite::start(&scene.rig, &scene.objects, "");
    let mut command = sextant();
    command.args([
        "doctor",
        "--json",
        "--site",
        "lap",
        "--connect",
        &site.connect,
    ]);
    let output = command.output().expect("sextant runs");
    names(
        &output,
        "site",
        "fault",
        "no fusion node on site lap, but on lab",
        "--site",
    );
}

#[test]
fn what_the_network_shows() {
    let mut scene = Scene::new(2, &["box"]);
    let mut site = FusedSite::start(&scene.rig, &scene.objects, "");
    let _held = prepare_faults(&mut site, &mut scene);

    let text = format!("site = \"lab\"\ncamera = \"desk\"\n{VIDEO}");
    let file = site.path("desk.toml");
    fs::write(&file, text).expect("a file");
    let output = site.run_command(&["doctor", "--json", file.to_str().expect("a path")]);
    names(
        &output,
        "rig",
        "fault",
        "camera attic runs, but the rig",
        "add it to the rig file",
    );
    names(
        &output,
        "name",
        "fault",
        "camera node desk runs on other-host",
        "another name",
    );
    names(
        &output,
        "version",
        "warning",
        "runs 0.0.9",
        "install one version",
    );
    names(
        &output,
        "version",
        "fault",
        "another version of the contract",
        "install one version",
    );
    names(
        &output,
        "tags",
        "warning",
        "tags of no object",
        "sextant echo camera/",
    );
    names(
        &output,
        "camera",
        "warning",
        "is not running",
        "start its node",
    );
}

/// Prepares a fault of each kind on the network. Some last as long as the returned values.
fn prepare_faults(site: &mut FusedSite, scene: &mut Scene) -> impl Sized + use<> {
    let cameras: Vec<_> = scene
        .rig
        .cameras()
        .iter()
        .map(|camera| camera.id.clone())
        .collect();
    // A camera that the rig lacks.
    let attic_id = NodeId::new("attic").expect("an id");
    let attic = site
        .bus
        .alive(&site.keys.alive(NodeKind::Camera, &attic_id))
        .expect("a token");
    // A name that another machine holds.
    let held = site
        .keys
        .holder(NodeKind::Camera, &NodeId::new("desk").expect("an id"));
    let held_name = site
        .bus
        .hold_name(&held, "other-host", &|| false)
        .expect("a name");
    // A status of another version of the program.
    let status = CameraStatus {
        camera: cameras[0].clone(),
        version: "0.0.9".to_owned(),
        host: "board".to_owned(),
        captured: 1,
        detected: 1,
        dropped: 0,
        rate_hz: 1.0,
        detect_ms: [1.0; 2],
        clock: ClockQuality::default(),
        uptime_s: 1,
        published: 1,
        fallbacks: 0,
        brightness: 0.0,
        controls: CameraControls::default(),
        notices: Vec::new(),
    };
    let kept = site
        .bus
        .raw_latest(&site.keys.camera_status(&cameras[0]), Qos::Config);
    let kept = kept.expect("a publisher");
    kept.put(&encode(&status).expect("a message"))
        .expect("the network takes it");
    // A message of another version of the contract.
    let start_ns = sextant_process::now_ns();
    let mut foreign = encode(&scene.observe(0, 0.0, start_ns)).expect("a message");
    foreign[1] += 1;
    let key = site.keys.observations(&cameras[0]);
    let publisher = site
        .bus
        .raw_publisher(&key, Qos::Config)
        .expect("a publisher");
    publisher.put(&foreign).expect("the network takes it");
    // A tag of no object.
    let mut stray = scene.observe(0, 0.0, start_ns);
    stray.tags[0].id = 77;
    site.publish(&stray);
    site.await_status(|status| {
        let first = &status.cameras[0];
        first.rejected.foreign_version > 0 && first.unknown_tags > 0
    });
    (attic, held_name, kept)
}
