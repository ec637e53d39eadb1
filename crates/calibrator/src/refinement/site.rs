//! The models of a site as an adjustment takes them: cameras and tags that have a place, each with an index.

use super::finding::{Change, Part};
use crate::bundle::{Anchor, BundleCamera, BundleTag, Freedom};
use crate::intake::Wanted;
use crate::resection::Placed;
use sextant_estimator::{Camera, CameraId, ObjectId, ObjectModel, PoseSigma, Rig, TagId};
use sextant_geometry::Pose;
use std::ops::Range;

/// Of a camera whose calibration says nothing of it.
const USUAL_CAMERA: PoseSigma = PoseSigma {
    position_m: 0.003,
    orientation_rad: 0.003,
};
/// Of a tag whose model says nothing of it.
const USUAL_TAG: PoseSigma = PoseSigma {
    position_m: 0.001,
    orientation_rad: 0.02,
};
/// No calibration is better.
const LEAST: PoseSigma = PoseSigma {
    position_m: 1e-4,
    orientation_rad: 1e-4,
};

/// Cameras and tags.
#[derive(Clone, Debug)]
pub(super) struct Site {
    pub cameras: Vec<SiteCamera>,
    pub tags: Vec<SiteTag>,
    pub objects: Vec<SiteObject>,
}

/// A camera that is calibrated.
#[derive(Clone, Debug)]
pub(super) struct SiteCamera {
    pub camera: Camera,
    pub world_from_camera: Pose,
    pub sigma: PoseSigma,
    /// Seconds from the first row of its images to the last, 0 where all have one time.
    pub readout_s: f64,
}

/// A tag that is placed.
#[derive(Clone, Debug)]
pub(super) struct SiteTag {
    pub tag: TagId,
    pub size_m: f64,
    pub object_from_tag: Pose,
    pub sigma: PoseSigma,
}

/// A rigid object.
#[derive(Clone, Debug)]
pub(super) struct SiteObject {
    pub id: ObjectId,
    /// Of the site's tags.
    pub tags: Range<usize>,
}

/// A camera or a tag by its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Place {
    Camera(usize),
    Tag(usize),
}

impl Site {
    pub(super) fn new(rig: &Rig, objects: &[ObjectModel]) -> Self {
        let cameras = rig.cameras().iter().filter_map(|camera| {
            Some(SiteCamera {
                camera: camera.clone(),
                world_from_camera: camera.world_from_camera?,
                sigma: rig.pose_sigma(&camera.id).unwrap_or(USUAL_CAMERA),
                readout_s: rig.line_delay_s(&camera.id).unwrap_or(0.0).abs()
                    * f64::from(camera.resolution[1]),
            })
        });
        let mut site = Self {
            cameras: cameras.collect(),
            tags: Vec::new(),
            objects: Vec::new(),
        };
        for object in objects.iter().filter(|o| o.articulation().is_none()) {
            let first = site.tags.len();
            site.tags.extend(object.tags().iter().filter_map(|tag| {
                Some(SiteTag {
                    tag: tag.tag,
                    size_m: tag.size_m,
                    object_from_tag: tag.object_from_tag?,
                    sigma: object.tag_sigma(&tag.tag).unwrap_or(USUAL_TAG),
                })
            }));
            site.objects.push(SiteObject {
                id: object.id().clone(),
                tags: first..site.tags.len(),
            });
        }
        site
    }

    pub(super) fn camera(&self, id: &CameraId) -> Option<usize> {
        self.cameras.iter().position(|known| known.camera.id == *id)
    }

    pub(super) fn wanted(&self, object: usize) -> Vec<Wanted> {
        let tags = self.tags[self.objects[object].tags.clone()].iter();
        tags.map(|tag| Wanted {
            tag: tag.tag,
            size_m: tag.size_m,
        })
        .collect()
    }

    pub(super) fn placed(&self, object: usize) -> Vec<Placed> {
        let tags = self.tags[self.objects[object].tags.clone()].iter();
        tags.map(|tag| Some((tag.object_from_tag, tag.size_m)))
            .collect()
    }

    /// All that could be moved. A tag alone on its object has no place but the object's own.
    pub(super) fn places(&self) -> Vec<Place> {
        let cameras = (0..self.cameras.len()).map(Place::Camera);
        let with_others = self.objects.iter().filter(|object| object.tags.len() > 1);
        let tags = with_others.flat_map(|object| object.tags.clone());
        cameras.chain(tags.map(Place::Tag)).collect()
    }

    pub(super) fn pose(&self, place: Place) -> Pose {
        match place {
            Place::Camera(at) => self.cameras[at].world_from_camera,
            Place::Tag(at) => self.tags[at].object_from_tag,
        }
    }

    pub(super) fn part(&self, place: Place) -> Part {
        match place {
            Place::Camera(at) => Part::Camera(self.cameras[at].camera.id.clone()),
            Place::Tag(at) => {
                let mut objects = self.objects.iter();
                let object = objects.find(|object| object.tags.contains(&at));
                Part::Tag {
                    object: object.map_or_else(|| self.objects[0].id.clone(), |o| o.id.clone()),
                    tag: self.tags[at].tag,
                }
            }
        }
    }

    pub(super) fn take(&mut self, change: &Change) {
        match &change.part {
            Part::Camera(id) => {
                let camera = self.cameras.iter_mut().find(|c| c.camera.id == *id);
                if let Some(camera) = camera {
                    camera.world_from_camera = change.after;
                    camera.camera.world_from_camera = Some(change.after);
                }
            }
            Part::Tag { tag: id, .. } => {
                if let Some(tag) = self.tags.iter_mut().find(|tag| tag.tag == *id) {
                    tag.object_from_tag = change.after;
                }
            }
        }
    }

    /// Everything where it is and known.
    pub(super) fn bundle_cameras(&self) -> Vec<BundleCamera> {
        let cameras = self.cameras.iter().map(|camera| BundleCamera {
            pose: Freedom::Fixed,
            ..BundleCamera::with_known_lens(camera.camera.lens, camera.world_from_camera)
        });
        cameras.collect()
    }

    /// Everything where it is and known.
    pub(super) fn bundle_tags(&self) -> Vec<BundleTag> {
        let tags = self.tags.iter().map(|tag| BundleTag {
            object_from_tag: tag.object_from_tag,
            size_m: tag.size_m,
            pose: Freedom::Fixed,
            size: Freedom::Fixed,
        });
        tags.collect()
    }

    /// What the calibration says of a place.
    pub(super) fn anchor(&self, place: Place) -> Anchor {
        match place {
            Place::Camera(camera) => Anchor::Camera {
                camera,
                world_from_camera: self.pose(place),
                sigma: at_least(self.cameras[camera].sigma),
            },
            Place::Tag(tag) => Anchor::Tag {
                tag,
                object_from_tag: self.pose(place),
                sigma: at_least(self.tags[tag].sigma),
            },
        }
    }
}

fn at_least(sigma: PoseSigma) -> PoseSigma {
    PoseSigma {
        position_m: sigma.position_m.max(LEAST.position_m),
        orientation_rad: sigma.orientation_rad.max(LEAST.orientation_rad),
    }
}
