//! World frame and scale of a solved site.
//!
//! All lengths share one scale, that of the printed sizes, which no image shows to be wrong. A measured distance
//! corrects it: a scalar Kalman update of the logarithm of the scale with the prior of a printer.

use super::members::Members;
use super::solution::{SiteSolution, StillTag};
use super::{MeasuredDistance, SiteError, SitePlan};
use nalgebra::{DMatrix, Vector3};
use sextant_geometry::Pose;
use sextant_site_model::{SIZE_SIGMA, TagId};

/// The frame of the result.
pub(super) struct WorldFrame {
    /// Maps points of the adjustment's frame into the world, before lengths are scaled.
    pub world_from_adjusted: Pose,
    /// The tag that is the world, if any.
    pub tag: Option<TagId>,
}

/// Correction of all lengths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// By which all lengths of the adjustment are multiplied.
    pub factor: f64,
    /// What the measured distances contribute to it.
    pub correction: f64,
    /// Relative standard deviation that remains.
    pub sigma: f64,
}

impl WorldFrame {
    /// That of the requested static tag, else of the one that most cameras see, else of the reference camera.
    pub fn choose(plan: &SitePlan, found: &SiteSolution) -> Result<Self, SiteError> {
        let still = &found.still_tags();
        let id = |still: &StillTag| found.members.wanted[still.tag].tag;
        let chosen = match plan.world {
            Some(wanted) => {
                let chosen = still.iter().find(|still| id(still) == wanted);
                Some(
                    chosen
                        .ok_or_else(|| SiteError::World(wanted, why_not(wanted, &found.members)))?,
                )
            }
            None => still
                .iter()
                .max_by_key(|still| (still.n_cameras, std::cmp::Reverse(still.tag))),
        };
        let reference = &found.adjusted.solution.bundle.cameras[found.reference];
        Ok(match chosen {
            Some(still) => Self {
                world_from_adjusted: still.adjusted_from_tag.inverse(),
                tag: Some(id(still)),
            },
            None => Self {
                world_from_adjusted: reference.world_from_camera.inverse(),
                tag: None,
            },
        })
    }
}

fn why_not(tag: TagId, members: &Members) -> &'static str {
    let place = members.wanted.iter().position(|wanted| wanted.tag == tag);
    match place.map(|at| members.body_of[at]) {
        Some(Some(_)) => "it moves",
        Some(None) => "no camera that could be placed sees it",
        None => "no image shows it, or it moves by itself",
    }
}

impl Scale {
    /// By the measured distances; without any, that of the given sizes.
    pub fn from_distances(
        distances: &[MeasuredDistance],
        found: &SiteSolution,
    ) -> Result<Self, SiteError> {
        let covariance = found.covariance_at_known_scale();
        let (mut logarithm, mut variance) = (0.0_f64, SIZE_SIGMA * SIZE_SIGMA);
        let common = found.common_size_error();
        for distance in distances {
            let (estimated_m, sigma_m) = distance_between(distance, found, &covariance)?;
            let noise = (distance.sigma_m.powi(2) + sigma_m.powi(2)) / estimated_m.powi(2);
            let innovation = (distance.distance_m / estimated_m).ln() + common - logarithm;
            let gain = variance / (variance + noise);
            logarithm += gain * innovation;
            variance *= 1.0 - gain;
        }
        Ok(Self {
            factor: (logarithm - found.common_size_error()).exp(),
            correction: logarithm.exp(),
            sigma: variance.sqrt(),
        })
    }

    /// A pose whose position has this scale.
    pub fn apply(&self, pose: &Pose) -> Pose {
        let mut scaled = *pose;
        scaled.translation.vector *= self.factor;
        scaled
    }
}

/// The estimated distance of two tags and its standard deviation apart from the scale.
fn distance_between(
    distance: &MeasuredDistance,
    found: &SiteSolution,
    covariance: &DMatrix<f64>,
) -> Result<(f64, f64), SiteError> {
    let refused = |cause| SiteError::Distance(distance.tags[0], distance.tags[1], cause);
    let members = &found.members;
    let place = |tag: TagId| members.wanted.iter().position(|wanted| wanted.tag == tag);
    let [Some(a), Some(b)] = distance.tags.map(place) else {
        return Err(refused("one of them was not seen, or moves by itself"));
    };
    if members.body_of[a] != members.body_of[b] {
        return Err(refused("they move relative to each other"));
    }
    let bundle = &found.adjusted.solution.bundle;
    let still = found.still_tags();
    let position = |tag: usize| -> Option<Vector3<f64>> {
        match members.body_of[tag] {
            Some(_) => {
                let pose = bundle.tags[tag].object_from_tag;
                found.is_tag_placed(tag).then_some(pose.translation.vector)
            }
            None => {
                let own = still.iter().find(|still| still.tag == tag)?;
                Some(own.adjusted_from_tag.translation.vector)
            }
        }
    };
    let (Some(from), Some(to)) = (position(a), position(b)) else {
        return Err(refused("one of them could not be placed"));
    };
    let apart = to - from;
    let length = apart.norm();
    if length <= 0.0 {
        return Err(refused("they are one tag"));
    }
    let direction = apart / length;
    let block = |i: usize, j: usize| covariance.fixed_view::<3, 3>(6 * i, 6 * j).into_owned();
    let of_both = block(a, a) + block(b, b) - block(a, b) - block(b, a);
    let variance = direction.dot(&(of_both * direction));
    Ok((length, variance.max(0.0).sqrt()))
}
