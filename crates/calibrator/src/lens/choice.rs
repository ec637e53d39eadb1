//! Selection of the lens model by cross-validation: the simplest of those that predict held-out corners best.

use super::adjust::{FreeParameters, Parameters, Start, adjust};
use super::board::Board;
use super::fit::{Fit, fit, restart};
use super::view::BoardView;
use sextant_geometry::LensModel;

/// Number of folds; each is predicted by a lens fitted to the others.
const FOLDS: usize = 4;
/// A simpler model is selected if its held-out error is larger by this factor at most.
const SIMPLER: f64 = 1.005;

/// Score of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelScore {
    /// The model.
    pub model: LensModel,
    /// RMS distance between corners and their predictions by a lens fitted to other images, pixels.
    pub held_out_rms_px: f64,
}

/// The fit of the selected model, and the scores of all, simplest first; `None` if no model could be fitted.
pub(super) fn choose(
    board: &Board,
    views: &[BoardView],
    start: &Start,
    models: &[LensModel],
    width: f64,
) -> Option<(Fit, Vec<ModelScore>)> {
    let fits: Vec<(LensModel, Fit)> = models
        .iter()
        .filter_map(|&model| Some((model, fit(board, views, start, model, width)?)))
        .collect();
    // All are evaluated on the same tags: those that fit the best model.
    let explained = |fit: &Fit| {
        let tags = fit
            .adjustment
            .poses
            .iter()
            .flatten()
            .map(|(_, tags)| tags.len());
        (
            std::cmp::Reverse(tags.sum::<usize>()),
            fit.adjustment.solution.rms_px,
        )
    };
    let judge = fits.iter().min_by(|a, b| {
        let (a, b) = (explained(&a.1), explained(&b.1));
        a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))
    })?;
    let tags: Vec<Option<Vec<usize>>> = judge
        .1
        .adjustment
        .poses
        .iter()
        .map(|pose| pose.as_ref().map(|(_, tags)| tags.clone()))
        .collect();
    let scores: Vec<ModelScore> = fits
        .iter()
        .filter_map(|(model, fit)| {
            let held_out_rms_px = held_out(board, views, fit, &tags)?;
            Some(ModelScore {
                model: *model,
                held_out_rms_px,
            })
        })
        .collect();
    let best = scores
        .iter()
        .map(|score| score.held_out_rms_px)
        .fold(f64::INFINITY, f64::min);
    let taken = scores
        .iter()
        .find(|score| score.held_out_rms_px <= SIMPLER * best);
    let model = taken.map_or(judge.0, |score| score.model);
    let fit = fits.into_iter().find(|(of, _)| *of == model)?.1;
    Some((fit, scores))
}

/// Root mean square error over all folds.
fn held_out(
    board: &Board,
    views: &[BoardView],
    fit: &Fit,
    tags: &[Option<Vec<usize>>],
) -> Option<f64> {
    let with_judges_tags = |start: Start| Start {
        poses: start
            .poses
            .into_iter()
            .zip(tags)
            .map(|(pose, tags)| Some((pose?.0, tags.clone()?)))
            .collect(),
        ..start
    };
    let whole = with_judges_tags(restart(&fit.adjustment));
    let part = |start: &Start, wanted: &dyn Fn(usize) -> bool| {
        let mut count = 0;
        let poses = start.poses.iter().map(|pose| {
            let pose = pose.clone()?;
            count += 1;
            wanted((count - 1) % FOLDS).then_some(pose)
        });
        Start {
            poses: poses.collect(),
            places: start.places.clone(),
            lens: start.lens,
        }
    };
    let (mut squares, mut corners) = (0.0, 0.0);
    for fold in 0..FOLDS {
        let training = part(&whole, &|at| at != fold);
        let trained = adjust(
            board,
            views,
            &training,
            &Parameters::fine(FreeParameters::All, fit.scale),
        )?;
        let mut test = part(&whole, &|at| at == fold);
        (test.lens, test.places) = (trained.lens, trained.places);
        let tested = adjust(
            board,
            views,
            &test,
            &Parameters::fine(FreeParameters::Nothing, fit.scale),
        )?;
        for residual in tested.solution.bundle.residuals() {
            squares += residual
                .corners_px
                .iter()
                .flatten()
                .map(|e| e.norm_squared())
                .sum::<f64>();
            corners += residual.corners_px.iter().flatten().count() as f64;
        }
    }
    let rms: f64 = (squares / f64::max(corners, 1.0)).sqrt();
    rms.is_finite().then_some(rms)
}
