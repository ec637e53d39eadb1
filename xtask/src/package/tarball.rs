//! A package's files without Debian around them, for systems where BusyBox is init: unpacked over the root, they are
//! installed.

use super::contents::Package;
use super::{Staged, VERSION, output};
use crate::tools::{copy, root, run};
use std::path::PathBuf;

/// What such a system reads: no unit, no manual page.
const PARTS: &[&str] = &["usr/bin", "etc/default", "etc/init.d", "usr/share/doc"];

/// Writes the archive as `NAME-VERSION-TARGET.tar.gz` and returns its path.
pub fn write(staged: &Staged) -> Result<PathBuf, String> {
    let Package { name, .. } = staged.package;
    let init = format!("deploy/init.d/S90{name}");
    // Beside the staged package, which dpkg would otherwise take along.
    let folder = output()?.join(format!("{name}-{}-busybox", staged.target.name));
    run("rm", &["-rf", &folder.display().to_string()])?;
    run(
        "cp",
        &[
            "-a",
            &staged.folder.display().to_string(),
            &folder.display().to_string(),
        ],
    )?;
    copy(&root().join(init), &folder.join("etc/init.d"), 0o755)?;
    let file = output()?.join(format!("{name}-{VERSION}-{}.tar.gz", staged.target.name));
    let archive = ["--create", "--gzip", "--file", &file.display().to_string()];
    let owner = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner"];
    let place = ["--directory", &folder.display().to_string()];
    run("tar", &[&archive[..], &owner, &place, PARTS].concat())?;
    Ok(file)
}
