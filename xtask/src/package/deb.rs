//! Debian packages, by dpkg-deb: the scripts of `deploy/packages` with a package's words in them.

use super::{Staged, output};
use crate::tools::{gzip, root, run};
use std::fs;
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

const SCRIPTS: &[&str] = &["postinst", "prerm", "postrm"];
/// Always the same, so that the package is.
const DATE: &str = "Thu, 01 Jan 2026 00:00:00 +0000";

/// Writes the package as `NAME_VERSION_ARCHITECTURE.deb` and returns its path.
pub fn write(staged: &Staged, version: &str) -> Result<PathBuf, String> {
    let folder = &staged.folder;
    let failed = |cause: io::Error| format!("{}: {cause}", folder.display());
    document(staged, version)?;
    let words = words(staged, version).map_err(failed)?;
    let control = folder.join("DEBIAN");
    fs::create_dir_all(&control).map_err(failed)?;
    fill(staged, "control", &words).map_err(failed)?;
    for script in SCRIPTS {
        fill(staged, script, &words).map_err(failed)?;
        let executable = fs::Permissions::from_mode(0o755);
        fs::set_permissions(control.join(script), executable).map_err(failed)?;
    }
    let conffiles = format!("/etc/default/{}\n", staged.package.name);
    fs::write(control.join("conffiles"), conffiles).map_err(failed)?;
    pack(folder, staged, version)
}

fn pack(folder: &Path, staged: &Staged, version: &str) -> Result<PathBuf, String> {
    let architecture = staged.target.architecture.unwrap_or_default();
    let name = format!("{}_{version}-1_{architecture}.deb", staged.package.name);
    let deb = output()?.join(name);
    let build = ["--root-owner-group", "--build"];
    let paths = [folder, &deb].map(|path| path.display().to_string());
    let paths = paths.each_ref().map(String::as_str);
    run("dpkg-deb", &[&build[..], &paths].concat())?;
    Ok(deb)
}

/// What stands for each `@WORD@`.
fn words(staged: &Staged, version: &str) -> io::Result<Vec<(&'static str, String)>> {
    let package = staged.package;
    let [major, minor] = staged.target.glibc;
    Ok(vec![
        ("@PACKAGE@", package.name.to_owned()),
        ("@OTHER@", package.other.to_owned()),
        ("@UNITS@", package.units.to_owned()),
        ("@STATE@", package.state.to_owned()),
        ("@VERSION@", format!("{version}-1")),
        (
            "@ARCHITECTURE@",
            staged.target.architecture.unwrap_or_default().to_owned(),
        ),
        ("@GLIBC@", format!("{major}.{minor}")),
        ("@DESCRIPTION@", package.description.to_owned()),
        ("@SIZE@", size(&staged.folder)?.div_ceil(1024).to_string()),
    ])
}

fn fill(staged: &Staged, name: &str, words: &[(&str, String)]) -> io::Result<()> {
    let text = fs::read_to_string(root().join("deploy/packages").join(name))?;
    let filled = words
        .iter()
        .fold(text, |text, (word, value)| text.replace(word, value));
    fs::write(staged.folder.join("DEBIAN").join(name), filled)
}

/// Changes, where Debian's tools look for them.
fn document(staged: &Staged, version: &str) -> Result<(), String> {
    let name = staged.package.name;
    let folder = staged.folder.join("usr/share/doc").join(name);
    gzip(&root().join("CHANGELOG.md"), &folder.join("changelog.gz"))?;
    let changes = format!(
        "sextant ({version}-1) unstable; urgency=medium\n\n  * See changelog.gz.\n\n -- Sextant \
         developers <sextant@packages.invalid>  {DATE}\n"
    );
    let plain = folder.join("changelog.Debian");
    fs::write(&plain, changes).map_err(|cause| format!("{}: {cause}", plain.display()))?;
    gzip(&plain, &folder.join("changelog.Debian.gz"))?;
    fs::remove_file(&plain).map_err(|cause| format!("{}: {cause}", plain.display()))
}

fn size(folder: &Path) -> io::Result<u64> {
    fs::read_dir(folder)?.try_fold(0, |sum, entry| {
        let path = entry?.path();
        let bytes = if path.is_dir() {
            size(&path)?
        } else {
            path.metadata()?.len()
        };
        Ok(sum + bytes)
    })
}

/// Debian's own check; warnings are printed and pass.
pub fn lint(deb: &Path) -> Result<(), String> {
    let deb = deb.display().to_string();
    run("lintian", &["--fail-on", "error", "--allow-root", &deb])
}
