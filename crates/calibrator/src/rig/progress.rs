//! Progress of a rig session, instructions, and errors that images show before a solution.

use super::{RigError, RigPlan};
use crate::graph::islands;
use crate::image_store::ImageView;
use crate::session_images::SessionImages;
use crate::verdict::listed;
use serde::Serialize;
use sextant_site_model::{CameraId, ObjectModel, Rig, TagId};
use std::collections::BTreeMap;

/// A camera's share of the images so far.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraProgress {
    /// Id of the camera.
    pub camera: String,
    /// Number of images received.
    pub images: usize,
    /// Number of images with a tag of the object.
    pub seeing: usize,
    /// Fields of its image (four by three) in which the object was seen, row by row.
    pub fields: Vec<bool>,
    /// Number of distances, out of three (a factor of 1.5 each), at which the object was seen.
    pub distances: usize,
    /// Number of its group of connected cameras; equal numbers are connected.
    pub group: usize,
}

/// Progress of a session.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RigProgress {
    /// Number of images received.
    pub images: usize,
    /// Every camera of the rig.
    pub cameras: Vec<CameraProgress>,
    /// Number of common views of each pair of cameras.
    pub together: Vec<(String, String, usize)>,
    /// Progress from 0 to 1; 1 is enough.
    pub complete: f64,
    /// Instruction for the next step, a sentence.
    pub hint: String,
}

/// Coverage by the images.
#[derive(Clone, Debug)]
pub(super) struct Coverage {
    cameras: Vec<CameraCoverage>,
    together: BTreeMap<[usize; 2], usize>,
    /// Images of each tag whose pose on the object is unknown.
    unplaced: BTreeMap<TagId, usize>,
}

#[derive(Clone, Debug, Default)]
struct CameraCoverage {
    images: usize,
    seeing: usize,
    last_ns: Option<u64>,
    fields: [bool; FIELDS[0] * FIELDS[1]],
    distances: Vec<i32>,
}

/// Columns and rows.
const FIELDS: [usize; 2] = [4, 3];
/// Images with the object no further apart show it together, ns.
const TOGETHER_NS: u64 = 60_000_000;
const ENOUGH_IMAGES: usize = 30;
const ENOUGH_TOGETHER: usize = 15;
const ENOUGH_FIELDS: usize = 6;
const ENOUGH_DISTANCES: usize = 2;
/// Sufficient number of images of a tag whose pose on the object is unknown.
const ENOUGH_SHOWN: usize = 5;
/// Number of images with a duplicated tag from which it exists twice.
const DOUBLED: usize = 3;

impl Coverage {
    pub(super) fn new(rig: &Rig, object: &ObjectModel) -> Self {
        let unplaced = object.tags().iter().filter(|_| !object.is_learned());
        Self {
            unplaced: unplaced.map(|tag| (tag.tag, 0)).collect(),
            cameras: vec![CameraCoverage::default(); rig.cameras().len()],
            together: BTreeMap::new(),
        }
    }

    pub(super) fn add(&mut self, view: &ImageView, images: &SessionImages) {
        let own = &mut self.cameras[view.camera];
        own.images += 1;
        if view.tags.is_empty() {
            return;
        }
        own.seeing += 1;
        own.last_ns = Some(view.capture_ns);
        for tag in &view.tags {
            if let Some(shown) = self.unplaced.get_mut(&images.wanted[tag.tag].tag) {
                *shown += 1;
            }
            let centre = tag
                .corners
                .corners
                .iter()
                .fold(nalgebra::Vector2::zeros(), |s, c| s + c.coords)
                / 4.0;
            own.fields[field(&centre, images.rig.cameras()[view.camera].resolution)] = true;
        }
        let distance = view.tags[0].branches[0].translation.vector.norm();
        let step = (distance.ln() / 1.5_f64.ln()).floor() as i32;
        if !own.distances.contains(&step) {
            own.distances.push(step);
        }
        self.join(view.camera, view.capture_ns);
    }

    fn join(&mut self, index: usize, time_ns: u64) {
        for (other, of) in self.cameras.iter().enumerate() {
            let near = of
                .last_ns
                .is_some_and(|t| t.abs_diff(time_ns) <= TOGETHER_NS);
            if other != index && near {
                *self
                    .together
                    .entry([index.min(other), index.max(other)])
                    .or_default() += 1;
            }
        }
    }

    /// Faults that make solving pointless.
    pub(super) fn check(&self, images: &SessionImages, plan: &RigPlan) -> Result<(), RigError> {
        if let Some(wrong) = images.wrong_resolution() {
            let camera = &images.rig.cameras()[wrong.camera];
            let [width, height] = camera.resolution;
            return Err(RigError::Resolution {
                camera: camera.id.clone(),
                part: wrong.percent,
                width,
                height,
            });
        }
        if let Some((&tag, &images)) = images.doubled().iter().find(|(_, n)| **n >= DOUBLED) {
            return Err(RigError::Doubled { tag, images });
        }
        if self.cameras.iter().all(|own| own.seeing == 0) {
            let foreign: Vec<TagId> = images.foreign().into_iter().take(8).collect();
            let seen = if foreign.is_empty() {
                ": no tag at all; check light, focus and distance".to_owned()
            } else {
                format!(
                    ", only {}: give the object that was carried",
                    listed(foreign)
                )
            };
            return Err(RigError::NothingSeen {
                images: images.stored.n_received(),
                object: plan.object.id().clone(),
                seen,
            });
        }
        Ok(())
    }

    pub(super) fn progress(&self, images: &SessionImages) -> RigProgress {
        let id = |at: usize| images.rig.cameras()[at].id.to_string();
        let groups = self.groups();
        let cameras = self
            .cameras
            .iter()
            .enumerate()
            .map(|(at, own)| CameraProgress {
                camera: id(at),
                images: own.images,
                seeing: own.seeing,
                fields: own.fields.to_vec(),
                distances: own.distances.len(),
                group: groups[at],
            });
        let together = self.together.iter();
        RigProgress {
            images: self.cameras.iter().map(|own| own.images).sum(),
            cameras: cameras.collect(),
            together: together.map(|(&[a, b], &n)| (id(a), id(b), n)).collect(),
            complete: self.complete(&groups),
            hint: self.hint(images, &groups),
        }
    }

    fn groups(&self) -> Vec<usize> {
        let enough = self.together.iter().filter(|(_, n)| **n >= ENOUGH_TOGETHER);
        islands(self.cameras.len(), enough.map(|(&nodes, _)| nodes))
    }

    fn complete(&self, groups: &[usize]) -> f64 {
        let part = |have: usize, enough: usize| (have as f64 / enough as f64).min(1.0);
        let of = |own: &CameraCoverage| {
            let fields = own.fields.iter().filter(|f| **f).count();
            let parts = [
                part(own.seeing, ENOUGH_IMAGES),
                part(fields, ENOUGH_FIELDS),
                part(own.distances.len(), ENOUGH_DISTANCES),
            ];
            parts.iter().sum::<f64>() / 3.0
        };
        let n = self.cameras.len().max(1) as f64;
        let mean = self.cameras.iter().map(of).sum::<f64>() / n;
        let apart = groups
            .iter()
            .enumerate()
            .filter(|(at, g)| *at == **g)
            .count()
            .saturating_sub(1);
        let joined = 1.0 - apart as f64 / (n - 1.0).max(1.0);
        let hidden = self.hidden().count() as f64 / self.unplaced.len().max(1) as f64;
        (0.5 * mean + 0.5 * joined) * (1.0 - hidden)
    }

    /// Tags of an unknown object with few images.
    fn hidden(&self) -> impl Iterator<Item = &TagId> {
        let few = self
            .unplaced
            .iter()
            .filter(|(_, shown)| **shown < ENOUGH_SHOWN);
        few.map(|(tag, _)| tag)
    }

    fn hint(&self, images: &SessionImages, groups: &[usize]) -> String {
        let id = |at: usize| &images.rig.cameras()[at].id;
        if let Some((tag, _)) = images.doubled().iter().find(|(_, n)| **n >= DOUBLED) {
            return format!("Tag {tag} is there twice: take one of the two away");
        }
        let seeing = |at: &usize| self.cameras[*at].seeing;
        let all = 0..self.cameras.len();
        if let Some(blind) = all
            .clone()
            .filter(|at| seeing(at) < ENOUGH_IMAGES)
            .min_by_key(seeing)
        {
            return format!(
                "Carry the object through what camera {} sees, slowly",
                id(blind)
            );
        }
        if let Some(tag) = self.hidden().next() {
            return format!("Turn the object: hardly an image shows its tag {tag}");
        }
        let other = |at: &usize| groups[*at] != groups[0];
        if let Some(apart) = all.clone().find(other) {
            let rest: Vec<&CameraId> = all.filter(|at| groups[*at] == groups[0]).map(id).collect();
            return format!(
                "Hold the object where camera {} and one of {} see it at the same time",
                id(apart),
                listed(rest)
            );
        }
        let fields = |at: &usize| self.cameras[*at].fields.iter().filter(|f| **f).count();
        if let Some(few) = all
            .clone()
            .filter(|at| fields(at) < ENOUGH_FIELDS)
            .min_by_key(fields)
        {
            return format!(
                "Carry the object to the edges of what camera {} sees",
                id(few)
            );
        }
        let near = |at: &usize| self.cameras[*at].distances.len() < ENOUGH_DISTANCES;
        if let Some(flat) = all.clone().find(near) {
            return format!(
                "Bring the object nearer to camera {} and further away, tilted to and fro",
                id(flat)
            );
        }
        "Enough: every camera has seen the object from near and far, and together with others"
            .to_owned()
    }
}

fn field(centre: &nalgebra::Vector2<f64>, [width, height]: [u32; 2]) -> usize {
    let part = |at: f64, size: u32, n: usize| {
        (((at + 0.5) / f64::from(size) * n as f64).max(0.0) as usize).min(n - 1)
    };
    part(centre.y, height, FIELDS[1]) * FIELDS[0] + part(centre.x, width, FIELDS[0])
}
