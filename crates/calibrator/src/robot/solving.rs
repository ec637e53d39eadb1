//! From images and poses to the adjusted robot: matching, start, adjustment, held-out poses.

use super::clock;
use super::poses::RobotPoses;
use super::report::CalibratedRobot;
use super::solution::RobotSolution;
use super::start::{PosePair, Transforms, start};
use super::{NumberedView, RobotError, RobotSession};
use crate::adjustment::{Adjustment, UsedImage};
use crate::bundle::{Arm, BundleCamera, BundleOptions, BundleTag, Freedom, Hand, Instant, Mount};
use crate::image_store::ImageView;
use crate::priors::Priors;
use crate::resection::{ObjectView, TagPlacement, agreeing_loosely, views_of_object};
use crate::verdict::listed;
use sextant_geometry::Pose;
use sextant_site_model::{PoseSigma, Prior};

/// Standard deviation of a robot's poses before any is compared.
const FIRST_SIGMA: PoseSigma = PoseSigma {
    position_m: 1e-3,
    orientation_rad: 2e-3,
};
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

/// An image with the robot's pose and what it shows of the object.
#[derive(Clone)]
struct Match {
    numbered: NumberedView,
    hand: Hand,
    seen: Vec<ObjectView>,
}

impl RobotSession {
    /// Solves for base and hand. What the motions do not determine is named in the report.
    ///
    /// # Errors
    /// If images and poses do not match, or nothing fits, with reason and remedy.
    pub fn solve(&self, poses: &RobotPoses) -> Result<CalibratedRobot, RobotError> {
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
        let (views, keys, adjustment) = self.adjustment(&matches, &first, delay_s);
        let mut adjusted = adjustment.solve(&views, &BundleOptions::default())?;
        for _ in 0..DELAY_ROUNDS {
            let arm = adjusted.adjustment.arm.as_ref();
            if arm.is_none_or(|arm| !arm.seeks_delay) {
                break;
            }
            let again = interpolated_anew(adjusted.adjustment, &keys, poses);
            adjusted = again.solve(&views, &BundleOptions::default())?;
        }
        self.finish(RobotSolution {
            views,
            keys,
            adjusted,
        })
    }

    fn object_in(&self, image: &NumberedView) -> Vec<ObjectView> {
        let lens = &self.rig.cameras()[image.view.camera].lens;
        views_of_object(lens, &image.view, &self.placements())
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
            let own = own.filter(|(image, _)| image.view.camera == camera);
            let mut own: Vec<(u64, Pose)> = own
                .filter_map(|(image, seen)| {
                    Some((image.view.capture_ns, seen.first()?.camera_from_object))
                })
                .collect();
            own.sort_by_key(|(capture_ns, _)| *capture_ns);
            own
        };
        let cameras = (0..self.rig.cameras().len()).map(of_camera);
        let longest = cameras.max_by_key(Vec::len).unwrap_or_default();
        clock::delay_s(poses, &longest)
    }

    /// Images that show the object and have a pose of the robot, in the order of time.
    fn matches(
        &self,
        poses: &RobotPoses,
        seen: &[Vec<ObjectView>],
        delay_s: f64,
    ) -> Result<Vec<Match>, RobotError> {
        let found = self.images.iter().zip(seen);
        let found = found.filter(|(_, seen)| !seen.is_empty());
        let n_images = found.clone().count();
        let matches = found.filter_map(|(numbered, seen)| {
            let hand = poses.hand(numbered.number, numbered.view.capture_ns, delay_s)?;
            Some(Match {
                numbered: numbered.clone(),
                hand,
                seen: seen.clone(),
            })
        });
        let mut matches: Vec<Match> = matches.collect();
        matches.sort_by_key(|m| (m.numbered.view.capture_ns, m.numbered.view.camera));
        if matches.len() < LEAST_POSES {
            return Err(RobotError::FewPoses {
                images: n_images,
                matched: matches.len(),
                hint: self.hint_on_times(poses),
            });
        }
        let every = matches.len().div_ceil(MOST_POSES).max(1);
        Ok(matches.into_iter().step_by(every).collect())
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
                let times = self.images.iter().map(|image| image.view.capture_ns);
                let (from, to) = (times.clone().min(), times.max());
                format!(
                    "images are from {} to {} ns and the robot's poses from {first} to {last} ns, and a pose counts within 0.2 s of one before and one after it or at exactly its time; where the hand stands still for each image, write the image's number (column `image`, from 0) in place of the time",
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
        let world_from_camera = self.world_from_camera(m.numbered.view.camera);
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

    /// The views, the keys of the instants, and the start of the adjustment.
    fn adjustment(
        &self,
        matches: &[Match],
        first: &Transforms,
        delay_s: f64,
    ) -> (Vec<ImageView>, Vec<(usize, u64)>, Adjustment) {
        let mut arm = Arm {
            mount: self.plan.mount,
            base_from_site: first.base_from_site,
            hand_from_carried: first.hand_from_carried,
            delay_s,
            seeks_delay: false,
            hands: Vec::new(),
            sigma: FIRST_SIGMA,
            reach_m: REACH_M,
        };
        let is_moving = |hand: &Hand| {
            let [v, w] = [0, 3].map(|at| hand.twist.fixed_rows::<3>(at).norm());
            v > MOVING[0] || w > MOVING[1]
        };
        if matches.iter().filter(|m| is_moving(&m.hand)).count() > matches.len() / 2 {
            arm.seeks_delay = true;
        }
        let (mut instants, mut images, mut keys) = (Vec::new(), Vec::new(), Vec::new());
        let placements = self.placements();
        for (at, m) in matches.iter().enumerate() {
            let view = &m.numbered.view;
            let key = (m.numbered.number, view.capture_ns);
            let world_from_camera = self.world_from_camera(view.camera);
            let seen = m.seen.iter().map(|seen| seen.camera_from_object);
            let world_from_object = seen.map(|pose| world_from_camera * pose).min_by(|a, b| {
                let error = |pose| arm.error(&m.hand.base_from_hand, pose).error.norm();
                error(a).total_cmp(&error(b))
            });
            let Some(world_from_object) = world_from_object else {
                continue;
            };
            if keys.last() != Some(&key) {
                keys.push(key);
                instants.push(Instant::at(
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
        let adjustment = Adjustment {
            cameras: self.bundle_cameras(&mut priors),
            tags: self.bundle_tags(&mut priors),
            instants,
            images,
            motion: None,
            priors,
            arm: Some(arm),
            noise: Vec::new(),
        };
        let views = matches.iter().map(|m| m.numbered.view.clone());
        (views.collect(), keys, adjustment)
    }

    /// Cameras where the rig has them, with lenses by their priors.
    fn bundle_cameras(&self, priors: &mut Priors) -> Vec<BundleCamera> {
        let cameras = self.rig.cameras().iter().enumerate();
        let cameras = cameras.map(|(at, camera)| BundleCamera {
            pose: Freedom::Fixed,
            ..BundleCamera::with_known_lens(camera.lens, self.world_from_camera(at))
        });
        let mut cameras: Vec<BundleCamera> = cameras.collect();
        for (at, camera) in self.rig.cameras().iter().enumerate() {
            priors.free_lens(&mut cameras, at, camera);
        }
        cameras
    }

    /// Tags by their priors; those with a sigma in the file were learned and stay fixed, as in the calibration of a rig.
    fn bundle_tags(&self, priors: &mut Priors) -> Vec<BundleTag> {
        let tags = self.plan.object.tags().iter();
        let tags = tags.map(|tag| BundleTag {
            object_from_tag: tag.object_from_tag.unwrap_or_default(),
            size_m: tag.size_m,
            pose: Freedom::Fixed,
            size: Freedom::Fixed,
        });
        let mut tags: Vec<BundleTag> = tags.collect();
        for (at, tag) in self.plan.object.tags().iter().enumerate() {
            if tag.pose_prior == Prior::Default {
                priors.free_pose(&mut tags, at);
            }
            if tag.size_prior == Prior::Default {
                priors.free_size(&mut tags, at);
            }
        }
        tags
    }
}

/// An adjustment with the hands at the delay that it found.
fn interpolated_anew(
    mut adjustment: Adjustment,
    keys: &[(usize, u64)],
    poses: &RobotPoses,
) -> Adjustment {
    if let Some(arm) = &mut adjustment.arm {
        let delay_s = arm.delay_s;
        let hands = keys.iter().map(|(n, ns)| poses.hand(*n, *ns, delay_s));
        arm.hands = hands.collect();
    }
    adjustment
}
