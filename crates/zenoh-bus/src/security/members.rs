//! Members of a site and their roles: the list that the authority keeps and each router enforces.

use std::fmt;

use serde::{Deserialize, Serialize};
use sextant_proto::{NodeId, SiteId};

/// Permissions of a member.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Publishes below its own camera's key and reads the site's configuration.
    Camera,
    /// Publishes poses and configuration, reads everything; can be the router.
    Fusion,
    /// Is a router apart from the fusion nodes. Passes on what the members behind it may publish and read, which it
    /// enforces itself.
    Router,
    /// Reads everything.
    Viewer,
    /// Reads everything and changes the rig and the objects.
    Operator,
    /// A browser, by the page of a viewer or operator, which publishes as this camera.
    Phone,
}

impl Role {
    /// Every role.
    pub const ALL: [Self; 6] = [
        Self::Camera,
        Self::Fusion,
        Self::Router,
        Self::Viewer,
        Self::Operator,
        Self::Phone,
    ];

    /// Whether such a member may listen: it has the list of members and a certificate for servers.
    pub fn can_be_router(self) -> bool {
        matches!(self, Self::Fusion | Self::Router)
    }

    /// Whether such a member serves a page.
    pub fn has_page(self) -> bool {
        matches!(self, Self::Viewer | Self::Operator)
    }

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Fusion => "fusion",
            Self::Router => "router",
            Self::Viewer => "viewer",
            Self::Operator => "operator",
            Self::Phone => "phone",
        }
    }
}

impl fmt::Display for Role {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// A member of a site.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Member {
    /// The camera's id, or the node's name.
    pub name: NodeId,
    /// Its role.
    pub role: Role,
    /// Common name of its certificate, `<name>.<number>`, and its user name. A name that is added again after a
    /// revocation gets the next number, so that its former keys stay revoked.
    pub common_name: String,
    /// End of its certificate's validity, seconds since the Unix epoch.
    pub valid_until_s: u64,
    /// Whether its keys have been revoked.
    #[serde(default, skip_serializing_if = "is_false")]
    pub revoked: bool,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde's signature")]
fn is_false(value: &bool) -> bool {
    !value
}

/// The members of a site: `members.toml`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Members {
    /// The site.
    pub site: SiteId,
    /// End of the authority's validity, seconds since the Unix epoch.
    pub authority_valid_until_s: u64,
    /// All members, including revoked ones, in the order in which they were added.
    #[serde(default, rename = "member")]
    pub members: Vec<Member>,
}

impl Members {
    /// Members whose keys are accepted.
    pub fn accepted(&self) -> impl Iterator<Item = &Member> {
        self.members.iter().filter(|member| !member.revoked)
    }

    /// The text of `members.toml`.
    ///
    /// # Errors
    /// Values that TOML cannot represent.
    pub fn to_toml(&self) -> Result<String, String> {
        toml::to_string(self).map_err(|cause| cause.to_string())
    }

    /// The member of this name whose keys are accepted.
    pub fn find(&self, name: &str) -> Option<&Member> {
        self.accepted().find(|member| member.name.as_str() == name)
    }
}
