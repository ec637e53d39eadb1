//! Names that ROS 2 takes: letters, digits and underscores, no digit in front, parts divided by slashes.

/// Why a text is no namespace.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is no ROS namespace: parts of A-Z, a-z, 0-9 and _, none of which begins with a digit, \
     divided by single slashes"
)]
pub struct NameError(String);

/// A namespace, absolute; the root is empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Namespace(String);

impl Namespace {
    /// As in a key of liveliness: `/sextant`, or `/` for the root.
    pub(crate) fn absolute(&self) -> &str {
        if self.0.is_empty() { "/" } else { &self.0 }
    }

    /// The topic of that name in this namespace.
    pub(crate) fn topic(&self, name: &str) -> String {
        format!("{}/{name}", self.0)
    }
}

impl std::str::FromStr for Namespace {
    type Err = NameError;

    /// With or without a slash in front.
    fn from_str(text: &str) -> Result<Self, NameError> {
        let relative = text.strip_prefix('/').unwrap_or(text);
        if relative.is_empty() {
            return Ok(Self(String::new()));
        }
        if relative.split('/').all(is_token) {
            Ok(Self(format!("/{relative}")))
        } else {
            Err(NameError(text.to_owned()))
        }
    }
}

/// The name of a camera, object or link as a part of a topic: `-` becomes `_`, and a digit in front gets one before it.
pub(crate) fn token(id: &str) -> String {
    let token = id.replace('-', "_");
    if token.starts_with(|first: char| first.is_ascii_digit()) {
        format!("_{token}")
    } else {
        token
    }
}

fn is_token(text: &str) -> bool {
    let mut characters = text.chars();
    let first = characters.next();
    first.is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && characters.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn namespaces_are_absolute() {
        for (text, absolute, topic) in [
            ("sextant", "/sextant", "/sextant/x"),
            ("/lab/west", "/lab/west", "/lab/west/x"),
            ("", "/", "/x"),
            ("/", "/", "/x"),
        ] {
            let namespace: Namespace = text.parse().unwrap();
            assert_eq!(namespace.absolute(), absolute);
            assert_eq!(namespace.topic("x"), topic);
        }
        for text in ["a//b", "a/", "1a", "a-b", "~", "a b", "//"] {
            assert!(text.parse::<Namespace>().is_err(), "{text}");
        }
    }

    #[test]
    fn ids_become_tokens() {
        assert_eq!(token("pad-2"), "pad_2");
        assert_eq!(token("2nd"), "_2nd");
        for id in ["pad-2", "2nd", "-", "cube"] {
            assert!(is_token(&token(id)), "{id}");
        }
    }
}
