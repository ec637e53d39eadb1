//! Exposure, gain and every other control of a camera, by name.

use sextant_process::Exit;
use sextant_proto::Control as Setting;

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

/// Sets what is configured and returns what the camera has now. What it refuses is logged, since it goes on with its
/// own value. `before` is the configuration until now: what is no longer configured returns to the driver's default.
///
/// # Errors
/// A control that the camera does not have, and a value beyond its range.
pub(super) fn apply(
    device: &impl Device,
    config: &V4l2Config,
    before: Option<&V4l2Config>,
) -> Result<InForce, SourceError> {
    let controls = all(device);
    let mut wishes = named(&controls, config)?;
    wishes.extend(before.map_or_else(Vec::new, |before| released(&controls, before, config)));
    wishes.extend(derived(&controls, config));
    // Switches first: what they take from the camera's automatic can only be set then.
    wishes.sort_by_key(|(control, _)| control.kind == ControlKind::Integer);
    for (control, value) in wishes {
        if let Err(cause) = device.set_control(control.id, value) {
            tracing::warn!(control = control.title, value, %cause, "the camera keeps its own value");
        }
    }
    Ok(in_force(device, &controls, config))
}

/// Exposure and gain of a camera. Values that it chooses by itself are unknown.
#[derive(Debug, Clone, Copy)]
pub(super) struct InForce {
    pub(super) exposure_us: Setting,
    pub(super) gain: Setting,
}

fn in_force(device: &impl Device, controls: &[Control], config: &V4l2Config) -> InForce {
    let setting = |control: Option<&Control>, unit: f64, is_fixed: bool| {
        let scaled = |value: i32| f64::from(value.max(0)) * unit;
        let value = |control: &Control| device.control(control.id).ok().map(scaled);
        let range = control.map(|control| control.range.map(scaled));
        Setting {
            wanted: None,
            value: control.filter(|_| is_fixed).and_then(value),
            range: range.filter(|[least, greatest]| least <= greatest),
        }
    };
    let unit_us = f64::from(EXPOSURE_UNIT_US);
    InForce {
        exposure_us: setting(
            find(controls, EXPOSURE_ABSOLUTE),
            unit_us,
            config.exposure_us.is_some(),
        ),
        gain: setting(gain(controls), 1.0, config.gain.is_some()),
    }
}

impl InForce {
    /// Exposure, ns; 0 where the camera has none that is fixed.
    pub(super) fn exposure_ns(&self) -> u32 {
        (self.exposure_us.value.unwrap_or(0.0) * 1000.0).max(0.0) as u32
    }
}

fn find(controls: &[Control], id: u32) -> Option<&Control> {
    controls.iter().find(|control| control.id == id)
}

fn gain(controls: &[Control]) -> Option<&Control> {
    find(controls, GAIN).or_else(|| find(controls, ANALOGUE_GAIN))
}

/// Defaults of what was configured before and is not any more.
fn released<'a>(
    controls: &'a [Control],
    before: &V4l2Config,
    config: &V4l2Config,
) -> Vec<(&'a Control, i32)> {
    let mut released = Vec::new();
    if before.exposure_us.is_some() && config.exposure_us.is_none() {
        let automatic = find(controls, EXPOSURE_AUTO);
        released.extend(automatic.or_else(|| find(controls, EXPOSURE_ABSOLUTE)));
    }
    if before.gain.is_some() && config.gain.is_none() {
        released.extend(find(controls, AUTOGAIN).or_else(|| gain(controls)));
    }
    if before.rate_hz.is_some() && config.rate_hz.is_none() {
        released.extend(find(controls, EXPOSURE_AUTO_PRIORITY));
    }
    let with_default = |control: &'a Control| (control, control.default);
    released.into_iter().map(with_default).collect()
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
    let mut wishes = Vec::new();
    if let Some(exposure_us) = config.exposure_us {
        wishes.extend(find(controls, EXPOSURE_AUTO).map(|control| (control, MANUAL)));
        let units = exposure_us.saturating_add(EXPOSURE_UNIT_US / 2) / EXPOSURE_UNIT_US;
        match find(controls, EXPOSURE_ABSOLUTE) {
            Some(control) => wishes.push((control, within(control, units))),
            None => tracing::warn!("the camera has no control for its exposure"),
        }
    }
    if let Some(gain) = config.gain {
        wishes.extend(find(controls, AUTOGAIN).map(|control| (control, 0)));
        match self::gain(controls) {
            Some(control) => wishes.push((control, within(control, gain))),
            None => tracing::warn!("the camera has no control for its gain"),
        }
    }
    if config.rate_hz.is_some() {
        wishes.extend(find(controls, EXPOSURE_AUTO_PRIORITY).map(|control| (control, 0)));
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
