//! Strict reading and writing of TOML files with any serde type.

use crate::atomic::write_atomically;
use crate::document::Document;
use crate::error::{Complaint, FileError};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Longest text file that is read, bytes.
pub const MOST_TEXT_BYTES: u64 = 16 << 20;

/// The text of a file, without a byte order mark; also UTF-16, which redirections of PowerShell write.
///
/// # Errors
/// A file that is missing, unreadable, no text, or longer than 16 MiB.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    let unreadable = |source, remedy| FileError::Unreadable {
        path: path.to_owned(),
        source,
        remedy,
    };
    let remedy = "check the path";
    let file = File::open(path).map_err(|source| unreadable(source, remedy))?;
    let mut bytes = Vec::new();
    let read = file.take(MOST_TEXT_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|source| unreadable(source, remedy))?;
    if bytes.len() as u64 > MOST_TEXT_BYTES {
        let cause = format!(
            "more than {} MiB, too much for a text file of a site",
            MOST_TEXT_BYTES >> 20
        );
        return Err(unreadable(io::Error::other(cause), remedy));
    }
    if let Some((cause, remedy)) = known_other(&bytes) {
        return Err(unreadable(io::Error::other(cause), remedy));
    }
    decoded(bytes).map_err(|_| unreadable(io::ErrorKind::InvalidData.into(), remedy))
}

fn decoded(bytes: Vec<u8>) -> Result<String, Vec<u8>> {
    let utf_16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let (units, _) = bytes.as_chunks();
        String::from_utf16(&units.iter().map(|pair| unit(*pair)).collect::<Vec<_>>())
    };
    let text = match &bytes[..] {
        [0xff, 0xfe, rest @ ..] => utf_16(rest, u16::from_le_bytes).ok(),
        [0xfe, 0xff, rest @ ..] => utf_16(rest, u16::from_be_bytes).ok(),
        _ => None,
    };
    let text = match text {
        Some(text) => text,
        None => String::from_utf8(bytes).map_err(|error| error.into_bytes())?,
    };
    Ok(match text.strip_prefix('\u{feff}') {
        Some(text) => text.to_owned(),
        None => text,
    })
}

/// Formats of other tools that are not read: what they are, and what to give in their place.
fn known_other(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    const NUMPY: &str = "write it as YAML: cv2.FileStorage(\"lens.yaml\", cv2.FILE_STORAGE_WRITE)";
    let known: [(&[u8], _, _); 7] = [
        (
            b"MATLAB",
            "this is a binary file of MATLAB",
            "write it as JSON: fprintf(f, '%s', jsonencode(toStruct(cameraParameters)))",
        ),
        (b"\x93NUMPY", "this is a binary file of numpy", NUMPY),
        (
            b"PK\x03\x04",
            "this is an archive or a binary file of numpy",
            NUMPY,
        ),
        (
            b"\x89MCAP",
            "this is a recording, not a text file",
            "give a rig, an object or a configuration",
        ),
        (
            b"# oST version",
            "this is the ost.txt of ROS' calibrator",
            "give the ost.yaml beside it",
        ),
        (
            b"Calibration results",
            "this is a report of Kalibr",
            "give the ...camchain.yaml beside it",
        ),
        (
            b"# Camera list with one line of data per camera",
            "this is a cameras.txt of COLMAP",
            "make a transforms.json of it with nerfstudio (ns-process-data), or write its \
             numbers into a rig.toml; pixels there begin half a pixel earlier",
        ),
    ];
    let found = known
        .into_iter()
        .find(|(begin, ..)| bytes.starts_with(begin));
    found.map(|(_, cause, remedy)| (cause, remedy))
}

/// A configuration file. Give `T` and its parts `#[serde(deny_unknown_fields)]`: then an unknown key is refused with
/// the nearest known one as a hint.
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
        source: io::Error::other(error),
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
    fn a_text_is_read_without_its_byte_order_mark() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f.toml");
        let text = "site = \"ü\"\n";
        let little = "\u{feff}site = \"ü\"\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes);
        let big = "\u{feff}site = \"ü\"\n"
            .encode_utf16()
            .flat_map(u16::to_be_bytes);
        for bytes in [
            text.into(),
            format!("\u{feff}{text}").into_bytes(),
            little.collect(),
            big.collect(),
        ] {
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(read_text(&path).unwrap(), text);
        }
    }

    #[test]
    fn what_is_no_text_or_endless_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f.toml");
        let refused = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let error = read_text(&path).unwrap_err().to_string();
            error.replace(&path.display().to_string(), "f.toml")
        };
        assert!(refused(b"\xff\x00x").starts_with("f.toml: this is not UTF-8 text; check"));
        assert!(refused(b"MATLAB 5.0 MAT-file\xff").contains("jsonencode"));
        assert!(refused(b"\x93NUMPY\x01").contains("a binary file of numpy; write it as YAML"));
        let endless = read_text(Path::new("/dev/zero")).unwrap_err().to_string();
        assert_eq!(
            endless,
            "/dev/zero: more than 16 MiB, too much for a text file of a site; check the path"
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
