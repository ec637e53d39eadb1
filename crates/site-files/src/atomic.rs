//! A file that is at every moment, also after a power cut, either the old one or the new one.

use crate::error::FileError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file whole or not at all: a temporary one beside it, flushed to the disk, then renamed over it. A symbolic link
/// stays one, and the permissions of an existing file stay.
///
/// # Errors
/// What the system refuses; the old file is then untouched and the temporary one gone.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<(), FileError> {
    let unwritable = |source| FileError::Unwritable {
        path: path.to_owned(),
        source,
    };
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let temporary = beside(&target).map_err(unwritable)?;
    let written = replace(&temporary, &target, content);
    if written.is_err() {
        // Best effort: the error that matters is the first one.
        let _ = fs::remove_file(&temporary);
    }
    written.map_err(unwritable)
}

/// Writes a file as [`write_atomically`] does and keeps the former one beside it, as `rig.toml.former`. A file that says the
/// same already stays as it is, and so does what was kept before.
///
/// # Errors
/// As [`write_atomically`]; the old file is then untouched.
pub fn write_keeping_former(path: &Path, content: &[u8]) -> Result<(), FileError> {
    match fs::read(path) {
        Ok(former) if former == content => return Ok(()),
        Ok(former) => write_atomically(&former_of(path), &former)?,
        // Nothing to keep, or nothing that can be read: writing says which.
        Err(_) => {}
    }
    write_atomically(path, content)
}

/// Where the former content of a file is kept.
pub fn former_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".former");
    name.into()
}

fn replace(temporary: &Path, target: &Path, content: &[u8]) -> io::Result<()> {
    if target.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(temporary)?;
    if let Ok(old) = fs::metadata(target) {
        file.set_permissions(old.permissions())?;
    }
    file.write_all(content)?;
    file.sync_all()?;
    fs::rename(temporary, target)?;
    File::open(folder_of(target))?.sync_all()
}

/// A name in the same folder that no other process uses.
fn beside(target: &Path) -> io::Result<PathBuf> {
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::from(io::ErrorKind::IsADirectory))?;
    let temporary = format!(".{}.{}.tmp", name.to_string_lossy(), std::process::id());
    Ok(folder_of(target).join(temporary))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn the_new_file_replaces_the_old_one_and_leaves_nothing_beside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        write_atomically(&path, b"old").unwrap();
        write_atomically(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names_in(folder.path()), ["rig.toml"]);
    }

    #[test]
    fn the_former_content_is_kept_until_another_takes_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        let former = || fs::read(former_of(&path)).ok();
        write_keeping_former(&path, b"first").unwrap();
        assert_eq!(former(), None);
        write_keeping_former(&path, b"second").unwrap();
        assert_eq!(former().unwrap(), b"first");
        write_keeping_former(&path, b"second").unwrap();
        assert_eq!(former().unwrap(), b"first");
        assert_eq!(names_in(folder.path()), ["rig.toml", "rig.toml.former"]);
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_atomically(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&real).unwrap(), b"new");
    }

    #[test]
    fn what_cannot_be_written_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let inside = folder.path().join("missing/rig.toml");
        assert!(matches!(
            write_atomically(&inside, b"x"),
            Err(FileError::Unwritable { .. })
        ));
        assert!(write_atomically(folder.path(), b"x").is_err());
        assert!(names_in(folder.path()).is_empty());
    }
}
