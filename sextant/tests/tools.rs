//! The small commands: `config`, `check`, and those that need a site where there is none.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{Recording, refused, sextant, stdout};
use serde_json::Value;
use sextant_recordings::read_picture;
use std::fs;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::Path;
use std::process::Stdio;

const KINDS: [&str; 5] = ["rig", "object", "camera", "fusion", "viewer"];

#[test]
fn what_config_prints_passes_check() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for kind in KINDS {
        let text = stdout(&sextant().args(["config", kind]).output().unwrap());
        let file = folder.path().join(format!("{kind}.toml"));
        fs::write(&file, text).unwrap();
        files.push(file);
    }
    let output = sextant().arg("check").args(&files).output().unwrap();
    let said = stdout(&output);
    assert_eq!(said.lines().count(), KINDS.len());
    for (line, kind) in said.lines().zip(KINDS) {
        assert!(line.contains(&format!(": {kind}, ")), "{line}");
    }
}

#[test]
fn check_sees_what_does_not_go_together() {
    let recording = Recording::new(2);
    let check = |more: &[&str]| {
        let mut command = sextant();
        command.arg("check").arg(recording.path("rig.toml"));
        command
            .arg(recording.path("object.toml"))
            .arg(recording.root());
        command.args(more).output().unwrap()
    };
    let said = stdout(&check(&[]));
    assert!(said.contains("4 images of 2 cameras"), "{said}");
    let rig = recording.path("rig.toml");
    let text = fs::read_to_string(&rig).unwrap();
    let [width, height] = recording.scenario.cameras[0].resolution;
    let other = text.replacen(&format!("[{width}, {height}]"), "[320, 240]", 1);
    fs::write(&rig, other.replace(recording.camera(1), "elsewhere")).unwrap();
    let output = check(&["--json"]);
    refused(&output, 3, "things are wrong");
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("says 320x240 of camera"), "{said}");
    assert!(
        said.contains(&format!("has no camera \\\"{}\\\"", recording.camera(1))),
        "{said}"
    );
}

#[test]
fn a_file_of_no_known_kind_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.toml");
    fs::write(&file, "a = 1\n").unwrap();
    let output = sextant().arg("check").arg(&file).output().unwrap();
    refused(&output, 3, "state what it shall be with --kind");
}

#[test]
fn without_a_router_the_site_is_out_of_reach() {
    // A port that was free a moment ago and that nobody listens on.
    let port = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    for command in ["list", "echo", "hz", "top"] {
        let endpoint = format!("tcp/127.0.0.1:{port}");
        let output = sextant()
            .args([command, "--connect", &endpoint])
            .output()
            .unwrap();
        refused(
            &output,
            4,
            &format!("no router answers at {endpoint}; start a site"),
        );
    }
}

#[test]
fn doctor_finds_wrong_files_and_says_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = folder.path().join("camera.toml");
    fs::write(&wrong, "site = \"a\"\ncamera = \"b\"\nsorce = 1\n").unwrap();
    let mut command = sextant();
    // Nobody listens on the port that is nobody's.
    command.args(["doctor", "--json", "--connect", "tcp/127.0.0.1:1"]);
    let output = command.arg(&wrong).output().unwrap();
    refused(&output, 1, "must be mended before a site runs");
    let said = String::from_utf8(output.stdout).unwrap();
    let findings: Vec<Value> = said
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let of = |about: &str| findings.iter().find(|finding| finding["about"] == about);
    let file = of("file").unwrap();
    assert_eq!(file["verdict"], "fault");
    assert!(
        file["words"]
            .as_str()
            .unwrap()
            .contains("did you mean `source`?"),
        "{file}"
    );
    assert_eq!(of("router").unwrap()["verdict"], "warning");
    for about in ["version", "clock", "shared memory", "folder"] {
        assert!(of(about).is_some(), "{about}: {said}");
    }
}

#[test]
fn a_reader_that_goes_away_ends_the_program_quietly() {
    let recording = Recording::new(2);
    let mut child = sextant()
        .args(["detect", "--json", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let picture =
        crate::recording::files_below(&recording.path(recording.camera(0)).join("data"))[0].clone();
    let line = format!("{}\n", picture.display());
    let mut input = child.stdin.take().unwrap();
    let feeder = std::thread::spawn(move || {
        // More than any pipe holds; ends when nobody reads any more.
        while std::io::Write::write_all(&mut input, line.as_bytes()).is_ok() {}
    });
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    let mut first = String::new();
    reader.read_line(&mut first).unwrap();
    assert!(first.starts_with("{\"file\""));
    drop(reader);
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap();
    assert_eq!((output.status.code(), output.stderr), (Some(0), vec![]));
}

#[test]
fn explain_draws_every_stage() {
    let recording = Recording::new(1);
    let picture =
        crate::recording::files_below(&recording.path(recording.camera(0)).join("data"))[0].clone();
    let out = recording.path("made/for/it");
    let explain = |picture: &Path, out: &Path| {
        let mut command = sextant();
        command.args(["detect", "--json", "--explain"]).arg(picture);
        command.arg("--out").arg(out).output().unwrap()
    };
    let said: Value = serde_json::from_str(&stdout(&explain(&picture, &out))).unwrap();
    for name in [
        "1-threshold-black.png",
        "2-components-black.png",
        "3-quads.png",
        "4-rejected.png",
        "5-corners.png",
        "6-tags.png",
    ] {
        read_picture(&out.join(name)).unwrap();
    }
    let report: Value =
        serde_json::from_str(&fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
    let tags = said["detections"].as_array().unwrap();
    assert!(!tags.is_empty());
    assert_eq!(report["detections"], said["detections"]);
    assert_eq!(report["counts"]["detections"], tags.len());
    let stages = report["stages"].as_array().unwrap();
    assert_eq!((stages.len(), &stages[0]["stage"]), (6, &"tiles".into()));
    let quads = report["counts"]["quads"].as_u64().unwrap();
    assert!(quads >= tags.len() as u64);

    let nowhere = recording.path("not-made");
    refused(
        &explain(&recording.path("rig.toml"), &nowhere),
        3,
        "no picture that is known",
    );
    refused(
        &explain(&recording.path("absent.png"), &nowhere),
        3,
        "no such file",
    );
    assert!(!nowhere.exists());
    refused(
        &explain(&picture, &picture),
        3,
        "no folder can be made there",
    );
    let without_out = sextant()
        .args(["detect", "--explain"])
        .arg(&picture)
        .output();
    refused(&without_out.unwrap(), 2, "--out");
}

#[test]
fn completions_know_every_command() {
    for shell in ["bash", "zsh", "fish"] {
        let script = stdout(&sextant().args(["completions", shell]).output().unwrap());
        for command in ["replay", "osc", "mavlink", "doctor"] {
            assert!(script.contains(command), "{shell}: {command}");
        }
    }
    refused(
        &sextant().args(["completions", "cmd"]).output().unwrap(),
        2,
        "possible values",
    );
}

#[test]
fn the_help_tells_the_exit_codes() {
    let said = stdout(&sextant().arg("--help").output().unwrap());
    for code in ["  2    wrong usage", "  3    a file", "  4    a port"] {
        assert!(said.contains(code), "{said}");
    }
}
