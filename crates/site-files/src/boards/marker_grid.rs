//! OpenCV's grid of markers as an object.

use super::{BoardError, check_grid, object_of, places, upside_down};
use nalgebra::UnitQuaternion;
use sextant_geometry::Pose;
use sextant_site_model::{ObjectId, ObjectModel, ObjectTag, TagId};
use sextant_tag_families::Family;

/// OpenCV's `GridBoard`: markers in columns and rows, ids row by row from the upper left. Its origin is the upper left
/// corner of the first marker, x along the columns, y down along the rows, z into the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkerGrid {
    /// Markers in a row.
    pub columns: u16,
    /// Rows of markers.
    pub rows: u16,
    /// Edge of a marker's black square, metres: OpenCV's `markerLength`.
    pub marker_m: f64,
    /// Gap between markers, metres: OpenCV's `markerSeparation`.
    pub separation_m: f64,
    /// The markers' family, which names the dictionary.
    pub family: Family,
    /// Id of the first marker.
    pub first: u32,
}

impl MarkerGrid {
    /// The board as an object.
    ///
    /// # Errors
    /// A grid without markers or gaps, with ids that the dictionary lacks, or with sizes that no tag has.
    pub fn object(&self, id: ObjectId) -> Result<ObjectModel, BoardError> {
        check_grid(self.columns, self.rows)?;
        if self.separation_m.is_nan() || self.separation_m <= 0.0 {
            return Err(BoardError::Separation(self.separation_m));
        }
        let pitch_m = self.marker_m + self.separation_m;
        let middle = |index: u16| f64::from(index) * pitch_m + self.marker_m / 2.0;
        // OpenCV draws AprilTags upside down.
        let by = if self.family.name().starts_with("tag") {
            std::f64::consts::PI
        } else {
            0.0
        };
        let turn = Pose::from_parts(
            Default::default(),
            UnitQuaternion::from_euler_angles(0.0, 0.0, by),
        );
        let tags = places(self.columns, self.rows)
            .zip(0..)
            .map(|(place, index)| {
                ObjectTag::new(
                    TagId {
                        family: self.family,
                        id: self.first.saturating_add(index),
                    },
                    self.marker_m,
                    Some(upside_down(place.map(middle)) * turn),
                )
            });
        object_of(id, tags.collect())
    }
}
