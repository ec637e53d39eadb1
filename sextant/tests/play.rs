//! `sextant play`: parts of recordings, again and again, with pictures of the recorded images; and files without an
//! end.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::posing_site::{Ended, PATIENCE, cube, pose, tag};
use crate::recording::{refused, sextant};
use serde_json::Value;
use sextant_proto::{Keys, ObjectConfig, ObjectPose, Preview, encode, limits};
use sextant_recordings::compressed_image::RecordedImage;
use sextant_recordings::mcap::RecordingInfo;
use sextant_recordings::mcap::writer::McapWriter;
use sextant_recordings::{GreyImage, grey_png};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{Bus, BusOptions, DropRule, Subscription};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::Instant;

const START_NS: u64 = 1_800_000_000_000_000_000;
const STEP_NS: u64 = 100_000_000;
/// Poses and images of a recording.
const N_STEPS: u64 = 40;

/// A model, then a pose and an image each tenth of a second.
fn recorded() -> Vec<u8> {
    let keys = Keys::new("lab").unwrap();
    let info = RecordingInfo {
        site: "lab".to_owned(),
        version: "0.1.0".to_owned(),
    };
    let object = ObjectConfig {
        id: cube(),
        links: Vec::new(),
        joints: Vec::new(),
        tags: vec![tag()],
        frame_sigma: None,
        scale_sigma: None,
        world_from_object: None,
    };
    let grey = GreyImage {
        width: 32,
        height: 24,
        pixels: vec![90; 32 * 24],
    };
    let png = grey_png(&grey).unwrap();
    let mut writer = McapWriter::begin(Vec::new(), Path::new("site.mcap"), &info).unwrap();
    let mut write = |key: &str, payload: Vec<u8>, at_ns| {
        writer.write_payload(key, &payload, at_ns).unwrap();
        let image = RecordedImage {
            camera: CameraId::new("north").unwrap(),
            capture_ns: at_ns,
            png: png.clone(),
        };
        writer.write_image(&image, at_ns).unwrap();
    };
    write(
        &keys.config_object(&cube()),
        encode(&object).unwrap(),
        START_NS,
    );
    for step in 0..N_STEPS {
        let payload = encode(&pose(step)).unwrap();
        write(&keys.pose(&cube()), payload, START_NS + step * STEP_NS);
    }
    writer.finish().unwrap()
}

/// A program that plays, and a client of its site.
struct Played {
    program: Ended,
    lines: BufReader<std::process::ChildStdout>,
    bus: Bus,
    keys: Keys,
}

impl Played {
    fn start(file: &Path, arguments: &[&str]) -> Self {
        let mut command = sextant();
        command.arg("play").arg(file).args(arguments);
        command.args(["--json", "--no-browser", "--port", "0"]);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap());
        let program = Ended::new(child);
        let playing = line(&mut lines);
        assert_eq!(playing["event"], "playing");
        let endpoint = playing["connect"].as_str().unwrap();
        Self {
            program,
            lines,
            bus: Bus::open(&BusOptions::client_of(endpoint)).unwrap(),
            keys: Keys::new("lab").unwrap(),
        }
    }

    fn subscribe(&self, key: &str) -> Subscription {
        let most = limits::MAX_PAYLOAD_BYTES;
        self.bus
            .subscribe(key, 1000, DropRule::Oldest, most)
            .unwrap()
    }
}

fn line(lines: &mut impl BufRead) -> Value {
    let mut line = String::new();
    lines.read_line(&mut line).unwrap();
    serde_json::from_str(&line).unwrap()
}

#[test]
fn a_part_of_a_recording_is_repeated_with_its_images() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("site.mcap");
    fs::write(&file, recorded()).unwrap();
    let arguments = ["--from", "2", "--repeat", "--speed", "4"];
    let mut played = Played::start(&file, &arguments);
    let poses = played.subscribe(&played.keys.pose(&cube()));
    let north = CameraId::new("north").unwrap();
    let previews = played.subscribe(&played.keys.preview(&north));
    let deadline = Instant::now() + PATIENCE;
    let mut sequences: Vec<u64> = Vec::new();
    while sequences.is_sorted() {
        assert!(Instant::now() < deadline, "it does not begin again");
        let item = poses.recv_timeout(PATIENCE).unwrap();
        sequences.push(item.decode::<ObjectPose>().unwrap().sequence);
    }
    assert_eq!(sequences.iter().min(), Some(&20), "{sequences:?}");
    let preview = previews.recv_timeout(PATIENCE).unwrap();
    let preview: Preview = preview.decode().unwrap();
    assert_eq!((preview.camera, preview.resolution), (north, [32, 24]));
    let step = (preview.capture_ns - START_NS) / STEP_NS;
    assert!((20..N_STEPS).contains(&step), "{step}");
    assert!(preview.jpeg.starts_with(&[0xff, 0xd8]));
    // The model stands before the part that is played.
    let key = played.keys.config_object(&cube());
    let kept = played.bus.latest(&key, limits::MAX_PAYLOAD_BYTES, PATIENCE);
    assert_eq!(kept.unwrap().len(), 1);
    for _ in 0..2 {
        let end = line(&mut played.lines);
        assert_eq!(
            (&end["event"], &end["skipped"]),
            (&"played".into(), &0.into())
        );
    }
    played.bus.close();
    drop(played.program);
}

fn play(file: &Path, arguments: &[&str]) -> Output {
    let mut command = sextant();
    command.arg("play").arg(file).args(arguments);
    command.args(["--no-browser", "--port", "0"]);
    command.output().unwrap()
}

#[test]
fn what_cannot_be_played_is_refused_with_its_cause() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("site.mcap");
    let whole = recorded();
    fs::write(&file, &whole).unwrap();
    let output = play(&file, &["--from", "60"]);
    refused(
        &output,
        3,
        "the recording ends after 3.9 s; give a smaller --from",
    );
    fs::write(&file, &whole[..300]).unwrap();
    let expected =
        "the file ends after 300 bytes, before its first whole message; copy or save it again";
    refused(&play(&file, &[]), 3, expected);
    let replay = sextant().arg("replay").arg(&file).output().unwrap();
    refused(
        &replay,
        3,
        "the recording was not closed: its last 186 bytes are incomplete and not used",
    );
}
