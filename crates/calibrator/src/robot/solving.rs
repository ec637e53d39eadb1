//! From images and poses to the adjusted robot: matching, start, adjustment, held-out poses.

use super::clock;
use super::poses::RobotPoses;
use super::report::CalibratedRobot;
use super::solution::{RobotMisfit, RobotSolution};
use super::start::{PosePair, Transforms, start};
use super::{RobotError, RobotSession};
use crate::adjustment::{Adjustment, UsedImage};
use crate::image_store::ImageView;
use crate::priors::Priors;
use crate::resection::{ObjectView, TagPlacement, agreeing_loosely, views_of_object};
use crate::verdict::listed;
use sextant_adjustment::{
    Arm, BodyId, BundleCamera, BundleOptions, BundleTag, Freedom, Hand, Instant, Mount,
};
use sextant_geometry::Pose;
use sextant_site_model::{PoseSigma, Prior};
use std::collections::BTreeSet;

/// Standard deviation of the distance of what a hand carries from the frame that the robot's poses are of, per axis, m.
const REACH_M: f64 = 0.5;
/// Most poses of an adjustment; of more, every second is used, or every third.
const MOST_POSES: usize = 600;
/// Least poses.
const LEAST_POSES: usize = 3;
/// Rounds of the delay: the hand is interpolated anew after each.
const DELAY_ROUNDS: usize = 3;
/// Slower hands tell nothing of the delay, m/s and rad/s.
const MOVING: [f64; 2] = [0.005, 0.02];
/// The delay is sought where so many hands move.
const LEAST_MOVING: usize = 5;

/// An image with the robot's pose and what it shows of the object.
#[derive(Clone)]
struct Match {
    view: ImageView,
    /// Number of the image in its camera.
    number: usize,
    /// See [`RobotPoses::key`].
    key: u64,
    hand: Hand,
    seen: Vec<ObjectView>,
}

impl RobotSession {
    /// Solves for base and hand. What the motions do not determine is named in the report.
    ///
    /// # Errors
    /// If images and poses do not match, the poses are written in another way, or nothing fits, with reason and
    /// remedy.
    pub fn solve(&self, poses: &RobotPoses) -> Result<CalibratedRobot, RobotError> {
        let found = self.solved(poses);
        if let Err(RobotError::NothingSeen { .. }) = found {
            return found.and_then(|found| self.finish(found));
        }
        let misfit = found.as_ref().ok().and_then(|found| found.misfit().ok());
        match self.other_reading(poses, misfit) {
            Some(other) => Err(other),
            None => self.finish(found?),
        }
    }

    /// What is left of poses that are read in some way.
    pub(super) fn misfit(&self, poses: &RobotPoses) -> Result<RobotMisfit, RobotError> {
        self.solved(poses)?.misfit()
    }

    /// Solves for base and hand.
    fn solved(&self, poses: &RobotPoses) -> Result<RobotSolution, RobotError> {
        if self.images.is_empty() {
            return Err(RobotError::NothingSeen {
                images: self.n_received(),
                object: self.plan.object.id().clone(),
                seen: match self.foreign.is_empty() {
                    true => String::new(),
                    false => format!("; they show {}", listed(self.foreign.iter().take(6))),
                },
            });
        }
        let seen: Vec<Vec<ObjectView>> = self.images.iter().map(|i| self.object_in(i)).collect();
        let delay_s = self.first_delay_s(poses, &seen);
        let matches = self.matches(poses, &seen, delay_s)?;
        let pairs: Vec<PosePair> = matches.iter().map(|m| self.pair(m)).collect();
        let first = start(&pairs).ok_or(RobotError::NoStart)?;
        let adjustment = self.adjustment(&matches, &first, delay_s);
        let views: Vec<ImageView> = matches.iter().map(|m| m.view.clone()).collect();
        let numbers: Vec<usize> = matches.iter().map(|m| m.number).collect();
        let mut adjusted = adjustment.solve(&views, &BundleOptions::default())?;
        for _ in 0..DELAY_ROUNDS {
            let arm = adjusted.adjustment.arm.as_ref();
            if arm.is_none_or(|arm| !arm.seeks_delay) {
                break;
            }
            let again = interpolated_anew(adjusted.adjustment, &views, &numbers, poses);
            adjusted = again.solve(&views, &BundleOptions::default())?;
        }
        Ok(RobotSolution {
            views,
            numbers,
            adjusted,
        })
    }

    fn object_in(&self, image: &ImageView) -> Vec<ObjectView> {
        let lens = &self.rig.cameras()[image.camera].lens;
        views_of_object(lens, image, &self.placements())
    }

    pub(super) fn placements(&self) -> Vec<TagPlacement> {
        let tags = self.plan.object.tags().iter();
        tags.map(|tag| Some((tag.object_from_tag?, tag.size_m)))
            .collect()
    }

    /// A start of the delay, from the camera with the most images.
    fn first_delay_s(&self, poses: &RobotPoses, seen: &[Vec<ObjectView>]) -> f64 {
        if matches!(poses, RobotPoses::ByImage(_)) {
            return 0.0;
        }
        let of_camera = |camera: usize| {
            let own = self.images.iter().zip(seen);
            let own = own.filter(|(image, _)| image.camera == camera);
            let mut own: Vec<(u64, Pose)> = own
                .filter_map(|(image, seen)| {
                    Some((image.capture_ns, seen.first()?.camera_from_object))
                })
                .collect();
            own.sort_by_key(|(capture_ns, _)| *capture_ns);
            own
        };
        let cameras = (0..self.rig.cameras().len()).map(of_camera);
        let longest = cameras.max_by_key(Vec::len).unwrap_or_default();
        clock::delay_s(poses, &longest)
    }

    /// Images that show the object and have a pose of the robot, in the order of the poses.
    fn matches(
        &self,
        poses: &RobotPoses,
        seen: &[Vec<ObjectView>],
        delay_s: f64,
    ) -> Result<Vec<Match>, RobotError> {
        let found = self.images.iter().zip(seen);
        let found = found.filter(|(_, seen)| !seen.is_empty());
        let n_images = found.clone().count();
        let matches = found.filter_map(|(view, seen)| {
            let number = self.number(view.camera, view.capture_ns);
            Some(Match {
                view: view.clone(),
                number,
                key: poses.key(number, view.capture_ns),
                hand: poses.hand(number, view.capture_ns, delay_s)?,
                seen: seen.clone(),
            })
        });
        let mut matches: Vec<Match> = matches.collect();
        matches.sort_by_key(|m| (m.key, m.view.camera));
        let n_poses = matches.chunk_by(|a, b| a.key == b.key).count();
        if n_poses < LEAST_POSES {
            return Err(RobotError::FewPoses {
                images: n_images,
                matched: matches.len(),
                poses: n_poses,
                hint: self.hint_on_times(poses),
            });
        }
        Ok(thinned(&matches, |m| m.key, MOST_POSES))
    }

    fn hint_on_times(&self, poses: &RobotPoses) -> String {
        let Some((first, last)) = poses.span() else {
            return "the robot's file has no pose".to_owned();
        };
        match poses {
            RobotPoses::ByImage(_) => format!(
                "the robot's file has poses of images {first} to {last}, counted from 0 in each camera"
            ),
            RobotPoses::ByTime(_) => {
                let times = self.images.iter().map(|image| image.capture_ns);
                let (from, to) = (times.clone().min(), times.max());
                format!(
                    "images are from {} to {} ns and the robot's poses from {first} to {last} \
                     ns, and an image counts between two poses that are at most 0.2 s apart or \
                     at exactly the time of one; where the hand stands still for each image, \
                     write the image's number (column `image`, from 0) in place of the time",
                    from.unwrap_or_default(),
                    to.unwrap_or_default()
                )
            }
        }
    }

    /// The frame of a camera in the world.
    fn world_from_camera(&self, camera: usize) -> Pose {
        self.rig.cameras()[camera]
            .world_from_camera
            .unwrap_or_default()
    }

    fn pair(&self, m: &Match) -> PosePair {
        let world_from_camera = self.world_from_camera(m.view.camera);
        let carried = m.seen.iter().map(|seen| {
            let world_from_object = world_from_camera * seen.camera_from_object;
            match self.plan.mount {
                Mount::Object => world_from_object,
                Mount::Camera => world_from_object.inverse(),
            }
        });
        PosePair {
            base_from_hand: m.hand.base_from_hand,
            site_from_carried: carried.collect(),
        }
    }

    /// The arm before the adjustment, without instants. Its delay is sought where enough of the hands move.
    fn first_arm(&self, matches: &[Match], first: &Transforms, delay_s: f64) -> Arm {
        let is_moving = |hand: &Hand| {
            let [v, w] = [0, 3].map(|at| hand.twist.fixed_rows::<3>(at).norm());
            v > MOVING[0] || w > MOVING[1]
        };
        let moving = matches.iter().filter(|m| is_moving(&m.hand));
        Arm {
            mount: self.plan.mount,
            base_from_site: first.base_from_site,
            hand_from_carried: first.hand_from_carried,
            delay_s,
            seeks_delay: moving.count() >= LEAST_MOVING,
            hands: Vec::new(),
            sigma: PoseSigma::OF_HAND,
            reach_m: REACH_M,
        }
    }

    /// The start of the adjustment, with an instant for each pose of the robot.
    fn adjustment(&self, matches: &[Match], first: &Transforms, delay_s: f64) -> Adjustment {
        let mut arm = self.first_arm(matches, first, delay_s);
        let (mut instants, mut images) = (Vec::new(), Vec::new());
        let mut last_key = None;
        let placements = self.placements();
        for (at, m) in matches.iter().enumerate() {
            let view = &m.view;
            let world_from_camera = self.world_from_camera(view.camera);
            let seen = m.seen.iter().map(|seen| seen.camera_from_object);
            let world_from_object = seen.map(|pose| world_from_camera * pose).min_by(|a, b| {
                let error = |pose| arm.error(&m.hand.base_from_hand, pose).error.norm();
                error(a).total_cmp(&error(b))
            });
            let Some(world_from_object) = world_from_object else {
                continue;
            };
            if last_key != Some(m.key) {
                last_key = Some(m.key);
                instants.push(Instant::at_rest(
                    BodyId::Moving(0),
                    view.capture_ns as f64 * 1e-9,
                    world_from_object,
                ));
                arm.hands.push(Some(m.hand));
            }
            let lens = &self.rig.cameras()[view.camera].lens;
            let camera_from_object = world_from_camera.inverse() * world_from_object;
            images.push(UsedImage {
                view: at,
                camera: view.camera,
                instant: instants.len() - 1,
                seconds_after_instant: 0.0,
                stamp_error_s: 0.0,
                tags: agreeing_loosely(lens, view, &placements, &camera_from_object),
            });
        }
        let mut priors = Priors::default();
        Adjustment {
            cameras: self.bundle_cameras(matches, &mut priors),
            tags: self.bundle_tags(matches, &mut priors),
            instants,
            images,
            motion: None,
            priors,
            arm: Some(arm),
            noise: Vec::new(),
        }
    }

    /// Cameras with lenses and poses by their priors; the first that is used holds the world.
    fn bundle_cameras(&self, matches: &[Match], priors: &mut Priors) -> Vec<BundleCamera> {
        let cameras = self.rig.cameras().iter().enumerate();
        let cameras = cameras.map(|(at, camera)| BundleCamera {
            pose: Freedom::Fixed,
            ..BundleCamera::with_known_lens(camera.lens, self.world_from_camera(at))
        });
        let mut cameras: Vec<BundleCamera> = cameras.collect();
        for (at, camera) in self.rig.cameras().iter().enumerate() {
            priors.free_lens(&mut cameras, at, camera);
        }
        let used: BTreeSet<usize> = matches.iter().map(|m| m.view.camera).collect();
        for &at in used.iter().skip(1) {
            let prior = self.rig.cameras()[at].pose_prior;
            if prior != Prior::Exact {
                priors.free_camera(&mut cameras, at, prior);
            }
        }
        cameras
    }

    /// Tags, those that are seen by their priors, which also hold the object's frame.
    fn bundle_tags(&self, matches: &[Match], priors: &mut Priors) -> Vec<BundleTag> {
        let tags = self.plan.object.tags().iter();
        let tags = tags.map(|tag| BundleTag {
            object_from_tag: tag.object_from_tag.unwrap_or_default(),
            size_m: tag.size_m,
            pose: Freedom::Fixed,
            size: Freedom::Fixed,
            scale: None,
        });
        let mut tags: Vec<BundleTag> = tags.collect();
        let seen = matches.iter().flat_map(|m| &m.view.tags);
        let seen: BTreeSet<usize> = seen.map(|seen| seen.tag).collect();
        for at in seen {
            let tag = &self.plan.object.tags()[at];
            if tag.pose_prior != Prior::Exact {
                priors.free_pose(&mut tags, at, tag.pose_prior);
            }
            if tag.size_prior != Prior::Exact {
                priors.free_size(&mut tags, at, tag.size_prior);
            }
        }
        tags
    }
}

/// An adjustment with the hands at the delay that it found, by its views and their numbers.
fn interpolated_anew(
    mut adjustment: Adjustment,
    views: &[ImageView],
    numbers: &[usize],
    poses: &RobotPoses,
) -> Adjustment {
    if let Some(arm) = &mut adjustment.arm {
        for image in &adjustment.images {
            let (number, capture_ns) = (numbers[image.view], views[image.view].capture_ns);
            arm.hands[image.instant] = poses.hand(number, capture_ns, arm.delay_s);
        }
    }
    adjustment
}

/// At most so many groups of items that follow one another with one key, spread over all of them.
fn thinned<T: Clone>(items: &[T], key: impl Fn(&T) -> u64, most: usize) -> Vec<T> {
    let groups: Vec<&[T]> = items.chunk_by(|a, b| key(a) == key(b)).collect();
    let every = groups.len().div_ceil(most).max(1);
    groups
        .into_iter()
        .step_by(every)
        .flatten()
        .cloned()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::thinned;

    #[test]
    fn thinning_keeps_the_images_of_one_instant_together() {
        let images: Vec<(u64, char)> = (0..4).flat_map(|at| [(at, 'a'), (at, 'b')]).collect();
        let kept = thinned(&images, |image| image.0, 3);
        assert_eq!(kept, [(0, 'a'), (0, 'b'), (2, 'a'), (2, 'b')]);
    }
}
