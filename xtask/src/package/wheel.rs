//! Wheels with the Python client and the command line in them, for 64-bit processors: `pip install sextant` gives both.
//!
//! That of this machine's processor is installed into a system that has nothing but Debian's Python, where a site runs and is recorded; the others' programs start under
//! qemu.

use super::contents::SEXTANT;
use super::target::{TARGETS, Target};
use super::{output, symbols};
use crate::python::{self, PIP};
use crate::tools::{copy, root, run};
use std::env::consts::ARCH;
use std::fs;
use std::path::{Path, PathBuf};

/// Debian's release of the clean system.
const RELEASE: &str = "bookworm";
/// Run in name spaces of its own, with the clean system's root: installs what is in its folder `wheels` and tries it.
const TRIAL: &str = "mount -t proc proc \"$1/proc\"
mount -t tmpfs tmpfs \"$1/dev/shm\"
exec chroot \"$1\" env -i PATH=/venv/bin:/usr/bin:/bin sh -ec 'python3 -m venv /venv
pip --quiet install --no-index --find-links /wheels sextant
exec python /wheels/installed.py'";

/// All wheels, in `target/package/wheels`.
pub fn wheels() -> Result<(), String> {
    let python = python::environment(&root().join("target/python/venv"))?;
    // This machine's first: that wheel is tried most.
    let (own, others): (Vec<_>, Vec<_>) = TARGETS
        .iter()
        .filter(|target| ["aarch64", "x86_64"].contains(&target.name))
        .partition(|target| target.name == ARCH);
    for target in own.into_iter().chain(others) {
        let program = target.build(&SEXTANT)?;
        symbols::check(&program, target.glibc)?;
        let wheel = pack(&python, target, &program)?;
        if target.name == ARCH {
            try_in_clean_system(&python, &wheel)?;
        } else {
            start_under_qemu(target, &program)?;
        }
    }
    Ok(())
}

fn pack(python: &str, target: &Target, program: &Path) -> Result<PathBuf, String> {
    let [major, minor] = target.glibc;
    let platform = format!("manylinux_{major}_{minor}_{}", target.name);
    let program = program.display().to_string();
    let variables = [
        ("SEXTANT_WHEEL_PROGRAM", program.as_str()),
        ("SEXTANT_WHEEL_PLATFORM", platform.as_str()),
    ];
    let folder = output()?.join("wheels").join(target.name);
    python::wheel(python, &folder, &platform, &variables)
}

fn start_under_qemu(target: &Target, program: &Path) -> Result<(), String> {
    let libraries = format!("/usr/{}", target.triple.replace("-unknown", ""));
    let program = program.display().to_string();
    let qemu = format!("qemu-{}", target.name);
    run(&qemu, &["-L", &libraries, &program, "--version"])
}

fn try_in_clean_system(python: &str, wheel: &Path) -> Result<(), String> {
    let system = output()?.join("clean-system");
    if !system.exists() {
        make_system(&system)?;
    }
    let wheels = system.join("wheels");
    for former in [&wheels, &system.join("venv")] {
        if former.exists() {
            fs::remove_dir_all(former).map_err(|cause| format!("{}: {cause}", former.display()))?;
        }
    }
    // The wheel, and what it depends on.
    let (wheel, folder) = (wheel.display().to_string(), wheels.display().to_string());
    let download = ["download", "--only-binary", ":all:", "--dest", &folder];
    run(python, &[PIP, &download, &[&wheel]].concat())?;
    copy(
        &root().join("clients/python/tests/installed.py"),
        &wheels,
        0o644,
    )?;
    let system = system.display().to_string();
    let name_spaces = ["--mount", "--pid", "--fork", "--kill-child"];
    run(
        "unshare",
        &[&name_spaces[..], &["sh", "-ec", TRIAL, "sh", &system]].concat(),
    )
}

fn make_system(system: &Path) -> Result<(), String> {
    let fresh = system.with_extension("fresh");
    if fresh.exists() {
        fs::remove_dir_all(&fresh).map_err(|cause| format!("{}: {cause}", fresh.display()))?;
    }
    let place = fresh.display().to_string();
    let contents = ["--quiet", "--variant=essential", "--include=python3-venv"];
    let source = [
        "--aptopt=APT::Install-Recommends \"false\"",
        RELEASE,
        &place,
    ];
    run("mmdebstrap", &[&contents[..], &source].concat())?;
    fs::rename(&fresh, system).map_err(|cause| format!("{}: {cause}", system.display()))
}
