//! The replay of a folder, and that of a site's recording.

use crate::finder::{ChessboardSearch, PartialViews, TagFinder};
use crate::live::{LiveComparison, LivePoses};
use crate::models::{ModelsError, ReplayModels};
use crate::observation::{ObservationError, observation};
use crate::ordered::in_order;
use crate::pass::{Pass, ReplayObserver};
use crate::plan::{Plan, PlanError, Run};
use sextant_estimator::{Fusion, FusionOptions, Input, ModelError};
use sextant_proto::ObjectPose;
use sextant_recordings::{Dataset, Row};
use sextant_site_model::{CameraId, ImageObservation, ObjectId, ObjectModel, Rig, posed_objects};
use sextant_site_report::{Fault, Imperfection, ObjectEstimate};
use std::collections::{BTreeMap, BTreeSet};

/// Why a recording is not replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// Rig and objects do not fit the recording.
    #[error(transparent)]
    Models(#[from] ModelsError),
    /// The estimator refuses rig and objects.
    #[error(transparent)]
    Fusion(#[from] ModelError),
    /// An image cannot be used.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// The recording has nothing to replay.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// The result of a replay.
#[derive(Debug, Clone)]
pub struct Replayed {
    /// The final poses, sorted by time and object.
    pub poses: Vec<ObjectEstimate>,
    /// The images of each camera.
    pub cameras: BTreeMap<CameraId, CameraCounts>,
    /// The objects of the models and of the recorded poses.
    pub objects: Vec<ObjectId>,
    /// Faults that the images show.
    pub faults: Vec<Fault>,
    /// Errors of the models that the estimator has found.
    pub imperfections: Vec<Imperfection>,
    /// The poses against those that were published live, of a site's recording.
    pub live: Option<LiveComparison>,
}

/// Images of a camera.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CameraCounts {
    /// All images.
    pub images: usize,
    /// Images that were older than the estimator's window when they arrived.
    pub late: u64,
    /// Images captured after their arrival.
    pub ahead: u64,
    /// Tags of no object.
    pub unknown_tags: u64,
}

/// Replays the images of a folder in order of arrival, then of capture time, then of camera. `threads` detect tags; the
/// poses do not depend on their number.
///
/// # Errors
/// [`ReplayError`], and those of the observer.
pub fn replay_folder<O: ReplayObserver>(
    dataset: &Dataset,
    models: &ReplayModels,
    threads: usize,
    observer: &mut O,
) -> Result<Replayed, O::Error>
where
    O::Error: From<ReplayError>,
{
    let rows = dataset.rows_by_arrival();
    let times_ns = rows.iter().map(|row| models.capture_ns(row));
    let fusion = estimator(&models.rig, &models.objects)?;
    let mut pass = Pass::new(fusion, times_ns);
    let options = models.detector_options();
    let chessboard = ChessboardSearch::among(&models.objects, PartialViews::LeftOut);
    in_order(
        threads,
        rows.iter().copied(),
        || TagFinder::new(&options, chessboard.as_ref()),
        |finder, row| (row, observation(finder, row, &models.rig)),
        |(row, seen): (&Row, Result<ImageObservation, ObservationError>)| {
            let image = models.rig.timed(seen.map_err(ReplayError::from)?);
            let input = Input::Image(image);
            pass.handle(row.arrival_ns, input, observer).map(drop)
        },
    )?;
    let images = dataset.cameras().iter();
    let images = images.map(|camera| (camera.camera.clone(), camera.rows.len()));
    let objects = posed_objects(&models.rig, &models.objects);
    Ok(Replayed::new(pass, images, objects.into_iter()))
}

/// Replays the inputs of a plan; `live` are the poses that were published then.
///
/// # Errors
/// [`ReplayError`], and those of the observer.
pub fn replay_plan<O: ReplayObserver>(
    plan: Plan,
    live: &[ObjectPose],
    observer: &mut O,
) -> Result<Replayed, O::Error>
where
    O::Error: From<ReplayError>,
{
    let (images, spans_ns) = (plan.images(), plan.spans_ns());
    let times_ns: Vec<u64> = plan.capture_times_ns().collect();
    let mut objects: BTreeSet<_> = live.iter().map(|pose| pose.object.clone()).collect();
    let mut live = LivePoses::new(live);
    let are_adjustments_known = plan.are_adjustments_known;
    let mut runs = plan.runs.into_iter();
    let first = runs.next().ok_or(ReplayError::Plan(PlanError::Empty))?;
    let of_run = |run: &Run| {
        let mut fusion = estimator(&run.rig, &run.objects)?;
        if are_adjustments_known {
            fusion.adjust_apart();
        }
        Ok::<_, ReplayError>(fusion)
    };
    let fusion = of_run(&first)?;
    let mut pass = Pass::new(fusion, times_ns.into_iter());
    for (number, run) in std::iter::once(first).chain(runs).enumerate() {
        if number > 0 {
            pass.fusion = of_run(&run)?;
        }
        objects.extend(posed_objects(&run.rig, &run.objects));
        for (now_ns, input) in run.steps {
            pass.handle(now_ns, input, observer)?
                .iter()
                .for_each(|pose| live.take(pose));
        }
    }
    let mut replayed = Replayed::new(pass, images.into_iter(), objects.into_iter());
    replayed.live = Some(live.comparison(&spans_ns));
    Ok(replayed)
}

fn estimator(rig: &Rig, objects: &[ObjectModel]) -> Result<Fusion, ReplayError> {
    let fusion = Fusion::new(rig.clone(), objects.to_vec(), FusionOptions::default());
    Ok(fusion?)
}

impl Replayed {
    fn new(
        pass: Pass,
        images: impl Iterator<Item = (CameraId, usize)>,
        objects: impl Iterator<Item = ObjectId>,
    ) -> Self {
        let (poses, fusion) = pass.finish();
        let statistics = fusion.statistics();
        let cameras = images.map(|(camera, images)| {
            let counts = statistics.cameras.get(&camera).copied().unwrap_or_default();
            let counts = CameraCounts {
                images,
                late: counts.late,
                ahead: counts.ahead,
                unknown_tags: counts.unknown_tags,
            };
            (camera, counts)
        });
        Self {
            cameras: cameras.collect(),
            objects: objects.collect(),
            faults: fusion.faults(),
            imperfections: fusion.imperfections(),
            live: None,
            poses,
        }
    }
}
