//! The packages of a folder, by the names that `cargo xtask package` gives them, and the one for a host.

use crate::digest::digest;
use crate::error::FleetError;
use crate::facts::{HostFacts, Init};
use std::fs;
use std::path::{Path, PathBuf};

const NAME: &str = "sextant-camera";
/// Oldest GNU C library that the packages for 32-bit and for 64-bit systems run with (deploy/README.md).
const GLIBC: [(u32, [u32; 2]); 2] = [(32, [2, 25]), (64, [2, 28])];

/// A package file of the camera node, by what its name says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Package {
    /// The file.
    pub file: PathBuf,
    /// With Debian's revision where it has one.
    pub version: String,
    /// Debian's architecture, or the processor.
    architecture: String,
    kind: PackageKind,
    /// SHA-256.
    pub digest: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PackageKind {
    Deb,
    Tarball,
}

impl Package {
    fn from_file_name(file: &Path) -> Option<Self> {
        let name = file.file_name()?.to_str()?;
        let rest = name.strip_prefix(NAME)?;
        let (kind, version, architecture) = match rest.strip_suffix(".deb") {
            Some(rest) => {
                let (version, architecture) = rest.strip_prefix('_')?.split_once('_')?;
                (PackageKind::Deb, version, architecture)
            }
            None => {
                let rest = rest.strip_suffix(".tar.gz")?.strip_prefix('-')?;
                let (version, processor) = rest.split_once('-')?;
                (PackageKind::Tarball, version, processor)
            }
        };
        Some(Self {
            file: file.to_owned(),
            version: version.to_owned(),
            architecture: architecture.to_owned(),
            kind,
            digest: String::new(),
        })
    }

    /// Its name where the host unpacks it.
    pub fn staged_name(&self) -> &'static str {
        match self.kind {
            PackageKind::Deb => "package.deb",
            PackageKind::Tarball => "package.tar.gz",
        }
    }

    /// What the program in it says its version is.
    pub fn program_version(&self) -> &str {
        self.version.split('-').next().unwrap_or(&self.version)
    }
}

/// All packages of a folder.
#[derive(Debug)]
pub struct PackageFolder {
    folder: PathBuf,
    packages: Vec<Package>,
}

impl PackageFolder {
    /// Reads the names in a folder.
    ///
    /// # Errors
    /// No such folder, or none with packages.
    pub fn open(folder: &Path) -> Result<Self, FleetError> {
        let none = |source| FleetError::NoPackages {
            folder: folder.to_owned(),
            source,
        };
        let entries = fs::read_dir(folder).map_err(|cause| none(Some(cause)))?;
        let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
        let packages: Vec<Package> = files
            .filter_map(|file| Package::from_file_name(&file))
            .collect();
        if packages.is_empty() {
            return Err(none(None));
        }
        Ok(Self {
            folder: folder.to_owned(),
            packages,
        })
    }

    /// The newest package that runs on a host.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn for_host(&self, facts: &HostFacts) -> Result<Package, String> {
        check_c_library(facts)?;
        let (kind, wanted): (_, Vec<&str>) = match (&facts.dpkg, facts.init) {
            (Some(dpkg), Init::Systemd) => (PackageKind::Deb, vec![dpkg]),
            (None, Init::Systemd) => {
                return Err(
                    "it has systemd, but no dpkg: there is no package for such systems".into(),
                );
            }
            (_, Init::Busybox) => (PackageKind::Tarball, facts.processors().to_vec()),
        };
        let of = |architecture: &&str| {
            let fitting = self
                .packages
                .iter()
                .filter(|package| package.kind == kind && package.architecture == **architecture);
            fitting.max_by_key(|package| version_order(&package.version))
        };
        let Some(found) = wanted.iter().find_map(of) else {
            return Err(format!(
                "{} has no package for it (a {} {} system{}); `cargo xtask package` makes them",
                self.folder.display(),
                facts.bits,
                facts.machine,
                facts
                    .dpkg
                    .as_ref()
                    .map_or(String::new(), |dpkg| format!(", Debian {dpkg}")),
            ));
        };
        let bytes =
            fs::read(&found.file).map_err(|cause| format!("{}: {cause}", found.file.display()))?;
        Ok(Package {
            digest: digest(&bytes),
            ..found.clone()
        })
    }
}

fn check_c_library(facts: &HostFacts) -> Result<(), String> {
    let oldest = GLIBC.iter().find(|(bits, _)| *bits == facts.bits);
    let [major, minor] = oldest.map_or([0, 0], |(_, glibc)| *glibc);
    match facts.glibc {
        Some(found) if found >= [major, minor] => Ok(()),
        _ => Err(format!(
            "its C library is {}; the packages need glibc {major}.{minor} or newer",
            facts.libc
        )),
    }
}

/// The numbers of a version, which are compared one after the other.
fn version_order(version: &str) -> Vec<u64> {
    let numbers = version.split(|c: char| !c.is_ascii_digit());
    numbers.filter_map(|number| number.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::tests::PI;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            fs::write(folder.path().join(name), name).unwrap();
        }
        folder
    }

    fn chosen(names: &[&str], facts: &str) -> Result<String, String> {
        let folder = folder(names);
        let packages = PackageFolder::open(folder.path()).unwrap();
        let package = packages.for_host(&HostFacts::parse(facts).unwrap())?;
        Ok(package
            .file
            .file_name()
            .unwrap()
            .to_str()
            .unwrap()
            .to_owned())
    }

    const ALL: &[&str] = &[
        "sextant_0.1.0-1_armhf.deb",
        "sextant-camera_0.1.0-2_armhf.deb",
        "sextant-camera_0.1.0-10_armhf.deb",
        "sextant-camera_0.1.0-10_arm64.deb",
        "sextant-camera-0.1.0-armv7.tar.gz",
        "sextant-camera-0.1.0-armv7-neon.tar.gz",
    ];

    #[test]
    fn a_host_gets_the_newest_package_for_its_system() {
        assert_eq!(
            chosen(ALL, PI).unwrap(),
            "sextant-camera_0.1.0-10_armhf.deb"
        );
        let small = PI
            .replace("dpkg armhf\n", "")
            .replace("systemd", "busybox")
            .replace("aarch64", "armv7l");
        assert_eq!(
            chosen(ALL, &small).unwrap(),
            "sextant-camera-0.1.0-armv7.tar.gz"
        );
        let neon = format!("neon yes\n{small}");
        assert_eq!(
            chosen(ALL, &neon).unwrap(),
            "sextant-camera-0.1.0-armv7-neon.tar.gz"
        );
    }

    #[test]
    fn a_system_without_a_package_gets_the_reason() {
        for (from, to, why) in [
            ("glibc 2.36", "glibc 2.24", "glibc 2.25 or newer"),
            ("glibc 2.36", "musl", "its C library is musl"),
            ("dpkg armhf\n", "", "no dpkg"),
            ("dpkg armhf", "dpkg i386", "Debian i386"),
        ] {
            let refused = chosen(ALL, &PI.replace(from, to)).unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
    }

    #[test]
    fn a_folder_without_packages_is_no_folder_of_packages() {
        let folder = folder(&["sextant_0.1.0-1_armhf.deb"]);
        let refused = PackageFolder::open(folder.path()).unwrap_err();
        assert!(refused.to_string().contains("cargo xtask package"));
    }
}
