//! What is in each package, and where it goes.

use crate::tools::{copy, gzip, root};
use std::fs;
use std::path::Path;

/// A package, the same for all processors.
pub struct Package {
    pub name: &'static str,
    /// The program in it, and that of the other package.
    pub program: &'static str,
    pub other: &'static str,
    pub cargo_package: &'static str,
    pub profile: &'static str,
    /// Cargo features beside the default ones, separated by commas.
    pub features: &'static str,
    /// Its units, as patterns for systemctl.
    pub units: &'static str,
    /// What only its own units write.
    pub state: &'static str,
    /// In a line, and in more.
    pub description: &'static str,
    /// Files of the project and the folders that they go to.
    files: &'static [(&'static str, &'static str)],
}

/// What a board with a camera needs.
pub const CAMERA: Package = Package {
    name: "sextant-camera",
    program: "node-camera",
    other: "sextant",
    cargo_package: "node-camera",
    profile: "board",
    features: "terse",
    units: "'sextant-capture@*.service' 'sextant-detect@*.service'",
    state: "/var/lib/sextant/camera*.toml",
    description: "camera node of Sextant, which tells where tagged objects are
 Captures the images of one camera, finds AprilTags in them and publishes
 their corners and poses on the site's network. A board needs nothing else
 of Sextant; fusion and the web page are in the package sextant.",
    files: &[
        ("deploy/systemd/sextant-capture@.service", UNITS),
        ("deploy/systemd/sextant-detect@.service", UNITS),
        ("deploy/sysusers.d/sextant-camera.conf", SYSUSERS),
        ("deploy/tmpfiles.d/sextant-camera.conf", TMPFILES),
        ("deploy/udev/70-sextant.rules", "usr/lib/udev/rules.d"),
        ("deploy/default/sextant-camera", "etc/default"),
        ("deploy/packages/copyright", "usr/share/doc/sextant-camera"),
        (
            "sextant/src/config/camera.toml",
            "usr/share/doc/sextant-camera/examples",
        ),
    ],
};

/// Everything else: every command, fusion and the page.
pub const SEXTANT: Package = Package {
    name: "sextant",
    program: "sextant",
    other: "node-camera",
    cargo_package: "sextant",
    profile: "dist",
    features: "",
    units: "sextant-fusion.service sextant-router.service sextant-viewer.service",
    state: "/var/lib/sextant-viewer",
    description: "tells where tagged objects are, in six degrees of freedom, live
 Fuses what the camera nodes of a site see of AprilTags into poses with
 covariance, shows them on a web page, calibrates cameras and objects, and
 simulates, replays and inspects sites. Camera nodes as services of this
 machine are in the package sextant-camera.",
    files: &[
        ("deploy/systemd/sextant-fusion.service", UNITS),
        ("deploy/systemd/sextant-router.service", UNITS),
        ("deploy/systemd/sextant-viewer.service", UNITS),
        ("deploy/sysusers.d/sextant.conf", SYSUSERS),
        ("deploy/tmpfiles.d/sextant.conf", TMPFILES),
        ("deploy/default/sextant", "etc/default"),
        ("deploy/packages/copyright", "usr/share/doc/sextant"),
        (
            "deploy/packages/lintian/sextant",
            "usr/share/lintian/overrides",
        ),
    ],
};

const UNITS: &str = "usr/lib/systemd/system";
const SYSUSERS: &str = "usr/lib/sysusers.d";
const TMPFILES: &str = "usr/lib/tmpfiles.d";

/// Lays a package's files out in an empty folder: its program, its files of the project, manual pages and completions.
pub fn stage(package: &Package, folder: &Path, sources: &[&Path; 2]) -> Result<(), String> {
    let [program, manual] = sources;
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(|cause| format!("{}: {cause}", folder.display()))?;
    }
    copy(program, &folder.join("usr/bin"), 0o755)?;
    for (file, to) in package.files {
        copy(&root().join(file), &folder.join(to), 0o644)?;
    }
    stage_manual(package, folder, manual)
}

fn stage_manual(package: &Package, folder: &Path, manual: &Path) -> Result<(), String> {
    let share = folder.join("usr/share");
    let program = package.program;
    for (made, to) in [
        (
            format!("bash/{program}.bash"),
            "bash-completion/completions",
        ),
        (format!("zsh/_{program}"), "zsh/vendor-completions"),
        (format!("fish/{program}.fish"), "fish/vendor_completions.d"),
    ] {
        copy(&manual.join(made), &share.join(to), 0o644)?;
    }
    // bash looks for the completion of `program` under its very name.
    let bash = share.join("bash-completion/completions");
    fs::rename(bash.join(format!("{program}.bash")), bash.join(program))
        .map_err(|cause| format!("{}: {cause}", bash.display()))?;
    let pages = fs::read_dir(manual.join("man")).map_err(|cause| format!("man: {cause}"))?;
    for page in pages.flatten() {
        let name = page.file_name().to_string_lossy().into_owned();
        if name == format!("{program}.1") || name.starts_with(&format!("{program}-")) {
            gzip(
                &page.path(),
                &share.join("man/man1").join(format!("{name}.gz")),
            )?;
        }
    }
    Ok(())
}
