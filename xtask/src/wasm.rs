//! The detector for browsers: the package of `clients/web`, from Rust and TypeScript. What it makes is committed, so
//! that the page and its users need no compiler, and is the same on every machine.

use crate::chores::{PAGE, page_packages, same_files};
use crate::tools::{root, run, run_with};
use std::fs;
use std::path::{Path, PathBuf};

pub const TARGET: &str = "wasm32-unknown-unknown";
const PACKAGE: &str = "clients/web";
/// Every browser since 2023 has these vectors.
const FEATURES: &str = "-Ctarget-feature=+simd128";

/// Writes the package's files.
pub fn wasm() -> Result<(), String> {
    build(&root().join(PACKAGE).join("dist"))
}

/// The committed files are what the sources make.
pub fn web() -> Result<(), String> {
    let fresh = root().join("target/web");
    build(&fresh)?;
    let committed = Path::new(PACKAGE).join("dist");
    same_files(
        &committed,
        Path::new("target/web"),
        "run `cargo xtask wasm` and commit it",
    )
}

fn build(folder: &Path) -> Result<(), String> {
    // Debian's packages of a browser are not needed for it, those of the page are: its compiler of TypeScript.
    if !root().join(PAGE).join("node_modules").is_dir() {
        page_packages()?;
    }
    let flags = [FEATURES.to_owned()].into_iter().chain(remapped()?);
    let flags: Vec<String> = flags.collect();
    let build = [
        "build",
        "--profile=web",
        "--package=sextant-web",
        "--target",
        TARGET,
        "--target-dir=target/wasm",
        "--quiet",
        "--locked",
    ];
    let flags = flags.join("\u{1f}");
    run_with(&[("CARGO_ENCODED_RUSTFLAGS", &flags)], "cargo", &build)?;
    let compiler = root().join(PAGE).join("node_modules/.bin/tsc");
    let project = root().join(PACKAGE);
    let words = |path: &Path| path.display().to_string();
    let compile = ["--project", &words(&project), "--outDir", &words(folder)];
    run(&words(&compiler), &compile)?;
    let module = root().join(format!("target/wasm/{TARGET}/web/sextant_web.wasm"));
    let bytes = fs::read(&module).map_err(|cause| format!("{}: {cause}", module.display()))?;
    let file = folder.join("sextant.wasm");
    fs::write(&file, bytes).map_err(|cause| format!("{}: {cause}", file.display()))
}

/// Messages of panics name source files: without the folders of this machine.
fn remapped() -> Result<[String; 2], String> {
    let home = std::env::var_os("HOME").map(PathBuf::from);
    let cargo = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let cargo = cargo
        .or_else(|| home.map(|home| home.join(".cargo")))
        .ok_or("neither CARGO_HOME nor HOME is set")?;
    let root = root();
    let root = root
        .canonicalize()
        .map_err(|cause| format!("{}: {cause}", root.display()))?;
    let remap = |from: &Path, to: &str| format!("--remap-path-prefix={}={to}", from.display());
    Ok([
        remap(&root, "sextant"),
        remap(&cargo.join("registry/src"), "registry"),
    ])
}
