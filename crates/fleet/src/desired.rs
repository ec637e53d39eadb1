//! What a host shall have: the configuration and the keys of its camera, checked before any host is asked.

use crate::digest::digest;
use crate::error::FleetError;
use node_camera::CameraNodeConfig;
use sextant_proto::SiteId;
use sextant_site_files::{read_text, write_atomically};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{KeyFiles, Profile};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Component, Path, PathBuf};

/// Where the keys of a camera go where its file does not say, below the state folder.
const KEYS: &str = "keys";

/// Where configurations and keys come from.
pub struct Sources<'a> {
    /// Has `camera-CAMERA.toml`, or a minimal one is written.
    pub folder: &'a Path,
    /// The folder of `sextant keys`.
    pub authority: Option<&'a Path>,
    /// Of configurations that are written: the site.
    pub site: &'a SiteId,
    /// Of configurations that are written: the router, as hosts reach it.
    pub router: &'a str,
}

/// Configuration and keys of a camera.
#[derive(Debug)]
pub struct Desired {
    config: String,
    keys: Option<Keys>,
}

#[derive(Debug)]
struct Keys {
    /// Here.
    folder: PathBuf,
    /// There, below the state folder.
    place: String,
}

impl Desired {
    /// Reads and checks what a camera gets.
    ///
    /// # Errors
    /// A file that is wrong, or that does not go with the keys.
    pub fn read(camera: &CameraId, sources: &Sources<'_>) -> Result<Self, FleetError> {
        let file = sources.folder.join(format!("camera-{camera}.toml"));
        let config = if file.exists() {
            read_text(&file)?
        } else {
            minimal(camera, sources)?
        };
        let mut parsed = CameraNodeConfig::parse(&file, &config)?;
        if parsed.camera != *camera || parsed.site != *sources.site {
            return Err(FleetError::OtherCamera {
                file,
                found: [parsed.camera.to_string(), parsed.site.to_string()],
                wanted: [camera.to_string(), sources.site.to_string()],
            });
        }
        let keys = match (&parsed.security.keys, sources.authority) {
            (None, _) => None,
            (Some(_), None) => return Err(FleetError::NoAuthority(file)),
            (Some(place), Some(authority)) => Some(Keys {
                folder: authority.join(camera.as_str()),
                place: place_below(place).ok_or_else(|| FleetError::KeysPlace {
                    file: file.clone(),
                    place: place.to_string_lossy().into_owned(),
                })?,
            }),
        };
        parsed.security.keys = keys.as_ref().map(|keys| keys.folder.clone());
        parsed.protection()?;
        Ok(Self { config, keys })
    }

    /// Where the keys go below the host's state folder; `-` for none, as `host.sh` has it.
    pub fn keys_place(&self) -> &str {
        self.keys.as_ref().map_or("-", |keys| &keys.place)
    }

    /// SHA-256 of each file, by the names that the host reports: `camera.toml`, `keys/NAME`.
    ///
    /// # Errors
    /// Keys that cannot be read.
    pub fn digests(&self) -> Result<BTreeMap<String, String>, FleetError> {
        let mut digests =
            BTreeMap::from([("camera.toml".to_owned(), digest(self.config.as_bytes()))]);
        for file in self.key_files()? {
            let name = file
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            digests.insert(
                format!("keys/{name}"),
                digest(&fs::read(&file).map_err(FleetError::system(&file))?),
            );
        }
        Ok(digests)
    }

    /// Lays the files out in a folder as the host unpacks them.
    ///
    /// # Errors
    /// What the system refuses.
    pub fn write(&self, folder: &Path) -> Result<(), FleetError> {
        let config = folder.join("camera.toml");
        write_atomically(&config, self.config.as_bytes())?;
        let private = |path: &Path, mode| {
            fs::set_permissions(path, fs::Permissions::from_mode(mode))
                .map_err(FleetError::system(path))
        };
        private(&config, 0o640)?;
        let files = self.key_files()?;
        if !files.is_empty() {
            let keys = folder.join("keys");
            fs::create_dir(&keys).map_err(FleetError::system(&keys))?;
            private(&keys, 0o700)?;
            for file in files {
                // With its permissions.
                fs::copy(&file, keys.join(file.file_name().unwrap_or_default()))
                    .map_err(FleetError::system(&file))?;
            }
        }
        Ok(())
    }

    fn key_files(&self) -> Result<Vec<PathBuf>, FleetError> {
        let Some(Keys { folder, .. }) = &self.keys else {
            return Ok(Vec::new());
        };
        let entries = fs::read_dir(folder).map_err(FleetError::system(folder))?;
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        Ok(paths.filter(|path| path.is_file()).collect())
    }
}

/// Name, router and keys; everything else comes from the site or is as usual.
fn minimal(camera: &CameraId, sources: &Sources<'_>) -> Result<String, FleetError> {
    let Sources {
        site,
        router,
        authority,
        ..
    } = sources;
    if is_loopback(router) {
        return Err(FleetError::LocalRouter {
            camera: camera.clone(),
            router: (*router).to_owned(),
            file: sources.folder.join(format!("camera-{camera}.toml")),
        });
    }
    let mut text = format!(
        "# Written by `sextant deploy`. Exposure, gain, the lens and the sizes of tags come from \
         the site.\nsite = \"{site}\"\ncamera = \"{camera}\"\n\n[network]\nconnect = [{router:?}]\n"
    );
    if authority.is_some_and(|authority| {
        KeyFiles::within(&authority.join(camera.as_str()))
            .node()
            .exists()
    }) {
        let profile = if router.starts_with("quic/") {
            Profile::Site
        } else {
            Profile::Lab
        };
        text.push_str(&format!(
            "\n[security]\nprofile = \"{}\"\nkeys = \"{KEYS}/{camera}\"\n",
            profile.name()
        ));
    } else if authority.is_some() {
        return Err(FleetError::NoKeys(camera.clone()));
    }
    Ok(text)
}

fn is_loopback(endpoint: &str) -> bool {
    ["/127.", "/localhost:", "/[::1]"]
        .iter()
        .any(|own| endpoint.contains(own))
}

/// A place for keys below the state folder, safe in a shell.
fn place_below(place: &Path) -> Option<String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-/".contains(c);
    let text = place.to_string_lossy();
    let mut parts = place.components();
    let is_below = parts.all(|part| matches!(part, Component::Normal(_)))
        && text.chars().all(is_plain)
        && !text.starts_with('-');
    is_below.then(|| text.trim_end_matches('/').to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources<'a>(folder: &'a Path, site: &'a SiteId, router: &'a str) -> Sources<'a> {
        Sources {
            folder,
            authority: None,
            site,
            router,
        }
    }

    fn read(config: Option<&str>, router: &str) -> Result<Desired, String> {
        let folder = tempfile::tempdir().unwrap();
        if let Some(text) = config {
            fs::write(folder.path().join("camera-north.toml"), text).unwrap();
        }
        let (site, camera) = (SiteId::new("lab").unwrap(), CameraId::new("north").unwrap());
        let desired = Desired::read(&camera, &sources(folder.path(), &site, router));
        desired.map_err(|cause| cause.to_string())
    }

    #[test]
    fn a_camera_needs_no_file_but_a_router_that_it_reaches() {
        let desired = read(None, "tcp/10.0.0.1:7447").unwrap();
        assert!(desired.config.contains("connect = [\"tcp/10.0.0.1:7447\"]"));
        assert_eq!(desired.keys_place(), "-");
        assert_eq!(desired.digests().unwrap().len(), 1);
        assert!(
            read(None, "tcp/127.0.0.1:7447")
                .unwrap_err()
                .contains("--router")
        );
    }

    #[test]
    fn a_file_for_another_camera_or_without_its_keys_is_refused() {
        for (text, why) in [
            (
                "site = \"lab\"\ncamera = \"south\"\n",
                "it is for camera south",
            ),
            ("site = \"attic\"\ncamera = \"north\"\n", "of site attic"),
            (
                "site = \"lab\"\ncamera = \"north\"\nexposure = 1\n",
                "exposure",
            ),
            (
                "site = \"lab\"\ncamera = \"north\"\n[security]\nprofile = \"site\"\nkeys = \"keys\"\n",
                "--authority",
            ),
        ] {
            let refused = read(Some(text), "tcp/10.0.0.1:7447").unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
    }

    #[test]
    fn keys_stay_below_the_state_folder() {
        assert_eq!(place_below(Path::new("keys/north/")).unwrap(), "keys/north");
        for place in ["/etc/keys", "../keys", "keys;rm", "-r", "keys/../.."] {
            assert!(place_below(Path::new(place)).is_none(), "{place}");
        }
    }
}
