//! Solves for the camera poses of a session: consensus, spanning tree, adjustment, clocks, frame.

use super::clocks::{Clocks, middle_row};
use super::comparison::{BETTER, left_by, options};
use super::former::FormerDifference;
use super::instants::{carried, floor};
use super::pairs::joined_cameras;
use super::report::RigSolution;
use super::sightings::Sightings;
use super::trajectory::{Moments, Trajectory, is_synchronised};
use super::{CalibratedRig, RigError, RigSession, clocks, stillness};
use crate::adjustment::{Adjustment, AdjustmentResult};
use crate::image_store::ImageView;
use crate::priors::Priors;
use crate::resection::{TagPlacement, views_of_object};
use crate::verdict::{Finding, Grade, listed};
use sextant_adjustment::{BundleCamera, BundleTag, Freedom};
use sextant_geometry::Pose;
use sextant_site_model::{Camera, CameraId, Prior, Rig};
use std::collections::BTreeSet;

/// Relative error of a focal length from which camera names may be swapped.
const SUSPICIOUS: f64 = 0.015;
impl RigSession {
    /// Solves for the camera poses. Cameras that cannot be placed keep their entries and are named in
    /// [`RigReport::unsolved`](super::RigReport::unsolved).
    ///
    /// # Errors
    /// If no two cameras can be placed, with reason and remedy.
    pub fn solve(&self) -> Result<CalibratedRig, RigError> {
        let refused = match self.solve_all() {
            Err(refused) => refused,
            calibrated => return calibrated,
        };
        let (RigError::NotConnected { apart, .. } | RigError::Stranger { apart, .. }) = &refused
        else {
            return Err(refused);
        };
        let Some(fewer) = self.without(apart) else {
            return Err(refused);
        };
        let mut found = fewer.solve()?;
        found.report.unsolved.insert(0, refused.to_string());
        found
            .report
            .verdict
            .add(Grade::Usable, Finding::Unplaced(refused.to_string()));
        found.report.images = self.images.stored.n_received();
        found.rig = self.with_former(&found.rig)?;
        Ok(found)
    }

    /// The rig with all cameras; unsolved ones keep their entries.
    fn with_former(&self, found: &Rig) -> Result<Rig, RigError> {
        let cameras = self.images.rig.cameras().iter();
        let cameras = cameras.map(|camera| found.camera(&camera.id).unwrap_or(camera).clone());
        Rig::new(cameras.collect()).map_err(|error| RigError::Undetermined(error.to_string()))
    }

    /// Solves for every camera.
    fn solve_all(&self) -> Result<CalibratedRig, RigError> {
        self.coverage.check(&self.images, &self.plan)?;
        let (sightings, first, synchronised) = self.first()?;
        let found = self.adjusted(&sightings, &first, synchronised);
        // Swapped names look like moved cameras, clock offsets and wrong lenses.
        let suspicious = found.as_ref().map_or(true, |(_, clocks)| {
            synchronised && clocks.iter().any(Option::is_some)
        });
        if (suspicious || self.doubts_lenses(&found))
            && let Some(swapped) = self.swapped_names(&sightings, &first)
        {
            return Err(swapped);
        }
        let (adjusted, clocks) = found?;
        let solved = &adjusted.solution.bundle.cameras;
        let poses: Vec<Pose> = solved
            .iter()
            .map(|camera| camera.world_from_camera)
            .collect();
        let former = FormerDifference::between(&self.images.rig, &poses, &self.plan.object);
        self.finish(RigSolution {
            former: former.filter(|former| !former.is_none()),
            sightings,
            adjusted,
            clocks,
            synchronised,
        })
    }

    /// Whether the error of a focal length exceeds that of any calibration.
    fn doubts_lenses(&self, found: &Result<(AdjustmentResult, Clocks), RigError>) -> bool {
        let Ok((adjusted, _)) = found else {
            return true;
        };
        let solved = &adjusted.solution.bundle.cameras;
        let off = self
            .images
            .rig
            .cameras()
            .iter()
            .zip(solved)
            .map(|(was, is)| is.lens.intrinsics().fx / was.lens.intrinsics().fx - 1.0);
        off.into_iter().any(|off: f64| off.abs() > SUSPICIOUS)
    }

    fn adjusted(
        &self,
        sightings: &Sightings,
        first: &Adjustment,
        synchronised: bool,
    ) -> Result<(AdjustmentResult, Clocks), RigError> {
        let views = &sightings.views;
        stillness::check_at_start(&self.images.rig, sightings, first)?;
        if !synchronised {
            let found = clocks::of_free_running(first.clone(), views)?;
            let moved = stillness::moved(&self.images.rig, &found.0, sightings)?;
            return moved.map_or(Ok(found), |(moved, _)| Err(moved));
        }
        let still = first.clone().solve(views, &options())?;
        let moved = stillness::moved(&self.images.rig, &still, sightings)?;
        let clocks = clocks::of_synchronised(&still, views)?;
        // A camera that moved looks like a clock offset, and at low rates the motion model bends to fit anything:
        // a move that explains the images nearly as well takes precedence.
        let n = self.images.rig.cameras().len();
        match (moved, clocks) {
            (None, None) => Ok((still, vec![None; n])),
            (Some((moved, _)), None) => Err(moved),
            (None, Some((start, _))) => clocks::solved(start, views),
            (Some((moved, apart)), Some((start, timed))) => {
                let left = left_by(&apart, &timed, n);
                let [apart, timed] = left.map(|cameras| cameras.iter().sum::<f64>());
                if apart < BETTER * timed {
                    return Err(moved);
                }
                clocks::solved(start, views)
            }
        }
    }

    /// The start of the adjustment, and whether shutters are synchronised.
    pub(super) fn first(&self) -> Result<(Sightings, Adjustment, bool), RigError> {
        let sightings = self.sightings()?;
        self.check_arrangement(&sightings)?;
        let trajectories = self.trajectories(&sightings);
        let together =
            is_synchronised(&trajectories).then(|| self.joined(&trajectories, Moments::Exact));
        // Cameras without a common time may still be connected by the object's motion between their images.
        let (start, synchronised) = match together {
            Some(Ok(start)) => (start, true),
            _ => (self.joined(&trajectories, Moments::Interpolated)?, false),
        };
        let first = self.adjustment(&sightings, &start);
        Ok((sightings, first, synchronised))
    }

    /// Refuses cameras that show something else than the object.
    fn check_arrangement(&self, sightings: &Sightings) -> Result<(), RigError> {
        let strangers = sightings.strangers(self.images.rig.cameras().len());
        if strangers.is_empty() {
            return Ok(());
        }
        let id = |at: &usize| self.images.rig.cameras()[*at].id.clone();
        let apart: Vec<CameraId> = strangers.iter().map(id).collect();
        let word = if apart.len() > 1 { "cameras" } else { "camera" };
        Err(RigError::Stranger {
            cameras: format!("{word} {}", listed(&apart)),
            apart,
            object: self.plan.object.id().clone(),
        })
    }

    fn sightings(&self) -> Result<Sightings, RigError> {
        let (placed, seeking_tags, unplaced) = self.placed()?;
        let views = self.images.views();
        let object = views.iter().map(|view| {
            let lens = &self.images.rig.cameras()[view.camera].lens;
            views_of_object(lens, view, &placed)
        });
        Ok(Sightings {
            object: object.collect(),
            views,
            placed,
            n_carried: self.n_carried(),
            seeking_tags,
            unplaced,
        })
    }

    /// The tags of the object, without those on the floor; learned from the images if they are unknown.
    fn placed(&self) -> Result<(Vec<TagPlacement>, bool, Vec<String>), RigError> {
        let known = self.plan.object.is_learned();
        let (object, unplaced) = if known {
            (self.plan.object.clone(), Vec::new())
        } else {
            self.learned_object()?
        };
        let place = |at: usize| {
            let wanted = &self.images.wanted[at];
            let tag = object.tags().iter().find(|t| t.tag == wanted.tag);
            let tag = tag.filter(|_| at < self.n_carried())?;
            Some((tag.object_from_tag?, tag.size_m))
        };
        let placed = (0..self.images.wanted.len()).map(place).collect();
        Ok((placed, !known, unplaced))
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
            Trajectory::from_sightings(own.collect())
        };
        (0..self.images.rig.cameras().len()).map(of).collect()
    }

    /// Approximate `world_from_camera` of every camera.
    fn joined(&self, trajectories: &[Trajectory], moments: Moments) -> Result<Vec<Pose>, RigError> {
        let pairs = joined_cameras(&[trajectories.to_vec()], moments);
        let of = pairs.islands();
        let size = |at: &usize| of.iter().filter(|island| *island == at).count();
        let largest = of
            .iter()
            .max_by_key(|at| (size(at), std::cmp::Reverse(**at)));
        let apart: Vec<usize> = (0..of.len())
            .filter(|&at| Some(&of[at]) != largest)
            .collect();
        if !apart.is_empty() {
            return Err(self.not_connected(trajectories, &apart));
        }
        let reference = self.plan.origin.reference(&self.images.rig);
        let world = self.images.rig.cameras()[reference]
            .world_from_camera
            .unwrap_or_default();
        let placed = pairs.placed(reference);
        Ok(placed
            .into_iter()
            .map(|pose| world * pose.unwrap_or_default())
            .collect())
    }

    fn not_connected(&self, trajectories: &[Trajectory], apart: &[usize]) -> RigError {
        let id = |at: usize| &self.images.rig.cameras()[at].id;
        let (blind, lost): (Vec<usize>, Vec<usize>) =
            apart.iter().partition(|at| trajectories[**at].is_empty());
        let rest = (0..trajectories.len()).filter(|at| !apart.contains(at));
        let rest = listed(rest.map(id));
        let words = |who: &[usize]| {
            if who.len() > 1 {
                ("cameras", "")
            } else {
                ("camera", "s")
            }
        };
        let mut cameras = Vec::new();
        if !blind.is_empty() {
            let names = listed(blind.iter().map(|&at| id(at)));
            cameras.push(format!("{} {names} never saw the object", words(&blind).0));
        }
        if !lost.is_empty() {
            let (word, s) = words(&lost);
            let names = listed(lost.iter().map(|&at| id(at)));
            cameras.push(format!("{word} {names} share{s} no view with {rest}"));
        }
        RigError::NotConnected {
            apart: apart.iter().map(|&at| id(at).clone()).collect(),
            cameras: cameras.join(", "),
            hint: if lost.is_empty() {
                "carry the object through what it sees, or take it out of the rig file".to_owned()
            } else {
                format!(
                    "hold the object where one of them and one of {rest} see it at the same time"
                )
            },
        }
    }

    /// The session without some cameras; `None` if fewer than two are left or the reference is not among them.
    fn without(&self, apart: &[CameraId]) -> Option<Self> {
        let cameras = self.images.rig.cameras().iter();
        let rest: Vec<Camera> = cameras
            .filter(|c| !apart.contains(&c.id))
            .cloned()
            .collect();
        if rest.len() < 2 || rest.len() == self.images.rig.cameras().len() {
            return None;
        }
        let mut fewer = Self::new(Rig::new(rest).ok()?, self.plan.clone()).ok()?;
        self.images
            .stored
            .iter()
            .for_each(|image| fewer.handle(image));
        Some(fewer)
    }

    fn adjustment(&self, sightings: &Sightings, start: &[Pose]) -> Adjustment {
        let reference = self.plan.origin.reference(&self.images.rig);
        let cameras = self.images.rig.cameras().iter().zip(start).enumerate();
        let cameras = cameras.map(|(at, (camera, pose))| BundleCamera {
            pose: if at == reference {
                Freedom::Fixed
            } else {
                Freedom::Free
            },
            line_delay_s: camera.line_delay_s.unwrap_or(0.0),
            middle_row: middle_row(camera),
            ..BundleCamera::with_known_lens(camera.lens, *pose)
        });
        let mut cameras: Vec<BundleCamera> = cameras.collect();
        let (mut instants, mut images) = floor(sightings, &cameras);
        carried(sightings, &cameras, &mut instants, &mut images);
        let mut priors = Priors::default();
        for (at, camera) in self.images.rig.cameras().iter().enumerate() {
            priors.free_lens(&mut cameras, at, camera);
        }
        Adjustment {
            tags: self.bundle_tags(sightings, &mut priors),
            cameras,
            instants,
            images,
            motion: None,
            priors,
            arm: None,
            noise: Vec::new(),
        }
    }

    /// Static tags seen by several cameras: their sizes follow from the camera poses.
    pub(super) fn still_tags_with_size(&self, views: &[ImageView]) -> Vec<usize> {
        let cameras = |tag: usize| -> BTreeSet<usize> {
            let own = views.iter().filter(|v| v.tags.iter().any(|t| t.tag == tag));
            own.map(|view| view.camera).collect()
        };
        (self.n_carried()..self.images.wanted.len())
            .filter(|tag| cameras(*tag).len() > 1)
            .collect()
    }

    /// The tags. Those with a sigma in the file were learned and stay fixed, so that rig and object remain consistent.
    fn bundle_tags(&self, sightings: &Sightings, priors: &mut Priors) -> Vec<BundleTag> {
        let frame = sightings.placed.iter().position(Option::is_some);
        let measured = self.still_tags_with_size(&sightings.views);
        let tags = self.images.wanted.iter().zip(&sightings.placed);
        let tags = tags.map(|(wanted, placed)| BundleTag {
            object_from_tag: placed.map_or_else(Pose::identity, |(pose, _)| pose),
            size_m: wanted.size_m,
            pose: Freedom::Fixed,
            size: Freedom::Fixed,
            scale: None,
        });
        let mut tags: Vec<BundleTag> = tags.collect();
        for (at, placed) in sightings.placed.iter().enumerate() {
            let mut own = self.plan.object.tags().iter();
            let own = own.find(|own| own.tag == self.images.wanted[at].tag);
            let is_placed = placed.is_some();
            if sightings.seeking_tags {
                if is_placed && Some(at) != frame {
                    tags[at].pose = Freedom::Free;
                }
            } else if is_placed && own.is_none_or(|own| own.pose_prior == Prior::Default) {
                priors.free_pose(&mut tags, at, Prior::Default);
            }
            if (is_placed || measured.contains(&at))
                && own.is_none_or(|own| own.size_prior == Prior::Default)
            {
                priors.free_size(&mut tags, at, Prior::Default);
            }
        }
        tags
    }
}
