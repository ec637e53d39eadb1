//! The faults by the names that people know.

use std::collections::BTreeMap;

use crate::health::{Fault, Health};
use crate::site::Site;
use crate::{CameraId, ClockOffset};

/// Seconds of clock offset that are worth a word: 1 mm at 1 m/s is not seen, 2 mm is.
const OFF_S: f64 = 0.002;
/// Sigmas by which an offset must be known.
const SURE: f64 = 10.0;

/// All faults: cameras, tags, clocks, twins, each in order of name.
pub(crate) fn all(
    site: &Site,
    health: &Health,
    clocks: &BTreeMap<CameraId, ClockOffset>,
) -> Vec<Fault> {
    let camera = |index: usize| site.cameras().get(index).map(|camera| camera.id.clone());
    let moved = health.moved_cameras().filter_map(|index| {
        Some(Fault::CameraMoved {
            camera: camera(index)?,
        })
    });
    let wrong = health.wrong_tags().filter_map(|(object, tag, ratio)| {
        let object = site.objects().get(object)?.clone();
        Some(match ratio {
            Some(ratio) => Fault::TagSize { object, tag, ratio },
            None => Fault::TagMisplaced { object, tag },
        })
    });
    let off = clocks
        .iter()
        .filter(|(_, clock)| clock.offset_s.abs() > OFF_S.max(SURE * clock.sigma_s));
    let off = off.map(|(camera, clock)| Fault::ClockOff {
        camera: camera.clone(),
        offset_s: clock.offset_s,
    });
    let twins = health.twins().filter_map(|(index, tag)| {
        Some(Fault::DuplicateTag {
            camera: camera(index)?,
            tag,
        })
    });
    moved.chain(wrong).chain(off).chain(twins).collect()
}
