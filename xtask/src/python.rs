//! The Python client: its module of messages, made from the contract, and its tests against a running demo.

mod generate;

use crate::generated::Generated;
use crate::tools::{root, run, run_in, run_with};
use sextant_test_needs::note_skip;
use std::fs;
use std::path::{Path, PathBuf};

const PACKAGE: &str = "clients/python";
const MESSAGES: Generated = Generated {
    file: "clients/python/src/sextant/_messages.py",
    chore: "python",
    make: generate::module,
};
/// Pip as a module of an interpreter.
pub const PIP: &[&str] = &["-m", "pip", "--quiet", "--disable-pip-version-check"];
/// Packages of other people that read what Sextant writes, where there are wheels for this machine's Python; their
/// tests are skipped without them.
const ORACLES: [&str; 5] = [
    "pygltflib>=1.16",
    "pylsl>=1.16",
    "robotpy-apriltag>=2025",
    "trimesh>=4",
    "usd-core>=24.11",
];
/// Virtual environment and wheel of the tests.
const SCRATCH: &str = "target/python";

/// Writes the module of messages from `proto/CONTRACT.md`.
pub fn generate() -> Result<(), String> {
    MESSAGES.write()
}

/// The committed module is what the contract makes; the wheel installs; types, tests, guide and notebook hold, against
/// a demo of the `sextant` of this build.
pub fn test() -> Result<(), String> {
    MESSAGES.check()?;
    let scratch = root().join(SCRATCH);
    let python = environment(&scratch.join("venv"))?;
    let wheel = wheel(&python, &scratch.join("wheels"), "any", &[])?;
    let wheel = wheel.display().to_string();
    let tested = format!("{wheel}[test]");
    run(&python, &[PIP, &["install", &tested]].concat())?;
    // The same version may have been installed before, with other content.
    let again = ["install", "--force-reinstall", "--no-deps", &wheel];
    run(&python, &[PIP, &again].concat())?;
    for oracle in ORACLES {
        if run(&python, &[PIP, &["install", oracle]].concat()).is_err() {
            note_skip(oracle, "there is none for this Python");
        }
    }
    run_in(PACKAGE, &python, &["-m", "mypy"])?;
    run(
        "cargo",
        &[
            "build",
            "--release",
            "--workspace",
            "--quiet",
            "--bin",
            "sextant",
        ],
    )?;
    let binary = root().join("target/release/sextant").display().to_string();
    let package = root().join(PACKAGE).display().to_string();
    let pytest = ["-m", "pytest", "--rootdir", &package, &package];
    run_with(&[("SEXTANT_BINARY", &binary)], &python, &pytest)
}

/// The package's wheel for a platform, in a folder that is emptied first; `variables` are for `hatch_build.py`.
pub fn wheel(
    python: &str,
    folder: &Path,
    platform: &str,
    variables: &[(&str, &str)],
) -> Result<PathBuf, String> {
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(|cause| format!("{}: {cause}", folder.display()))?;
    }
    let place = folder.display().to_string();
    let build = ["wheel", "--no-deps", "--wheel-dir", &place, PACKAGE];
    run_with(variables, python, &[PIP, &build].concat())?;
    let version = env!("CARGO_PKG_VERSION");
    let wheel = folder.join(format!("sextant-{version}-py3-none-{platform}.whl"));
    if wheel.is_file() {
        return Ok(wheel);
    }
    Err(format!(
        "{} was not built: {PACKAGE}/pyproject.toml has another version than the workspace",
        wheel.display()
    ))
}

/// The package's source for `pip`, into a folder.
pub fn source_package(python: &str, folder: &Path) -> Result<(), String> {
    run(python, &[PIP, &["install", "hatchling>=1.25"]].concat())?;
    let build = ["-m", "hatchling", "build", "--target", "sdist"];
    let place = folder.display().to_string();
    run_in(
        PACKAGE,
        python,
        &[&build[..], &["--directory", &place]].concat(),
    )
}

/// The interpreter of a virtual environment, made where it is missing.
pub fn environment(folder: &Path) -> Result<String, String> {
    let python = folder.join("bin/python").display().to_string();
    let has_pip = || run(&python, &["-c", "import pip"]).is_ok();
    if Path::new(&python).exists() && has_pip() {
        return Ok(python);
    }
    let target = folder.display().to_string();
    run("python3", &["-m", "venv", "--clear", &target])?;
    Ok(python)
}
