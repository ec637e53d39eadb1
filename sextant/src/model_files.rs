//! Rig and object files as commands read them: what a file of another tool leaves open and is assumed is said on
//! stderr.

use sextant_site_files::{FileError, assumptions};
use sextant_site_model::{ObjectModel, Rig};
use std::path::Path;

/// The rig of a file.
///
/// # Errors
/// As [`sextant_site_files::read_rig`].
pub fn read_rig(path: &Path) -> Result<Rig, FileError> {
    let rig = sextant_site_files::read_rig(path)?;
    say_assumptions(path)?;
    Ok(rig)
}

/// The object of a file.
///
/// # Errors
/// As [`sextant_site_files::read_object`].
pub fn read_object(path: &Path) -> Result<ObjectModel, FileError> {
    let object = sextant_site_files::read_object(path)?;
    say_assumptions(path)?;
    Ok(object)
}

/// Says what was assumed of a file that has been read.
///
/// # Errors
/// As [`assumptions`].
pub fn say_assumptions(path: &Path) -> Result<(), FileError> {
    for assumed in assumptions(path)? {
        eprintln!("warning: {}: {assumed}", path.display());
    }
    Ok(())
}
