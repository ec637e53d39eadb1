//! Atomic writing: a file is the old one or the new one at every moment, also after a power cut.

use crate::error::FileError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file atomically: writes a temporary file beside it, flushes it to disk, and renames it. A symbolic link remains a link, and
/// the permissions of an existing file are kept.
///
/// # Errors
/// An I/O error; the old file is then unchanged and the temporary one removed.
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

/// Former versions of a file that are kept beside it; older ones are removed.
pub const FORMER_VERSIONS: usize = 9;

/// Writes a file as [`write_atomically`] does and keeps the former versions beside it, as [`former_of`] and
/// [`former_version`] name them. A file that says the same already stays as it is, and so do its former versions.
///
/// # Errors
/// As [`write_atomically`], and for a file that cannot be read; the old file is then untouched.
pub fn write_keeping_former(path: &Path, content: &[u8]) -> Result<(), FileError> {
    let unwritable = |source| FileError::Unwritable {
        path: path.to_owned(),
        source,
    };
    match fs::read(path) {
        Ok(former) if former == content => return Ok(()),
        Ok(former) => {
            make_room_for_former(path).map_err(unwritable)?;
            write_atomically(&former_of(path), &former)?;
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => return Err(unwritable(error)),
    }
    write_atomically(path, content)
}

/// Removes a file, which becomes its newest former version.
///
/// # Errors
/// An I/O error.
pub fn retire(path: &Path) -> Result<(), FileError> {
    let retired = make_room_for_former(path).and_then(|()| fs::rename(path, former_of(path)));
    retired.map_err(|source| FileError::Unwritable {
        path: path.to_owned(),
        source,
    })
}

/// Path of the newest former version of a file: `rig.toml.former`.
pub fn former_of(path: &Path) -> PathBuf {
    former_version(path, 1)
}

/// Path of a former version, 1 being the newest: `rig.toml.former`, `rig.toml.former.2`, up to [`FORMER_VERSIONS`].
pub fn former_version(path: &Path, number: usize) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".former");
    if number > 1 {
        name.push(format!(".{number}"));
    }
    name.into()
}

/// Renumbers the former versions to make room for the newest; the oldest is overwritten.
fn make_room_for_former(path: &Path) -> io::Result<()> {
    for number in (1..FORMER_VERSIONS).rev() {
        let (newer, older) = (
            former_version(path, number),
            former_version(path, number + 1),
        );
        match fs::rename(newer, older) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
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
    fn former_versions_are_numbered_from_the_newest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        for content in ["first", "second", "second", "third"] {
            write_keeping_former(&path, content.as_bytes()).unwrap();
        }
        let former = |number| fs::read(former_version(&path, number)).unwrap();
        assert_eq!(
            [former(1), former(2)],
            [b"second".to_vec(), b"first".to_vec()]
        );
        retire(&path).unwrap();
        let names = ["rig.toml.former", "rig.toml.former.2", "rig.toml.former.3"];
        assert_eq!(names_in(folder.path()), names);
        assert_eq!(
            [former(1), former(3)],
            [b"third".to_vec(), b"first".to_vec()]
        );
    }

    #[test]
    fn ten_times_as_many_versions_as_are_kept_leave_the_newest() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        let n = 10 * FORMER_VERSIONS;
        for version in 0..=n {
            write_keeping_former(&path, version.to_string().as_bytes()).unwrap();
        }
        assert_eq!(names_in(folder.path()).len(), 1 + FORMER_VERSIONS);
        for number in 1..=FORMER_VERSIONS {
            let former = fs::read_to_string(former_version(&path, number)).unwrap();
            assert_eq!(former, (n - number).to_string());
        }
    }

    #[test]
    fn what_cannot_be_read_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        // A link to itself: reading fails, and not because nothing is there.
        std::os::unix::fs::symlink(&path, &path).unwrap();
        assert!(write_keeping_former(&path, b"new").is_err());
        assert!(fs::symlink_metadata(&path).unwrap().is_symlink());
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
