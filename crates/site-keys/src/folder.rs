//! Folders and files of keys: private from the start, and written whole or not at all.

use crate::KeysError;
use rustix::fs::{CWD, RenameFlags, renameat_with};
use sextant_zenoh_bus::KeyFiles;
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

const UNWRITABLE: &str = ": cannot be written";

/// The authority's key pair, which signs every certificate.
pub struct FolderFiles {
    /// Its private key, PEM.
    pub authority_key: String,
    /// Its certificate, PEM.
    pub authority: String,
}

impl FolderFiles {
    /// Reads the key pair.
    ///
    /// # Errors
    /// An error of the system.
    pub fn read(dir: &Path) -> Result<Self, KeysError> {
        let read = |name: &str| {
            let file = dir.join(name);
            fs::read_to_string(&file).map_err(KeysError::system(&file, ""))
        };
        Ok(Self {
            authority_key: read("authority.key")?,
            authority: read("authority.pem")?,
        })
    }
}

/// Writes a file that only its owner can read, whole or not at all.
///
/// # Errors
/// An error of the system.
pub fn write_secret(path: &Path, content: &str) -> Result<(), KeysError> {
    let temporary = beside(path);
    let write = || -> std::io::Result<()> {
        let mut file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(&temporary)?;
        file.write_all(content.as_bytes())?;
        file.sync_all()?;
        fs::rename(&temporary, path)
    };
    write()
        .inspect_err(|_| drop(fs::remove_file(&temporary)))
        .map_err(KeysError::system(path, UNWRITABLE))
}

/// Fills a new private folder and moves it to `folder`, whose former content is then removed.
///
/// # Errors
/// An error of the system; the former folder is then unchanged.
pub fn in_place_of(
    folder: &Path,
    fill: impl FnOnce(&Path) -> Result<(), KeysError>,
) -> Result<(), KeysError> {
    let temporary = beside(folder);
    let unwritable = || KeysError::system(folder, UNWRITABLE);
    DirBuilder::new()
        .mode(0o700)
        .create(&temporary)
        .map_err(unwritable())?;
    let filled = fill(&temporary).and_then(|()| {
        if !folder.exists() {
            return fs::rename(&temporary, folder).map_err(unwritable());
        }
        // In one step, so that a kill leaves either.
        renameat_with(CWD, &temporary, CWD, folder, RenameFlags::EXCHANGE)
            .map_err(std::io::Error::from)
            .map_err(unwritable())?;
        remove_keys(&KeyFiles::within(&temporary))
    });
    if filled.is_err() {
        let _ = fs::remove_dir_all(&temporary);
    }
    filled?;
    let above = folder.parent().filter(|above| *above != Path::new(""));
    File::open(above.unwrap_or(Path::new(".")))
        .and_then(|above| above.sync_all())
        .map_err(unwritable())
}

/// Removes a member's folder; ignores a folder without `node.toml`.
///
/// # Errors
/// An error of the system.
pub fn remove_keys(files: &KeyFiles) -> Result<(), KeysError> {
    let folder = files.folder();
    if !folder.exists() {
        return Ok(());
    }
    if !files.node().is_file() {
        return Err(KeysError::NoKeys(folder.to_owned()));
    }
    fs::remove_dir_all(folder).map_err(KeysError::system(folder, ": cannot be removed"))
}

/// Removes half-made files and folders, which hold private keys, from an authority's folder and those of its members.
///
/// # Errors
/// An error of the system.
pub fn remove_leftovers(dir: &Path) -> Result<(), KeysError> {
    let unreadable = || KeysError::system(dir, ": cannot be read");
    for entry in fs::read_dir(dir).map_err(unreadable())? {
        let entry = entry.map_err(unreadable())?;
        let (path, name) = (entry.path(), entry.file_name());
        let is_leftover =
            name.as_encoded_bytes().starts_with(b".") && name.as_encoded_bytes().ends_with(b".tmp");
        let is_folder = entry.file_type().map_err(unreadable())?.is_dir();
        let done = match (is_leftover, is_folder) {
            (true, true) => fs::remove_dir_all(&path),
            (true, false) => fs::remove_file(&path),
            (false, true) if KeyFiles::within(&path).node().is_file() => {
                remove_leftovers(&path)?;
                Ok(())
            }
            (false, _) => Ok(()),
        };
        done.map_err(KeysError::system(&path, ": cannot be removed"))?;
    }
    Ok(())
}

/// A name in the same folder that no other process uses.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}
