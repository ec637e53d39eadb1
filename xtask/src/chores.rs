//! The chores themselves: each a short list of commands.

use crate::tools::{run, run_in};
use std::fs;
use std::path::Path;

const PAGE: &str = "node-viewer-bridge/page";
const ARMV7: &str = "armv7-unknown-linux-gnueabihf";
const AARCH64: &str = "aarch64-unknown-linux-gnu";

pub fn fmt() -> Result<(), String> {
    run("cargo", &["fmt", "--all", "--check"])
}

pub fn lint() -> Result<(), String> {
    run(
        "cargo",
        &[
            "clippy",
            "--release",
            "--workspace",
            "--all-targets",
            "--quiet",
            "--",
            "-D",
            "warnings",
        ],
    )
}

pub fn docs() -> Result<(), String> {
    run(
        "env",
        &[
            "RUSTDOCFLAGS=-D warnings",
            "cargo",
            "doc",
            "--release",
            "--workspace",
            "--no-deps",
            "--quiet",
        ],
    )
}

pub fn page() -> Result<(), String> {
    run_in(
        PAGE,
        "npm",
        &["ci", "--no-audit", "--no-fund", "--loglevel=error"],
    )?;
    run_in(PAGE, "npm", &["run", "--silent", "check"])?;
    run_in(PAGE, "npm", &["run", "--silent", "test"])?;
    run_in(
        PAGE,
        "npm",
        &[
            "run",
            "--silent",
            "build",
            "--",
            "--outDir",
            "../../target/page",
        ],
    )?;
    same_files(
        Path::new(PAGE).join("dist").as_path(),
        Path::new("target/page"),
    )
}

/// The committed bundle is what people run; it must be what the sources make.
fn same_files(committed: &Path, fresh: &Path) -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let (committed, fresh) = (root.join(committed), root.join(fresh));
    let (old, new) = (files_below(&committed)?, files_below(&fresh)?);
    if old == new {
        return Ok(());
    }
    Err(format!(
        "{} differs from a fresh build: run `npm run build` in {PAGE} and commit dist/",
        committed.display()
    ))
}

fn files_below(folder: &Path) -> Result<Vec<(String, Vec<u8>)>, String> {
    let failed = |cause: std::io::Error| format!("{}: {cause}", folder.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if path.is_dir() {
            found.extend(
                files_below(&path)?
                    .into_iter()
                    .map(|(below, bytes)| (format!("{name}/{below}"), bytes)),
            );
        } else {
            found.push((name, fs::read(&path).map_err(failed)?));
        }
    }
    found.sort();
    Ok(found)
}

pub fn workspace() -> Result<(), String> {
    // The browser test drives the page with the packages that the page's lock file names.
    if !Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .join(PAGE)
        .join("node_modules")
        .is_dir()
    {
        run_in(
            PAGE,
            "npm",
            &["ci", "--no-audit", "--no-fund", "--loglevel=error"],
        )?;
    }
    run("cargo", &["test", "--release", "--workspace", "--quiet"])
}

/// For the boards' 32-bit processor what widths of numbers and vectors can change; the detector's kernels for the 64-bit one, of
/// which compilers make other vectors. How well corners are found is arithmetic that no processor does otherwise, and takes minutes to emulate.
pub fn arm() -> Result<(), String> {
    let crates = ["sextant-geometry", "sextant-tag-families", "sextant-proto"];
    let chosen: Vec<&str> = crates.iter().flat_map(|name| ["--package", name]).collect();
    let tests = ["test", "--release", "--quiet", "--target"];
    run("cargo", &[&tests, &[ARMV7][..], chosen.as_slice()].concat())?;
    let kernels = ["--package", "sextant-apriltag", "--lib"];
    let whole = ["any_bytes", "changed_pictures", "no_allocation"];
    let whole: Vec<&str> = whole.iter().flat_map(|name| ["--test", name]).collect();
    let detector = [&tests, &[ARMV7][..], &kernels, &whole].concat();
    run("cargo", &detector)?;
    run("cargo", &[&tests, &[AARCH64][..], &kernels].concat())
}

pub fn cross() -> Result<(), String> {
    [AARCH64, ARMV7].iter().try_for_each(|target| {
        run(
            "cargo",
            &[
                "check",
                "--release",
                "--quiet",
                "--package",
                "node-camera",
                "--target",
                target,
            ],
        )
    })
}

pub fn bench() -> Result<(), String> {
    run(
        "cargo",
        &[
            "bench",
            "--package",
            "sextant-benches",
            "--features",
            "peer",
            "--bench",
            "detector",
        ],
    )
}
