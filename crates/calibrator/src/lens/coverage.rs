//! Coverage of the image by the board, and its orientations.

use super::view::BoardView;
use nalgebra::{Point2, Vector3};
use sextant_geometry::Pose;

/// Cells across the picture.
pub const COLUMNS: usize = 12;
/// Cells down the picture.
pub const ROWS: usize = 9;

/// Least tilt of a normal, as a tangent, that counts: 17 degrees.
const TILTED: f64 = 0.3;
/// Spread of the corners of a board that is close, as a share of the image width (RMS distance from their
/// centroid): it fills more than half of the image.
const NEAR: f64 = 0.24;

/// Counts over the views.
#[derive(Clone, Debug, PartialEq, Default)]
pub(super) struct Coverage {
    /// Corners in each cell, row by row.
    pub corners: [[u32; COLUMNS]; ROWS],
    /// Views in which the board's left, right, upper and lower side is turned away.
    pub tilted: [u32; 4],
    /// Views that the board fills, whose perspective separates focal length from distance.
    pub near: u32,
    pub views: u32,
}

impl Coverage {
    pub(super) fn take(&mut self, resolution: [u32; 2], view: &BoardView, pose: Option<&Pose>) {
        self.views += 1;
        let (_, spread) = view.extent();
        self.near += u32::from(spread >= NEAR * f64::from(resolution[0]));
        for corner in view.corners() {
            let [column, row] = cell_of(resolution, corner);
            self.corners[row][column] += 1;
        }
        if let Some(pose) = pose {
            let [right, down] = lean(pose);
            let ways = [-right, right, -down, down];
            for (count, way) in self.tilted.iter_mut().zip(ways) {
                *count += u32::from(way > TILTED);
            }
        }
    }

    /// Share of the cells between two bounds, in thirds of the image, that contain a corner.
    pub(super) fn part(
        &self,
        columns: std::ops::Range<usize>,
        rows: std::ops::Range<usize>,
    ) -> f64 {
        let all = columns.len() * rows.len();
        let full = rows.flat_map(|row| columns.clone().map(move |column| (row, column)));
        let full = full
            .filter(|&(row, column)| self.corners[row][column] > 0)
            .count();
        full as f64 / all.max(1) as f64
    }

    pub(super) fn whole(&self) -> f64 {
        self.part(0..COLUMNS, 0..ROWS)
    }
}

/// Tilt of the board's normal to the right and downwards relative to the image plane, as tangents: a board whose right
/// side is farther away tilts to the right. This tilt separates focal length from distance.
pub(super) fn lean(camera_from_board: &Pose) -> [f64; 2] {
    let normal = camera_from_board.rotation * Vector3::z();
    let lean = [normal.x / -normal.z, normal.y / -normal.z];
    lean.map(|tangent| if tangent.is_finite() { tangent } else { 0.0 })
}

/// Column and row of the cell of a corner.
pub(super) fn cell_of([width, height]: [u32; 2], corner: &Point2<f64>) -> [usize; 2] {
    let cell = |x: f64, pixels: u32, n: usize| {
        let at = (x + 0.5) / f64::from(pixels.max(1)) * n as f64;
        (at.max(0.0) as usize).min(n - 1)
    };
    [cell(corner.x, width, COLUMNS), cell(corner.y, height, ROWS)]
}
