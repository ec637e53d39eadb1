//! Revision of tag poses: once most tags are placed, each image that shows a tag beside others proposes a pose for it.
//! This corrects a tag that was first placed by the mirrored branch of its pose.

use crate::adjustment::AdjustmentResult;
use crate::constellation::thinned;
use crate::image_store::{ImageView, TagView};
use crate::resection::{edge_px, tag_error_px};
use sextant_geometry::{Lens, Pose};

/// A tag seen beside others.
#[derive(Clone, Copy)]
struct Sighting<'a> {
    lens: &'a Lens,
    camera_from_object: Pose,
    view: &'a TagView,
}

/// A proposal agrees with an image within this share of the tag's edge in that image.
const NEAR: f64 = 0.1;
/// A new pose must agree with this many times as many images as the former one.
const CLEARLY: f64 = 1.1;

/// The pose of a tag with which most images agree, if they clearly prefer it to the adjusted one.
pub(super) fn better_place(
    adjusted: &AdjustmentResult,
    views: &[ImageView],
    tag: usize,
) -> Option<Pose> {
    let bundle = &adjusted.solution.bundle;
    let sightings = adjusted.adjustment.images.iter().filter_map(|image| {
        let others = image.tags.iter().map(|&at| views[image.view].tags[at].tag);
        if others.filter(|other| *other != tag).count() == 0 {
            return None;
        }
        let camera = &bundle.cameras[image.camera];
        let world_from_object = bundle.instants[image.instant].world_from_object;
        Some(Sighting {
            lens: &camera.lens,
            camera_from_object: camera.world_from_camera.inverse() * world_from_object,
            view: views[image.view].tags.iter().find(|view| view.tag == tag)?,
        })
    });
    let sightings = thinned(sightings.collect());
    let size_m = bundle.tags[tag].size_m;
    let votes = |place: &Pose| -> f64 {
        let votes = sightings.iter().map(|seen| {
            let corners = &seen.view.corners.corners;
            let error = tag_error_px(
                seen.lens,
                &(seen.camera_from_object * place),
                size_m,
                corners,
            );
            let bound = NEAR * edge_px(corners);
            error.map_or(0.0, |error| (1.0 - error / bound).max(0.0))
        });
        votes.sum()
    };
    let proposals = sightings.iter().flat_map(|seen| {
        let branches = seen.view.branches.iter();
        branches.map(|branch| seen.camera_from_object.inverse() * branch)
    });
    let scored = proposals.map(|place| (votes(&place), place));
    let (most, best) = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (most > CLEARLY * votes(&bundle.tags[tag].object_from_tag) + 0.5).then_some(best)
}
