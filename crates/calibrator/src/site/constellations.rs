//! Lenses and constellations from each image by itself: no camera pose is known yet.

use super::members::{BodyViews, Members};
use crate::adjustment::{Adjustment, UsedImage};
use crate::constellation::{Group, GroupedView, joined_tags};
use crate::priors::Priors;
use crate::resection::{TagPlacement, agreeing_loosely, views_of_object};
use crate::rig::sightings::Sightings;
use sextant_adjustment::{
    BodyId, BundleCamera, BundleError, BundleOptions, BundleTag, Freedom, Instant,
};
use sextant_geometry::{Lens, Pose};
use sextant_site_model::Rig;
use std::collections::BTreeSet;

/// Images of a body in a camera that are used.
const MOST_IMAGES: usize = 200;

/// What images tell one by one.
#[derive(Clone, Debug)]
pub(super) struct Constellations {
    /// Of each camera.
    pub lenses: Vec<Lens>,
    /// Of each wanted tag on its body; `None` where it could not be placed, and for tags that stand still.
    pub placed: Vec<TagPlacement>,
}

/// Lenses and constellations; the lenses of the rig are the start.
pub(super) fn constellations(
    rig: &Rig,
    members: &Members,
    seen: &BodyViews,
) -> Result<Constellations, BundleError> {
    let views = selected(rig, members, seen);
    let placed = first_guess(rig, members, seen, &views);
    let (instants, images) = resected_images(rig, seen, &views, &placed);
    let cameras = rig.cameras().iter().map(|camera| BundleCamera {
        pose: Freedom::Fixed,
        ..BundleCamera::with_known_lens(camera.lens, Pose::identity())
    });
    let mut cameras: Vec<BundleCamera> = cameras.collect();
    let mut priors = Priors::bounded();
    let used: BTreeSet<usize> = images.iter().map(|image| image.camera).collect();
    for camera in used {
        let resolution = rig.cameras()[camera].resolution;
        priors.free_unknown_lens(&mut cameras, camera, resolution);
    }
    let adjustment = Adjustment {
        cameras,
        tags: bundle_tags(members, &placed),
        instants,
        images,
        motion: None,
        priors,
        arm: None,
        noise: Vec::new(),
    };
    let options = BundleOptions {
        by_clusters: false,
        ..BundleOptions::default()
    };
    let solved = adjustment.solve(&seen.views, &options)?.solution.bundle;
    let poses = solved.tags.iter().zip(placed);
    Ok(Constellations {
        lenses: solved.cameras.iter().map(|camera| camera.lens).collect(),
        placed: poses
            .map(|(tag, placed)| placed.map(|_| (tag.object_from_tag, tag.size_m)))
            .collect(),
    })
}

/// An instant and an image of each view whose pose follows from the tags that are placed.
fn resected_images(
    rig: &Rig,
    seen: &BodyViews,
    views: &[usize],
    placed: &[TagPlacement],
) -> (Vec<Instant>, Vec<UsedImage>) {
    let (mut instants, mut images) = (Vec::new(), Vec::new());
    for &at in views {
        let view = &seen.views[at];
        let lens = &rig.cameras()[view.camera].lens;
        let Some(object) = views_of_object(lens, view, placed).into_iter().next() else {
            continue;
        };
        images.push(UsedImage {
            view: at,
            camera: view.camera,
            instant: instants.len(),
            seconds_after_instant: 0.0,
            stamp_error_s: 0.0,
            tags: agreeing_loosely(lens, view, placed, &object.camera_from_object),
        });
        instants.push(Instant::at_rest(
            BodyId::Moving(0),
            0.0,
            object.camera_from_object,
        ));
    }
    (instants, images)
}

/// The tags with free poses, save the first placed one of each body, which is its frame.
pub(super) fn bundle_tags(members: &Members, placed: &[TagPlacement]) -> Vec<BundleTag> {
    let frames = frames(members, placed);
    let tags = members.wanted.iter().zip(placed).enumerate();
    tags.map(|(at, (wanted, place))| BundleTag {
        object_from_tag: place.map_or_else(Pose::identity, |(pose, _)| pose),
        size_m: wanted.size_m,
        pose: if place.is_some() && !frames.contains(&at) {
            Freedom::Free
        } else {
            Freedom::Fixed
        },
        size: Freedom::Fixed,
        scale: None,
    })
    .collect()
}

/// The first placed tag of each body.
fn frames(members: &Members, placed: &[TagPlacement]) -> Vec<usize> {
    let of_body = |body| members.tags_of(body).find(|&tag| placed[tag].is_some());
    (0..members.n_bodies).filter_map(of_body).collect()
}

/// At most [`MOST_IMAGES`] of each body in each camera, from all over the recording: of each stretch of time the one
/// with most tags.
fn selected(rig: &Rig, members: &Members, seen: &BodyViews) -> Vec<usize> {
    let mut selected = Vec::new();
    for body in 0..members.n_bodies {
        for camera in 0..rig.cameras().len() {
            let own = seen.of_body(Some(body));
            let own: Vec<usize> = own.filter(|&at| seen.views[at].camera == camera).collect();
            let n = own.len().min(MOST_IMAGES);
            let stretch = |k: usize| &own[k * own.len() / n..(k + 1) * own.len() / n];
            let most_tags = |of: &[usize]| {
                of.iter()
                    .copied()
                    .max_by_key(|&at| seen.views[at].tags.len())
            };
            selected.extend((0..n).filter_map(|k| most_tags(stretch(k))));
        }
    }
    selected
}

/// Places of the tags of every body relative to its best joined tag.
fn first_guess(
    rig: &Rig,
    members: &Members,
    seen: &BodyViews,
    views: &[usize],
) -> Vec<TagPlacement> {
    let groups = views.iter().map(|&at| {
        let view = &seen.views[at];
        let tags = view.tags.iter().map(|tag| GroupedView {
            lens: &rig.cameras()[view.camera].lens,
            group_from_camera: Pose::identity(),
            view: tag,
        });
        tags.collect()
    });
    let groups: Vec<Group<'_>> = groups.collect();
    let joints = joined_tags(&groups, &members.wanted);
    let mut placed = vec![None; members.wanted.len()];
    for body in 0..members.n_bodies {
        let strength = |tag: &usize| joints.strength(*tag);
        let root = members
            .tags_of(body)
            .max_by(|a, b| strength(a).total_cmp(&strength(b)).then(b.cmp(a)));
        let Some(root) = root else { continue };
        for (tag, pose) in joints.placed(root).into_iter().enumerate() {
            if let Some(pose) = pose {
                placed[tag] = Some((pose, members.wanted[tag].size_m));
            }
        }
    }
    placed
}

/// Where each body may be in each image.
pub(super) fn sightings(
    rig: &Rig,
    members: &Members,
    seen: &BodyViews,
    known: &Constellations,
) -> Sightings {
    let object = seen.views.iter().zip(&seen.body_of);
    let object = object.map(|(view, body)| match body {
        Some(_) => views_of_object(&rig.cameras()[view.camera].lens, view, &known.placed),
        None => Vec::new(),
    });
    Sightings {
        object: object.collect(),
        views: seen.views.clone(),
        placed: known.placed.clone(),
        n_carried: members.n_carried(),
        seeking_tags: true,
        unplaced: Vec::new(),
    }
}
