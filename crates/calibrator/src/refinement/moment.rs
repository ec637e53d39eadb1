//! A moment: what all cameras saw of one object within a tenth of a second, checked and ready for an adjustment.

use super::adjusting::{bundle_of, options};
use super::gathering::Gathered;
use super::options::RefinementOptions;
use super::site::{Place, Site};
use crate::bundle::{BundleImage, Instant, SeenTag, solve};
use crate::intake::{ImageView, take_in};
use crate::resection::{ObjectView, Placed, agreeing_loosely, views_of_object};
use nalgebra::Point2;
use sextant_geometry::Pose;
use std::collections::BTreeMap;

/// Images no further apart were taken at one time, ns.
const SAME_TIME_NS: u64 = 500_000;
/// A moment that shows an object where another one does, nearer than this, says nothing new: metres, radians.
const NEW: (f64, f64) = (0.03, 0.12);
/// Slanted and far tags agree with many poses: a moment with fewer agreeing tags in all is left out.
const LEAST_TAGS: usize = 3;

/// Checked images of one object.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    pub object: usize,
    pub start_ns: u64,
    /// Seconds from the moment's start; ascending.
    pub instants: Vec<Instant>,
    /// `instant` counts within the moment, `tag` among the site's tags.
    pub images: Vec<BundleImage>,
}

impl Moment {
    /// `None` where it can tell nothing, or what it shows does not fit together.
    pub(super) fn of(
        site: &Site,
        gathered: &Gathered,
        tunables: &RefinementOptions,
    ) -> Option<Self> {
        if is_fast(site, gathered, tunables.fastest_px_s) {
            return None;
        }
        let placed = site.placed(gathered.object);
        let mut views = views(site, gathered, &placed);
        views.sort_by_key(|(view, _)| (view.capture_ns, view.camera));
        let pose = consensus(site, &views, &placed)?;
        let mut moment = Self {
            object: gathered.object,
            start_ns: gathered.start_ns,
            instants: Vec::new(),
            images: Vec::new(),
        };
        for (view, object) in &views {
            moment.add(site, (view, object), (&placed, &pose));
        }
        moment.can_tell().then(|| moment.settled(site))?
    }

    /// With the object where the models in force see it: from there, every adjustment has a short way.
    fn settled(mut self, site: &Site) -> Option<Self> {
        let solution = solve(bundle_of(site, [&self]), &options()).ok()?;
        self.instants = solution.bundle.instants;
        Some(self)
    }

    fn add(
        &mut self,
        site: &Site,
        (view, objects): (&ImageView, &[ObjectView]),
        (placed, pose): (&[Placed], &Pose),
    ) {
        let camera = &site.cameras[view.camera];
        let camera_from_object = camera.world_from_camera.inverse() * pose;
        let agreeing = agreeing_loosely(&camera.camera.lens, view, placed, &camera_from_object);
        let first = site.objects[self.object].tags.start;
        let believed = |at: &usize| objects.iter().any(|o| o.agreeing.contains(at));
        let tags: Vec<SeenTag> = agreeing
            .into_iter()
            .filter(believed)
            .map(|at| {
                let mut seen = view.tags[at].seen();
                seen.tag += first;
                seen
            })
            .collect();
        if tags.is_empty() {
            return;
        }
        let seconds = view.capture_ns.saturating_sub(self.start_ns) as f64 * 1e-9;
        let same = SAME_TIME_NS as f64 * 1e-9;
        if self
            .instants
            .last()
            .is_none_or(|last| seconds - last.seconds > same)
        {
            self.instants.push(Instant::at(seconds, *pose));
        }
        let instant = self.instants.len() - 1;
        self.images.push(BundleImage {
            camera: view.camera,
            instant,
            seconds_after_instant: seconds - self.instants[instant].seconds,
            tags,
        });
    }

    /// Two cameras, or two tags, and not too little of either.
    fn can_tell(&self) -> bool {
        let several = |of: &dyn Fn(&BundleImage) -> Vec<usize>| {
            let mut all: Vec<usize> = self.images.iter().flat_map(of).collect();
            all.sort_unstable();
            all.dedup();
            all.len() > 1
        };
        let tags: usize = self.images.iter().map(|image| image.tags.len()).sum();
        let cameras = several(&|image| vec![image.camera]);
        let several_tags = several(&|image| image.tags.iter().map(|seen| seen.tag).collect());
        tags >= LEAST_TAGS && (cameras || several_tags)
    }

    /// Whether a camera or tag has part in it.
    pub(super) fn shows(&self, place: Place) -> bool {
        self.images.iter().any(|image| match place {
            Place::Camera(camera) => image.camera == camera,
            Place::Tag(tag) => image.tags.iter().any(|seen| seen.tag == tag),
        })
    }

    /// Whether it shows the same object in the same place.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let (Some(one), Some(two)) = (self.instants.first(), other.instants.first()) else {
            return true;
        };
        let apart = one.world_from_object.inverse() * two.world_from_object;
        self.object == other.object
            && apart.translation.vector.norm() < NEW.0
            && apart.rotation.angle() < NEW.1
    }
}

/// Images with where the object may be in each.
type Views = Vec<(ImageView, Vec<ObjectView>)>;

fn views(site: &Site, gathered: &Gathered, placed: &[Placed]) -> Views {
    let wanted = site.wanted(gathered.object);
    let views = gathered.images.iter().filter_map(|image| {
        let index = site.camera(&image.camera)?;
        let camera = &site.cameras[index].camera;
        let (view, _) = take_in((index, camera), &wanted, image);
        let object = views_of_object(&camera.lens, &view, placed);
        Some((view, object))
    });
    views.collect()
}

/// Where the object is by most tags of all images.
fn consensus(site: &Site, views: &Views, placed: &[Placed]) -> Option<Pose> {
    let agreeing = |pose: &Pose| {
        let of_image = views.iter().map(|(view, _)| {
            let camera = &site.cameras[view.camera];
            let camera_from_object = camera.world_from_camera.inverse() * pose;
            agreeing_loosely(&camera.camera.lens, view, placed, &camera_from_object).len()
        });
        of_image.sum::<usize>()
    };
    let proposals = views.iter().flat_map(|(view, objects)| {
        let world_from_camera = site.cameras[view.camera].world_from_camera;
        objects
            .iter()
            .map(move |o| (o, world_from_camera * o.camera_from_object))
    });
    let scored = proposals.map(|(object, pose)| (agreeing(&pose), object.agreeing.len(), pose));
    let best = scored.max_by_key(|(all, own, _)| (*all, *own));
    best.map(|(_, _, pose)| pose)
}

/// While the rows of a rolling shutter are read, a corner may go this far, pixels.
const SHEAR_PX: f64 = 0.2;

/// Whether a corner goes faster between images of one camera than the limit, or than its shutter bears; not where no tag is
/// seen twice.
fn is_fast(site: &Site, gathered: &Gathered, limit_px_s: f64) -> bool {
    let mut first: BTreeMap<_, (u64, [Point2<f64>; 4])> = BTreeMap::new();
    for image in &gathered.images {
        let camera = site.camera(&image.camera);
        let readout_s = camera.map_or(0.0, |at| site.cameras[at].readout_s);
        let bearable_px_s = limit_px_s.min(SHEAR_PX / readout_s.max(f64::MIN_POSITIVE));
        for seen in &image.tags {
            let key = (&image.camera, seen.tag);
            let (then, corners) = *first.entry(key).or_insert((image.capture_ns, seen.corners));
            let seconds = image.capture_ns.abs_diff(then) as f64 * 1e-9;
            if seconds > 0.01 {
                let way = corners
                    .iter()
                    .zip(&seen.corners)
                    .map(|(a, b)| (a - b).norm());
                let least = way.fold(f64::INFINITY, f64::min);
                if least / seconds > bearable_px_s {
                    return true;
                }
            }
        }
    }
    false
}
