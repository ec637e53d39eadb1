//! The chores themselves: each a short list of commands.

use crate::page_types;
use crate::tools::{Zigbuild, files_below, run, run_in, run_with};
use std::path::Path;

pub const PAGE: &str = "node-viewer-bridge/page";
const ARMV7: &str = "armv7-unknown-linux-gnueabihf";
const NEON: &str = "thumbv7neon-unknown-linux-gnueabihf";
const AARCH64: &str = "aarch64-unknown-linux-gnu";

pub fn fmt() -> Result<(), String> {
    run("cargo", &["fmt", "--all", "--check"])
}

/// What the checker finds is on standard error, a line each.
pub fn tidy() -> Result<(), String> {
    run("cargo", &["run", "--quiet", "--package", "sextant-tidy"])
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
    let doc = ["doc", "--release", "--workspace", "--no-deps", "--quiet"];
    run_with(&[("RUSTDOCFLAGS", "-D warnings")], "cargo", &doc)
}

pub fn page() -> Result<(), String> {
    page_types::MESSAGES.check()?;
    page_packages()?;
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
        &format!("run `npm run build` in {PAGE} and commit dist/"),
    )
}

/// The packages that the page's lock file names: what builds it, and what drives a browser.
pub fn page_packages() -> Result<(), String> {
    let install = ["ci", "--no-audit", "--no-fund", "--loglevel=error"];
    run_in(PAGE, "npm", &install)
}

/// The committed bundle is what people run; it must be what the sources make.
pub fn same_files(committed: &Path, fresh: &Path, remedy: &str) -> Result<(), String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let (committed, fresh) = (root.join(committed), root.join(fresh));
    let (old, new) = (files_below(&committed)?, files_below(&fresh)?);
    if old == new {
        return Ok(());
    }
    Err(format!(
        "{} differs from a fresh build: {remedy}",
        committed.display()
    ))
}

/// For the boards' 32-bit processor what widths of numbers and vectors can change; the detector's kernels for the
/// 64-bit one, of which compilers make other vectors. How well corners are found is arithmetic that no processor does
/// otherwise, and takes minutes to emulate.
pub fn arm() -> Result<(), String> {
    let crates = ["sextant-geometry", "sextant-tag-families", "sextant-proto"];
    let chosen: Vec<&str> = crates.iter().flat_map(|name| ["--package", name]).collect();
    let tests = ["test", "--release", "--quiet", "--target"];
    run("cargo", &[&tests, &[ARMV7][..], chosen.as_slice()].concat())?;
    let kernels = ["--package", "sextant-apriltag", "--lib"];
    let whole = [
        "any_bytes",
        "changed_pictures",
        "no_allocation",
        "processors",
    ];
    let whole: Vec<&str> = whole.iter().flat_map(|name| ["--test", name]).collect();
    let detector = [&tests, &[ARMV7][..], &kernels, &whole].concat();
    run("cargo", &detector)?;
    let same = ["--package", "sextant-apriltag", "--test", "processors"];
    run("cargo", &[&tests, &[NEON][..], &same].concat())?;
    let same = ["--test", "processors"];
    run("cargo", &[&tests, &[AARCH64][..], &kernels, &same].concat())
}

/// For the 64-bit boards; the 32-bit one's package is built and run by `cargo xtask board`.
pub fn cross() -> Result<(), String> {
    let check = ["check", "--release", "--quiet", "--package", "node-camera"];
    run("cargo", &[&check[..], &["--target", AARCH64]].concat())
}

/// Nothing is linked. zig is the C compiler of the few dependencies that have C in them: ring, and psm below pest.
pub fn elsewhere(targets: &[&str]) -> Result<(), String> {
    let zigbuild = Zigbuild::installed()?;
    let compiler = [("CARGO_ZIGBUILD_ZIG_PATH", &*zigbuild.compiler)];
    let check = [
        "check",
        "--release",
        "--quiet",
        "--package",
        "sextant-client",
    ];
    let targets = targets.iter().flat_map(|target| ["--target", target]);
    let check: Vec<&str> = check.into_iter().chain(targets).collect();
    run_with(&compiler, &zigbuild.program, &check)
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
