//! A file system that is full: what is refused costs nothing of what was there.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use sextant_test_needs::FORMER_VERSIONS;
use std::process::Command;
use system_tests::sextant;

/// Five versions of a rig, a full disk, more refused changes than versions are kept.
const SCRIPT: &str = r#"
mount -t tmpfs -o size=256k tmpfs "$1" && cd "$1" || exit 9
lens() {
    printf 'image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [%s.0, 0.0, 320.0, 0.0, 600.0, 240.0, 0.0, 0.0, 1.0]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [0.0, 0.0, 0.0, 0.0, 0.0]}\n' "$1" > lens.yaml
}
for focal in 600 601 602 603 604; do lens $focal; "$2" convert lens.yaml --camera north --out rig.toml || exit 8; done
lens 700
head -c 1000000 /dev/zero > full 2> /dev/null
for try in 1 2 3 4 5 6 7 8 9 10 11; do "$2" convert lens.yaml --camera north --out rig.toml && exit 7; done
grep -h -o 'fx = 60[0-9]' rig.toml rig.toml.former rig.toml.former.2 rig.toml.former.3 rig.toml.former.4
ls -A
"#;

#[test]
fn refused_changes_on_a_full_disk_cost_no_former_version() {
    if FORMER_VERSIONS.is_skipped() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let program = sextant();
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", SCRIPT, "sh"])
        .arg(folder.path())
        .arg(program.get_program())
        .output()
        .expect("unshare runs: it comes with util-linux");
    let words = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    let focal: Vec<&str> = words
        .lines()
        .filter(|line| line.starts_with("fx"))
        .collect();
    let expected = ["fx = 604", "fx = 603", "fx = 602", "fx = 601", "fx = 600"];
    assert_eq!(focal, expected, "{words}");
    assert!(!words.contains(".tmp"), "{words}");
}
