//! Faults with the ids of cameras, objects and tags.

use std::collections::{BTreeMap, BTreeSet};

use crate::clocks::offset_search::OffsetSearch;
use crate::diagnosis::{Diagnosis, MovedCamera};
use crate::mended::MendedModels;
use crate::site::ModelledSite;
use sextant_site_model::{CameraId, ObjectModel};
use sextant_site_report::{ClockOffset, Fault};

/// Clock offset that is worth naming, s: 2 mm at 1 m/s.
const OFF_S: f64 = 0.002;
/// Standard deviations by which an offset must differ from zero.
const SURE: f64 = 10.0;

/// Whether a clock offset is worth naming.
pub(crate) fn is_off(clock: &ClockOffset) -> bool {
    clock.offset_s.abs() > OFF_S.max(SURE * clock.sigma_s)
}

/// All faults: cameras, tags, clocks, duplicates, each in order of name. A moved camera is not named while its clock
/// may be the cause.
pub(crate) fn all(
    site: &ModelledSite,
    diagnosis: &Diagnosis,
    clocks: &BTreeMap<CameraId, ClockOffset>,
    search: &OffsetSearch,
    now_ns: u64,
) -> Vec<Fault> {
    let is_sure = !search.is_young(now_ns);
    let camera = |index: usize| site.camera_id(index);
    let is_timely = |one: &MovedCamera| one.is_timely && !search.is_out_of_step(one.camera);
    let moved = diagnosis.moved_cameras();
    let moved = moved.filter(|one| is_sure || is_timely(one));
    let moved = moved.filter_map(|one| {
        let pair_with = |other: usize| Some((one.camera.min(other), one.camera.max(other)));
        Some(match one.or.and_then(pair_with) {
            None => Fault::CameraMoved {
                camera: camera(one.camera)?,
            },
            Some((a, b)) => Fault::CamerasDisagree {
                a: camera(a)?,
                b: camera(b)?,
            },
        })
    });
    let wrong = diagnosis.wrong_tags().filter_map(|(tag, ratio)| {
        let object = site.object_of(&tag)?.clone();
        Some(match ratio {
            Some(ratio) => Fault::TagSize { object, tag, ratio },
            None => Fault::TagMisplaced { object, tag },
        })
    });
    let misplaced_tags = diagnosis.misplaced_tags().filter_map(|(object, tag, on)| {
        Some(Fault::TagElsewhere {
            object: site.objects().get(object)?.clone(),
            tag,
            on: on.and_then(|on| site.objects().get(on).cloned()),
        })
    });
    let duplicate_tags = diagnosis.duplicate_tags().filter_map(|(index, tag)| {
        Some(Fault::DuplicateTag {
            camera: camera(index)?,
            tag,
        })
    });
    let tags = wrong.chain(misplaced_tags);
    let mut all: Vec<Fault> = moved.chain(tags).collect();
    all.extend(of_clocks(site, diagnosis, clocks, search, now_ns));
    all.extend(duplicate_tags);
    all
}

/// Clocks that are steadily off, then cameras whose images are rejected for their age.
fn of_clocks(
    site: &ModelledSite,
    diagnosis: &Diagnosis,
    clocks: &BTreeMap<CameraId, ClockOffset>,
    search: &OffsetSearch,
    now_ns: u64,
) -> Vec<Fault> {
    let is_sure = !search.is_young(now_ns);
    let camera = |index: usize| site.camera_id(index);
    // Poses allow for offsets: a camera that contradicts all the same has another fault, and a camera that is moved
    // spoils the offsets of all others.
    let contradicting: BTreeSet<usize> = diagnosis.contradicting_cameras().collect();
    let is_spoilt = diagnosis.moved_cameras().next().is_some();
    let steadily_off = search.steadily_off(now_ns);
    let steadily_off =
        steadily_off.filter(|index| is_sure && !is_spoilt && !contradicting.contains(index));
    let steady: BTreeSet<CameraId> = search
        .offsets()
        .map(|(index, _)| index)
        .chain(steadily_off)
        .filter_map(camera)
        .collect();
    let host_offset_ns = search.host_offset_ns();
    let host = (host_offset_ns != 0).then_some(Fault::HostClockOff {
        offset_s: host_offset_ns as f64 * 1e-9,
    });
    let off = clocks
        .iter()
        .filter(|(camera, clock)| steady.contains(*camera) && is_off(clock));
    let off = off.map(|(camera, clock)| Fault::ClockOff {
        camera: camera.clone(),
        offset_s: clock.offset_s,
    });
    let untimely = search.untimely().filter(|_| is_sure);
    let untimely = untimely.filter_map(|(index, age_s)| {
        Some(Fault::Untimely {
            camera: camera(index)?,
            age_s,
        })
    });
    host.into_iter().chain(off).chain(untimely).collect()
}

/// Cameras whose pictures stand still, then those that see nothing, then those with other lenses.
pub(crate) fn of_cameras(
    site: &ModelledSite,
    frozen: impl Iterator<Item = (usize, f64)>,
    blind: impl Iterator<Item = (usize, usize, f64)>,
    diagnosis: &Diagnosis,
) -> Vec<Fault> {
    let frozen = frozen.filter_map(|(index, still_s)| {
        Some(Fault::CameraFrozen {
            camera: site.camera_id(index)?,
            still_s,
        })
    });
    let blind = blind.filter_map(|(index, object, blind_s)| {
        Some(Fault::CameraBlind {
            camera: site.camera_id(index)?,
            object: site.objects().get(object)?.clone(),
            blind_s,
        })
    });
    let lenses = diagnosis.wrong_lenses().filter_map(|index| {
        Some(Fault::LensOff {
            camera: site.camera_id(index)?,
        })
    });
    frozen.chain(blind).chain(lenses).collect()
}

/// Cameras whose images are of another size than the rig says.
pub(crate) fn of_sizes<'a>(
    site: &ModelledSite,
    sizes: impl Iterator<Item = (&'a CameraId, [u32; 2])>,
) -> Vec<Fault> {
    let faults = sizes.filter_map(|(camera, size)| {
        Some(Fault::ImageSize {
            camera: camera.clone(),
            size,
            of_rig: site.camera(camera)?.1.resolution,
        })
    });
    faults.collect()
}

/// The camera of a fault that is one of its images, and known for as long as they arrive.
pub(crate) fn camera_of_images(fault: &Fault) -> Option<&CameraId> {
    match fault {
        Fault::CameraFrozen { camera, .. }
        | Fault::CameraBlind { camera, .. }
        | Fault::ImageSize { camera, .. }
        | Fault::Untimely { camera, .. } => Some(camera),
        _ => None,
    }
}

/// What keeps an object from being tracked, whatever camera or tag it is due to.
pub(crate) fn of_objects(
    site: &ModelledSite,
    models: &MendedModels,
    refused_share: impl Fn(usize) -> Option<f64>,
) -> Vec<Fault> {
    let (_, objects) = models.files();
    let scaled = objects.iter().enumerate().filter_map(|(index, model)| {
        let scales = [models.print_scale(index), site.learned_scale(index)];
        let is_known = scales.iter().any(Option::is_some);
        is_known.then(|| Fault::ObjectScaled {
            object: model.id().clone(),
            ratio: scales.into_iter().flatten().product(),
        })
    });
    let contradicted = objects.iter().enumerate().filter_map(|(index, model)| {
        Some(Fault::ObjectContradicted {
            object: model.id().clone(),
            share: refused_share(index)?,
        })
    });
    let is_placed = |model: &ObjectModel| {
        let mut tags = model.tags().iter();
        tags.len() == 1 || tags.any(|tag| tag.object_from_tag.is_some())
    };
    let unplaced = objects.iter().filter(|model| !is_placed(model));
    let unplaced = unplaced.map(|model| Fault::ObjectUnplaced {
        object: model.id().clone(),
    });
    scaled.chain(contradicted).chain(unplaced).collect()
}
