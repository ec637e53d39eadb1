//! Poses of the object in groups of simultaneous images, given its tag poses.

use crate::adjustment::UsedImage;
use crate::constellation::{Group, GroupedView};
use crate::image_store::ImageView;
use crate::resection::{TagPlacement, agreeing_loosely, views_of_object};
use sextant_adjustment::{BodyId, Instant};
use sextant_geometry::Pose;
use sextant_site_model::Rig;

/// Images of one instant (indices into the views) and their cameras' poses in a common frame.
pub(super) struct Groups {
    pub of_views: Vec<Vec<usize>>,
    /// Pose of each camera of the rig, by index.
    pub group_from_camera: Vec<Pose>,
}

/// Largest difference of capture times within an instant, ns.
const SAME_INSTANT_NS: u64 = 500_000;

impl Groups {
    /// Groups simultaneous images of cameras with known poses; other images form groups of one.
    pub(super) fn from_views(rig: &Rig, views: &[ImageView]) -> Self {
        let mut used: Vec<usize> = views.iter().map(|view| view.camera).collect();
        used.sort_unstable();
        used.dedup();
        let poses = rig.cameras().iter().map(|camera| camera.world_from_camera);
        let known = used
            .iter()
            .all(|&c| rig.cameras()[c].world_from_camera.is_some());
        let mut groups = Self {
            of_views: Vec::new(),
            group_from_camera: poses.map(|pose| pose.unwrap_or_default()).collect(),
        };
        let mut order: Vec<usize> = (0..views.len()).collect();
        order.sort_by_key(|&at| (views[at].capture_ns, views[at].camera));
        for view in order {
            let joins = known
                && used.len() > 1
                && groups.of_views.last().is_some_and(|group| {
                    let first = &views[group[0]];
                    views[view].capture_ns - first.capture_ns <= SAME_INSTANT_NS
                        && group.iter().all(|&o| views[o].camera != views[view].camera)
                });
            match groups.of_views.last_mut().filter(|_| joins) {
                Some(group) => group.push(view),
                None => groups.of_views.push(vec![view]),
            }
        }
        groups
    }

    /// A group of its own for each image.
    pub(super) fn apart(rig: &Rig, views: &[ImageView]) -> Self {
        Self {
            of_views: (0..views.len()).map(|at| vec![at]).collect(),
            group_from_camera: vec![Pose::identity(); rig.cameras().len()],
        }
    }

    /// Whether any group has several cameras.
    pub(super) fn joins_cameras(&self) -> bool {
        self.of_views.iter().any(|group| group.len() > 1)
    }

    /// Input of the consensus.
    pub(super) fn seen<'a>(&self, rig: &'a Rig, views: &'a [ImageView]) -> Vec<Group<'a>> {
        let group = |of: &Vec<usize>| {
            let images = of.iter().map(|&at| &views[at]);
            let tags = images.flat_map(|image| {
                let (lens, pose) = (&rig.cameras()[image.camera].lens, image.camera);
                let group_from_camera = self.group_from_camera[pose];
                image.tags.iter().map(move |view| GroupedView {
                    lens,
                    group_from_camera,
                    view,
                })
            });
            tags.collect()
        };
        self.of_views.iter().map(group).collect()
    }

    /// Poses of the object in each group that shows placed tags, and the tags of its images that fit there.
    pub(super) fn instants(
        &self,
        rig: &Rig,
        views: &[ImageView],
        tags: &[TagPlacement],
    ) -> (Vec<Instant>, Vec<UsedImage>) {
        let (mut instants, mut images) = (Vec::new(), Vec::new());
        for group in &self.of_views {
            let Some(pose) = self.object_in(group, rig, views, tags) else {
                continue;
            };
            for &view in group {
                images.push(UsedImage {
                    view,
                    camera: views[view].camera,
                    instant: instants.len(),
                    seconds_after_instant: 0.0,
                    stamp_error_s: 0.0,
                    tags: self.fitting(view, rig, views, tags, &pose),
                });
            }
            instants.push(Instant::at_rest(BodyId::Moving(0), 0.0, pose));
        }
        (instants, images)
    }

    /// The pose with which most tags of all images of the group agree.
    fn object_in(
        &self,
        group: &[usize],
        rig: &Rig,
        views: &[ImageView],
        tags: &[TagPlacement],
    ) -> Option<Pose> {
        let proposals = group.iter().flat_map(|&at| {
            let camera = views[at].camera;
            let found = views_of_object(&rig.cameras()[camera].lens, &views[at], tags);
            let found = found.into_iter();
            found.map(move |view| {
                (
                    self.group_from_camera[camera] * view.camera_from_object,
                    view.rms_px,
                )
            })
        });
        let scored = proposals.map(|(pose, rms_px)| {
            let fitting = group
                .iter()
                .map(|&at| self.fitting(at, rig, views, tags, &pose).len());
            (fitting.sum::<usize>(), rms_px, pose)
        });
        let best = scored.max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        best.map(|(_, _, pose)| pose)
    }

    fn fitting(
        &self,
        view: usize,
        rig: &Rig,
        views: &[ImageView],
        tags: &[TagPlacement],
        pose: &Pose,
    ) -> Vec<usize> {
        let image = &views[view];
        let camera_from_object = self.group_from_camera[image.camera].inverse() * pose;
        agreeing_loosely(
            &rig.cameras()[image.camera].lens,
            image,
            tags,
            &camera_from_object,
        )
    }
}
