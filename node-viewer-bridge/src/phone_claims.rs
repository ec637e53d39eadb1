//! The device that each phone's link belongs to: the first that became a camera by it.
//!
//! Kept as `phone-claims.toml` in the bridge's folder, without secrets: digests of the link's token and of the device's
//! key. A phone whose key of the site is renewed has another token, and its new link is free.

use serde::{Deserialize, Serialize};
use sextant_site_files::{FileError, read_toml, write_toml};
use sextant_site_model::CameraId;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

const FILE: &str = "phone-claims.toml";

/// The device that a phone's link belongs to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    link: String,
    device: String,
}

impl Claim {
    fn from_token(token: &str, key: &str) -> Self {
        Self {
            link: digest(&[token]),
            device: digest(&[token, key]),
        }
    }
}

/// The claims of all phones, by their cameras' names.
#[derive(Debug, Default)]
pub(crate) struct PhoneClaims {
    /// Where they are kept; without it they last as long as the bridge.
    file: Option<PathBuf>,
    claims: Mutex<BTreeMap<CameraId, Claim>>,
    /// Why the file cannot be read; then no link is given to a device that may not be its own.
    unreadable: Option<String>,
    /// Held by the one that writes the file.
    writing: Mutex<()>,
}

impl PhoneClaims {
    /// Reads the claims kept in the folder, if there are any. With a file that has none, the page goes on without
    /// phones that have keys.
    pub(crate) fn open(folder: Option<&Path>) -> Self {
        let file = folder.map(|folder| folder.join(FILE));
        let read = match &file {
            Some(file) if file.exists() => read_toml(file),
            _ => Ok(BTreeMap::new()),
        };
        let unreadable = read.as_ref().err().map(|cause: &FileError| {
            tracing::error!("no phone becomes a camera by a link: {cause}");
            format!("the bridge cannot read whose this link is: {cause}; put the file right, or remove it")
        });
        Self {
            file,
            claims: Mutex::new(read.unwrap_or_default()),
            unreadable,
            writing: Mutex::default(),
        }
    }

    /// Whether the link with this token belongs to the device whose browser shows this key.
    pub(crate) fn knows(&self, camera: &CameraId, token: &str, key: &str) -> bool {
        self.claims().get(camera) == Some(&Claim::from_token(token, key))
    }

    /// Lets a device be a camera by a link with this token. `key` is what its browser shows each time. Waits for the
    /// disk.
    ///
    /// # Errors
    /// Why not, in words for the person who holds it.
    pub(crate) fn claim(&self, camera: &CameraId, token: &str, key: &str) -> Result<(), String> {
        if let Some(cause) = &self.unreadable {
            return Err(cause.clone());
        }
        let claim = Claim::from_token(token, key);
        let _writing = self.writing();
        let claims = self.claims().clone();
        match claims.get(camera) {
            Some(known) if *known == claim => Ok(()),
            Some(known) if known.link == claim.link => Err(
                "this link is another device's: ask whoever runs the site to free it, or for another link"
                    .to_owned(),
            ),
            _ => {
                let mut changed = claims;
                changed.insert(camera.clone(), claim);
                self.keep(&changed)
                    .map_err(|error| format!("the bridge cannot keep whose this link is: {error}"))?;
                *self.claims() = changed;
                Ok(())
            }
        }
    }

    /// Whether a device has used the link with this token.
    pub(crate) fn is_used(&self, camera: &CameraId, token: &str) -> bool {
        let claims = self.claims();
        claims
            .get(camera)
            .is_some_and(|claim| claim.link == digest(&[token]))
    }

    /// Lets another device use a phone's link. Waits for the disk.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn free(&self, camera: &CameraId) -> Result<(), FileError> {
        let _writing = self.writing();
        let mut changed = self.claims().clone();
        if changed.remove(camera).is_some() {
            self.keep(&changed)?;
            *self.claims() = changed;
        }
        Ok(())
    }

    fn keep(&self, claims: &BTreeMap<CameraId, Claim>) -> Result<(), FileError> {
        let Some(file) = &self.file else {
            return Ok(());
        };
        // Nothing else may have made the folder; why it cannot be made is why the file cannot be written.
        let _ = file.parent().map(std::fs::create_dir_all);
        write_toml(file, claims)
    }

    fn writing(&self) -> MutexGuard<'_, ()> {
        self.writing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn claims(&self) -> MutexGuard<'_, BTreeMap<CameraId, Claim>> {
        self.claims.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// SHA-256 of these texts, which hold no line break, as hexadecimal digits.
fn digest(texts: &[&str]) -> String {
    let digest = Sha256::digest(texts.join("\n"));
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pocket() -> CameraId {
        CameraId::new("pocket").unwrap()
    }

    #[test]
    fn a_link_is_for_the_first_device_which_may_return() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("kept");
        let claims = PhoneClaims::open(Some(&folder));
        assert!(!claims.is_used(&pocket(), "token"));
        claims.claim(&pocket(), "token", "first").unwrap();
        assert!(claims.knows(&pocket(), "token", "first"));
        assert!(!claims.knows(&pocket(), "token", "second"));
        let words = claims.claim(&pocket(), "token", "second").unwrap_err();
        assert!(words.contains("another device's"), "{words}");
        // As after a restart.
        let claims = PhoneClaims::open(Some(&folder));
        claims.claim(&pocket(), "token", "first").unwrap();
        assert!(claims.claim(&pocket(), "token", "second").is_err());
        let file = std::fs::read_to_string(folder.join(FILE)).unwrap();
        assert!(!file.contains("token") && !file.contains("first"), "{file}");
    }

    /// A broken file costs the phones with keys, not the page, and gives no link away.
    #[test]
    fn a_file_that_cannot_be_read_gives_no_link_to_anybody() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(FILE), "pocket = 3\n").unwrap();
        let claims = PhoneClaims::open(Some(folder.path()));
        let refused = claims.claim(&pocket(), "token", "first").unwrap_err();
        assert!(
            refused.contains(FILE) && refused.contains("remove it"),
            "{refused}"
        );
        assert!(claims.free(&pocket()).is_ok());
        let file = std::fs::read_to_string(folder.path().join(FILE)).unwrap();
        assert_eq!(file, "pocket = 3\n");
    }

    #[test]
    fn a_link_that_is_freed_or_renewed_is_anybodys_once_more() {
        let claims = PhoneClaims::default();
        claims.claim(&pocket(), "token", "first").unwrap();
        claims.free(&pocket()).unwrap();
        assert!(!claims.is_used(&pocket(), "token"));
        claims.claim(&pocket(), "token", "second").unwrap();
        claims.claim(&pocket(), "renewed", "third").unwrap();
        assert!(claims.is_used(&pocket(), "renewed") && !claims.is_used(&pocket(), "token"));
    }
}
