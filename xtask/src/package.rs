//! Packages for boards and PCs: a `.deb` for each processor, tarballs of the camera node for systems with BusyBox, and
//! Python wheels, all in `target/package`.
//!
//! Programs are linked by zig against the C library of the oldest system that they are for; none is packed that needs a
//! newer one.

mod clean_system;
mod contents;
mod deb;
mod lifecycle;
mod symbols;
mod tarball;
mod target;
mod wheel;

use crate::tools::{root, run};
use contents::{CAMERA, Package, SEXTANT, stage};
use std::fs;
use std::path::{Path, PathBuf};
use target::{ARMV7, TARGETS, Target};
pub use wheel::wheels;

pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Everything: both packages and a tarball for each processor.
pub fn all() -> Result<(), String> {
    let manual = manual()?;
    for target in TARGETS {
        let camera = Staged::new(&CAMERA, target, &manual)?;
        tarball::write(&camera)?;
        if target.architecture.is_some() {
            for staged in [camera, Staged::new(&SEXTANT, target, &manual)?] {
                let deb = linted_deb(&staged)?;
                lifecycle::check(&staged, &deb)?;
            }
        }
    }
    Ok(())
}

/// What the emulated board installs.
pub struct BoardFiles {
    pub deb: PathBuf,
    pub tarball: PathBuf,
}

/// The camera node for armv7 alone.
pub fn camera_for_board() -> Result<BoardFiles, String> {
    let staged = Staged::new(&CAMERA, &ARMV7, &manual()?)?;
    // The board installs and removes it.
    Ok(BoardFiles {
        tarball: tarball::write(&staged)?,
        deb: linted_deb(&staged)?,
    })
}

/// A package's files for one target, in a folder that looks like the root of the system that they go to.
struct Staged {
    package: &'static Package,
    target: &'static Target,
    folder: PathBuf,
}

impl Staged {
    fn new(
        package: &'static Package,
        target: &'static Target,
        manual: &Path,
    ) -> Result<Self, String> {
        let program = target.build(package)?;
        symbols::check(&program, target.glibc)?;
        let folder = output()?.join(format!("{}-{}", package.name, target.name));
        stage(package, &folder, &[&program, manual])?;
        Ok(Self {
            package,
            target,
            folder,
        })
    }
}

fn linted_deb(staged: &Staged) -> Result<PathBuf, String> {
    let deb = deb::write(staged, VERSION)?;
    deb::lint(&deb)?;
    Ok(deb)
}

/// A folder of `target/package` with nothing in it.
pub fn fresh_folder(name: &str) -> Result<PathBuf, String> {
    let folder = output()?.join(name);
    let failed = |cause| format!("{}: {cause}", folder.display());
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(failed)?;
    }
    fs::create_dir_all(&folder).map_err(failed)?;
    Ok(folder)
}

fn output() -> Result<PathBuf, String> {
    let folder = root().join("target/package");
    fs::create_dir_all(&folder).map_err(|cause| format!("{}: {cause}", folder.display()))?;
    folder
        .canonicalize()
        .map_err(|cause| format!("{}: {cause}", folder.display()))
}

/// Manual pages and completions, which this machine's own program writes for all.
fn manual() -> Result<PathBuf, String> {
    let folder = output()?.join("manual");
    // As the tests build it: another choice of packages would compile zenoh anew.
    let build = ["build", "--release", "--workspace", "--bin", "sextant"];
    run("cargo", &build)?;
    let folder_name = folder.display().to_string();
    run("target/release/sextant", &["manual", &folder_name])?;
    Ok(folder)
}
