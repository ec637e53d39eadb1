//! Names of sites and nodes: `[a-z0-9_-]`, 1 to 32 characters, so that they fit into keys, file names and shells
//! unquoted.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A text that is not an id.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not an id: use 1 to 32 of a-z, 0-9, `_` and `-`")]
pub struct IdError(
    /// The name, cut to 40 characters.
    pub String,
);

fn checked(text: &str) -> Result<String, IdError> {
    let fits = (1..=32).contains(&text.len())
        && text
            .bytes()
            .all(|b| matches!(b, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-'));
    if fits {
        Ok(text.to_owned())
    } else {
        Err(IdError(text.chars().take(40).collect()))
    }
}

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(try_from = "String", into = "String")]
        pub struct $name(String);

        impl $name {
            /// The id of that name, when it is one.
            ///
            /// # Errors
            /// Anything but 1 to 32 of `a-z`, `0-9`, `_` and `-`.
            pub fn new(name: &str) -> Result<Self, IdError> {
                checked(name).map(Self)
            }

            /// The name.
            #[must_use]
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str(&self.0)
            }
        }

        impl FromStr for $name {
            type Err = IdError;
            fn from_str(name: &str) -> Result<Self, IdError> {
                Self::new(name)
            }
        }

        impl TryFrom<String> for $name {
            type Error = IdError;
            fn try_from(name: String) -> Result<Self, IdError> {
                Self::new(&name)
            }
        }

        impl From<$name> for String {
            fn from(id: $name) -> Self {
                id.0
            }
        }
    };
}

id! {
    /// A process on the network that is neither a camera nor an object: a fusion node, a viewer bridge.
    NodeId
}
id! {
    /// A place with its own cameras and objects; everything of it lies under one key.
    SiteId
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_fits_into_a_key() {
        assert!(NodeId::new("fusion-2_b").is_ok());
        for wrong in ["", "A", "a/b", "*", "$", "a b", "ä", "@x"] {
            assert!(SiteId::new(wrong).is_err(), "{wrong}");
        }
        assert!(NodeId::new(&"x".repeat(32)).is_ok());
        assert!(NodeId::new(&"x".repeat(33)).is_err());
    }
}
