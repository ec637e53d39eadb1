//! Files that commands write line by line or message by message. An existing one is replaced only with `--force`, and
//! only once the new one has content; two programs never write one.

use anyhow::anyhow;
use sextant_process::{Exit, Failure};
use sextant_site_files::Replacement;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// A file that is being written.
pub struct OutputFile {
    file: File,
    /// Where it takes the place of another one, which is locked until then.
    replacement: Option<(Replacement, File)>,
}

impl OutputFile {
    /// Creates a file; devices and pipes are opened.
    ///
    /// # Errors
    /// [`Exit::Input`] for a file that exists without `force`, that another program writes, and for what the system
    /// refuses.
    pub fn create(path: &Path, force: bool) -> anyhow::Result<Self> {
        let refused =
            |cause: String| Failure::new(Exit::Input, anyhow!("{}: {cause}", path.display()));
        Self::open(path, force).map_err(|error| {
            let failure = match error.kind() {
                ErrorKind::AlreadyExists => {
                    "the file exists; choose another name, or replace it with --force".to_owned()
                }
                ErrorKind::WouldBlock => {
                    "another program is writing this file; end it, or choose another name"
                        .to_owned()
                }
                _ => format!("{error}; check the folder"),
            };
            refused(failure).into()
        })
    }

    fn open(path: &Path, force: bool) -> io::Result<Self> {
        let found = std::fs::metadata(path);
        let (file, replacement) = match found {
            Ok(found) if found.is_file() && force => {
                let former = File::open(path)?;
                lock(&former)?;
                let replacement = Replacement::begin(path)?;
                // Another program may have replaced it since it was opened.
                if former.metadata()?.ino() != std::fs::metadata(path)?.ino() {
                    return Err(ErrorKind::WouldBlock.into());
                }
                let file = replacement.file().try_clone()?;
                (file, Some((replacement, former)))
            }
            Ok(found) if !found.is_file() && !found.is_dir() => {
                (OpenOptions::new().write(true).open(path)?, None)
            }
            _ => {
                let mut options = OpenOptions::new();
                let file = options.write(true).create_new(true).open(path)?;
                lock(&file)?;
                (file, None)
            }
        };
        Ok(Self { file, replacement })
    }

    /// A handle for writing.
    ///
    /// # Errors
    /// When there is none to be had.
    pub fn writer(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Puts the file in the place of the former one, if it is not there yet. Call it after the first write.
    ///
    /// # Errors
    /// An I/O error; the former file is then unchanged.
    pub fn keep(&mut self) -> io::Result<()> {
        match self.replacement.take() {
            Some((replacement, _)) => replacement.commit().map(drop),
            None => Ok(()),
        }
    }
}

/// Locks a file; file systems without locks have none.
fn lock(file: &File) -> io::Result<()> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(ErrorKind::WouldBlock.into()),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::io::Write;

    fn refused(path: &Path, force: bool) -> String {
        OutputFile::create(path, force).err().unwrap().to_string()
    }

    #[test]
    fn a_file_is_replaced_only_when_forced_and_once_there_is_another() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old").unwrap();
        assert!(refused(&path, false).contains("replace it with --force"));
        let abandoned = OutputFile::create(&path, true).unwrap();
        abandoned.writer().unwrap().write_all(b"half").unwrap();
        drop(abandoned);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        let mut file = OutputFile::create(&path, true).unwrap();
        file.writer().unwrap().write_all(b"new").unwrap();
        file.keep().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        file.writer().unwrap().write_all(b" more").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new more");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn two_programs_do_not_write_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let first = OutputFile::create(&path, false).unwrap();
        assert!(refused(&path, true).contains("another program is writing this file"));
        drop(first);
        let mut second = OutputFile::create(&path, true).unwrap();
        // It has no content yet.
        assert!(refused(&path, true).contains("another program is writing this file"));
        second.keep().unwrap();
        assert!(refused(&path, true).contains("another program is writing this file"));
    }

    #[test]
    fn a_device_is_no_file_to_replace() {
        let null = Path::new("/dev/null");
        assert!(OutputFile::create(null, false).is_ok());
        assert!(
            refused(Path::new("/"), true).contains("check the folder")
                || refused(Path::new("/"), true).contains("exists")
        );
    }
}
