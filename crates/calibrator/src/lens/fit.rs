//! Fit of one lens model to the views, without outlier tags.

use super::adjust::{Adjustment, FreeParameters, Noise, Parameters, Start, adjust};
use super::board::Board;
use super::poses::board_pose;
use super::view::BoardView;
use nalgebra::DMatrix;
use sextant_adjustment::{KeptParameter, TagResidual};
use sextant_geometry::{Lens, LensModel};

/// Largest sum of squared errors of a tag, in units of their noise, that is no outlier: 8 is expected, and one
/// tag of 300000 exceeds 40 by chance.
const WRONG: f64 = 40.0;
/// Median of a sum of eight squared normal deviates.
const MEDIAN_OF_EIGHT: f64 = 7.344;
/// Least number of tags in a view.
pub(super) const LEAST_TAGS: usize = 2;
/// Least noise, as a multiple of the detector's.
const LEAST_NOISE: f64 = 0.05;
/// Largest error of a tag to be included again with a lens that fits, as a share of the image width.
const SECOND_CHANCE: f64 = 0.01;

/// A model fitted to views.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub adjustment: Adjustment,
    /// Noise as a multiple of the detector's.
    pub scale: f64,
}

/// Fits a model from a start; `None` if no start of the model is valid.
pub(super) fn fit(
    board: &Board,
    views: &[BoardView],
    start: &Start,
    model: LensModel,
    width: f64,
) -> Option<Fit> {
    let start = start_of(board, views, start, model, width)?;
    let rough = adjust(board, views, &start, &Parameters::judging(1.0))?;
    let wide = Parameters {
        sought: FreeParameters::All,
        noise: Noise::Common(0.5),
        max_iterations: 40,
        ..Parameters::judging(1.0)
    };
    let mut fit = Fit {
        adjustment: adjust(board, views, &restart(&rough), &wide)?,
        scale: 1.0,
    };
    for _ in 0..2 {
        fit.scale = fit.noise(views);
        let start = fit.sorted(board, views, width);
        let fine = Parameters::fine(FreeParameters::All, fit.scale);
        fit.adjustment = adjust(board, views, &start, &fine)?;
    }
    Some(fit)
}

/// A start for another model: the same focal lengths, with new poses of the board.
fn start_of(
    board: &Board,
    views: &[BoardView],
    start: &Start,
    model: LensModel,
    width: f64,
) -> Option<Start> {
    let numbers = start.lens.intrinsics();
    let lens = match model {
        model if model == start.lens.model() => start.lens,
        LensModel::Pinhole => Lens::pinhole(numbers).ok()?,
        LensModel::BrownConrady => Lens::brown_conrady(numbers, [0.0; 5]).ok()?,
        LensModel::KannalaBrandt => Lens::kannala_brandt(numbers, [0.0; 4]).ok()?,
    };
    let poses = views
        .iter()
        .zip(&start.poses)
        .map(|(view, pose)| match pose {
            Some(pose) if lens.model() == start.lens.model() => Some(pose.clone()),
            _ => board_pose(board, view, &lens, 2.0 * SECOND_CHANCE * width),
        });
    Some(Start {
        lens,
        places: start.places.clone(),
        poses: poses.collect(),
    })
}

/// The solution of an adjustment as a start.
pub(super) fn restart(adjustment: &Adjustment) -> Start {
    Start {
        lens: adjustment.lens,
        places: adjustment.places.clone(),
        poses: adjustment.poses.clone(),
    }
}

impl Fit {
    /// Noise as a multiple of the detector's, from the median tag.
    fn noise(&self, views: &[BoardView]) -> f64 {
        let residuals = self.residuals();
        let mut sums: Vec<f64> = residuals
            .iter()
            .map(|(view, tag, r)| chi_square(views, *view, *tag, r))
            .collect();
        if sums.is_empty() {
            return 1.0;
        }
        sums.sort_by(f64::total_cmp);
        (sums[sums.len() / 2] / MEDIAN_OF_EIGHT)
            .sqrt()
            .max(LEAST_NOISE)
    }

    /// Residual of every fitted tag, with the indices of its view and of the tag in the view.
    pub(super) fn residuals(&self) -> Vec<(usize, usize, TagResidual)> {
        let bundle = &self.adjustment.solution.bundle;
        let with_places = bundle.residuals().map(|residual| {
            let view = self.adjustment.view_of[residual.image];
            let tags = self.adjustment.poses[view]
                .as_ref()
                .map(|(_, tags)| tags[residual.seen]);
            (view, tags.unwrap_or_default(), residual)
        });
        with_places.collect()
    }

    /// Start of the next round: without tags that do not fit the board, and with those that fit now.
    fn sorted(&self, board: &Board, views: &[BoardView], width: f64) -> Start {
        let lens = self.adjustment.lens;
        let board = &board.bent(&self.adjustment.places);
        let poses = views
            .iter()
            .zip(&self.adjustment.poses)
            .map(|(view, pose)| {
                let tolerance = SECOND_CHANCE * width;
                let (pose, _) = match pose {
                    Some(pose) => pose.clone(),
                    None => board_pose(board, view, &lens, tolerance)?,
                };
                let fitting = (0..view.tags.len()).filter(|&at| {
                    let seen = &view.tags[at];
                    let corners = board.tags[seen.tag].corners.iter().zip(&seen.corners);
                    let squares =
                        corners
                            .zip(seen.sigmas_px)
                            .map(|((on_board, in_image), sigma)| {
                                let projected = lens.project(&(pose * on_board));
                                projected.map_or(f64::INFINITY, |p| {
                                    ((p - in_image) / sigma).norm_squared()
                                })
                            });
                    squares.sum::<f64>() <= WRONG * self.scale * self.scale
                });
                let fitting: Vec<usize> = fitting.collect();
                (fitting.len() >= LEAST_TAGS).then_some((pose, fitting))
            });
        Start {
            lens,
            places: board.places(),
            poses: poses.collect(),
        }
    }

    /// Relative standard deviation of the focal length.
    pub(super) fn focal_uncertainty(&self) -> f64 {
        let sigma = |parameter| {
            let lens = KeptParameter::Lens {
                camera: 0,
                parameter,
            };
            self.adjustment
                .solution
                .covariance
                .sigma(lens)
                .unwrap_or(f64::INFINITY)
        };
        let numbers = self.adjustment.lens.intrinsics();
        (sigma(0) / numbers.fx).max(sigma(1) / numbers.fy)
    }

    pub(super) fn covariance(&self) -> DMatrix<f64> {
        self.adjustment.solution.covariance.lens(0)
    }

    /// Angle between the board and the image plane in each fitted view, radians.
    pub(super) fn tilts(&self) -> Vec<f64> {
        let poses = self.adjustment.poses.iter().flatten();
        let tilts = poses.map(|(pose, _)| {
            let normal = pose.rotation * nalgebra::Vector3::z();
            (-normal).angle(&nalgebra::Vector3::z())
        });
        tilts.collect()
    }

    /// Relative excess of the size of the squares over that in the board file, and its standard deviation: the
    /// component of the residuals along the motion of each corner when its tag grows about its own centre, on a board
    /// that does not bend. `None` where that cannot be adjusted.
    pub(super) fn growth(&self, board: &Board, views: &[BoardView]) -> Option<(f64, f64)> {
        let start = Start {
            places: board.places(),
            ..restart(&self.adjustment)
        };
        let flat = Parameters {
            bends: false,
            ..Parameters::fine(FreeParameters::All, self.scale)
        };
        let flat = adjust(board, views, &start, &flat)?;
        let (mut along, mut square) = (0.0, 0.0);
        let bundle = &flat.solution.bundle;
        let mut noise = (0.0, 0.0);
        for residual in bundle.residuals() {
            let image = &bundle.images[residual.image];
            let pose = bundle.instants[image.instant].world_from_object;
            let tag = &board.tags[image.tags[residual.seen].tag];
            let middle = tag.board_from_tag.translation.vector;
            for (error, corner) in residual.corners_px.iter().zip(&tag.corners) {
                let in_camera = pose * corner;
                let projected = flat.lens.project_with_jacobian(&in_camera);
                let (Some(error), Some((_, by_point))) = (error, projected) else {
                    continue;
                };
                let way = by_point * (pose.rotation * (corner.coords - middle));
                along -= way.dot(error);
                square += way.norm_squared();
                noise = (noise.0 + error.norm_squared() / 2.0, noise.1 + 1.0);
            }
        }
        let sigma_px = (noise.0 / f64::max(noise.1, 1.0)).sqrt();
        let square = f64::max(square, f64::MIN_POSITIVE);
        Some((along / square, sigma_px / square.sqrt()))
    }
}

/// Sum of squared errors of a tag in units of its noise.
fn chi_square(views: &[BoardView], view: usize, tag: usize, residual: &TagResidual) -> f64 {
    let sigmas = views[view].tags[tag].sigmas_px;
    let errors = residual.corners_px.iter().zip(sigmas);
    errors
        .filter_map(|(error, sigma)| error.map(|e| (e / sigma).norm_squared()))
        .sum()
}
