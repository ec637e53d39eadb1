//! The stages from images to the adjusted site.

use super::constellations::{Constellations, bundle_tags, constellations, sightings};
use super::focal_length::focal_length;
use super::members::{BodyViews, Members};
use super::scales::contradictions;
use super::solution::SiteSolution;
use super::{CalibratedSite, SiteError, SiteSession};
use crate::adjustment::{Adjustment, AdjustmentResult};
use crate::discovery::TagGroups;
use crate::graph::PoseGraph;
use crate::priors::Priors;
use crate::rig::clocks::{self, Clocks};
use crate::rig::comparison::options;
use crate::rig::instants::{carried_in, floor_in, give_twists};
use crate::rig::pairs::joined_cameras;
use crate::rig::sightings::Sightings;
use crate::rig::trajectory::{Moments, Trajectory, is_synchronised};
use crate::verdict::listed;
use sextant_adjustment::{BodyId, BundleCamera, Freedom};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_site_model::{Camera, CameraId, Prior, Rig};
use std::collections::BTreeSet;

/// Rounds of lenses and constellations from each image by itself: the poses of single tags that they begin with depend
/// on the lens.
const ROUNDS: usize = 2;
/// Images of a static tag in a camera that are used: the errors of more are the same.
const MOST_STILL: usize = 12;

/// Images of bodies that are used of free-running cameras, where each costs more, since its motion is sought, too. Of
/// more, only every second stretch of this length is used, or every third.
const MOST_FREE_RUNNING: usize = 8000;
const STRETCH_NS: u64 = 500_000_000;

/// Cameras and where they are, before the adjustment.
struct Placement {
    /// `world_from_camera`, in the frame of the reference; `None` for a camera without common views.
    poses: Vec<Option<Pose>>,
    reference: usize,
    synchronised: bool,
}

impl SiteSession {
    /// Solves for the whole site. Cameras and tags that cannot be placed are named in the report.
    ///
    /// # Errors
    /// If no two cameras can be placed or no object learned, with reason and remedy.
    pub fn solve(&self) -> Result<CalibratedSite, SiteError> {
        let rig = self.first_rig()?;
        let groups = TagGroups::from_images(&rig, self.images.iter(), &self.plan.families);
        let mut members = self.members(groups)?;
        let (mut rig, mut known) = self.known_from_single_images(rig, &members)?;
        let seen = self.body_views(&rig, &members);
        let contradictions = contradictions(&rig, &members, &seen, &known);
        if !contradictions.is_empty() {
            for found in &contradictions {
                members.rescale(found.body, found.ratio);
            }
            (rig, known) = self.known_from_single_images(rig, &members)?;
        }
        let seen = self.body_views(&rig, &members).thinned(rig.cameras().len());
        let sightings = sightings(&rig, &members, &seen, &known);
        let placement = placement(&rig, &members, &seen, &sightings)?;
        let first = adjustment(&rig, &members, &known, &seen, &sightings, &placement);
        let (adjusted, clocks) = adjusted(first, &sightings, placement.synchronised)?;
        self.finish(SiteSolution {
            rig,
            members,
            seen,
            adjusted,
            clocks,
            is_placed: placement.poses.iter().map(Option::is_some).collect(),
            reference: placement.reference,
            synchronised: placement.synchronised,
            contradictions,
        })
    }

    /// The rig with the lenses, and the constellations, that images tell one by one.
    fn known_from_single_images(
        &self,
        mut rig: Rig,
        members: &Members,
    ) -> Result<(Rig, Constellations), SiteError> {
        let mut known = None;
        for _ in 0..ROUNDS {
            let seen = self.body_views(&rig, members);
            let found = constellations(&rig, members, &seen)?;
            rig = with_lenses(&rig, &found.lenses)?;
            known = Some(found);
        }
        let tags = members.wanted.iter().map(|wanted| wanted.tag);
        let known = known.filter(|known| known.placed.iter().any(Option::is_some));
        let known = known.ok_or_else(|| SiteError::NoObject(listed(tags)))?;
        Ok((rig, known))
    }

    /// Cameras none of whose images shows a tag: nothing is known of their lenses. None where that is so of all.
    pub(super) fn blind_cameras(&self) -> Vec<CameraId> {
        let is_seeing = |id: &CameraId| {
            let mut own = self.images.iter().filter(|image| image.camera == *id);
            own.any(|image| {
                let mut tags = image.tags.iter();
                tags.any(|seen| self.plan.families.contains(&seen.tag.family))
            })
        };
        let ids = self.plan.cameras.iter().map(|(id, _)| id.clone());
        let (seeing, blind): (Vec<CameraId>, Vec<CameraId>) = ids.partition(is_seeing);
        if seeing.is_empty() { seeing } else { blind }
    }

    /// Every camera that sees a tag, with a lens from its single tags.
    fn first_rig(&self) -> Result<Rig, SiteError> {
        let blind = self.blind_cameras();
        let cameras = self
            .plan
            .cameras
            .iter()
            .filter(|(id, _)| !blind.contains(id));
        let cameras = cameras.map(|(id, resolution)| {
            let own = self.images.iter().filter(|image| image.camera == *id);
            let tags = own.flat_map(|image| image.tags.iter().map(|tag| &tag.corners));
            let focal = focal_length(tags, *resolution);
            let [width, height] = resolution.map(f64::from);
            let numbers = Intrinsics {
                fx: focal,
                fy: focal,
                cx: (width - 1.0) / 2.0,
                cy: (height - 1.0) / 2.0,
            };
            let lens = Lens::brown_conrady(numbers, [0.0; 5]);
            lens.map(|lens| Camera::new(id.clone(), *resolution, lens, None))
        });
        let cameras: Result<Vec<Camera>, _> = cameras.collect();
        let cameras = cameras.map_err(|error| SiteError::Result(error.to_string()))?;
        Rig::new(cameras).map_err(|error| SiteError::Result(error.to_string()))
    }

    fn members(&self, groups: TagGroups) -> Result<Members, SiteError> {
        if groups.bodies.is_empty() && groups.loose.is_empty() {
            return Err(match groups.still.as_slice() {
                [] => SiteError::NothingSeen(self.images.n_received()),
                still => SiteError::NothingMoves(listed(still)),
            });
        }
        Ok(Members::from_groups(&self.plan, groups))
    }
}

fn with_lenses(rig: &Rig, lenses: &[Lens]) -> Result<Rig, SiteError> {
    let cameras = rig.cameras().iter().zip(lenses);
    let cameras = cameras.map(|(camera, lens)| Camera {
        lens: *lens,
        ..camera.clone()
    });
    Rig::new(cameras.collect()).map_err(|error| SiteError::Result(error.to_string()))
}

/// Approximate poses of the largest group of cameras that common views connect.
fn placement(
    rig: &Rig,
    members: &Members,
    seen: &BodyViews,
    sightings: &Sightings,
) -> Result<Placement, SiteError> {
    let sighting = |at: usize| {
        let poses = sightings.object[at].iter().map(|o| o.camera_from_object);
        (seen.views[at].capture_ns, poses.collect())
    };
    let n = rig.cameras().len();
    let trajectory = |body: Option<usize>, camera: usize| {
        let views = (0..seen.views.len()).filter(|&at| {
            let is_body = body.is_none_or(|body| seen.body_of[at] == Some(body));
            is_body && seen.views[at].camera == camera
        });
        Trajectory::from_sightings(views.map(sighting).collect())
    };
    let of_all: Vec<Trajectory> = (0..n).map(|camera| trajectory(None, camera)).collect();
    let bodies = (0..members.n_bodies).map(|body| {
        (0..n)
            .map(|camera| trajectory(Some(body), camera))
            .collect()
    });
    let bodies: Vec<Vec<Trajectory>> = bodies.collect();
    let synchronised = is_synchronised(&of_all);
    let exact = synchronised.then(|| joined_cameras(&bodies, Moments::Exact));
    let exact = exact.filter(|pairs| largest_island(pairs).len() == n);
    // Cameras without a common time may still be connected by the motion of objects between their images.
    let synchronised = exact.is_some();
    let pairs = exact.unwrap_or_else(|| joined_cameras(&bodies, Moments::Interpolated));
    let island = largest_island(&pairs);
    match island.as_slice() {
        [reference, _, ..] => Ok(Placement {
            poses: pairs.placed(*reference),
            reference: *reference,
            synchronised,
        }),
        _ if n == 1 => Ok(Placement {
            poses: vec![Some(Pose::identity())],
            reference: 0,
            synchronised: true,
        }),
        _ => Err(SiteError::NotConnected),
    }
}

/// The cameras of the largest connected group, in ascending order.
fn largest_island(pairs: &PoseGraph) -> Vec<usize> {
    let of = pairs.islands();
    let members = |island: usize| -> Vec<usize> {
        let cameras = of.iter().enumerate();
        cameras
            .filter(|(_, of)| **of == island)
            .map(|(camera, _)| camera)
            .collect()
    };
    let islands: BTreeSet<usize> = of.iter().copied().collect();
    let groups = islands.into_iter().rev().map(members);
    groups.max_by_key(Vec::len).unwrap_or_default()
}

/// The cameras, free but for the reference, with those parameters of the lenses free that nothing is known of.
fn bundle_cameras(rig: &Rig, placement: &Placement, priors: &mut Priors) -> Vec<BundleCamera> {
    let cameras = rig.cameras().iter().zip(&placement.poses).enumerate();
    let cameras = cameras.map(|(at, (camera, pose))| BundleCamera {
        pose: if pose.is_some() && at != placement.reference {
            Freedom::Free
        } else {
            Freedom::Fixed
        },
        middle_row: clocks::middle_row(camera),
        ..BundleCamera::with_known_lens(camera.lens, pose.unwrap_or_default())
    });
    let mut cameras: Vec<BundleCamera> = cameras.collect();
    for (at, camera) in rig.cameras().iter().enumerate() {
        if placement.poses[at].is_some() {
            priors.free_unknown_lens(&mut cameras, at, camera.resolution);
        }
    }
    cameras
}

fn adjustment(
    rig: &Rig,
    members: &Members,
    known: &Constellations,
    seen: &BodyViews,
    sightings: &Sightings,
    placement: &Placement,
) -> Adjustment {
    let mut priors = Priors::bounded();
    let cameras = bundle_cameras(rig, placement, &mut priors);
    let every = if placement.synchronised {
        1
    } else {
        seen.views.len().div_ceil(MOST_FREE_RUNNING) as u64
    };
    let is_placed = |view: usize| placement.poses[seen.views[view].camera].is_some();
    let is_used = |view: usize| {
        let stretch = seen.views[view].capture_ns / STRETCH_NS;
        is_placed(view) && stretch.is_multiple_of(every)
    };
    let all: Vec<usize> = (0..seen.views.len()).filter(|&at| is_placed(at)).collect();
    let (mut instants, mut images) = floor_in(&all, sightings, &cameras);
    let mut tags = bundle_tags(members, &known.placed);
    for tag in 0..tags.len() {
        let is_still = members.body_of[tag].is_none();
        if known.placed[tag].is_some() || (is_still && is_seen_twice(seen, &all, tag)) {
            priors.free_size(&mut tags, tag, Prior::Default);
        }
    }
    for body in 0..members.n_bodies {
        let (mut own, mut own_images) = (Vec::new(), Vec::new());
        let views: Vec<usize> = seen
            .of_body(Some(body))
            .filter(|&view| is_used(view))
            .collect();
        let id = BodyId::Moving(body);
        carried_in(&views, id, sightings, &cameras, &mut own, &mut own_images);
        give_twists(&mut own);
        for image in &mut own_images {
            image.instant += instants.len();
        }
        instants.append(&mut own);
        images.append(&mut own_images);
    }
    Adjustment {
        cameras,
        tags,
        instants,
        images,
        motion: None,
        priors,
        arm: None,
        noise: Vec::new(),
    }
}

/// Whether a tag is in views of two cameras.
fn is_seen_twice(seen: &BodyViews, views: &[usize], tag: usize) -> bool {
    let views = views.iter().map(|&at| &seen.views[at]);
    let views = views.filter(|view| view.tags.iter().any(|seen| seen.tag == tag));
    views.map(|view| view.camera).collect::<BTreeSet<_>>().len() > 1
}

fn adjusted(
    first: Adjustment,
    sightings: &Sightings,
    synchronised: bool,
) -> Result<(AdjustmentResult, Clocks), SiteError> {
    let views = &sightings.views;
    if !synchronised {
        return Ok(clocks::of_free_running(first, views)?);
    }
    let n = first.cameras.len();
    let still = first.solve(views, &options())?;
    Ok(match clocks::of_synchronised(&still, views)? {
        Some((start, _)) => clocks::solved(start, views)?,
        None => (still, vec![None; n]),
    })
}

impl BodyViews {
    /// Without most images of the tags that stand still: at most [`MOST_STILL`] of each camera, from all over the
    /// recording.
    pub(super) fn thinned(mut self, n_cameras: usize) -> Self {
        let mut kept: BTreeSet<usize> = BTreeSet::new();
        for camera in 0..n_cameras {
            let own = self.of_body(None);
            let own: Vec<usize> = own.filter(|&at| self.views[at].camera == camera).collect();
            let n = own.len().min(MOST_STILL);
            kept.extend((0..n).map(|k| own[k * own.len() / n]));
        }
        let is_kept = |at: usize, body: &Option<usize>| body.is_some() || kept.contains(&at);
        let flags: Vec<bool> = self
            .body_of
            .iter()
            .enumerate()
            .map(|(at, body)| is_kept(at, body))
            .collect();
        let mut flag = flags.iter();
        self.views.retain(|_| flag.next().copied().unwrap_or(true));
        let mut flag = flags.iter();
        self.body_of
            .retain(|_| flag.next().copied().unwrap_or(true));
        self
    }
}
