//! From the images of a session to the cameras' poses: consensus, spanning tree, adjustment, clocks, frame.

use super::clocks::{Clocked, Clocks};
use super::instants::{carried, floor};
use super::pairs::joined_cameras;
use super::report::Found;
use super::trajectory::{Moments, Trajectory};
use super::{Calibrated, RigError, RigSession, clocks, stillness};
use crate::adjustment::Adjustment;
use crate::bundle::{BundleCamera, BundleOptions, BundleTag, Freedom};
use crate::intake::{ImageView, take_in};
use crate::resection::{ObjectView, Placed, views_of_object};
use crate::verdict::listed;
use sextant_estimator::CameraId;
use sextant_geometry::Pose;
use std::collections::BTreeSet;

/// Images, what each shows, and where the object may be in each.
pub(super) struct Sightings {
    pub views: Vec<ImageView>,
    pub object: Vec<Vec<ObjectView>>,
    pub placed: Vec<Placed>,
    /// Number of the carried object's tags; further ones lie on the floor.
    pub n_carried: usize,
    /// Whether the object's tags were unknown and are sought too.
    pub seeking_tags: bool,
}

/// A ratio of errors to stated noise above which the cameras' names are doubted.
const SUSPICIOUS: f64 = 2.5;
/// More than this part of images with a partner at the same time: shutters are synchronised.
const SYNCHRONISED: f64 = 0.5;

impl RigSession {
    /// Finds the cameras.
    ///
    /// # Errors
    /// When the images cannot place every camera, with the reason and a remedy.
    pub fn solve(&self) -> Result<Calibrated, RigError> {
        self.coverage
            .check(&self.rig, &self.plan, self.images.came())?;
        let (sightings, first, synchronised) = self.first()?;
        let found = self.adjusted(&sightings, &first, synchronised);
        // Swapped names look like moves and like clocks that are off.
        let suspicious = match &found {
            Ok((adjusted, clocks)) => {
                let odd = adjusted.adjusted.solution.variance_factor > SUSPICIOUS * SUSPICIOUS;
                odd || synchronised && clocks.iter().any(Option::is_some)
            }
            Err(_) => true,
        };
        if suspicious && let Some(swapped) = self.swapped_names(&sightings, &first) {
            return Err(swapped);
        }
        let (adjusted, clocks) = found?;
        self.finish(Found {
            sightings,
            adjusted,
            clocks,
            synchronised,
        })
    }

    fn adjusted(
        &self,
        sightings: &Sightings,
        first: &Adjustment,
        synchronised: bool,
    ) -> Result<(Clocked, Clocks), RigError> {
        stillness::check_at_start(&self.rig, sightings, first)?;
        let (adjusted, clocks) = if synchronised {
            let off = clocks::off(first, &sightings.views)?;
            clocks::of_synchronised(&self.rig, first.clone(), sightings, off)?
        } else {
            clocks::of_free_running(first.clone(), &sightings.views)?
        };
        stillness::check(&self.rig, &adjusted, sightings)?;
        Ok((adjusted, clocks))
    }

    /// The start of the adjustment, and whether shutters are synchronised.
    pub(super) fn first(&self) -> Result<(Sightings, Adjustment, bool), RigError> {
        let sightings = self.sightings()?;
        let trajectories = self.trajectories(&sightings);
        let together =
            is_synchronised(&trajectories).then(|| self.joined(&trajectories, Moments::Taken));
        // Cameras that are joined at no common moment may still be by the object's motion between their images.
        let (start, synchronised) = match together {
            Some(Ok(start)) => (start, true),
            _ => (self.joined(&trajectories, Moments::Any)?, false),
        };
        let first = self.adjustment(&sightings, &start);
        Ok((sightings, first, synchronised))
    }

    fn sightings(&self) -> Result<Sightings, RigError> {
        let (placed, seeking_tags) = self.placed()?;
        let views = self.views();
        let object = views.iter().map(|view| {
            let lens = &self.rig.cameras()[view.camera].lens;
            views_of_object(lens, view, &placed)
        });
        Ok(Sightings {
            object: object.collect(),
            views,
            placed,
            n_carried: self.n_carried(),
            seeking_tags,
        })
    }

    fn views(&self) -> Vec<ImageView> {
        let views = self.images.iter().filter_map(|image| {
            let index = self.camera_of(image)?;
            let camera = &self.rig.cameras()[index];
            let (view, _) = take_in((index, camera), &self.wanted, image);
            (!view.tags.is_empty()).then_some(view)
        });
        views.collect()
    }

    /// The object's tags; learned from the images where they are not known. Tags on the floor are no part of it.
    fn placed(&self) -> Result<(Vec<Placed>, bool), RigError> {
        let known = self.plan.object.is_learned();
        let object = if known {
            self.plan.object.clone()
        } else {
            self.learned_object()?
        };
        let place = |at: usize| {
            let wanted = &self.wanted[at];
            let tag = object.tags().iter().find(|t| t.tag == wanted.tag);
            let tag = tag.filter(|_| at < self.n_carried())?;
            Some((tag.object_from_tag?, tag.size_m))
        };
        Ok(((0..self.wanted.len()).map(place).collect(), !known))
    }

    fn trajectories(&self, sightings: &Sightings) -> Vec<Trajectory> {
        let of = |camera: usize| {
            let own = sightings.views.iter().zip(&sightings.object);
            let own = own
                .filter(|(view, _)| view.camera == camera)
                .map(|(view, object)| {
                    let poses = object.iter().map(|o| o.camera_from_object);
                    (view.capture_ns, poses.collect())
                });
            Trajectory::of(own.collect())
        };
        (0..self.rig.cameras().len()).map(of).collect()
    }

    /// `world_from_camera` of every camera, roughly.
    fn joined(&self, trajectories: &[Trajectory], moments: Moments) -> Result<Vec<Pose>, RigError> {
        let pairs = joined_cameras(trajectories, moments);
        let reference = self.plan.origin.reference(&self.rig);
        let of = pairs.islands();
        let apart: Vec<usize> = (0..of.len())
            .filter(|&at| of[at] != of[reference])
            .collect();
        if !apart.is_empty() {
            return Err(self.not_connected(trajectories, &of, &apart));
        }
        let world = self.rig.cameras()[reference]
            .world_from_camera
            .unwrap_or_default();
        let placed = pairs.placed(reference);
        Ok(placed
            .into_iter()
            .map(|pose| world * pose.unwrap_or_default())
            .collect())
    }

    fn not_connected(
        &self,
        trajectories: &[Trajectory],
        of: &[usize],
        apart: &[usize],
    ) -> RigError {
        let id = |at: usize| &self.rig.cameras()[at].id;
        let blind: Vec<&CameraId> = apart
            .iter()
            .filter(|at| trajectories[**at].is_empty())
            .map(|&at| id(at))
            .collect();
        if !blind.is_empty() {
            return RigError::NotConnected {
                cameras: format!(
                    "camera {} never saw the object, so it shares no view",
                    listed(blind)
                ),
                hint: "carry the object through what it sees, or take it out of the rig file"
                    .to_owned(),
            };
        }
        let island = of[apart[0]];
        let lost: Vec<usize> = apart
            .iter()
            .copied()
            .filter(|&at| of[at] == island)
            .collect();
        let rest: Vec<&CameraId> = (0..of.len())
            .filter(|at| !lost.contains(at))
            .map(id)
            .collect();
        let (word, verb) = if lost.len() > 1 {
            ("cameras", "share")
        } else {
            ("camera", "shares")
        };
        RigError::NotConnected {
            cameras: format!(
                "{word} {} {verb} no view",
                listed(lost.iter().map(|&at| id(at)))
            ),
            hint: format!(
                "hold the object where one of them and one of {} see it at the same time",
                listed(rest)
            ),
        }
    }

    fn adjustment(&self, sightings: &Sightings, start: &[Pose]) -> Adjustment {
        let reference = self.plan.origin.reference(&self.rig);
        let cameras = self.rig.cameras().iter().zip(start).enumerate();
        let cameras = cameras.map(|(at, (camera, pose))| BundleCamera {
            pose: if at == reference {
                Freedom::Fixed
            } else {
                Freedom::Free
            },
            ..BundleCamera::with_known_lens(camera.lens, *pose)
        });
        let cameras: Vec<BundleCamera> = cameras.collect();
        let (mut instants, mut images) = floor(sightings, &cameras);
        carried(sightings, &cameras, &mut instants, &mut images);
        Adjustment {
            tags: self.bundle_tags(sightings),
            cameras,
            instants,
            images,
            motion: None,
        }
    }

    /// Tags that lie still and that several cameras saw: their sizes follow from where the cameras are.
    pub(super) fn still_tags_with_size(&self, views: &[ImageView]) -> Vec<usize> {
        let cameras = |tag: usize| -> BTreeSet<usize> {
            let own = views.iter().filter(|v| v.tags.iter().any(|t| t.tag == tag));
            own.map(|view| view.camera).collect()
        };
        (self.n_carried()..self.wanted.len())
            .filter(|tag| cameras(*tag).len() > 1)
            .collect()
    }

    fn bundle_tags(&self, sightings: &Sightings) -> Vec<BundleTag> {
        let frame = sightings.placed.iter().position(Option::is_some);
        let measured = self.still_tags_with_size(&sightings.views);
        let tags = self.wanted.iter().zip(&sightings.placed).enumerate();
        let tags = tags.map(|(at, (wanted, placed))| {
            let sought = sightings.seeking_tags && placed.is_some() && Some(at) != frame;
            BundleTag {
                object_from_tag: placed.map_or_else(Pose::identity, |(pose, _)| pose),
                size_m: wanted.size_m,
                pose: if sought {
                    Freedom::Free
                } else {
                    Freedom::Fixed
                },
                // All lengths rest on the object: a tag that lies still and is stated wrong must not bend the rig.
                size: if measured.contains(&at) {
                    Freedom::Free
                } else {
                    Freedom::Fixed
                },
            }
        });
        tags.collect()
    }
}

fn is_synchronised(trajectories: &[Trajectory]) -> bool {
    let part = |at: usize| {
        let others = trajectories
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != at);
        let others: Vec<&Trajectory> = others.map(|(_, trajectory)| trajectory).collect();
        trajectories[at].part_shared(&others)
    };
    let parts: Vec<f64> = (0..trajectories.len()).map(part).collect();
    parts.iter().sum::<f64>() >= SYNCHRONISED * parts.len() as f64
}

/// Options of every adjustment of a rig.
pub(super) fn options() -> BundleOptions {
    BundleOptions::default()
}
