//! The faults by the names that people know.

use std::collections::{BTreeMap, BTreeSet};

use crate::clocks::offset_search::OffsetSearch;
use crate::diagnosis::{Diagnosis, MovedCamera};
use crate::fault::Fault;
use crate::site::Site;
use crate::{CameraId, ClockOffset};

/// Seconds of clock offset that are worth a word: 1 mm at 1 m/s is not seen, 2 mm is.
const OFF_S: f64 = 0.002;
/// Sigmas by which an offset must be known.
const SURE: f64 = 10.0;

/// Whether a clock's offset is worth a word.
pub(crate) fn is_off(clock: &ClockOffset) -> bool {
    clock.offset_s.abs() > OFF_S.max(SURE * clock.sigma_s)
}

/// All faults: cameras, tags, clocks, twins, each in order of name. What looks like a moved camera or tag waits while it may
/// yet be a clock, for which arrivals that have changed speak, too.
pub(crate) fn all(
    site: &Site,
    health: &Diagnosis,
    clocks: &BTreeMap<CameraId, ClockOffset>,
    search: &OffsetSearch,
    now_ns: u64,
) -> Vec<Fault> {
    let is_sure = !search.is_young(now_ns);
    let camera = |index: usize| site.camera_id(index);
    let is_timely = |one: &MovedCamera| one.timely && !search.is_out_of_step(one.camera);
    let moved = health.moved_cameras();
    let moved = moved.filter(|one| is_sure || is_timely(one));
    let moved = moved.filter_map(|one| {
        let one_of = |other: usize| Some((one.camera.min(other), one.camera.max(other)));
        Some(match one.or.and_then(one_of) {
            None => Fault::CameraMoved {
                camera: camera(one.camera)?,
            },
            Some((a, b)) => Fault::CamerasDisagree {
                a: camera(a)?,
                b: camera(b)?,
            },
        })
    });
    let wrong = health.wrong_tags().filter_map(|(object, tag, ratio)| {
        let object = site.objects().get(object)?.clone();
        Some(match ratio {
            Some(ratio) => Fault::TagSize { object, tag, ratio },
            None => Fault::TagMisplaced { object, tag },
        })
    });
    let misplaced_tags = health.misplaced_tags().filter_map(|(object, tag, on)| {
        Some(Fault::TagElsewhere {
            object: site.objects().get(object)?.clone(),
            tag,
            on: on.and_then(|on| site.objects().get(on).cloned()),
        })
    });
    let duplicate_tags = health.duplicate_tags().filter_map(|(index, tag)| {
        Some(Fault::DuplicateTag {
            camera: camera(index)?,
            tag,
        })
    });
    let tags = wrong.chain(misplaced_tags);
    let mut all: Vec<Fault> = moved.chain(tags).collect();
    all.extend(of_clocks(site, health, clocks, search, now_ns));
    all.extend(duplicate_tags);
    all
}

/// Clocks that are steadily off, then cameras whose images are of no use for their age.
fn of_clocks(
    site: &Site,
    health: &Diagnosis,
    clocks: &BTreeMap<CameraId, ClockOffset>,
    search: &OffsetSearch,
    now_ns: u64,
) -> Vec<Fault> {
    let is_sure = !search.is_young(now_ns);
    let camera = |index: usize| site.camera_id(index);
    // Offsets are allowed for: a camera that contradicts all the same has another fault.
    let contradicted = health.contradicted_cameras();
    let moved_ones = health.moved_cameras().map(|one| one.camera);
    let wrong_ones: BTreeSet<usize> = contradicted.chain(moved_ones).collect();
    let long_off = search.long_off(now_ns);
    let long_off = long_off.filter(|index| is_sure && !wrong_ones.contains(index));
    let steady: BTreeSet<CameraId> = search
        .offsets()
        .map(|(index, _)| index)
        .chain(long_off)
        .filter_map(camera)
        .collect();
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
    off.chain(untimely).collect()
}
