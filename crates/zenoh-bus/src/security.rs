//! The `[security]` section of every node's configuration, and its effect on a session: which endpoints are accepted,
//! how a process authenticates, and, for a router, who may publish and read what.
//!
//! | profile | links | who may join | rules |
//! |---|---|---|---|
//! | demo | loopback only | every process of this machine | none |
//! | lab | TCP | members with a user name and a password | by user name |
//! | site | QUIC | members with a certificate of the site's authority | by the certificate's common name |
//! | open | anything | everyone who reaches the port | none |

mod access;
mod endpoints;
mod members;
mod node_keys;
mod settings;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::SecurityError;
pub(crate) use endpoints::check_all;
pub use members::{Member, Members, Role};
pub use node_keys::{KeyFiles, NodeKeys};
pub(crate) use settings::{check_overrides, settings};

/// How far a process trusts its network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Profile {
    /// No protection; only this machine can connect.
    #[default]
    Demo,
    /// Members authenticate by user name and password; messages can be read in transit.
    Lab,
    /// Members and router authenticate by certificates; links are encrypted.
    Site,
    /// No protection, on any network. Also for those who configure zenoh's own security.
    Open,
}

impl Profile {
    /// Its word in a file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Demo => "demo",
            Self::Lab => "lab",
            Self::Site => "site",
            Self::Open => "open",
        }
    }
}

/// The `[security]` section of a node's file.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SecurityOptions {
    /// demo (default), lab, site or open.
    pub profile: Profile,
    /// The node's folder of keys, as `sextant keys add` makes it, beside this file or absolute; lab and site need one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keys: Option<PathBuf>,
}

/// Identity that a process requires on the network: its keys must agree.
#[derive(Debug, Clone, Copy)]
pub struct Identity<'a> {
    /// The site.
    pub site: &'a str,
    /// The node's name.
    pub name: &'a str,
    /// Roles that can do its work.
    pub roles: &'a [Role],
}

/// A profile with the keys that it needs, read and checked.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Security {
    profile: Profile,
    keys: Option<NodeKeys>,
}

impl SecurityOptions {
    /// Reads the keys; `folder` is that of the configuration file.
    ///
    /// # Errors
    /// Keys that are missing, unreadable, readable for others, or of another node.
    pub(crate) fn load_keys(
        &self,
        folder: &Path,
        identity: Identity<'_>,
    ) -> Result<Security, SecurityError> {
        let keys = self.read(folder)?;
        if let Some(keys) = &keys {
            keys.check_identity(identity)?;
        }
        let profile = self.profile;
        Ok(Security { profile, keys })
    }

    fn read(&self, folder: &Path) -> Result<Option<NodeKeys>, SecurityError> {
        match (self.profile, &self.keys) {
            (Profile::Demo | Profile::Open, None) => Ok(None),
            (Profile::Demo | Profile::Open, Some(_)) => Err(SecurityError::KeysWithoutUse {
                profile: self.profile.name(),
            }),
            (Profile::Lab | Profile::Site, None) => Err(SecurityError::NoKeys {
                profile: self.profile.name(),
            }),
            (Profile::Lab | Profile::Site, Some(keys)) => {
                NodeKeys::read(&folder.join(keys)).map(Some)
            }
        }
    }
}

impl Security {
    /// No protection: [`Profile::Demo`], or [`Profile::Open`] where other machines take part.
    pub fn none(profile: Profile) -> Self {
        Self {
            profile,
            keys: None,
        }
    }

    /// For a program that only connects: the profile that goes with the endpoint, and these keys.
    ///
    /// # Errors
    /// As [`SecurityOptions::load`].
    pub fn of_client(
        endpoint: &str,
        keys: Option<&Path>,
        site: &str,
    ) -> Result<Self, SecurityError> {
        let keys = keys.map(NodeKeys::read).transpose()?;
        if let Some(keys) = &keys {
            keys.check_site(site)?;
        }
        let profile = match (&keys, endpoint.starts_with("quic/")) {
            (None, false) => Profile::Demo,
            (Some(_), false) => Profile::Lab,
            (Some(_), true) => Profile::Site,
            (None, true) => return Err(SecurityError::NoKeys { profile: "site" }),
        };
        Ok(Self { profile, keys })
    }

    /// The profile in force: who may connect, and how.
    pub fn profile(&self) -> Profile {
        self.profile
    }

    /// The keys, if the profile needs any.
    pub fn keys(&self) -> Option<&NodeKeys> {
        self.keys.as_ref()
    }

    /// The role on the network; `None` for profiles without roles.
    pub fn role(&self) -> Option<Role> {
        self.keys.as_ref().map(|keys| keys.member.role)
    }

    /// Whether a router whose clock shows `now_s`, seconds since the Unix epoch, refuses the certificate.
    pub fn has_expired(&self, now_s: u64) -> bool {
        let keys = self.keys.as_ref();
        self.profile == Profile::Site && keys.is_some_and(|keys| keys.member.valid_until_s <= now_s)
    }

    /// What a person should know about the certificate at `now_s`, seconds since the Unix epoch.
    pub fn warning(&self, now_s: u64) -> Option<String> {
        match (self.profile, &self.keys) {
            (Profile::Site, Some(keys)) => keys.warning(now_s),
            _ => None,
        }
    }
}
