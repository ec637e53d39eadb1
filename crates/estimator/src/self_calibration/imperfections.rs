//! Corrections of the files that are worth a message.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::self_calibration::keyframes::Keyframe;
use crate::site::ModelledSite;
use crate::site::corrections::Corrections;
use sextant_site_report::Imperfection;

/// m by which two cameras must disagree about an object.
const APART_M: f64 = 0.002;
/// m and rad by which a tag must be off its place.
const OFF: (f64, f64) = (0.0007, 0.02);
/// Share by which a size or a focal length must be off.
const SIZE_OFF: f64 = 0.006;
/// Standard deviations by which the scale of an object must be off.
const CLEAR: f64 = 4.0;
const FOCAL_OFF: f64 = 0.002;

/// The worst of each kind: the pair of cameras, and of each object the tag; every camera whose focal length is off, and
/// every object whose scale is.
pub(crate) fn imperfections(
    corrections: &Corrections,
    site: &ModelledSite,
    newest: Option<&Keyframe>,
) -> Vec<Imperfection> {
    let place = newest.map(|keyframe| keyframe.pose.translation.vector);
    let cameras = place.and_then(|place| cameras(corrections, site, &place));
    let focal_lengths = corrections.cameras.iter().filter_map(|(camera, one)| {
        let ratio = 1.0 + one.focal_px / site.file_camera(*camera)?.lens.intrinsics().fx;
        let camera = site.camera_id(*camera)?;
        let worth = (ratio - 1.0).abs() > FOCAL_OFF;
        worth.then_some(Imperfection::FocalLengthOff { camera, ratio })
    });
    let cameras = cameras.into_iter().chain(focal_lengths);
    let tags = tags(corrections, site);
    cameras
        .chain(tags)
        .chain(scales(corrections, site))
        .collect()
}

/// The two cameras that would see an object at a place farthest apart by the rig's file.
fn cameras(
    corrections: &Corrections,
    site: &ModelledSite,
    place: &Vector3<f64>,
) -> Option<Imperfection> {
    let seen = corrections.cameras.iter().filter_map(|(camera, one)| {
        let file = &site.file_camera(*camera)?.world_from_camera;
        let in_camera = one.pose(file).inverse() * Point3::from(*place);
        Some((*camera, file * in_camera))
    });
    let seen: Vec<(usize, Point3<f64>)> = seen.collect();
    let pairs = seen.iter().enumerate().flat_map(|(index, one)| {
        let others = seen[index + 1..].iter();
        others.map(move |other| ((one.1 - other.1).norm(), one.0, other.0))
    });
    let (apart_m, a, b) = pairs.max_by(|one, other| one.0.total_cmp(&other.0))?;
    let (a, b) = (site.camera_id(a)?, site.camera_id(b)?);
    (apart_m > APART_M).then_some(Imperfection::CamerasDisagree { a, b, apart_m })
}

/// Objects at another scale, as far as that is no fault.
fn scales(corrections: &Corrections, site: &ModelledSite) -> Vec<Imperfection> {
    let scales = corrections.scales.iter().filter_map(|(object, one)| {
        let off = one.log_factor.abs();
        let worth = off > SIZE_OFF.max(CLEAR * one.sigma) && !one.is_clear();
        worth.then_some(Imperfection::ScaleOff {
            object: site.objects().get(*object)?.clone(),
            ratio: one.log_factor.exp(),
        })
    });
    scales.collect()
}

fn tags(corrections: &Corrections, site: &ModelledSite) -> Vec<Imperfection> {
    let mut places: BTreeMap<_, (f64, Imperfection)> = BTreeMap::new();
    let mut sizes: BTreeMap<_, (f64, Imperfection)> = BTreeMap::new();
    for (tag, one) in &corrections.tags {
        let Some(object) = site.object_of(tag) else {
            continue;
        };
        let (position_m, orientation_rad) = (
            one.step.fixed_rows::<3>(0).norm(),
            one.step.fixed_rows::<3>(3).norm(),
        );
        let off = (position_m / OFF.0).max(orientation_rad / OFF.1);
        keep_worst(&mut places, object, off, || Imperfection::TagOff {
            object: object.clone(),
            tag: *tag,
            position_m,
            orientation_rad,
        });
        let scale = site
            .placement(tag)
            .and_then(|place| corrections.scales.get(&place.body().0));
        let log_size = one.log_size - scale.map_or(0.0, |scale| scale.log_factor);
        let off = log_size.abs() / SIZE_OFF;
        keep_worst(&mut sizes, object, off, || Imperfection::SizeOff {
            object: object.clone(),
            tag: *tag,
            ratio: log_size.exp(),
        });
    }
    let worst = places.into_values().chain(sizes.into_values());
    worst.map(|(_, imperfection)| imperfection).collect()
}

/// Keeps what is off most of each object, where it is off by more than one.
fn keep_worst<K: Ord + Clone>(
    all: &mut BTreeMap<K, (f64, Imperfection)>,
    key: &K,
    off: f64,
    imperfection: impl FnOnce() -> Imperfection,
) {
    let is_worst = all.get(key).is_none_or(|(worst, _)| *worst < off);
    if off > 1.0 && is_worst {
        all.insert(key.clone(), (off, imperfection()));
    }
}
