//! Sheets to print in true size, with the objects that they make: boards for calibration, single tags, cubes to fold.
//!
//! Sizes on paper are in millimetres from its lower left corner, those of objects in metres. The same job gives the
//! same bytes of PDF.

mod board;
mod calibration_boards;
mod cube;
mod error;
pub mod pdf;
mod sheet;
mod starter;
mod tags;

pub use board::board;
pub use calibration_boards::{aprilgrid, charuco, chessboard};
pub use cube::{Cube, cube};
pub use error::SheetError;
pub use sheet::{Paper, length_text};
pub use starter::{Starter, starter};
pub use tags::tags;

use nalgebra::Translation3;
use pdf::Page;
use sextant_site_model::{ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;

/// Pages with their object.
#[derive(Debug, Clone)]
pub struct PrintJob {
    /// Title of the PDF.
    pub title: String,
    /// The pages.
    pub pages: Vec<Page>,
    /// The object.
    pub model: ObjectModel,
    /// Edge of the black squares, mm.
    pub size: f64,
}

impl PrintJob {
    /// The object with the measured size of its tags.
    ///
    /// # Errors
    /// [`SheetError::Scale`].
    pub fn as_measured(&self, measured_m: f64) -> Result<ObjectModel, SheetError> {
        enlarged(&self.model, measured_m * 1e3 / self.size)
    }
}

/// Scales an object as a whole, as a printer does.
///
/// # Errors
/// [`SheetError::Scale`] for a scale that no printer causes.
pub fn enlarged(object: &ObjectModel, scale: f64) -> Result<ObjectModel, SheetError> {
    if !(0.5..=2.0).contains(&scale) {
        return Err(SheetError::Scale(scale));
    }
    let tags = object.tags().iter().map(|tag| {
        let place = tag.object_from_tag.map(|mut pose| {
            pose.translation = Translation3::from(pose.translation.vector * scale);
            pose
        });
        ObjectTag::new(tag.tag, tag.size_m * scale, place)
    });
    Ok(ObjectModel::new(object.id().clone(), tags.collect())?)
}

/// `count` consecutive tags of a family.
fn ids_from(family: Family, first: u32, count: u32) -> Result<Vec<TagId>, SheetError> {
    (0..count)
        .map(|index| tag_of(family, first.saturating_add(index)))
        .collect()
}

fn tag_of(family: Family, id: u32) -> Result<TagId, SheetError> {
    if let Some(board) = family.data().board {
        return Err(SheetError::OfBoard { family, board });
    }
    let last = family.data().codes.len() - 1;
    if id as usize > last {
        return Err(SheetError::UnknownTag { family, id, last });
    }
    Ok(TagId { family, id })
}

/// Also refuses NaN.
fn check_size(mm: f64) -> Result<(), SheetError> {
    if (5.0..=300.0).contains(&mm) {
        Ok(())
    } else {
        Err(SheetError::Size(mm * 1e-3))
    }
}

#[cfg(test)]
mod tests;
