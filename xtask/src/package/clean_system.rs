//! Debian systems with nothing but their essential packages, for each processor, in which packages and wheels are
//! tried.
//!
//! Each is made once, by mmdebstrap, and stays as it is: a trial works on a layer above it, which goes with the trial.
//! Programs of another processor run by qemu, where the kernel knows of it (binfmt_misc).

use super::output;
use crate::tools::run;
use std::fs;
use std::path::{Path, PathBuf};

/// Debian's release.
const RELEASE: &str = "bookworm";
/// Run in name spaces of its own: `$1` is the system, `$2` a folder that appears in it as `/trial`, `$3` the script to
/// run there with the rest.
const ENTER: &str = r#"system=$(realpath "$1") trial=$(realpath "$2") script=$3
shift 3
mount -t tmpfs tmpfs /mnt
cd /mnt
mkdir upper work root
mount -t overlay overlay -o "lowerdir=$system,upperdir=upper,workdir=work" root
mkdir root/trial
mount --bind "$trial" root/trial
mount -t proc proc root/proc
mount -t tmpfs tmpfs root/dev/shm
exec chroot root env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin sh -e "/trial/$script" "$@""#;

/// The folder with a system.
pub struct CleanSystem(PathBuf);

impl CleanSystem {
    /// With these packages beside the essential ones; made where it is missing.
    pub fn new(architecture: &str, packages: &str) -> Result<Self, String> {
        let name = format!("{RELEASE}-{architecture}-{}", packages.replace(',', "-"));
        let system = output()?.join("systems").join(name);
        if !system.exists() {
            println!("xtask: making {}", system.display());
            make(&system, architecture, packages)?;
        }
        Ok(Self(system))
    }

    /// Runs a script of a folder in the system.
    pub fn run(&self, folder: &Path, script: &str, arguments: &[&str]) -> Result<(), String> {
        let paths = [&self.0, folder].map(|path| path.display().to_string());
        let name_spaces = ["--mount", "--pid", "--fork", "--kill-child"];
        let enter = ["sh", "-ec", ENTER, "sh", &paths[0], &paths[1], script];
        run("unshare", &[&name_spaces[..], &enter, arguments].concat())
    }
}

fn make(system: &Path, architecture: &str, packages: &str) -> Result<(), String> {
    let fresh = system.with_extension("fresh");
    if fresh.exists() {
        fs::remove_dir_all(&fresh).map_err(|cause| format!("{}: {cause}", fresh.display()))?;
    }
    fs::create_dir_all(output()?.join("systems"))
        .map_err(|cause| format!("{}: {cause}", fresh.display()))?;
    let place = fresh.display().to_string();
    let options = [
        "--quiet",
        "--variant=essential",
        "--architectures",
        architecture,
        "--include",
        packages,
        "--aptopt=APT::Install-Recommends \"false\"",
        // Mirrors of updates are not always whole, and none is needed.
        "--setup-hook=sed -i /security/d\\;/updates/d \"$1/etc/apt/sources.list\"",
        RELEASE,
        &place,
    ];
    run("mmdebstrap", &options)?;
    fs::rename(&fresh, system).map_err(|cause| format!("{}: {cause}", system.display()))
}
