//! What a host lacks of what it shall have.

use crate::desired::Desired;
use crate::error::FleetError;
use crate::facts::HostFacts;
use crate::packages::Package;

/// What is to be done on a host.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The package to install.
    pub package: Option<Package>,
    /// Version that is installed, as far as that is known.
    pub from: Option<String>,
    /// Version that shall be.
    pub to: String,
    /// What the program says its version is, afterwards.
    pub program_version: String,
    /// As text.
    pub changes: Vec<String>,
}

impl Plan {
    /// Compares.
    ///
    /// # Errors
    /// Keys that cannot be read here.
    pub fn compare(
        facts: &HostFacts,
        package: Package,
        desired: &Desired,
    ) -> Result<Self, FleetError> {
        let wanted = desired.digests()?;
        let part = |name: &str| {
            let of = |files: &std::collections::BTreeMap<String, String>| {
                let own = files.iter().filter(|(file, _)| file.starts_with(name));
                own.map(|(file, digest)| (file.clone(), digest.clone()))
                    .collect::<Vec<_>>()
            };
            of(&facts.files) != of(&wanted)
        };
        let is_other = facts.deployed.as_deref() != Some(&package.digest);
        let mut changes = Vec::new();
        if facts.is_interrupted {
            changes.push("undo a deployment that was cut off".to_owned());
        }
        if is_other {
            changes.push(match &facts.installed {
                Some(from) if *from != package.version => {
                    format!("update {from} to {}", package.version)
                }
                Some(from) => format!("install {from} again"),
                None => format!("install {}", package.version),
            });
        }
        if part("camera.toml") {
            changes.push("write the configuration".to_owned());
        }
        if part("keys/") {
            changes.push("write the keys".to_owned());
        }
        if !facts.is_active {
            changes.push("start it".to_owned());
        }
        Ok(Self {
            from: facts.installed.clone(),
            to: package.version.clone(),
            program_version: package.program_version().to_owned(),
            package: is_other.then_some(package),
            changes,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::desired::Sources;
    use crate::facts::tests::PI;
    use crate::packages::PackageFolder;
    use sextant_proto::SiteId;
    use sextant_site_model::CameraId;

    #[test]
    fn a_host_that_has_everything_needs_nothing() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("sextant-camera_0.1.0-2_armhf.deb"), "p").unwrap();
        let camera = CameraId::new("north").unwrap();
        let sources = Sources {
            folder: folder.path(),
            authority: None,
            site: &SiteId::new("lab").unwrap(),
            router: "tcp/10.0.0.1:7447",
        };
        let desired = Desired::read(&camera, &sources).unwrap();
        let facts = PI.replace("file keys/key.pem k\n", "");
        let plan = |facts: &str| {
            let facts = HostFacts::parse(facts).unwrap();
            let package = PackageFolder::open(folder.path())
                .unwrap()
                .for_host(&facts)
                .unwrap();
            Plan::compare(&facts, package, &desired).unwrap()
        };
        let new = plan(&facts);
        assert_eq!(
            new.changes,
            ["update 0.1.0-1 to 0.1.0-2", "write the configuration"]
        );
        assert_eq!(new.program_version, "0.1.0");
        let package = new.package.unwrap().digest;
        let same = facts
            .replace("deployed d p", &format!("deployed {package} p"))
            .replace(
                "camera.toml c",
                &format!("camera.toml {}", desired.digests().unwrap()["camera.toml"]),
            );
        assert!(plan(&same).changes.is_empty());
        assert_eq!(
            plan(&same.replace("active yes\n", "")).changes,
            ["start it"]
        );
        let cut_off = plan(&same.replace("end\n", "interrupted yes\nend\n"));
        assert_eq!(cut_off.changes, ["undo a deployment that was cut off"]);
    }
}
