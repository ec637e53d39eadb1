//! Processors, and how a program is built for one.

use super::contents::Package;
use crate::tools::{Zigbuild, root, run_with};
use std::path::PathBuf;

/// A processor with the oldest C library that packages for it run with.
pub struct Target {
    /// In the names of files.
    pub name: &'static str,
    /// Rust's name.
    pub triple: &'static str,
    /// Major and minor version of the GNU C library.
    pub glibc: [u32; 2],
    /// Debian's name; absent where it has none of its own.
    pub architecture: Option<&'static str>,
}

/// 32-bit boards. The C library of the RZ/A2M's toolchain is the oldest there is.
pub const ARMV7: Target = Target {
    name: "armv7",
    triple: "armv7-unknown-linux-gnueabihf",
    glibc: [2, 25],
    architecture: Some("armhf"),
};

/// Debian 10, of which the 64-bit systems of Raspberry Pis descend, has 2.28.
pub const TARGETS: &[Target] = &[
    ARMV7,
    Target {
        name: "armv7-neon",
        triple: "thumbv7neon-unknown-linux-gnueabihf",
        glibc: [2, 25],
        architecture: None,
    },
    Target {
        name: "aarch64",
        triple: "aarch64-unknown-linux-gnu",
        glibc: [2, 28],
        architecture: Some("arm64"),
    },
    Target {
        name: "x86_64",
        triple: "x86_64-unknown-linux-gnu",
        glibc: [2, 28],
        architecture: Some("amd64"),
    },
];

impl Target {
    /// Builds a package's program.
    pub fn build(&self, package: &Package) -> Result<PathBuf, String> {
        let zigbuild = Zigbuild::installed()?;
        let [major, minor] = self.glibc;
        let target = format!("{}.{major}.{minor}", self.triple);
        // Link-time optimisation excludes incremental compilation.
        let what = ["--package", package.cargo_package, "--target", &target];
        let how = ["--profile", package.profile, "--features", package.features];
        run_with(
            &[
                ("CARGO_ZIGBUILD_ZIG_PATH", &zigbuild.compiler),
                ("CARGO_INCREMENTAL", "0"),
            ],
            &zigbuild.program,
            &[&["zigbuild"][..], &what, &how].concat(),
        )?;
        let built = root().join("target").join(self.triple);
        Ok(built.join(package.profile).join(package.program))
    }
}
