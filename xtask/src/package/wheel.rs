//! Wheels with the Python client and the command line in them, for 64-bit processors: `pip install sextant` gives both.
//!
//! Each is installed into a clean system of its processor.

use super::clean_system::CleanSystem;
use super::contents::SEXTANT;
use super::target::{TARGETS, Target};
use super::{fresh_folder, output, symbols};
use crate::python::{self, PIP};
use crate::tools::{copy, root, run};
use std::fs;
use std::path::{Path, PathBuf};

/// That of the clean systems.
const PYTHON: &str = "3.11";
const SCRIPT: &str = "wheel.sh";

/// All wheels, in `target/package/wheels`.
pub fn wheels() -> Result<(), String> {
    let python = python::environment(&root().join("target/python/venv"))?;
    // For systems that have no other: the client without the command line.
    let folder = output()?.join("wheels/any");
    python::wheel(&python, &folder, "any", &[])?;
    for target in TARGETS
        .iter()
        .filter(|target| ["aarch64", "x86_64"].contains(&target.name))
    {
        let program = target.build(&SEXTANT)?;
        symbols::check(&program, target.glibc)?;
        let wheel = pack(&python, target, &program)?;
        try_in_clean_system(&python, target, &wheel)?;
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

/// Where the system has nothing but Debian's Python, a site runs and is recorded.
fn try_in_clean_system(python: &str, target: &Target, wheel: &Path) -> Result<(), String> {
    let system = CleanSystem::new(target.architecture.unwrap_or_default(), "python3-venv")?;
    let folder = fresh_folder("trial")?;
    // The wheel, and what it depends on.
    let (wheel, place) = (wheel.display().to_string(), folder.display().to_string());
    // Pip knows of each name of a platform just those wheels that have it.
    let platforms = ["2014", "_2_17", "_2_28", "_2_34"]
        .map(|glibc| format!("--platform=manylinux{glibc}_{}", target.name));
    let what = ["download", "--only-binary", ":all:"];
    let platforms = platforms.each_ref().map(String::as_str);
    let interpreter = ["--python-version", PYTHON, "--dest", &place, &wheel];
    run(python, &[PIP, &what, &platforms, &interpreter].concat())?;
    let installed = root().join("clients/python/tests/installed.py");
    copy(&installed, &folder, 0o644)?;
    let script = folder.join(SCRIPT);
    fs::write(&script, include_str!("wheel.sh"))
        .map_err(|cause| format!("{}: {cause}", script.display()))?;
    system.run(&folder, SCRIPT, &[])
}
