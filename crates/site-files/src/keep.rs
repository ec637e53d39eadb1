//! Automatic saving: a file is replaced only by another version of the same rig or object.
//!
//! Former versions stay beside it, as [`crate::write_keeping_former`] keeps them.

use crate::atomic::{retire, write_keeping_former};
use crate::error::FileError;
use crate::foreign::is_foreign;
use crate::object::{object_toml, read_object};
use crate::read::read_text;
use crate::rig::{parse_rig, rig_toml};
use sextant_site_model::{ObjectId, ObjectModel, Rig};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Path of a new object, relative to the folder of the site: `objects/<id>.toml`. That folder has no other files of a
/// site, whatever the id of the object.
pub fn object_file(id: &ObjectId) -> PathBuf {
    format!("objects/{id}.toml").into()
}

/// Writes a rig file, unless another kind of file is there.
///
/// # Errors
/// [`FileError::Occupied`], or an I/O error; the old file is then unchanged.
pub fn keep_rig(path: &Path, rig: &Rig) -> Result<(), FileError> {
    if exists(path)? {
        let text = read_text(path).map_err(|error| error.to_string());
        let is_rig = text.and_then(|text| match is_foreign(path, &text) {
            true => Err("another program's file".to_owned()),
            false => parse_rig(path, &text).map_err(|error| error.to_string()),
        });
        is_rig.map_err(|cause| occupied(path, "the rig".to_owned(), cause))?;
    }
    write_keeping_former(path, rig_toml(rig).as_bytes())
}

/// Writes an object file, unless another kind of file or object is there; creates its folder if it is missing.
///
/// # Errors
/// [`FileError::Occupied`], or an I/O error; the old file is then unchanged.
pub fn keep_object(path: &Path, object: &ObjectModel) -> Result<(), FileError> {
    if exists(path)? {
        check_object(path, object.id())?;
    } else if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(|source| unwritable(path, source))?;
    }
    write_keeping_former(path, object_toml(object).as_bytes())
}

/// Removes an object file and keeps it as the newest former version. Other files are left alone.
///
/// # Errors
/// An I/O error.
pub fn retire_object(path: &Path, id: &ObjectId) -> Result<(), FileError> {
    if !exists(path)? || check_object(path, id).is_err() {
        return Ok(());
    }
    retire(path)
}

fn check_object(path: &Path, id: &ObjectId) -> Result<(), FileError> {
    let cause = match read_object(path) {
        Ok(object) if object.id() == id => return Ok(()),
        Ok(other) => format!("it describes object {}", other.id()),
        Err(error) => error.to_string(),
    };
    Err(occupied(path, format!("object {id}"), cause))
}

/// Whether the path exists, also as a dangling link.
fn exists(path: &Path) -> Result<bool, FileError> {
    match fs::symlink_metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(unwritable(path, error)),
    }
}

fn occupied(path: &Path, expected: String, cause: String) -> FileError {
    FileError::Occupied {
        path: path.to_owned(),
        expected,
        cause,
    }
}

fn unwritable(path: &Path, source: io::Error) -> FileError {
    FileError::Unwritable {
        path: path.to_owned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atomic::former_of;
    use crate::object::parse_object;

    const RIG: &str = "[[camera]]\nid = \"north\"\nresolution = [640, 480]\n\
        lens = { model = \"pinhole\", fx = 600.0, fy = 600.0, cx = 319.5, cy = 239.5 }\n";

    fn object(id: &str, tag: u32) -> ObjectModel {
        let text =
            format!("id = \"{id}\"\n[[tag]]\nfamily = \"tag36h11\"\nid = {tag}\nsize = 0.04\n");
        parse_object(Path::new("o"), &text).unwrap()
    }

    #[test]
    fn an_object_replaces_its_own_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(object_file(object("cube", 1).id()));
        keep_object(&path, &object("cube", 1)).unwrap();
        keep_object(&path, &object("cube", 2)).unwrap();
        assert_eq!(read_object(&path).unwrap(), object("cube", 2));
        assert_eq!(read_object(&former_of(&path)).unwrap(), object("cube", 1));
        for (content, cause) in [
            (object_toml(&object("box", 1)), "it describes object box"),
            ("site = \"lab\"\n".to_owned(), "unknown field `site`"),
            (String::new(), "id"),
        ] {
            fs::write(&path, &content).unwrap();
            let error = keep_object(&path, &object("cube", 3)).unwrap_err();
            assert!(matches!(error, FileError::Occupied { .. }), "{error}");
            assert!(error.to_string().contains(cause), "{error}");
            retire_object(&path, object("cube", 3).id()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
    }

    #[test]
    fn a_link_to_nowhere_is_no_free_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cube.toml");
        std::os::unix::fs::symlink(folder.path().join("elsewhere"), &path).unwrap();
        assert!(keep_object(&path, &object("cube", 1)).is_err());
        assert!(!folder.path().join("elsewhere").exists());
    }

    #[test]
    fn a_rig_replaces_a_rig_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let rig = parse_rig(Path::new("r"), RIG).unwrap();
        let path = folder.path().join("rig.toml");
        keep_rig(&path, &rig).unwrap();
        keep_rig(&path, &rig).unwrap();
        for (name, content) in [
            ("viewer.toml", "site = \"lab\"\n"),
            ("camchain.yaml", "cam0:\n"),
        ] {
            let path = folder.path().join(name);
            fs::write(&path, content).unwrap();
            assert!(keep_rig(&path, &rig).is_err(), "{name}");
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
    }
}
