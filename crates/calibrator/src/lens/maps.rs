//! Maps over the image in cells: coverage, residuals and uncertainty.

use super::coverage::{COLUMNS, ROWS, cell_of};
use super::fit::Fit;
use nalgebra::{DMatrix, Matrix2x3, Matrix2xX, Matrix3, Matrix3xX, Point2, Vector2};
use serde::Serialize;
use sextant_geometry::{Lens, so3};

/// One cell of the image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MapCell {
    /// Number of fitted corners.
    pub corners: u32,
    /// Mean of projected minus detected corners, pixels: the systematic error of the model.
    pub mean_px: [f64; 2],
    /// Their root mean square, pixels.
    pub rms_px: f64,
    /// Standard deviation of the pixel of a ray, without a rotation of the whole camera, pixels; `None` outside the
    /// field of the lens.
    pub sigma_px: Option<f64>,
}

/// [`ROWS`] rows of [`COLUMNS`] cells, from the top left.
#[derive(Clone, Debug, PartialEq)]
pub struct LensMaps {
    /// Cells, row by row.
    pub cells: Vec<Vec<MapCell>>,
}

impl LensMaps {
    pub(super) fn from_fit(fit: &Fit, resolution: [u32; 2]) -> Self {
        let mut sums = vec![vec![(0_u32, Vector2::zeros(), 0.0); COLUMNS]; ROWS];
        let bundle = &fit.adjustment.solution.bundle;
        for residual in bundle.residuals() {
            let seen = &bundle.images[residual.image].tags[residual.seen];
            for (error, corner) in residual.corners_px.iter().zip(&seen.corners) {
                let Some(error) = error else { continue };
                let [column, row] = cell_of(resolution, corner);
                let (count, sum, square) = &mut sums[row][column];
                *count += 1;
                *sum += error;
                *square += error.norm_squared();
            }
        }
        let sigmas = deviations(&fit.adjustment.lens, &fit.covariance(), resolution);
        let cell = |row: usize, column: usize| {
            let (corners, sum, square) = sums[row][column];
            let n = f64::from(corners.max(1));
            let mean: Vector2<f64> = sum / n;
            MapCell {
                corners,
                mean_px: mean.into(),
                rms_px: f64::sqrt(square / n),
                sigma_px: sigmas[row * COLUMNS + column],
            }
        };
        Self {
            cells: (0..ROWS)
                .map(|row| (0..COLUMNS).map(|column| cell(row, column)).collect())
                .collect(),
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &MapCell> {
        self.cells.iter().flatten()
    }

    /// Mean and largest standard deviation over the image, pixels, and the share of the image in the field of the lens.
    pub fn uncertainty(&self) -> (f64, f64, f64) {
        let known: Vec<f64> = self.iter().filter_map(|cell| cell.sigma_px).collect();
        let n = known.len().max(1) as f64;
        (
            known.iter().sum::<f64>() / n,
            known.iter().copied().fold(0.0, f64::max),
            known.len() as f64 / (ROWS * COLUMNS) as f64,
        )
    }

    /// Share of the cells that contain a corner.
    pub fn coverage(&self) -> f64 {
        self.iter().filter(|cell| cell.corners > 0).count() as f64 / (ROWS * COLUMNS) as f64
    }

    /// The largest mean error of a cell beyond three times what its noise explains, pixels.
    pub fn systematic_px(&self) -> f64 {
        let beyond = self.iter().filter(|cell| cell.corners >= 8).map(|cell| {
            let mean = Vector2::from(cell.mean_px).norm();
            let noise = cell.rms_px / f64::from(cell.corners).sqrt();
            (mean - 3.0 * noise).max(0.0)
        });
        beyond.fold(0.0, f64::max)
    }
}

fn middle([width, height]: [u32; 2], row: usize, column: usize) -> Point2<f64> {
    let at = |cell: usize, n: usize, pixels: u32| {
        (cell as f64 + 0.5) / n as f64 * f64::from(pixels) - 0.5
    };
    Point2::new(at(column, COLUMNS, width), at(row, ROWS, height))
}

/// Derivatives of a pixel with respect to the parameters of the lens and to a rotation of the camera.
pub(super) struct Movement {
    pub by_parameters: Matrix2xX<f64>,
    pub by_turn: Matrix2x3<f64>,
}

/// Centres of the cells in the field of the lens, with their derivatives.
pub(super) fn movements(
    lens: &Lens,
    n_parameters: usize,
    resolution: [u32; 2],
) -> Vec<(Point2<f64>, Movement)> {
    let cells = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
    let middles = cells.map(|(row, column)| middle(resolution, row, column));
    middles
        .filter_map(|pixel| Some((pixel, movement(lens, n_parameters, &pixel)?)))
        .collect()
}

/// One standard deviation, by cell, of the pixel of the ray through its centre. A rotation of the whole camera is
/// removed (the one that minimises the motion over the image for each parameter), since the camera's pose absorbs it:
/// an error of half a pixel of the principal point is little else.
fn deviations(lens: &Lens, covariance: &DMatrix<f64>, resolution: [u32; 2]) -> Vec<Option<f64>> {
    let cells = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
    let movements: Vec<Option<Movement>> = cells
        .map(|(row, column)| movement(lens, covariance.nrows(), &middle(resolution, row, column)))
        .collect();
    let (mut normal, mut right) = (Matrix3::zeros(), Matrix3xX::zeros(covariance.nrows()));
    for movement in movements.iter().flatten() {
        normal += movement.by_turn.transpose() * movement.by_turn;
        right += movement.by_turn.transpose() * &movement.by_parameters;
    }
    let turns = normal.try_inverse().map(|inverse| inverse * right);
    let sigma = |movement: &Movement| {
        let by_parameters = match &turns {
            Some(turns) => &movement.by_parameters - movement.by_turn * turns,
            None => movement.by_parameters.clone(),
        };
        let of_pixel = &by_parameters * covariance * by_parameters.transpose();
        Some(of_pixel.trace().max(0.0).sqrt()).filter(|sigma| sigma.is_finite())
    };
    movements
        .iter()
        .map(|movement| sigma(movement.as_ref()?))
        .collect()
}

fn movement(lens: &Lens, n_parameters: usize, pixel: &Point2<f64>) -> Option<Movement> {
    let ray = lens.unproject(pixel).ok()?;
    let by_parameters = lens.parameter_jacobian(&ray.into())?;
    let (_, by_point) = lens.project_with_jacobian(&ray.into())?;
    Some(Movement {
        by_parameters: Matrix2xX::from_fn(n_parameters, |i, j| by_parameters[(i, j)]),
        by_turn: -by_point * so3::hat(&ray),
    })
}
