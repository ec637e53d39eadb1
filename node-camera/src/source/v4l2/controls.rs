//! Exposure, gain and every other control of a camera, by name.

use std::io;

use sextant_process::Exit;

use super::device::{Control, ControlKind, Device};
use crate::config::V4l2Config;
use crate::source::SourceError;

const AUTOGAIN: u32 = 0x0098_0912;
const GAIN: u32 = 0x0098_0913;
const EXPOSURE_AUTO: u32 = 0x009a_0901;
const EXPOSURE_ABSOLUTE: u32 = 0x009a_0902;
/// Whether automatic exposure may lower the rate.
const EXPOSURE_AUTO_PRIORITY: u32 = 0x009a_0903;
const ANALOGUE_GAIN: u32 = 0x009e_0903;

/// The entry of [`EXPOSURE_AUTO`] that leaves the exposure to us.
const MANUAL: i32 = 1;
/// Length of one unit of [`EXPOSURE_ABSOLUTE`], µs.
const EXPOSURE_UNIT_US: u32 = 100;

const FLAG_DISABLED: u32 = 1;
const FLAG_READ_ONLY: u32 = 4;

/// More controls than any camera has: a driver that counts in circles is not followed further.
const MOST_CONTROLS: usize = 1024;

/// Every control that has a value.
pub(super) fn all(device: &impl Device) -> Vec<Control> {
    let mut controls = Vec::new();
    let mut last = 0;
    while let Ok(control) = device.control_after(last) {
        if control.id <= last || controls.len() == MOST_CONTROLS {
            break;
        }
        last = control.id;
        if control.kind != ControlKind::Other && control.flags & FLAG_DISABLED == 0 {
            controls.push(control);
        }
    }
    controls
}

/// A control's name in files: its title in small letters, words joined by underscores, as `v4l2-ctl` has it.
pub(super) fn name(control: &Control) -> String {
    let letter = |c: char| {
        if c.is_ascii_alphanumeric() {
            c.to_ascii_lowercase()
        } else {
            ' '
        }
    };
    let spaced: String = control.title.chars().map(letter).collect();
    spaced.split_whitespace().collect::<Vec<_>>().join("_")
}

/// Sets what the file says and returns the exposure that the camera has now, ns; 0 where it has none that is fixed.
/// What the camera refuses is logged, since it goes on with its own value.
///
/// # Errors
/// A control that the camera does not have, and a value beyond its range.
pub(super) fn apply(device: &impl Device, config: &V4l2Config) -> Result<u32, SourceError> {
    let controls = all(device);
    let mut wishes = named(&controls, config)?;
    wishes.extend(derived(&controls, config));
    // Switches first: what they take from the camera's automatic can only be set then.
    wishes.sort_by_key(|(control, _)| control.kind == ControlKind::Integer);
    for (control, value) in wishes {
        if let Err(cause) = device.set_control(control.id, value) {
            tracing::warn!(control = control.title, value, %cause, "the camera keeps its own value");
        }
    }
    Ok(config.exposure_us.map_or(0, |_| exposure_ns(device)))
}

/// The controls that the file names.
fn named<'a>(
    controls: &'a [Control],
    config: &V4l2Config,
) -> Result<Vec<(&'a Control, i32)>, SourceError> {
    let find = |(wanted, value): (&String, &i32)| {
        let found = controls.iter().find(|control| name(control) == *wanted);
        let control = found.ok_or_else(|| unknown(wanted, controls))?;
        let [least, most] = control.range;
        if !(least..=most).contains(value) {
            let message = format!(
                "source.controls.{wanted}: {value} is not from {least} to {most}, the camera's range"
            );
            return Err(SourceError::new(Exit::Input, message));
        }
        if control.flags & FLAG_READ_ONLY != 0 {
            let message = format!("source.controls.{wanted}: it can only be read; leave it out");
            return Err(SourceError::new(Exit::Input, message));
        }
        Ok((control, *value))
    };
    config.controls.iter().map(find).collect()
}

fn unknown(wanted: &str, controls: &[Control]) -> SourceError {
    let names: Vec<String> = controls.iter().map(name).collect();
    let message = format!(
        "source.controls.{wanted}: the camera has no such control; it has {}",
        names.join(", ")
    );
    SourceError::new(Exit::Input, message)
}

/// What exposure, gain and rate mean in controls, as far as the camera has them.
fn derived<'a>(controls: &'a [Control], config: &V4l2Config) -> Vec<(&'a Control, i32)> {
    let find = |id: u32| controls.iter().find(move |control| control.id == id);
    let mut wishes = Vec::new();
    if let Some(exposure_us) = config.exposure_us {
        wishes.extend(find(EXPOSURE_AUTO).map(|control| (control, MANUAL)));
        let units = exposure_us.saturating_add(EXPOSURE_UNIT_US / 2) / EXPOSURE_UNIT_US;
        match find(EXPOSURE_ABSOLUTE) {
            Some(control) => wishes.push((control, within(control, units))),
            None => tracing::warn!("the camera lets nobody choose its exposure"),
        }
    }
    if let Some(gain) = config.gain {
        wishes.extend(find(AUTOGAIN).map(|control| (control, 0)));
        match find(GAIN).or_else(|| find(ANALOGUE_GAIN)) {
            Some(control) => wishes.push((control, within(control, gain))),
            None => tracing::warn!("the camera lets nobody choose its gain"),
        }
    }
    if config.rate_hz.is_some() {
        wishes.extend(find(EXPOSURE_AUTO_PRIORITY).map(|control| (control, 0)));
    }
    wishes
}

/// The nearest value in a control's range.
fn within(control: &Control, value: u32) -> i32 {
    let [least, most] = control.range;
    let nearest = i32::try_from(value)
        .unwrap_or(i32::MAX)
        .min(most)
        .max(least);
    if i64::from(nearest) != i64::from(value) {
        tracing::warn!(
            control = control.title,
            value,
            nearest,
            "beyond the camera's range; it gets the nearest value"
        );
    }
    nearest
}

fn exposure_ns(device: &impl Device) -> u32 {
    let units: io::Result<i32> = device.control(EXPOSURE_ABSOLUTE);
    let units = units.ok().and_then(|units| u32::try_from(units).ok());
    units.unwrap_or(0).saturating_mul(EXPOSURE_UNIT_US * 1000)
}
