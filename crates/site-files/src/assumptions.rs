//! What a file of another tool leaves open, and what is assumed in its place: the unit of lengths, the family and the
//! size of tags.

use crate::boards::layouts;
use crate::error::FileError;
use crate::foreign::{anipose, is_foreign, parse_document};
use crate::read::read_text;
use std::path::Path;

/// What [`crate::read_rig`] or [`crate::read_object`] assume on reading a file: a sentence each, with what to write
/// into the file where it is otherwise. None of files that leave nothing open, and of this project's own.
///
/// # Errors
/// A file that is missing or malformed.
pub fn assumptions(path: &Path) -> Result<Vec<String>, FileError> {
    let text = read_text(path)?;
    if !is_foreign(path, &text) {
        return Ok(Vec::new());
    }
    let document = parse_document(path, &text)?;
    let unit = anipose::assumption(&document);
    Ok(unit
        .into_iter()
        .chain(layouts::assumption(&document))
        .collect())
}
