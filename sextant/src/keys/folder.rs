//! Folders and files of keys: private from the start, and written whole or not at all.

use anyhow::{Context, ensure};
use sextant_zenoh_bus::KeyFiles;
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

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
    pub fn read(dir: &Path) -> anyhow::Result<Self> {
        let read = |name: &str| {
            let file = dir.join(name);
            fs::read_to_string(&file).with_context(|| file.display().to_string())
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
pub fn write_secret(path: &Path, content: &str) -> anyhow::Result<()> {
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
        .with_context(|| format!("{}: cannot be written", path.display()))
}

/// Fills a new private folder and moves it to `folder`, whose former content is then removed.
///
/// # Errors
/// An error of the system; the former folder is then unchanged.
pub fn in_place_of(
    folder: &Path,
    fill: impl FnOnce(&Path) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let temporary = beside(folder);
    let unwritable = || format!("{}: cannot be written", folder.display());
    DirBuilder::new()
        .mode(0o700)
        .create(&temporary)
        .with_context(unwritable)?;
    let filled = fill(&temporary).and_then(|()| {
        let former = beside(&temporary);
        if folder.exists() {
            fs::rename(folder, &former).with_context(unwritable)?;
        }
        fs::rename(&temporary, folder).with_context(unwritable)?;
        if former.exists() {
            remove_keys(&KeyFiles::within(&former))?;
        }
        Ok(())
    });
    if filled.is_err() {
        let _ = fs::remove_dir_all(&temporary);
    }
    filled?;
    let above = folder.parent().filter(|above| *above != Path::new(""));
    File::open(above.unwrap_or(Path::new(".")))
        .and_then(|above| above.sync_all())
        .with_context(unwritable)
}

/// Removes a member's folder; ignores a folder without `node.toml`.
///
/// # Errors
/// An error of the system.
pub fn remove_keys(files: &KeyFiles) -> anyhow::Result<()> {
    let folder = files.folder();
    if !folder.exists() {
        return Ok(());
    }
    ensure!(
        files.node().is_file(),
        "{}: is no folder of keys and is left as it is",
        folder.display()
    );
    fs::remove_dir_all(folder).with_context(|| format!("{}: cannot be removed", folder.display()))
}

/// A name in the same folder that no other process uses.
fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}
