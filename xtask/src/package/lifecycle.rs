//! A package is installed, upgraded, downgraded, removed and purged in an empty root; its scripts run, as they do when an image of a system is made.

use super::{Staged, VERSION, deb, output};
use crate::tools::run;
use std::fs;
use std::path::{Path, PathBuf};

/// The version that it is upgraded to.
const NEWER: &str = "9999.0.0";
/// What a script may need of the root's own.
const FOLDERS: &[&str] = &["var/lib/dpkg/info", "var/lib/dpkg/updates", "etc"];

/// Fails where a step does, leaves something behind or takes too much away.
pub fn check(staged: &Staged, deb: &Path) -> Result<(), String> {
    let root = Scratch::new(staged)?;
    let conffile = format!("etc/default/{}", staged.package.name);
    let state = "var/lib/sextant/camera-north.toml";
    let newer = deb::write(staged, NEWER)?;

    root.dpkg(&["--install", &deb.display().to_string()])?;
    root.expect_version(staged, VERSION)?;
    root.expect_file("var/lib/sextant")?;
    root.expect_text("etc/passwd", "sextant:")?;
    // What a person changed stays as it is through every step but the last.
    root.write(&conffile, "SEXTANT_LOG=debug\n")?;
    root.write(state, "site = \"demo\"\n")?;
    for (deb, version) in [(newer.as_path(), NEWER), (deb, VERSION)] {
        root.dpkg(&["--install", &deb.display().to_string()])?;
        root.expect_version(staged, version)?;
        root.expect_text(&conffile, "debug")?;
        root.expect_text(state, "demo")?;
    }
    root.dpkg(&["--remove", staged.package.name])?;
    root.expect_no_file(&format!("usr/bin/{}", staged.package.program))?;
    root.expect_text(&conffile, "debug")?;
    root.expect_text(state, "demo")?;
    root.dpkg(&["--purge", staged.package.name])?;
    for gone in [
        conffile.as_str(),
        "var/lib/sextant",
        "var/lib/sextant-viewer",
    ] {
        root.expect_no_file(gone)?;
    }
    fs::remove_file(&newer).map_err(|cause| format!("{}: {cause}", newer.display()))
}

/// A root with nothing but dpkg's database in it.
struct Scratch(PathBuf);

impl Scratch {
    fn new(staged: &Staged) -> Result<Self, String> {
        let folder = output()?.join("scratch");
        let scratch = Self(folder);
        scratch.clear()?;
        for folder in FOLDERS {
            let folder = scratch.0.join(folder);
            fs::create_dir_all(&folder)
                .map_err(|cause| format!("{}: {cause}", folder.display()))?;
        }
        scratch.write("var/lib/dpkg/status", "")?;
        let architecture = staged.target.architecture.unwrap_or_default();
        scratch.write("var/lib/dpkg/arch", &format!("{architecture}\n"))?;
        Ok(scratch)
    }

    fn clear(&self) -> Result<(), String> {
        match fs::remove_dir_all(&self.0) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                Err(format!("{}: {cause}", self.0.display()))
            }
            _ => Ok(()),
        }
    }

    /// Dependencies are another processor's, and the scripts are not to change into the root, where no program is.
    fn dpkg(&self, arguments: &[&str]) -> Result<(), String> {
        let root = format!("--root={}", self.0.display());
        let force = [
            "--force-script-chrootless",
            "--force-depends,architecture,confold,downgrade",
        ];
        run("dpkg", &[&[root.as_str()][..], &force, arguments].concat())
    }

    fn write(&self, file: &str, text: &str) -> Result<(), String> {
        let path = self.0.join(file);
        fs::write(&path, text).map_err(|cause| format!("{}: {cause}", path.display()))
    }

    fn expect_version(&self, staged: &Staged, version: &str) -> Result<(), String> {
        let name = staged.package.name;
        self.expect_text("var/lib/dpkg/status", &format!("Version: {version}-1\n"))?;
        self.expect_text(
            "var/lib/dpkg/status",
            &format!("Package: {name}\nStatus: install ok installed\n"),
        )
    }

    fn expect_text(&self, file: &str, text: &str) -> Result<(), String> {
        let path = self.0.join(file);
        match fs::read_to_string(&path) {
            Ok(found) if found.contains(text) => Ok(()),
            Ok(found) => Err(format!("{}: no {text:?} in {found:?}", path.display())),
            Err(cause) => Err(format!("{}: {cause}", path.display())),
        }
    }

    fn expect_file(&self, file: &str) -> Result<(), String> {
        let path = self.0.join(file);
        path.exists()
            .then_some(())
            .ok_or_else(|| format!("{} is missing", path.display()))
    }

    fn expect_no_file(&self, file: &str) -> Result<(), String> {
        let path = self.0.join(file);
        (!path.exists())
            .then_some(())
            .ok_or_else(|| format!("{} is left behind", path.display()))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = self.clear();
    }
}
