//! Solves for a constellation: consensus, spanning tree, adjustment, frame.

use super::gauge::Gauge;
use super::places::Groups;
use super::progress::joining_hint;
use super::replacing::better_place;
use super::report::{LearnReport, LearnedTag};
use super::solved::fitting;
use super::{LearnError, LearnSession, LearnedObject};
use crate::adjustment::{Adjustment, AdjustmentResult};
use crate::constellation::joined_tags;
use crate::graph::PoseGraph;
use crate::image_store::ImageView;
use crate::priors::Priors;
use crate::resection::TagPlacement;
use crate::verdict::{Finding, Grade, listed};
use sextant_adjustment::{BundleCamera, BundleOptions, BundleTag, Freedom};
use sextant_geometry::Pose;
use sextant_site_model::{Prior, TagId};
use std::collections::BTreeSet;

/// Rounds of locating the object in every image and adjusting; the first starts from the spanning tree.
const ROUNDS: usize = 4;
/// Ratio of the residuals to the detector's noise, and share of a tag's left-out images, from which a solution is
/// suspicious.
const ODD: (f64, f64) = (1.5, 0.15);
/// Ratio from which residuals are clearly smaller.
const CLEARLY: f64 = 1.3;
/// Least share of the images of a tag that must fit; below it the tag has no consistent pose.
const LEAST_FITTING: f64 = 0.4;

impl LearnSession {
    /// Places the tags. Tags that the images cannot place are left out and named in [`LearnReport::unsolved`].
    ///
    /// # Errors
    /// If no tags can be placed, with cause and remedy.
    pub fn solve(&self) -> Result<LearnedObject, LearnError> {
        let refused = match self.solve_all() {
            Err(refused) => refused,
            learned => return learned,
        };
        let others = |tags: &[TagId]| {
            let all = self.plan.tags.iter().map(|(tag, _)| *tag);
            all.filter(|tag| !tags.contains(tag)).collect()
        };
        let lost: Vec<TagId> = match &refused {
            LearnError::NeverSeen { tags } | LearnError::Inconsistent { tags, .. } => tags.clone(),
            LearnError::NotConnected { islands, .. } => {
                let size = |island: &&Vec<TagId>| island.len();
                islands
                    .iter()
                    .max_by_key(size)
                    .map_or(Vec::new(), |i| others(i))
            }
            _ => return Err(refused),
        };
        let Some(fewer) = self.without(&lost) else {
            return Err(refused);
        };
        let mut learned = fewer.solve().map_err(|_| refused.clone())?;
        learned.report.unsolved.insert(0, refused.to_string());
        learned
            .report
            .verdict
            .add(Grade::Usable, Finding::Unplaced(refused.to_string()));
        learned.report.images = self.images.stored.n_received();
        Ok(learned)
    }

    /// Places every tag.
    fn solve_all(&self) -> Result<LearnedObject, LearnError> {
        let views = self.images.views();
        self.check_seen(&views)?;
        let together = Groups::from_views(&self.images.rig, &views);
        let joins_cameras = together.joins_cameras();
        let learned = self.solve_in(views, &together);
        if joins_cameras && learned.as_ref().map_or(true, is_odd) {
            return self.solve_apart(learned);
        }
        learned
    }

    /// Solves with each image separately, where cameras that see the object at the same time contradict each other.
    fn solve_apart(
        &self,
        together: Result<LearnedObject, LearnError>,
    ) -> Result<LearnedObject, LearnError> {
        let views = self.images.views();
        let apart = Groups::apart(&self.images.rig, &views);
        let Ok(mut apart) = self.solve_in(views, &apart) else {
            return together;
        };
        if let Ok(joint) = &together
            && !is_clearer(&apart.report, &joint.report)
        {
            return together;
        }
        apart
            .report
            .verdict
            .add(Grade::Usable, Finding::ContradictingCameras);
        Ok(apart)
    }

    fn solve_in(
        &self,
        views: Vec<ImageView>,
        groups: &Groups,
    ) -> Result<LearnedObject, LearnError> {
        let fixed = self.known();
        let mut placed = self.first_guess(groups, &views, &fixed)?;
        let mut adjusted = self.adjust(groups, &views, &placed)?;
        for _ in 1..ROUNDS {
            let mut is_better = false;
            for (at, place) in placed.iter_mut().enumerate() {
                let tag = &adjusted.solution.bundle.tags[at];
                let other = better_place(&adjusted, &views, at);
                let other = other.filter(|_| tag.pose == Freedom::Free);
                is_better |= other.is_some();
                *place = Some((other.unwrap_or(tag.object_from_tag), tag.size_m));
            }
            if !is_better && adjusted.misfits.is_empty() {
                break;
            }
            adjusted = self.adjust(groups, &views, &placed)?;
        }
        self.check_fit(&views, &adjusted)?;
        let solved = self.framed(views, adjusted);
        Ok(LearnedObject {
            object: self.object(&solved)?,
            report: self.report(&solved),
        })
    }

    fn check_seen(&self, views: &[ImageView]) -> Result<(), LearnError> {
        if let Some(wrong) = self.images.wrong_resolution() {
            let camera = &self.images.rig.cameras()[wrong.camera];
            let [width, height] = camera.resolution;
            return Err(LearnError::Resolution {
                camera: camera.id.clone(),
                part: wrong.percent,
                width,
                height,
            });
        }
        if views.is_empty() {
            return Err(LearnError::NothingSeen {
                images: self.images.stored.n_received(),
                seen: self.what_is_seen(),
            });
        }
        let seen = |at: usize| views.iter().any(|v| v.tags.iter().any(|t| t.tag == at));
        let never: Vec<_> = (0..self.images.wanted.len())
            .filter(|&at| !seen(at))
            .map(|at| self.images.wanted[at].tag)
            .collect();
        if never.is_empty() {
            return Ok(());
        }
        Err(LearnError::NeverSeen { tags: never })
    }

    fn what_is_seen(&self) -> String {
        let foreign = self.images.foreign();
        if foreign.is_empty() {
            return ": no tag at all; check light, focus and distance".to_owned();
        }
        format!(", only {}", listed(foreign.iter().take(8)))
    }

    /// Poses of the known object's tags that stay.
    pub(super) fn known(&self) -> Vec<Option<Pose>> {
        let relearned = |tag| self.plan.tags.iter().any(|(t, _)| *t == tag);
        let place = |tag| {
            let object = self.plan.from.as_ref()?;
            object.tags().iter().find(|t| t.tag == tag)?.object_from_tag
        };
        let wanted = self.images.wanted.iter();
        wanted
            .map(|w| place(w.tag).filter(|_| !relearned(w.tag)))
            .collect()
    }

    /// Poses from the spanning tree, in the frame of the known tags if there are any.
    fn first_guess(
        &self,
        groups: &Groups,
        views: &[ImageView],
        fixed: &[Option<Pose>],
    ) -> Result<Vec<TagPlacement>, LearnError> {
        let joints = joined_tags(&groups.seen(&self.images.rig, views), &self.images.wanted);
        let strongest = |at: &usize, other: &usize| {
            joints
                .strength(*at)
                .total_cmp(&joints.strength(*other))
                .then(other.cmp(at))
        };
        let fixed_ones = (0..fixed.len()).filter(|&at| fixed[at].is_some());
        let root = fixed_ones.max_by(strongest);
        let root = root.or_else(|| (0..fixed.len()).max_by(strongest));
        let root = root.ok_or(LearnError::NoTag)?;
        let object_from_root = fixed[root].unwrap_or_default();
        let guesses = joints.placed(root);
        let placed: Vec<TagPlacement> = (0..fixed.len())
            .map(|at| {
                let place = fixed[at].or_else(|| guesses[at].map(|guess| object_from_root * guess));
                place.map(|pose| (pose, self.images.wanted[at].size_m))
            })
            .collect();
        if placed.iter().any(Option::is_none) {
            return Err(self.not_connected(&joints));
        }
        Ok(placed)
    }

    fn not_connected(&self, joints: &PoseGraph) -> LearnError {
        let of = joints.islands();
        let mut numbers = of.clone();
        numbers.sort_unstable();
        numbers.dedup();
        let islands = numbers.iter().map(|number| {
            let members = (0..of.len()).filter(|&at| of[at] == *number);
            members.map(|at| self.images.wanted[at].tag).collect()
        });
        let islands: Vec<Vec<TagId>> = islands.collect();
        let groups: Vec<String> = islands.iter().map(listed).collect();
        let mut tags = self.progress().tags;
        for (tag, group) in tags.iter_mut().zip(&of) {
            tag.group = *group;
        }
        LearnError::NotConnected {
            islands,
            groups: groups.join(" | "),
            hint: joining_hint(&tags).unwrap_or_default(),
        }
    }

    fn adjust(
        &self,
        groups: &Groups,
        views: &[ImageView],
        placed: &[TagPlacement],
    ) -> Result<AdjustmentResult, LearnError> {
        let (instants, images) = groups.instants(&self.images.rig, views, placed);
        let cameras = self
            .images
            .rig
            .cameras()
            .iter()
            .zip(&groups.group_from_camera);
        let cameras = cameras.map(|(camera, pose)| BundleCamera {
            pose: Freedom::Fixed,
            ..BundleCamera::with_known_lens(camera.lens, *pose)
        });
        let mut cameras: Vec<BundleCamera> = cameras.collect();
        let tags = placed
            .iter()
            .zip(&self.images.wanted)
            .map(|(placed, wanted)| BundleTag {
                object_from_tag: placed.map_or_else(Pose::identity, |(pose, _)| pose),
                size_m: wanted.size_m,
                pose: Freedom::Fixed,
                size: Freedom::Fixed,
                scale: None,
            });
        let mut tags: Vec<BundleTag> = tags.collect();
        let mut priors = Priors::default();
        self.free_cameras(groups, views, &mut cameras, &mut priors);
        let known = self.known();
        for (at, fixed) in self.fixed_tags(placed, views).into_iter().enumerate() {
            if known[at].is_none() {
                priors.free_size(&mut tags, at, Prior::Default);
            }
            if !fixed {
                tags[at].pose = Freedom::Free;
            }
        }
        let adjustment = Adjustment {
            cameras,
            tags,
            instants,
            images,
            motion: None,
            priors,
            arm: None,
            noise: Vec::new(),
        };
        Ok(adjustment.solve(views, &BundleOptions::default())?)
    }

    /// Lenses, and, where cameras see the object together, the poses of all but the first.
    fn free_cameras(
        &self,
        groups: &Groups,
        views: &[ImageView],
        cameras: &mut [BundleCamera],
        priors: &mut Priors,
    ) {
        let used: BTreeSet<usize> = views.iter().map(|view| view.camera).collect();
        for (number, &at) in used.iter().enumerate() {
            let camera = &self.images.rig.cameras()[at];
            priors.free_lens(cameras, at, camera);
            if number > 0 && groups.joins_cameras() {
                priors.free_camera(cameras, at, camera.pose_prior);
            }
        }
    }

    /// Fixed tags: those of the known object or, without one, the tag that defines the frame.
    fn fixed_tags(&self, placed: &[TagPlacement], views: &[ImageView]) -> Vec<bool> {
        let known = self.known();
        if known.iter().any(Option::is_some) {
            return known.iter().map(Option::is_some).collect();
        }
        let frame = match self.plan.gauge {
            Gauge::Tag(tag) => self.images.wanted.iter().position(|w| w.tag == tag),
            Gauge::Centroid => None,
        };
        let count = |at: usize| {
            views
                .iter()
                .filter(|v| v.tags.iter().any(|t| t.tag == at))
                .count()
        };
        let most = || (0..placed.len()).max_by_key(|&at| (count(at), std::cmp::Reverse(at)));
        let frame = frame.or_else(most);
        (0..placed.len()).map(|at| Some(at) == frame).collect()
    }

    fn check_fit(
        &self,
        views: &[ImageView],
        adjusted: &AdjustmentResult,
    ) -> Result<(), LearnError> {
        let counts = fitting(self.images.wanted.len(), views, adjusted);
        let lost: Vec<usize> = (0..counts.len())
            .filter(|&at| (counts[at].fits as f64) < LEAST_FITTING * counts[at].seen as f64)
            .collect();
        if lost.is_empty() {
            return Ok(());
        }
        let moved = lost.iter().any(|&at| self.known()[at].is_some());
        let tags = lost.iter().map(|&at| self.images.wanted[at].tag).collect();
        let cause = if moved {
            "not where the given object has them, so they have moved: name them with --tags to \
             learn them again"
                .to_owned()
        } else {
            "the images put them in different places; is a tag loose, bent, or there twice?"
                .to_owned()
        };
        Err(LearnError::Inconsistent { tags, cause })
    }
}

/// Whether a solution has clearly smaller residuals than another, or equal ones with clearly fewer outliers.
fn is_clearer(one: &LearnReport, other: &LearnReport) -> bool {
    let left_out = |report: &LearnReport| report.tags.iter().map(|t| t.left_out).sum::<usize>();
    let noise = other.noise_ratio / one.noise_ratio;
    noise > CLEARLY || noise * CLEARLY > 1.0 && 2 * left_out(one) < left_out(other)
}

/// Whether the images contradict each other more than their noise allows.
fn is_odd(learned: &LearnedObject) -> bool {
    let tags = &learned.report.tags;
    let left_out = |tag: &LearnedTag| tag.left_out as f64 > ODD.1 * tag.images as f64;
    learned.report.noise_ratio > ODD.0 || tags.iter().any(left_out)
}
