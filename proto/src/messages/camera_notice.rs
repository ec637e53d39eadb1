//! What is wrong with a camera node, its images or what the site tells it.

use crate::check::{self, OutOfRange};
use serde::{Deserialize, Serialize};
use sextant_site_report::Severity;
use std::fmt;

/// Something about a camera node that a person should know; shown while it holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraNotice {
    /// No image has come from the capturing part.
    NoImage {
        /// For how long, s.
        silent_s: f64,
    },
    /// Other nodes with this camera's name run; this is one of them.
    NameTaken {
        /// The machine that it runs on.
        host: String,
    },
    /// An image could not be used, or its message not be published; shown until the node ends.
    ImageRefused {
        /// Cause of the last one, English text.
        detail: String,
    },
    /// The rig has no camera of this name: tags have no poses.
    NotInRig,
    /// A rig or object of the site cannot be used; shown until a usable one comes.
    ModelRefused {
        /// The key below the site.
        key: String,
        /// What is wrong with it, English text.
        detail: String,
    },
    /// The site has more objects or tags than the node keeps sizes of: tags of this object have no poses.
    TooManyTags {
        /// The key below the site.
        key: String,
    },
}

impl fmt::Display for CameraNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoImage { silent_s } => {
                write!(
                    f,
                    "no image from the capturing part for {silent_s:.0} s: see its log"
                )
            }
            Self::NameTaken { host } => write!(
                f,
                "a camera of this name also runs on {host}: stop one of them"
            ),
            Self::ImageRefused { detail } => write!(f, "an image was refused: {detail}"),
            Self::NotInRig => write!(f, "the rig has no camera of this name: add it to the rig"),
            Self::ModelRefused { key, detail } => write!(f, "{key} cannot be used: {detail}"),
            Self::TooManyTags { key } => write!(
                f,
                "too many objects or tags: the tags of {key} have no poses in the observations; fusion needs none"
            ),
        }
    }
}

impl CameraNotice {
    /// Whether it calls for action.
    #[must_use]
    pub fn severity(&self) -> Severity {
        match self {
            Self::TooManyTags { .. } => Severity::Information,
            Self::NoImage { .. }
            | Self::NameTaken { .. }
            | Self::ImageRefused { .. }
            | Self::NotInRig
            | Self::ModelRefused { .. } => Severity::Fault,
        }
    }

    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        const FIELD: &str = "notices[]";
        match self {
            Self::NoImage { silent_s } => check::amount(*silent_s, FIELD),
            Self::NameTaken { host } => check::name(host, FIELD),
            Self::ImageRefused { detail } => check::detail(detail, FIELD),
            Self::NotInRig => Ok(()),
            Self::ModelRefused { key, detail } => {
                check::detail(key, FIELD)?;
                check::detail(detail, FIELD)
            }
            Self::TooManyTags { key } => check::detail(key, FIELD),
        }
    }
}
