//! A node's folder of keys: its files and how they are read. `sextant keys` writes it.

use std::fs::Metadata;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sextant_proto::SiteId;

use super::{Identity, Member, Members, Role};
use crate::SecurityError;

/// Remaining validity of a certificate, in days, below which a warning is shown.
const SOON_DAYS: u64 = 30;
const DAY_S: u64 = 86_400;

/// Paths of a node's keys.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyFiles {
    folder: PathBuf,
}

#[allow(missing_docs, reason = "each is the path of the file of its name")]
impl KeyFiles {
    /// The files of this folder.
    pub fn within(folder: &Path) -> Self {
        let folder = folder.to_owned();
        Self { folder }
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Owner of the keys.
    pub fn node(&self) -> PathBuf {
        self.folder.join("node.toml")
    }

    /// The certificate of the site's authority.
    pub fn authority(&self) -> PathBuf {
        self.folder.join("authority.pem")
    }

    pub fn certificate(&self) -> PathBuf {
        self.folder.join("certificate.pem")
    }

    /// The private key of the node, which is secret.
    pub fn private_key(&self) -> PathBuf {
        self.folder.join("key.pem")
    }

    /// Secret, for profile lab.
    pub fn password(&self) -> PathBuf {
        self.folder.join("password")
    }

    /// For those who can be the router: the members.
    pub fn members(&self) -> PathBuf {
        self.folder.join("members.toml")
    }

    /// Secret, for role fusion: every member's password, in zenoh's format.
    pub fn passwords(&self) -> PathBuf {
        self.folder.join("passwords")
    }

    /// For viewers and operators: the page's certificate.
    pub fn page_certificate(&self) -> PathBuf {
        self.folder.join("page.pem")
    }

    /// Secret, for viewers and operators.
    pub fn page_private_key(&self) -> PathBuf {
        self.folder.join("page.key")
    }

    /// Secret, for viewers and operators: the tokens of the page.
    pub fn page_tokens(&self) -> PathBuf {
        self.folder.join("page-tokens.toml")
    }

    /// Secret, for viewers and operators: the tokens of browsers that are cameras, by the camera's name.
    pub fn phones(&self) -> PathBuf {
        self.folder.join("phones.toml")
    }
}

/// Owner of the keys: `node.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeFile {
    site: SiteId,
    node: Member,
}

/// A node's keys. Secrets stay in their files until they are needed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodeKeys {
    /// The site.
    pub site: SiteId,
    /// Their owner.
    pub member: Member,
    /// Their paths.
    pub files: KeyFiles,
    /// For role fusion: the members.
    pub members: Option<Members>,
}

impl NodeKeys {
    /// Reads a folder. Only the owner may have permission to read its private key.
    ///
    /// # Errors
    /// A folder without keys, or with a secret that others can read.
    pub fn read(folder: &Path) -> Result<Self, SecurityError> {
        let files = KeyFiles::within(folder);
        let NodeFile { site, node } = read(&files, &files.node())?;
        for file in [files.authority(), files.certificate()] {
            text(&files, &file)?;
        }
        let mut secrets = vec![files.private_key(), files.password()];
        match node.role {
            Role::Camera | Role::Phone => {}
            Role::Fusion | Role::Router => secrets.push(files.passwords()),
            Role::Viewer | Role::Operator => {
                secrets.extend([files.page_private_key(), files.page_tokens()]);
                // Keys from before there were phones have none.
                secrets.extend(Some(files.phones()).filter(|file| file.exists()));
            }
        }
        for secret in secrets {
            check_secret(&files, &secret)?;
        }
        let members = match node.role {
            role if role.can_be_router() => Some(read(&files, &files.members())?),
            _ => None,
        };
        Ok(Self {
            site,
            member: node,
            files,
            members,
        })
    }

    /// The text of `node.toml` for a member.
    ///
    /// # Errors
    /// Values that TOML cannot represent.
    pub fn node_toml(site: &SiteId, member: &Member) -> Result<String, String> {
        let (site, node) = (site.clone(), member.clone());
        toml::to_string(&NodeFile { site, node }).map_err(|cause| cause.to_string())
    }

    /// The password of profile lab.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn password(&self) -> Result<String, SecurityError> {
        Ok(text(&self.files, &self.files.password())?.trim().to_owned())
    }

    pub(super) fn check_site(&self, site: &str) -> Result<(), SecurityError> {
        if self.site.as_str() == site {
            return Ok(());
        }
        Err(self.other(format!("site {site}")))
    }

    pub(super) fn check_identity(&self, identity: Identity<'_>) -> Result<(), SecurityError> {
        let Identity { site, name, roles } = identity;
        if self.site.as_str() == site
            && self.member.name.as_str() == name
            && roles.contains(&self.member.role)
        {
            return Ok(());
        }
        let roles: Vec<&str> = roles.iter().map(|role| role.name()).collect();
        Err(self.other(format!("{} {name} of site {site}", roles.join(" or "))))
    }

    fn other(&self, expected: String) -> SecurityError {
        SecurityError::OtherIdentity {
            path: self.files.folder().to_owned(),
            found: format!(
                "{} {} of site {}",
                self.member.role, self.member.name, self.site
            ),
            expected,
        }
    }

    /// Warning about the certificate's validity at `now_s`, seconds since the Unix epoch.
    pub fn warning(&self, now_s: u64) -> Option<String> {
        let name = &self.member.name;
        let days = self.member.valid_until_s.saturating_sub(now_s) / DAY_S;
        let state = if now_s >= self.member.valid_until_s {
            "has expired, unless this machine's clock is wrong".to_owned()
        } else if days < SOON_DAYS {
            format!("expires in {days} days")
        } else {
            return None;
        };
        Some(format!(
            "the certificate of {name} {state}: renew it with `sextant keys renew DIR {name}` and copy its folder here"
        ))
    }
}

fn read<T: DeserializeOwned>(files: &KeyFiles, file: &Path) -> Result<T, SecurityError> {
    toml::from_str(&text(files, file)?).map_err(|cause| not_keys(files, file, cause.message()))
}

fn text(files: &KeyFiles, file: &Path) -> Result<String, SecurityError> {
    std::fs::read_to_string(file).map_err(|cause| not_keys(files, file, &cause.to_string()))
}

fn check_secret(files: &KeyFiles, file: &Path) -> Result<(), SecurityError> {
    let metadata =
        std::fs::metadata(file).map_err(|cause| not_keys(files, file, &cause.to_string()))?;
    if is_readable_by_others(&metadata) {
        return Err(SecurityError::Readable {
            path: file.to_owned(),
        });
    }
    text(files, file).map(drop)
}

/// Whether users other than its owner may read a file or write it.
#[cfg(unix)]
fn is_readable_by_others(metadata: &Metadata) -> bool {
    use std::os::unix::fs::PermissionsExt;
    metadata.permissions().mode() & 0o077 != 0
}

/// Elsewhere files have lists of rights, which folders of a user keep to that user by default.
#[cfg(not(unix))]
fn is_readable_by_others(_: &Metadata) -> bool {
    false
}

fn not_keys(files: &KeyFiles, file: &Path, cause: &str) -> SecurityError {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    SecurityError::NotKeys {
        path: files.folder().to_owned(),
        cause: format!("{name}: {cause}"),
    }
}
