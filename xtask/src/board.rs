//! The emulated Cortex-A9 board: its image is made of Debian's packages once and kept in the user's cache, where a
//! fresh checkout finds it, then `tests/tests/board.rs` runs on it.
//!
//! The package for it is built and checked in any case; where qemu, Debian's packages or time are missing, the rest is
//! passed over with a word.

use crate::install;
use crate::package::{self, BoardFiles};
use crate::tools::{self, cache, command, root, run, run_with, wait};
use sextant_test_needs::{CPIO, KMOD, MKE2FS, MMDEBSTRAP, Need, QEMU_SYSTEM_ARM, note_skip};
use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::{Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// All of the chore.
const LIMIT: Duration = Duration::from_secs(25 * 60);
/// Less than this is not worth beginning with.
const SHORTEST: Duration = Duration::from_secs(6 * 60);
pub const NEEDS: &[&Need] = &[&QEMU_SYSTEM_ARM, &MMDEBSTRAP, &KMOD, &CPIO, &MKE2FS];
/// A release without its updates, so that the image changes with the release's own points only.
const RELEASE: &str = "bookworm";
const PACKAGES: &str =
    "systemd-sysv,udev,kmod,linux-image-armmp,v4l-utils,busybox-static,iproute2,procps";

/// Builds the camera node's package, tries it, and runs it on the board.
pub fn board() -> Result<(), String> {
    let started = Instant::now();
    let program = test_program()?;
    let files = package::camera_for_board()?;
    match image()? {
        Ok(image) => match LIMIT.checked_sub(started.elapsed()) {
            Some(left) if left > SHORTEST => test(&program, &image, &files, left),
            _ => {
                pass_over("no time is left after making what it needs; it is kept for the next run")
            }
        },
        Err(why) => pass_over(&why),
    }
}

fn pass_over(why: &str) -> Result<(), String> {
    note_skip("the emulated board", why);
    Ok(())
}

/// Builds the test and what it runs. It is started without cargo, whose lock other chores may hold meanwhile.
fn test_program() -> Result<PathBuf, String> {
    let binary = ["build", "--release", "--workspace", "--bin", "sextant"];
    run("cargo", &binary)?;
    let mut build = command("cargo");
    build.args(["test", "--release", "--workspace", "--test", "board"]);
    let built = build.args(["--no-run", "--color", "never"]).output();
    let built = built.map_err(|cause| format!("cargo: {cause}"))?;
    let words = String::from_utf8_lossy(&built.stderr);
    let path = words
        .rsplit_once("(")
        .and_then(|(_, rest)| rest.split_once(")"));
    match path {
        Some((path, _)) if built.status.success() => Ok(root().join(path)),
        _ => Err(format!("cargo test --no-run: {words}")),
    }
}

fn test(program: &Path, image: &Path, files: &BoardFiles, left: Duration) -> Result<(), String> {
    let given = [
        ("IMAGE", image),
        ("DEB", &files.deb),
        ("TARBALL", &files.tarball),
    ];
    let given = given.map(|(what, path)| (format!("SEXTANT_BOARD_{what}"), path));
    let left = left.as_secs().to_string();
    let program = program.display().to_string();
    let limit = ["--kill-after=20", &left, &program];
    let how = ["--ignored", "--nocapture"];
    let mut test = command("timeout");
    test.envs(given).args(limit).args(how);
    wait(test.current_dir(root().join("tests")))
}

/// The folder with the board's files, or why there is none.
fn image() -> Result<Result<PathBuf, String>, String> {
    let folder = cache()?.join(format!("board-{:016x}", key()?));
    if folder.is_dir() {
        return Ok(Ok(folder));
    }
    let unmet = install::provide(NEEDS);
    if let Some(lack) = unmet.first() {
        return Ok(Err(lack.clone()));
    }
    make(&folder)
}

fn make(folder: &Path) -> Result<Result<PathBuf, String>, String> {
    println!("xtask board: making {}", folder.display());
    let fresh = folder.with_extension("fresh");
    let failed = |cause: io::Error| format!("{}: {cause}", fresh.display());
    if fresh.exists() {
        fs::remove_dir_all(&fresh).map_err(failed)?;
    }
    fs::create_dir_all(&fresh).map_err(failed)?;
    let made = unpack(&fresh);
    // The hook's first deed: until then nothing but the network and Debian's archive had a part in it.
    if made.is_err() && !fresh.join("unpacked").exists() {
        return Ok(Err("Debian's packages cannot be had".to_owned()));
    }
    made?;
    fs::rename(&fresh, folder).map_err(failed)?;
    Ok(Ok(folder.to_owned()))
}

fn unpack(fresh: &Path) -> Result<(), String> {
    let place = fresh.display().to_string();
    let hook = root().join("tests/board/make-image.sh");
    let hook = format!("--extract-hook={}", hook.display());
    let without = ["doc", "man", "locale"]
        .map(|folder| format!("--dpkgopt=path-exclude=/usr/share/{folder}/*"));
    let without = without.each_ref().map(String::as_str);
    let what = [
        "--quiet",
        "--arch=armhf",
        "--variant=extract",
        "--format=null",
    ];
    let packages = [
        "--components=main",
        "--include=?essential",
        "--include",
        PACKAGES,
    ];
    let hooks = [
        "--aptopt=APT::Install-Recommends \"false\"",
        "--setup-hook=sed -i /security/d\\;/updates/d \"$1/etc/apt/sources.list\"",
        "--hook-dir=/usr/share/mmdebstrap/hooks/merged-usr",
        &hook,
        RELEASE,
    ];
    let arguments = [&what[..], &packages, &without, &hooks].concat();
    run_with(&[("BOARD", &place)], "mmdebstrap", &arguments)
}

/// Of all that the image is made of but Debian's own.
fn key() -> Result<u64, String> {
    let mut hasher = DefaultHasher::new();
    (RELEASE, PACKAGES).hash(&mut hasher);
    tools::files_below(&root().join("tests/board"))?.hash(&mut hasher);
    Ok(hasher.finish())
}
