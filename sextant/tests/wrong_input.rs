//! Wrong input, each with its message, its exit code, and nothing half written.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::recording::{Recording, files_below, refused, sextant, stderr};
use std::fs;
use std::path::Path;
use std::process::Output;

/// Changes a file by replacing a text in it.
fn edit(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{text}\nshould contain\n{from}");
    fs::write(path, text.replacen(from, to, 1)).unwrap();
}

/// A replay into a file, which must be refused with code 3 and leave no file behind.
fn replay_is_refused(recording: &Recording, expected: &str) {
    let before = files_below(recording.root());
    let out = recording.path("poses.jsonl").display().to_string();
    let output = recording.replay(recording.root(), &["--out", &out]);
    refused(&output, 3, expected);
    assert!(output.stdout.is_empty());
    assert_eq!(files_below(recording.root()), before);
}

#[test]
fn a_wrong_rig_is_refused() {
    let recording = Recording::new(1);
    let rig = recording.path("rig.toml");
    let good = fs::read_to_string(&rig).unwrap();
    for (from, to, expected) in [
        ("resolution", "resolutoin", "did you mean `resolution`?"),
        ("[[camera]]", "[[camera]", "malformed TOML"),
        (
            "position = [",
            "position = [nan, ",
            "4 elements are too many",
        ),
        ("fx = ", "fx = -", "focal length fx"),
    ] {
        fs::write(&rig, good.replacen(from, to, 1)).unwrap();
        replay_is_refused(&recording, &format!("{}:", rig.display()));
        replay_is_refused(&recording, expected);
    }
    fs::remove_file(&rig).unwrap();
    replay_is_refused(
        &recording,
        "rig.toml: there is no such file or folder; check the path",
    );
}

#[test]
fn a_wrong_object_is_refused() {
    let recording = Recording::new(1);
    let object = recording.path("object.toml");
    let good = fs::read_to_string(&object).unwrap();
    let value_of = |key: &str| {
        let lines = good.lines().filter(|line| line.starts_with(key));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let (ids, sizes) = (value_of("id = "), value_of("size = "));
    // The first id is the object's own.
    for (from, to, expected) in [
        (
            ids[2].as_str(),
            ids[1].as_str(),
            "is there already, on line",
        ),
        (&sizes[0], "size = 0", "tag[0].size: "),
        (&sizes[0], "size = -0.04", "tag[0].size: "),
        (&sizes[0], "size = nan", "tag[0].size: "),
        ("size", "sise", "did you mean `size`?"),
    ] {
        fs::write(&object, good.replacen(from, to, 1)).unwrap();
        replay_is_refused(&recording, expected);
    }
}

#[test]
fn objects_that_share_a_tag_are_refused() {
    let recording = Recording::new(1);
    let twin = recording.path("twin.toml");
    fs::copy(recording.path("object.toml"), &twin).unwrap();
    let own = format!("id = \"{}\"", recording.object);
    edit(&twin, &own, "id = \"twin\"");
    let more = ["--object", twin.to_str().unwrap()];
    let output = recording.replay(recording.root(), &more);
    refused(&output, 3, "and on object twin");
}

#[test]
fn wrong_lists_of_pictures_are_refused() {
    let recording = Recording::new(2);
    let csv = recording.path(recording.camera(0)).join("data.csv");
    let good = fs::read_to_string(&csv).unwrap();
    let [header, first, second] = good.lines().collect::<Vec<_>>()[..] else {
        panic!("{good}")
    };
    for (text, expected) in [
        (
            format!("{header}\n{second}\n{first}\n"),
            "data.csv:3: the timestamp ",
        ),
        (
            format!("{header}\n{second}\n{first}\n"),
            "sort the lines by timestamp",
        ),
        (
            format!("{header}\n{first}\n{first}\n"),
            "is there already, on line 2",
        ),
        (
            format!("{header}\nsoon,a.png\n"),
            "data.csv:2: \"soon\" is no timestamp",
        ),
        (format!("{header}\n1,absent.png\n"), "absent.png is missing"),
    ] {
        fs::write(&csv, text).unwrap();
        replay_is_refused(&recording, expected);
    }
    fs::remove_file(&csv).unwrap();
    replay_is_refused(&recording, "data.csv: there is no such file");
}

/// A PNG of 2x2 pixels with that many bits and colour channels.
fn png(bits: u8, colour: u8) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 2, 2);
    encoder.set_depth(png::BitDepth::from_u8(bits).unwrap());
    encoder.set_color(png::ColorType::from_u8(colour).unwrap());
    let channels = if colour == 2 { 3 } else { 1 };
    let bytes = vec![0; 4 * channels * usize::from(bits) / 8];
    encoder
        .write_header()
        .unwrap()
        .write_image_data(&bytes)
        .unwrap();
    file
}

#[test]
fn wrong_pictures_are_refused() {
    let recording = Recording::new(2);
    let picture = files_below(&recording.path(recording.camera(1)).join("data"))[1].clone();
    let good = fs::read(&picture).unwrap();
    let name = picture.file_name().unwrap().to_str().unwrap();
    for (bytes, expected) in [
        (png(8, 0), "2x2 pixels, but 640x480 are those of camera"),
        (png(16, 0), "2x2 pixels, but 640x480 are those of camera"),
        (png(8, 2), "2x2 pixels, but 640x480 are those of camera"),
        (
            good[..good.len() / 2].to_vec(),
            "the picture is truncated; copy",
        ),
        (
            b"GIF89a".to_vec(),
            "a GIF picture, which is not supported; save",
        ),
    ] {
        fs::write(&picture, bytes).unwrap();
        replay_is_refused(&recording, &format!("{name}: {expected}"));
    }
}

#[test]
fn a_recording_that_does_not_fit_the_rig_is_refused() {
    let recording = Recording::new(1);
    fs::rename(
        recording.path(recording.camera(1)),
        recording.path("stranger"),
    )
    .unwrap();
    replay_is_refused(&recording, "has no camera \"stranger\"; add it there");
}

#[test]
fn a_recording_that_is_none_is_refused() {
    let recording = Recording::without_pictures();
    replay_is_refused(&recording, "no camera's folder in it");
    let output = recording.replay(Path::new("/nowhere"), &[]);
    refused(&output, 3, "/nowhere: there is no such file or folder");
    let output = recording.replay(Path::new("walk.mcap"), &[]);
    refused(&output, 3, "walk.mcap: there is no such file or folder");
    let text = recording.path("text.mcap");
    fs::write(&text, "no recording").unwrap();
    let output = recording.replay(&text, &[]);
    refused(
        &output,
        3,
        "text.mcap: this is not an MCAP file; give a recording",
    );
}

#[test]
fn wrong_detections_are_refused() {
    let recording = Recording::without_pictures();
    let folder = recording.path(recording.camera(0));
    fs::create_dir(&folder).unwrap();
    let corners = "[[1,2],[3,2],[3,4],[1,4]]";
    let line = |t: u64, corners: &str| {
        format!(
            "{{\"t_ns\":{t},\"detections\":[{{\"family\":\"tag36h11\",\"id\":0,\"corners\":{corners}}}]}}\n"
        )
    };
    for (text, expected) in [
        (
            line(1, corners) + &line(1, corners),
            "detections.jsonl:2: the timestamp 1 is there already",
        ),
        (
            line(2, corners) + &line(1, corners),
            "detections.jsonl:2: the timestamp 1 is earlier",
        ),
        (
            line(1, &corners.replacen('1', "NaN", 1)),
            "detections.jsonl:1: ",
        ),
        (line(1, "[[1,2]]"), "detections.jsonl:1: invalid length 1"),
    ] {
        fs::write(folder.join("detections.jsonl"), text).unwrap();
        replay_is_refused(&recording, expected);
    }
}

#[test]
fn a_wrong_picture_does_not_keep_detect_from_the_others() {
    let recording = Recording::new(2);
    let pictures = files_below(&recording.path(recording.camera(0)).join("data"));
    fs::write(&pictures[0], b"no picture").unwrap();
    let run = |images: &[&Path]| -> Output {
        sextant()
            .args(["detect", "--json"])
            .args(images)
            .output()
            .unwrap()
    };
    let output = run(&[&pictures[0], &pictures[1], Path::new("/nowhere.png")]);
    refused(&output, 3, "/nowhere.png: there is no such file");
    assert!(stderr(&output).ends_with("error: 2 of 3 pictures could not be used\n"));
    let lines = String::from_utf8(output.stdout).unwrap();
    assert_eq!(lines.lines().count(), 1);
    assert!(lines.contains(pictures[1].to_str().unwrap()));
}

#[test]
fn unknown_keys_of_nodes_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    for (node, text, expected) in [
        (
            "fusion",
            "site = \"a\"\nrig = \"rig.toml\"\nobjets = []\n",
            "config.toml:3:1: objets: unknown field",
        ),
        (
            "fusion",
            "site = \"a\"\nrig = \"rig.toml\"\nobjets = []\n",
            "did you mean `objects`?",
        ),
        (
            "viewer",
            "site = \"a\"\nlisen = \"127.0.0.1:0\"\n",
            "did you mean `listen`?",
        ),
        (
            "viewer",
            "site = \"a\"\n[network]\nmod = \"client\"\n",
            "config.toml:3:1: network.mod: unknown field",
        ),
        (
            "camera",
            "site = \"a\"\ncamera = \"b\"\nsorce = 1\n",
            "did you mean `source`?",
        ),
        (
            "fusion",
            "site = \"a\"\nrig = \"absent.toml\"\n",
            "absent.toml: there is no such file",
        ),
    ] {
        let config = folder.path().join("config.toml");
        fs::write(&config, text).unwrap();
        let output = sextant()
            .args([node, "--config"])
            .arg(&config)
            .output()
            .unwrap();
        refused(&output, 3, expected);
    }
}

#[test]
fn network_settings_without_code_behind_them_are_refused_by_every_node() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rig.toml"), "").unwrap();
    let nodes = [
        ("fusion", "site = \"a\"\nrig = \"rig.toml\"\n"),
        ("viewer", "site = \"a\"\nlisten = \"127.0.0.1:0\"\n"),
        (
            "camera",
            "site = \"a\"\ncamera = \"b\"\n[source]\nkind = \"images\"\nfolder = \"r\"\n",
        ),
    ];
    let settings = [
        (
            "[network.overrides]\n\"transport/auth/pubkey/public_key_pem\" = \"'a'\"\n",
            "auth_pubkey",
        ),
        (
            "[network]\nmode = \"router\"\nlisten = [\"udp/127.0.0.1:0\"]\n",
            "without zenoh's protocol \"udp\"",
        ),
    ];
    for (node, head) in nodes {
        for (setting, expected) in settings {
            let config = folder.path().join("config.toml");
            fs::write(&config, format!("{head}{setting}")).unwrap();
            let run = |arguments: &[&str]| sextant().args(arguments).arg(&config).output().unwrap();
            refused(&run(&[node, "--config"]), 3, expected);
            let checked = run(&["check"]);
            assert_eq!(checked.status.code(), Some(3), "{}", stderr(&checked));
            let words = stderr(&checked) + &String::from_utf8_lossy(&checked.stdout);
            assert!(words.contains(expected), "{words}");
        }
    }
}

#[test]
fn wrong_usage_has_its_own_code() {
    for arguments in [
        &["detect"][..],
        &["replay", "x"],
        &["detect", "--family", "tag99h1", "a.png"],
        &[
            "detect", "--family", "tag36h11", "--family", "tag36h11", "a.png",
        ],
        &["detect", "--threads", "0", "a.png"],
        &["detect", "--tracking", "--threads", "2", "a.png"],
        &["nonsense"],
    ] {
        let output = sextant().args(arguments).output().unwrap();
        assert_eq!(
            output.status.code(),
            Some(2),
            "{arguments:?}: {}",
            stderr(&output)
        );
    }
}

#[test]
fn a_router_without_options_names_both_ways_to_run_it() {
    let output = sextant().arg("router").output().unwrap();
    refused(&output, 2, "<--config <FILE>|--listen <ENDPOINT>>");
}
