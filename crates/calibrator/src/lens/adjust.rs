//! One bundle adjustment of a lens: the camera is fixed, the pose of the board in every view is free, and so are the
//! requested parameters of the lens.

use super::board::Board;
use super::view::BoardView;
use sextant_adjustment::residuals::corners::KERNEL;
use sextant_adjustment::{
    BodyId, Bundle, BundleCamera, BundleImage, BundleOptions, BundleSolution, FreeLens, Freedom,
    Instant, TagObservation, solve,
};
use sextant_geometry::least_squares::Kernel;
use sextant_geometry::lens::MAX_PARAMETERS;
use sextant_geometry::{Lens, Pose};

/// Free parameters and weights of an adjustment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parameters {
    pub sought: FreeParameters,
    /// Whether the board may be bent.
    pub bends: bool,
    /// Factor on the noise of each tag.
    pub noise: Noise,
    pub kernel: Kernel,
    pub max_iterations: usize,
}

/// Free parameters of the lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FreeParameters {
    /// None: only the poses of the board.
    Nothing,
    /// Focal lengths and the first distortion coefficient.
    FocalAndDistortion,
    /// All.
    All,
}

/// Noise of the corners.
#[derive(Clone, Copy, Debug)]
pub(super) enum Noise {
    /// A common standard deviation, pixels.
    Common(f64),
    /// The detector's standard deviation for each tag, times this factor.
    Stated(f64),
}

impl Parameters {
    pub(super) fn judging(sigma_px: f64) -> Self {
        Self {
            sought: FreeParameters::FocalAndDistortion,
            bends: false,
            noise: Noise::Common(sigma_px),
            kernel: KERNEL,
            max_iterations: 15,
        }
    }

    pub(super) fn fine(sought: FreeParameters, scale: f64) -> Self {
        Self {
            bends: sought == FreeParameters::All,
            sought,
            noise: Noise::Stated(scale),
            kernel: Kernel::Huber { width: 4.0 },
            max_iterations: 40,
        }
    }
}

/// A lens, the places of the board's tags, and the pose of the board and its fitting tags in each view; views that the
/// lens does not explain have no pose.
pub(super) struct Start {
    pub lens: Lens,
    pub places: Vec<Pose>,
    pub poses: Vec<Option<(Pose, Vec<usize>)>>,
}

/// Result of an adjustment.
#[derive(Clone, Debug)]
pub(super) struct Adjustment {
    pub lens: Lens,
    /// Places of the board's tags.
    pub places: Vec<Pose>,
    /// Pose and fitting tags of each view.
    pub poses: Vec<Option<(Pose, Vec<usize>)>>,
    pub cost: f64,
    pub solution: BundleSolution,
    /// Index of the view of each image in the solution's bundle.
    pub view_of: Vec<usize>,
}

/// Adjusts from a start, also the places of the tags of a board that bends and is printed as `board` says; `None` if no
/// view has a pose or the start has no finite error.
pub(super) fn adjust(
    board: &Board,
    views: &[BoardView],
    start: &Start,
    parameters: &Parameters,
) -> Option<Adjustment> {
    let (bundle, view_of) = bundle(board, views, start, parameters);
    let options = BundleOptions {
        kernel: parameters.kernel,
        max_iterations: parameters.max_iterations,
        by_clusters: parameters.bends,
        ..BundleOptions::default()
    };
    let solution = solve(bundle, &options).ok()?;
    let mut poses = start.poses.clone();
    for (&view, instant) in view_of.iter().zip(&solution.bundle.instants) {
        if let Some((pose, _)) = &mut poses[view] {
            *pose = instant.world_from_object;
        }
    }
    Some(Adjustment {
        lens: solution.bundle.cameras[0].lens,
        places: {
            let tags = solution.bundle.tags.iter();
            tags.map(|tag| tag.object_from_tag).collect()
        },
        poses,
        cost: solution.cost,
        solution,
        view_of,
    })
}

/// The bundle of a start, and the view of each of its images.
fn bundle(
    board: &Board,
    views: &[BoardView],
    start: &Start,
    parameters: &Parameters,
) -> (Bundle, Vec<usize>) {
    let (of_tags, anchors) = if parameters.bends {
        (Freedom::Free, board.anchors())
    } else {
        (Freedom::Fixed, Vec::new())
    };
    let mut bundle = Bundle {
        cameras: vec![camera(start.lens, parameters.sought)],
        tags: board.bent(&start.places).bundle_tags(of_tags),
        anchors,
        ..Bundle::default()
    };
    let mut view_of = Vec::new();
    for (at, (view, pose)) in views.iter().zip(&start.poses).enumerate() {
        let Some((pose, tags)) = pose else { continue };
        let seen = tags.iter().map(|&tag| {
            let tag = &view.tags[tag];
            let sigmas_px = tag.sigmas_px.map(|sigma_px| match parameters.noise {
                Noise::Common(common_px) if sigma_px.is_finite() => common_px,
                Noise::Common(_) => sigma_px,
                Noise::Stated(scale) => sigma_px * scale,
            });
            TagObservation::with_sigmas(tag.tag, tag.corners, sigmas_px)
        });
        bundle.images.push(BundleImage {
            camera: 0,
            instant: bundle.instants.len(),
            seconds_after_instant: 0.0,
            stamp_error_s: 0.0,
            tags: seen.collect(),
        });
        let instant = Instant::at_rest(BodyId::Moving(0), at as f64, *pose);
        bundle.instants.push(instant);
        view_of.push(at);
    }
    (bundle, view_of)
}

fn camera(lens: Lens, sought: FreeParameters) -> BundleCamera {
    let mut free = [Freedom::Fixed; MAX_PARAMETERS];
    let indices: &[usize] = match sought {
        FreeParameters::Nothing => &[],
        FreeParameters::FocalAndDistortion => &[0, 1, 4],
        FreeParameters::All => &[0, 1, 2, 3, 4, 5, 6, 7, 8],
    };
    for &index in indices {
        free[index] = Freedom::Free;
    }
    BundleCamera {
        pose: Freedom::Fixed,
        free_lens: FreeLens(free),
        ..BundleCamera::with_known_lens(lens, Pose::identity())
    }
}
