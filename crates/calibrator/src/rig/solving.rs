//! From the images of a session to the cameras' poses: consensus, spanning tree, adjustment, clocks, frame.

use super::pairs::Pairs;
use super::report::Found;
use super::trajectory::{SAME_TIME_NS, Trajectory, twist};
use super::{Calibrated, RigError, RigSession, clocks, stillness};
use crate::adjustment::{Adjustment, UsedImage};
use crate::bundle::{BundleCamera, BundleOptions, BundleTag, Freedom, Instant};
use crate::intake::{ImageView, take_in};
use crate::learn::{Gauge, LearnPlan, LearnSession};
use crate::resection::{ObjectView, Placed, agreeing_loosely, views_of_object};
use crate::verdict::listed;
use sextant_estimator::{Camera, CameraId, Rig};
use sextant_geometry::Pose;

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

/// More than this part of images with a partner at the same time: shutters are synchronised.
const SYNCHRONISED: f64 = 0.5;

impl RigSession {
    /// Finds the cameras.
    ///
    /// # Errors
    /// When the images cannot place every camera, with the reason and a remedy.
    pub fn solve(&self) -> Result<Calibrated, RigError> {
        self.coverage
            .check(&self.rig, &self.plan, self.images.len())?;
        let sightings = self.sightings()?;
        let trajectories = self.trajectories(&sightings);
        let start = self.joined(&trajectories)?;
        let synchronised = is_synchronised(&trajectories);
        let first = self.adjustment(&sightings, &start);
        stillness::check_at_start(&self.rig, &sightings, &first)?;
        let (adjusted, clocks) = if synchronised {
            clocks::of_synchronised(first, &sightings.views)?
        } else {
            clocks::of_free_running(first, &sightings.views)?
        };
        self.check_names(&adjusted.adjusted)?;
        stillness::check(&self.rig, &adjusted, &sightings.views)?;
        self.finish(Found {
            sightings,
            adjusted,
            clocks,
            synchronised,
        })
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
        let known = self
            .plan
            .object
            .tags()
            .iter()
            .all(|t| t.object_from_tag.is_some());
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

    /// Each image by itself: the cameras' poses are not known, those of the rig may be wrong.
    fn learned_object(&self) -> Result<sextant_estimator::ObjectModel, RigError> {
        let blind = self.rig.cameras().iter().map(|camera| Camera {
            world_from_camera: None,
            ..camera.clone()
        });
        let rig = Rig::new(blind.collect())
            .map_err(|_| RigError::Undetermined("the rig is not usable".to_owned()))?;
        let tags = self.plan.object.tags().iter();
        let plan = LearnPlan {
            object: self.plan.object.id().clone(),
            tags: tags.map(|tag| (tag.tag, tag.size_m)).collect(),
            cameras: Vec::new(),
            gauge: Gauge::Centroid,
            from: None,
        };
        let mut session = LearnSession::new(rig, plan)?;
        self.images.iter().for_each(|image| session.handle(image));
        Ok(session.solve()?.object)
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
    fn joined(&self, trajectories: &[Trajectory]) -> Result<Vec<Pose>, RigError> {
        let pairs = Pairs::of(trajectories);
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

    fn bundle_tags(&self, sightings: &Sightings) -> Vec<BundleTag> {
        let frame = sightings.placed.iter().position(Option::is_some);
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
                size: Freedom::Fixed,
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

/// Seconds before all others at which the floor's tags stand: apart from each other and from any motion.
const FLOOR_SECONDS: f64 = -1e6;

/// An instant for every tag on the floor, seen by all images that show it.
fn floor(sightings: &Sightings, cameras: &[BundleCamera]) -> (Vec<Instant>, Vec<UsedImage>) {
    let (mut instants, mut images) = (Vec::new(), Vec::new());
    for tag in sightings.n_carried..sightings.placed.len() {
        let own = sightings.views.iter().enumerate().filter_map(|(at, view)| {
            let seen = view.tags.iter().position(|t| t.tag == tag)?;
            Some((at, seen))
        });
        let own: Vec<(usize, usize)> = own.collect();
        let proposals = own.iter().flat_map(|&(at, seen)| {
            let view = &sightings.views[at];
            let camera = &cameras[view.camera].world_from_camera;
            view.tags[seen]
                .branches
                .iter()
                .map(move |branch| camera * branch)
        });
        let proposals: Vec<Pose> = proposals.collect();
        let Some(pose) = nearest_to_all(&proposals) else {
            continue;
        };
        images.extend(own.iter().map(|&(view, seen)| UsedImage {
            view,
            camera: sightings.views[view].camera,
            instant: instants.len(),
            seconds_after_instant: 0.0,
            tags: vec![seen],
        }));
        let seconds = FLOOR_SECONDS * (1.0 + (sightings.placed.len() - tag) as f64);
        instants.push(Instant::at(seconds, pose));
    }
    (instants, images)
}

/// The pose with most others near it.
fn nearest_to_all(poses: &[Pose]) -> Option<Pose> {
    let near = |a: &Pose, b: &Pose| {
        let apart = a.inverse() * b;
        (1.0 - apart.rotation.angle() / 0.2).max(0.0)
            * (1.0 - apart.translation.vector.norm() / 0.2).max(0.0)
    };
    let stride = poses.len().div_ceil(60).max(1);
    let votes = poses
        .iter()
        .step_by(stride)
        .map(|a| (poses.iter().map(|b| near(a, b)).sum::<f64>(), a));
    votes
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, pose)| *pose)
}

/// An instant for every time at which images show the object.
fn carried(
    sightings: &Sightings,
    cameras: &[BundleCamera],
    instants: &mut Vec<Instant>,
    images: &mut Vec<UsedImage>,
) {
    let views = &sightings.views;
    let mut order: Vec<usize> = (0..views.len())
        .filter(|&at| !sightings.object[at].is_empty())
        .collect();
    order.sort_by_key(|&at| (views[at].capture_ns, views[at].camera));
    let Some(start_ns) = order.first().map(|&at| views[at].capture_ns) else {
        return;
    };
    let seconds = |at: usize| (views[at].capture_ns - start_ns) as f64 * 1e-9;
    let same = |a: &usize, b: &usize| views[*b].capture_ns - views[*a].capture_ns <= SAME_TIME_NS;
    let mut before: Option<Pose> = None;
    for group in order.chunk_by(same) {
        let Some(pose) = best_pose(sightings, cameras, group, before.as_ref()) else {
            continue;
        };
        before = Some(pose);
        let fitting = |at: usize| {
            let camera = &cameras[views[at].camera];
            let camera_from_object = camera.world_from_camera.inverse() * pose;
            agreeing_loosely(
                &camera.lens,
                &views[at],
                &sightings.placed,
                &camera_from_object,
            )
        };
        images.extend(group.iter().map(|&at| UsedImage {
            view: at,
            camera: views[at].camera,
            instant: instants.len(),
            seconds_after_instant: seconds(at) - seconds(group[0]),
            tags: fitting(at),
        }));
        instants.push(Instant::at(seconds(group[0]), pose));
    }
    give_twists(instants);
}

/// The possible pose that most tags of all images agree with; of equals the one nearest to the instant before.
fn best_pose(
    sightings: &Sightings,
    cameras: &[BundleCamera],
    group: &[usize],
    before: Option<&Pose>,
) -> Option<Pose> {
    let proposals = group.iter().flat_map(|&at| {
        let camera = &cameras[sightings.views[at].camera];
        let object = sightings.object[at].iter();
        object.map(move |o| camera.world_from_camera * o.camera_from_object)
    });
    let scored = proposals.map(|pose| {
        let fits = group.iter().map(|&at| {
            let view = &sightings.views[at];
            let camera = &cameras[view.camera];
            let camera_from_object = camera.world_from_camera.inverse() * pose;
            agreeing_loosely(&camera.lens, view, &sightings.placed, &camera_from_object).len()
        });
        let turned = before.map_or(0.0, |b| b.rotation.angle_to(&pose.rotation));
        (fits.sum::<usize>(), turned, pose)
    });
    let best = scored.max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
    best.map(|(_, _, pose)| pose)
}

/// First twists: from each instant's neighbours.
pub(super) fn give_twists(instants: &mut [Instant]) {
    let twists: Vec<_> = (0..instants.len())
        .map(|at| {
            let (from, to) = (at.saturating_sub(1), (at + 1).min(instants.len() - 1));
            let (from, to) = (&instants[from], &instants[to]);
            let dt = to.seconds - from.seconds;
            (0.0 < dt && dt < 1.0)
                .then(|| twist(&from.world_from_object, &to.world_from_object, dt))
        })
        .collect();
    for (instant, twist) in instants.iter_mut().zip(twists) {
        instant.twist = twist.unwrap_or_default();
    }
}

/// Options of every adjustment of a rig.
pub(super) fn options() -> BundleOptions {
    BundleOptions::default()
}
