//! Tests whether two tags are on the same rigid body, without knowing their sizes: their relative attitude is constant,
//! and so is their relative position with the right ratio of sizes.
//!
//! With unit tags, a tag's pose has its position in edges. For tags a and b of one body with sizes s_a and s_b = r s_a,
//! each image says `r R_a^-1 t_b - R_a^-1 t_a = c`, linear in the ratio r and the constant c (position of b in a's
//! frame, in edges of a). The tags' depth is what tells r; mirrored branches do not agree on the attitude.

use nalgebra::{Point2, UnitQuaternion, Vector3};
use sextant_geometry::planar_pose::tag_poses;
use sextant_geometry::{Lens, Pose};

/// Relative attitudes that differ by less agree, radians.
const AGREE: f64 = 0.2;
/// Least share of the views that must agree.
const MOST: f64 = 0.6;
/// Least number of views that must agree.
pub(super) const LEAST_VIEWS: usize = 4;
/// Relative positions may differ by this many edges, and by this part of the distance.
const SPREAD: (f64, f64) = (0.3, 0.012);
/// Share of the agreeing views that are used in the fit of position.
const INLIER_SHARE: f64 = 0.75;
/// Rounds of that fit.
const ROUNDS: usize = 4;
/// Ratios of sizes on one object.
const RATIOS: std::ops::Range<f64> = 0.05..20.0;

/// The poses that a tag's corners allow, positions in edges of the tag.
#[derive(Clone, Debug)]
pub(super) struct UnitPoses(Vec<Pose>);

impl UnitPoses {
    pub(super) fn from_corners(lens: &Lens, corners: &[Point2<f64>; 4]) -> Self {
        let poses = tag_poses(lens, corners, 1.0);
        Self(poses.iter().map(|pose| pose.camera_from_tag).collect())
    }
}

/// Two tags in one image.
#[derive(Clone, Debug)]
pub(super) struct PairView {
    /// For each pair of branches.
    proposals: Vec<Proposal>,
}

/// The relative pose that one pair of branches implies.
#[derive(Clone, Copy, Debug)]
struct Proposal {
    a_from_b: UnitQuaternion<f64>,
    /// `R_a^-1 t_b`, in edges of b.
    to_b: Vector3<f64>,
    /// `R_a^-1 t_a`, in edges of a.
    to_a: Vector3<f64>,
}

/// Rigid connection of two tags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Joint {
    /// Size of the second by that of the first.
    pub ratio: f64,
    /// Views that agree.
    pub views: usize,
}

impl PairView {
    pub(super) fn between(a: &UnitPoses, b: &UnitPoses) -> Self {
        let both = a.0.iter().flat_map(|a| b.0.iter().map(move |b| (a, b)));
        let proposal = |(a, b): (&Pose, &Pose)| {
            let turn = a.rotation.inverse();
            Proposal {
                a_from_b: turn * b.rotation,
                to_b: turn * b.translation.vector,
                to_a: turn * a.translation.vector,
            }
        };
        Self {
            proposals: both.map(proposal).collect(),
        }
    }

    /// The proposal nearest to a relative attitude, if it agrees.
    fn nearest(&self, a_from_b: &UnitQuaternion<f64>) -> Option<&Proposal> {
        let angle = |proposal: &&Proposal| proposal.a_from_b.angle_to(a_from_b);
        let nearest = self
            .proposals
            .iter()
            .min_by(|x, y| angle(x).total_cmp(&angle(y)));
        nearest.filter(|proposal| angle(proposal) < AGREE)
    }
}

/// The joint of two tags, if they are on the same body.
pub(super) fn joint(views: &[PairView]) -> Option<Joint> {
    let agreeing = agreeing(views);
    let enough = (MOST * views.len() as f64).ceil() as usize;
    if agreeing.len() < enough.max(LEAST_VIEWS) {
        return None;
    }
    let (ratio, residuals) = position(&agreeing)?;
    let away = median(agreeing.iter().map(|p| p.to_a.norm()).collect())?;
    let fits = median(residuals)? < SPREAD.0 + SPREAD.1 * away;
    (fits && RATIOS.contains(&ratio)).then_some(Joint {
        ratio,
        views: agreeing.len(),
    })
}

/// The proposals that agree with the relative attitude of the largest consensus.
fn agreeing(views: &[PairView]) -> Vec<&Proposal> {
    let candidates = views.iter().flat_map(|view| &view.proposals);
    let with = |candidate: &Proposal| -> Vec<&Proposal> {
        let nearest = |view| PairView::nearest(view, &candidate.a_from_b);
        views.iter().filter_map(nearest).collect()
    };
    let mut best = Vec::new();
    for candidate in candidates {
        let supporters = with(candidate);
        if supporters.len() > best.len() {
            best = supporters;
        }
    }
    best
}

/// Ratio of sizes, and what is left of every view's relative position, in edges of the first.
fn position(views: &[&Proposal]) -> Option<(f64, Vec<f64>)> {
    let ratios = views.iter().map(|p| p.to_a.norm() / p.to_b.norm());
    let mut ratio = median(ratios.collect())?;
    let relative = |ratio: f64| views.iter().map(move |p| p.to_b * ratio - p.to_a);
    let axis = |axis: usize| median(relative(ratio).map(|at| at[axis]).collect());
    let mut place = Vector3::new(axis(0)?, axis(1)?, axis(2)?);
    for _ in 0..ROUNDS {
        let consistent = consistent(views, ratio, &place);
        (ratio, place) = fitted(&consistent)?;
    }
    let residuals = relative(ratio).map(|at| (at - place).norm());
    Some((ratio, residuals.collect()))
}

fn consistent<'a>(views: &[&'a Proposal], ratio: f64, place: &Vector3<f64>) -> Vec<&'a Proposal> {
    let off = |p: &&Proposal| (p.to_b * ratio - p.to_a - place).norm();
    let mut sorted = views.to_vec();
    sorted.sort_by(|x, y| off(x).total_cmp(&off(y)));
    sorted.truncate((INLIER_SHARE * views.len() as f64).ceil() as usize);
    sorted
}

/// Least squares for the ratio and the constant.
fn fitted(views: &[&Proposal]) -> Option<(f64, Vector3<f64>)> {
    let n = views.len() as f64;
    let mean =
        |of: fn(&Proposal) -> Vector3<f64>| views.iter().map(|p| of(p)).sum::<Vector3<f64>>() / n;
    let (to_b, to_a) = (mean(|p| p.to_b), mean(|p| p.to_a));
    let (mut square, mut product) = (0.0, 0.0);
    for view in views {
        let own = view.to_b - to_b;
        square += own.norm_squared();
        product += own.dot(&(view.to_a - to_a));
    }
    let ratio = product / square;
    (ratio.is_finite() && ratio > 0.0).then(|| (ratio, to_b * ratio - to_a))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values
        .get(values.len() / 2)
        .copied()
        .filter(|v| v.is_finite())
}
