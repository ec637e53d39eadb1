//! Strict reading and writing of TOML files with any serde type.

use crate::atomic::write_atomically;
use crate::document::Document;
use crate::error::{Complaint, FileError};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::Path;

/// The text of a file.
///
/// # Errors
/// A file that is missing, unreadable or not UTF-8.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    fs::read_to_string(path).map_err(|source| FileError::Unreadable {
        path: path.to_owned(),
        source,
        remedy: "check the path",
    })
}

/// A configuration file. Give `T` and its parts `#[serde(deny_unknown_fields)]`: then an unknown key is refused with the
/// nearest known one as a hint.
///
/// # Errors
/// A file that is missing, malformed, or not a valid `T`.
pub fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T, FileError> {
    read_toml_checked(path, |_| Ok(()))
}

/// Like [`read_toml`], with further checks: a [`Complaint`] about a key gets that key's line and column.
///
/// # Errors
/// As [`read_toml`], and errors of `check`.
pub fn read_toml_checked<T: DeserializeOwned>(
    path: &Path,
    check: impl FnOnce(&T) -> Result<(), Complaint>,
) -> Result<T, FileError> {
    parse_toml(path, &read_text(path)?, check)
}

/// Like [`read_toml_checked`], for a text; `path` is for messages.
///
/// # Errors
/// As [`read_toml_checked`].
pub fn parse_toml<T: DeserializeOwned>(
    path: &Path,
    text: &str,
    check: impl FnOnce(&T) -> Result<(), Complaint>,
) -> Result<T, FileError> {
    let document = Document::parse(path, text)?;
    let value = document.read()?;
    check(&value).map_err(|complaint| document.complaint(complaint))?;
    Ok(value)
}

/// Writes a configuration file atomically.
///
/// # Errors
/// A value that TOML cannot represent, or an error of the system; the old file is then unchanged.
pub fn write_toml<T: Serialize>(path: &Path, value: &T) -> Result<(), FileError> {
    let text = toml::to_string(value).map_err(|error| FileError::Unwritable {
        path: path.to_owned(),
        source: std::io::Error::other(error),
    })?;
    write_atomically(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Config {
        site: String,
        #[serde(default)]
        network: Network,
    }

    #[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct Network {
        connect: Vec<String>,
        port: u16,
    }

    fn complaint_about(text: &str) -> String {
        parse_toml::<Config>(Path::new("f.toml"), text, |_| Ok(()))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn a_good_file_is_read() {
        let text = "site = \"a\"\nnetwork = { port = 7447 }\n";
        let config: Config = parse_toml(Path::new("f.toml"), text, |_| Ok(())).unwrap();
        let network = Network {
            connect: vec![],
            port: 7447,
        };
        let expected = Config {
            site: "a".into(),
            network,
        };
        assert_eq!(config, expected);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let config = Config {
            site: "a \"b\"".into(),
            network: Network {
                connect: vec!["tcp/127.0.0.1:7447".into()],
                port: 5,
            },
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config.toml");
        write_toml(&path, &config).unwrap();
        assert_eq!(read_toml::<Config>(&path).unwrap(), config);
    }

    #[test]
    fn an_unknown_key_is_refused_with_its_place_and_the_nearest_known_one() {
        assert_eq!(
            complaint_about("site = \"a\"\n[network]\nconect = []\n"),
            "f.toml:3:1: network.conect: unknown field `conect`, expected `connect` or `port`; did you mean `connect`?"
        );
        assert_eq!(
            complaint_about("site = \"a\"\nsites = 3\n"),
            "f.toml:2:1: sites: unknown field `sites`, expected `site` or `network`; did you mean `site`?"
        );
    }

    #[test]
    fn a_value_of_the_wrong_type_is_refused_with_its_place() {
        let message = complaint_about("site = \"a\"\nnetwork = { port = 99999 }\n");
        assert!(
            message.starts_with("f.toml:2:20: network.port: invalid value: integer `99999`"),
            "{message}"
        );
        let message = complaint_about("site = 7\n");
        assert!(
            message.starts_with("f.toml:1:8: site: invalid type"),
            "{message}"
        );
    }

    #[test]
    fn a_missing_key_is_named() {
        let message = complaint_about("[network]\nport = 1\n");
        assert!(
            message.ends_with("missing field `site`; add `site = ...`"),
            "{message}"
        );
    }

    #[test]
    fn malformed_text_is_refused_with_its_place() {
        let message = complaint_about("site = \"a\"\n[network\n");
        assert!(
            message.starts_with("f.toml:2:9: malformed TOML: "),
            "{message}"
        );
        assert!(!message.contains('\n'));
    }

    #[test]
    fn a_rule_of_the_caller_gets_its_place_too() {
        let text = "site = \"a\"\n[network]\nport = 0\n";
        let rule = |_: &Config| Err(Complaint::new("network.port", "port 0", "give another"));
        let error = parse_toml(Path::new("f.toml"), text, rule).unwrap_err();
        assert_eq!(
            error.to_string(),
            "f.toml:3:8: network.port: port 0; give another"
        );
    }

    #[test]
    fn a_missing_file_is_said_so() {
        let error = read_toml::<Config>(Path::new("/nowhere/f.toml")).unwrap_err();
        assert_eq!(
            error.to_string(),
            "/nowhere/f.toml: there is no such file or folder; check the path"
        );
    }
}
