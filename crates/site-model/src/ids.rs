//! The names of cameras, objects, links and joints: 1 to 32 characters of `[a-z0-9_-]`, cheap to clone, ordered.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sextant_tag_families::Family;
use thiserror::Error;

/// Identity of a tag: its family and its id in the family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct TagId {
    /// The family of code words.
    pub family: Family,
    /// The number of the code word.
    pub id: u32,
}

impl fmt::Display for TagId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.family, self.id)
    }
}

/// The longest name in bytes.
const LONGEST: usize = 32;

/// Why a text is not a valid name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum IdError {
    /// The text is empty or has more than 32 characters.
    #[error("a name has 1 to {LONGEST} characters, this one has {0}")]
    Length(usize),
    /// A character outside of `[a-z0-9_-]`.
    #[error("a name is made of a-z, 0-9, _ and -, not {0:?}")]
    Character(char),
}

fn check(text: &str) -> Result<(), IdError> {
    let allowed = |c: &char| matches!(c, 'a'..='z' | '0'..='9' | '_' | '-');
    if let Some(foreign) = text.chars().find(|c| !allowed(c)) {
        return Err(IdError::Character(foreign));
    }
    match text.len() {
        1..=LONGEST => Ok(()),
        length => Err(IdError::Length(length)),
    }
}

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "String")]
        pub struct $name(Arc<str>);

        impl $name {
            /// Checks a name.
            ///
            /// # Errors
            /// When the text is empty, longer than 32 characters or has others than `[a-z0-9_-]`.
            pub fn new(text: &str) -> Result<Self, IdError> {
                check(text).map(|()| Self(text.into()))
            }

            /// The name as text.
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl FromStr for $name {
            type Err = IdError;

            fn from_str(text: &str) -> Result<Self, IdError> {
                Self::new(text)
            }
        }

        impl TryFrom<String> for $name {
            type Error = IdError;

            fn try_from(text: String) -> Result<Self, IdError> {
                Self::new(&text)
            }
        }

        impl From<$name> for String {
            fn from(id: $name) -> Self {
                id.0.as_ref().into()
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&self.0)
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{:?}", &*self.0)
            }
        }
    };
}

id! {
    /// The name of a camera.
    CameraId
}

id! {
    /// The name of an object.
    ObjectId
}

id! {
    /// The name of a link of an articulated object.
    LinkId
}

id! {
    /// The name of a joint between two links.
    JointId
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short_and_plain() {
        assert_eq!(CameraId::new("north-1_a").unwrap().to_string(), "north-1_a");
        assert_eq!(CameraId::new(""), Err(IdError::Length(0)));
        assert_eq!(ObjectId::new(&"a".repeat(33)), Err(IdError::Length(33)));
        assert!(ObjectId::new(&"a".repeat(32)).is_ok());
        for foreign in ["North", "a/b", "a b", "a*", "ü", "@"] {
            assert!(
                matches!(foreign.parse::<ObjectId>(), Err(IdError::Character(_))),
                "{foreign}"
            );
        }
    }
}
