//! Atomic writing: a file is the old one or the new one at every moment, also after a power cut.

use crate::error::FileError;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

/// Writes a file atomically: writes a temporary file beside it, flushes it to disk, and renames it. A symbolic link
/// remains a link, and the permissions of an existing file are kept.
///
/// # Errors
/// An I/O error; the old file is then unchanged and the temporary one removed.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<(), FileError> {
    let written = written(path, content).and_then(Replacement::commit);
    written.map_err(|source| FileError::Unwritable {
        path: path.to_owned(),
        source,
    })?;
    Ok(())
}

/// A new file beside the one that it is to replace, `.NAME.tmp`. It is locked: of two processes that replace one file
/// the second waits for two seconds at most, and a file that one left behind is removed by the next. Dropped without
/// [`Self::commit`], it is removed.
#[derive(Debug)]
pub struct Replacement {
    /// Nothing once it was committed.
    file: Option<File>,
    temporary: PathBuf,
    target: PathBuf,
}

impl Replacement {
    /// Creates the new file, with the permissions of the old one.
    ///
    /// # Errors
    /// An I/O error, as for a folder in place of the file; [`io::ErrorKind::WouldBlock`] where another process goes on
    /// writing.
    pub fn begin(path: &Path) -> io::Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if target.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        let temporary = beside(&target)?;
        let file = locked(&temporary)?;
        let replacement = Self {
            file: Some(file),
            temporary,
            target,
        };
        if let Ok(old) = fs::metadata(&replacement.target) {
            replacement.file().set_permissions(old.permissions())?;
        }
        Ok(replacement)
    }

    /// The new file, to be written.
    pub fn file(&self) -> &File {
        // Only `commit` takes it, together with the whole.
        self.file.as_ref().unwrap_or_else(|| unreachable!())
    }

    /// Puts the new file in the place of the old one; both are on disk afterwards. Returns it, still open and locked.
    ///
    /// # Errors
    /// An I/O error; the old file is then unchanged.
    pub fn commit(mut self) -> io::Result<File> {
        self.file().sync_all()?;
        fs::rename(&self.temporary, &self.target)?;
        let file = self.file.take().unwrap_or_else(|| unreachable!());
        File::open(folder_of(&self.target))?.sync_all()?;
        Ok(file)
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        if self.file.is_some() {
            // Best effort: the next one removes it as well.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

/// A new file that no other process takes for a leftover, since this one holds its lock.
fn locked(temporary: &Path) -> io::Result<File> {
    loop {
        let created = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(temporary);
        match created {
            Ok(file) => {
                // Some file systems have no locks.
                let is_ours = !matches!(file.try_lock(), Err(TryLockError::WouldBlock));
                if is_ours && is_at(&file, temporary) {
                    return Ok(file);
                }
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                remove_leftover(temporary)?;
            }
            Err(error) => return Err(error),
        }
    }
}

/// How often a lock is tried, and the time between.
const TRIES: u32 = 200;
const BETWEEN: Duration = Duration::from_millis(10);

/// Removes a temporary file after its writer has released its lock.
fn remove_leftover(temporary: &Path) -> io::Result<()> {
    match fs::symlink_metadata(temporary) {
        Ok(found) if !found.is_file() => return Err(io::ErrorKind::AlreadyExists.into()),
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let file = match File::open(temporary) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
    };
    for _ in 0..TRIES {
        let is_written = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
        match (is_at(&file, temporary), is_written) {
            (false, _) => return Ok(()),
            (true, false) => return fs::remove_file(temporary),
            (true, true) => thread::sleep(BETWEEN),
        }
    }
    let cause = "another program is writing this file; end it, or choose another name";
    Err(io::Error::new(io::ErrorKind::WouldBlock, cause))
}

/// Whether a path leads to an open file, and not to another one meanwhile.
fn is_at(file: &File, path: &Path) -> bool {
    let identity = |found: fs::Metadata| (found.dev(), found.ino());
    let found = fs::symlink_metadata(path).map(identity);
    let opened = file.metadata().map(identity);
    matches!((found, opened), (Ok(found), Ok(opened)) if found == opened)
}

fn written(path: &Path, content: &[u8]) -> io::Result<Replacement> {
    let replacement = Replacement::begin(path)?;
    replacement.file().write_all(content)?;
    replacement.file().sync_all()?;
    Ok(replacement)
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
    let former = match fs::read(path) {
        Ok(former) if former == content => return Ok(()),
        Ok(former) => former,
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            return write_atomically(path, content);
        }
        Err(error) => return Err(unwritable(error)),
    };
    replace_keeping(path, content, &former).map_err(unwritable)
}

/// Whatever needs room on the disk is written before anything is renamed: a full disk must not cost former versions.
fn replace_keeping(path: &Path, content: &[u8], former: &[u8]) -> io::Result<()> {
    let new = written(path, content)?;
    let kept = written(&former_of(path), former)?;
    make_room_for_former(path)?;
    kept.commit()?;
    new.commit()?;
    Ok(())
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

/// The name of the temporary file, in the same folder.
fn beside(target: &Path) -> io::Result<PathBuf> {
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::from(io::ErrorKind::IsADirectory))?;
    let temporary = format!(".{}.tmp", name.to_string_lossy());
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
    fn what_cannot_be_written_costs_no_former_version() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        for content in ["first", "second", "third"] {
            write_keeping_former(&path, content.as_bytes()).unwrap();
        }
        let before = names_in(folder.path());
        // In the way of the new file, and then in the way of the former one.
        for name in [".rig.toml.tmp", ".rig.toml.former.tmp"] {
            let in_the_way = folder.path().join(name);
            fs::create_dir(&in_the_way).unwrap();
            for _ in 0..FORMER_VERSIONS {
                assert!(write_keeping_former(&path, b"fourth").is_err());
            }
            fs::remove_dir(&in_the_way).unwrap();
            assert_eq!(names_in(folder.path()), before);
            let former = |number| fs::read(former_version(&path, number)).unwrap();
            assert_eq!(
                [former(1), former(2)],
                [b"second".to_vec(), b"first".to_vec()]
            );
            assert_eq!(fs::read(&path).unwrap(), b"third");
        }
    }

    #[test]
    fn a_leftover_is_removed_and_a_living_writer_awaited() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        fs::write(folder.path().join(".rig.toml.tmp"), "half a").unwrap();
        write_atomically(&path, b"whole").unwrap();
        assert_eq!(names_in(folder.path()), ["rig.toml"]);
        let first = written(&path, b"first").unwrap();
        let second = thread::scope(|scope| {
            let second = scope.spawn(|| write_atomically(&path, b"second"));
            first.commit().unwrap();
            second.join().unwrap()
        });
        second.unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        drop(written(&path, b"never").unwrap());
        assert_eq!(names_in(folder.path()), ["rig.toml"]);
    }

    #[test]
    fn a_writer_that_goes_on_is_named_rather_than_awaited() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.jsonl");
        let first = written(&path, b"first").unwrap();
        let error = write_atomically(&path, b"second").unwrap_err().to_string();
        assert!(
            error.contains("another program is writing this file; end it"),
            "{error}"
        );
        // Once it has replaced the file it blocks no other writer, although it still holds its lock.
        let _file = first.commit().unwrap();
        write_atomically(&path, b"third").unwrap();
    }

    #[test]
    fn many_writers_at_once_leave_one_whole_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        let content = |writer: u8| vec![b'a' + writer; 10_000];
        thread::scope(|scope| {
            for writer in 0..8 {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..10 {
                        write_atomically(path, &content(writer)).unwrap();
                    }
                });
            }
        });
        let written = fs::read(&path).unwrap();
        assert!((0..8).any(|writer| written == content(writer)));
        assert_eq!(names_in(folder.path()), ["rig.toml"]);
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
