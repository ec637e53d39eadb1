//! Where the object is in one image, by consensus of its tags: each branch of each tag proposes a pose of the whole
//! constellation, all tags vote, the winners are refined on the tags that agree.

use crate::image_store::ImageView;
use nalgebra::{Matrix2x6, Vector6};
use sextant_adjustment::TagObservation;
use sextant_geometry::least_squares::{Kernel, NormalEquations, Options, Problem, minimise};
use sextant_geometry::{Lens, Pose, se3, so3, tag_corners_in_tag};

/// Where a tag sits on the object; `None` while unknown.
pub(crate) type TagPlacement = Option<(Pose, f64)>;

/// A pose of the object in an image, and which tags of the image agree with it.
#[derive(Clone, Debug)]
pub(crate) struct ObjectView {
    pub camera_from_object: Pose,
    /// Indices into the image's tags.
    pub agreeing: Vec<usize>,
    /// Root mean square over the agreeing corners, pixels.
    pub rms_px: f64,
}

/// A proposal comes from one small tag: others may be off by this much, as a part of their own size in the image, and
/// in pixels.
const LOOSE: (f64, f64) = (0.5, 6.0);
/// After refinement, the same.
const TIGHT: (f64, f64) = (0.03, 1.5);
/// How many proposals are refined.
const REFINED: usize = 4;
/// A second pose is kept whose error is at most this many times the first's: the images cannot tell them apart.
const RIVAL: f64 = 2.5;
/// Poses nearer than this (metres, radians) are one.
const SAME: f64 = 0.02;

/// The best pose, and the rival where the tags cannot tell it from its mirror image. Empty where no known tag is seen.
pub(crate) fn views_of_object(
    lens: &Lens,
    image: &ImageView,
    tags: &[TagPlacement],
) -> Vec<ObjectView> {
    let proposals = image.tags.iter().flat_map(|view| {
        let placed = tags[view.tag].as_ref();
        let branches = view.branches.iter();
        branches.filter_map(move |branch| placed.map(|(at, _)| branch * at.inverse()))
    });
    let mut scored: Vec<(f64, Pose)> = proposals
        .map(|pose| (votes(lens, image, tags, &pose), pose))
        .collect();
    scored.sort_by(|a, b| b.0.total_cmp(&a.0));
    scored.truncate(REFINED);
    let mut views: Vec<ObjectView> = Vec::new();
    for (_, proposal) in scored {
        let view = refined(lens, image, tags, proposal);
        let known = |other: &ObjectView| {
            se3::difference(&other.camera_from_object, &view.camera_from_object).amax() < SAME
        };
        if !view.agreeing.is_empty() && !views.iter().any(known) {
            views.push(view);
        }
    }
    best_of(views)
}

fn best_of(mut views: Vec<ObjectView>) -> Vec<ObjectView> {
    views.sort_by(|a, b| {
        let more = b.agreeing.len().cmp(&a.agreeing.len());
        more.then(a.rms_px.total_cmp(&b.rms_px))
    });
    let Some((n, rms)) = views.first().map(|v| (v.agreeing.len(), v.rms_px)) else {
        return views;
    };
    views.retain(|v| v.agreeing.len() == n && v.rms_px <= RIVAL * (rms + 0.1));
    views.truncate(2);
    views
}

/// How many tags agree, each counting less the further off it is.
fn votes(lens: &Lens, image: &ImageView, tags: &[TagPlacement], pose: &Pose) -> f64 {
    let votes = image.tags.iter().filter_map(|view| {
        let (at, size_m) = tags[view.tag].as_ref()?;
        let error = tag_error_px(lens, &(pose * at), *size_m, &view.corners.corners)?;
        let bound = LOOSE.0 * edge_px(&view.corners.corners) + LOOSE.1;
        Some((1.0 - error / bound).max(0.0))
    });
    votes.sum()
}

/// The agreeing tags of a pose, within a part of their size and some pixels.
fn agreeing(
    lens: &Lens,
    image: &ImageView,
    tags: &[TagPlacement],
    pose: &Pose,
    part: f64,
    px: f64,
) -> Vec<usize> {
    let agrees = |view: &crate::image_store::TagView| {
        let (at, size_m) = tags[view.tag].as_ref()?;
        let error = tag_error_px(lens, &(pose * at), *size_m, &view.corners.corners)?;
        (error <= part * edge_px(&view.corners.corners) + px).then_some(())
    };
    let seen = image.tags.iter().enumerate();
    seen.filter_map(|(index, view)| agrees(view).map(|()| index))
        .collect()
}

/// The tags of an image that a pose explains roughly: a start for an adjustment, which decides by itself.
pub(crate) fn agreeing_loosely(
    lens: &Lens,
    image: &ImageView,
    tags: &[TagPlacement],
    pose: &Pose,
) -> Vec<usize> {
    agreeing(lens, image, tags, pose, LOOSE.0, LOOSE.1)
}

fn refined(lens: &Lens, image: &ImageView, tags: &[TagPlacement], proposal: Pose) -> ObjectView {
    let mut pose = proposal;
    for bounds in [LOOSE, TIGHT] {
        let used = agreeing(lens, image, tags, &pose, bounds.0, bounds.1);
        pose = resected(lens, image, tags, &used, pose);
    }
    let agreeing = agreeing(lens, image, tags, &pose, TIGHT.0, TIGHT.1);
    let squares = agreeing.iter().filter_map(|&index| {
        let view = &image.tags[index];
        let (at, size_m) = tags[view.tag].as_ref()?;
        tag_error_px(lens, &(pose * at), *size_m, &view.corners.corners).map(|e| e * e)
    });
    let rms_px = (squares.sum::<f64>() / agreeing.len().max(1) as f64).sqrt();
    ObjectView {
        camera_from_object: pose,
        agreeing,
        rms_px,
    }
}

/// Root mean square distance of a tag's four corners from where a pose puts them; `None` where it cannot be seen there.
pub(crate) fn tag_error_px(
    lens: &Lens,
    camera_from_tag: &Pose,
    size_m: f64,
    corners: &[nalgebra::Point2<f64>; 4],
) -> Option<f64> {
    let mut sum = 0.0;
    for (in_tag, seen) in tag_corners_in_tag(size_m).iter().zip(corners) {
        sum += (lens.project(&(camera_from_tag * in_tag))? - seen).norm_squared();
    }
    Some((0.25 * sum).sqrt())
}

/// Mean edge of a tag in the image, pixels.
pub(crate) fn edge_px(corners: &[nalgebra::Point2<f64>; 4]) -> f64 {
    let edges = (0..4).map(|at| (corners[(at + 1) % 4] - corners[at]).norm());
    0.25 * edges.sum::<f64>()
}

/// The pose that fits the given tags of an image best; `start` where nothing better is found.
pub(crate) fn resected(
    lens: &Lens,
    image: &ImageView,
    tags: &[TagPlacement],
    used: &[usize],
    start: Pose,
) -> Pose {
    let seen = used.iter().filter_map(|&index| {
        let view = &image.tags[index];
        tags[view.tag].map(|placed| (view.seen(), placed))
    });
    let problem = Resection {
        lens,
        seen: seen.collect(),
    };
    if problem.seen.is_empty() {
        return start;
    }
    let options = Options {
        initial_damping: 1e-3,
        tolerance: 1e-4,
        ..Options::default()
    };
    minimise(&problem, start, &options).map_or(start, |solution| solution.state)
}

struct Resection<'a> {
    lens: &'a Lens,
    seen: Vec<(TagObservation, (Pose, f64))>,
}

impl Problem<6> for Resection<'_> {
    type State = Pose;

    fn linearise(&self, state: &Pose, equations: &mut NormalEquations<6>) -> Option<()> {
        let rotation = state.rotation.to_rotation_matrix();
        for (seen, (object_from_tag, size_m)) in &self.seen {
            for (corner, in_tag) in tag_corners_in_tag(*size_m).iter().enumerate() {
                let in_object = object_from_tag * in_tag;
                let (pixel, by_point) = self.lens.project_with_jacobian(&(state * in_object))?;
                let whitening = &seen.whitening[corner];
                let by_point = by_point * rotation.matrix();
                let mut by_step = Matrix2x6::zeros();
                by_step.fixed_columns_mut::<3>(0).copy_from(&by_point);
                by_step
                    .fixed_columns_mut::<3>(3)
                    .copy_from(&(-by_point * so3::hat(&in_object.coords)));
                let error = pixel - seen.corners[corner];
                let information = whitening.transpose() * whitening;
                equations.add(
                    &error,
                    &by_step,
                    &information,
                    Kernel::CauchyTails { width: 5.0 },
                );
            }
        }
        Some(())
    }

    fn step(&self, state: &Pose, step: &Vector6<f64>) -> Pose {
        let mut moved = state * se3::exp(step);
        moved.rotation.renormalize();
        moved
    }
}
