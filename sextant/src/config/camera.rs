//! `sextant config get|set camera`: exposure, gain and rate of a camera, from the site to the camera and back.

use super::change::change;
use crate::output::{Format, print_line};
use crate::site::SiteArguments;
use crate::words;
use anyhow::{anyhow, bail};
use clap::Args;
use sextant_gateways::site::SiteSession;
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Exit, Failure};
use sextant_proto::{
    CameraControls, CameraSettings, CameraStatus, Control, SettingsOutcome, limits,
};
use sextant_site_model::CameraId;
use sextant_zenoh_bus::{DropRule, Subscription};
use std::time::{Duration, Instant};

/// How long the camera may take: it may have to be opened anew, and reports once a second.
const PATIENCE: Duration = Duration::from_secs(10);
const QUEUE: usize = 16;

/// What to set. What is left out stays as it is; `file` leaves it to the camera's own file.
#[derive(Args, Debug)]
pub struct SetCamera {
    /// Its name.
    id: CameraId,
    /// Exposure with its unit, such as 4ms or 250us, up to 1s; or `file`.
    #[arg(long, value_name = "TIME", value_parser = exposure_us)]
    exposure: Option<Wanted>,
    /// Gain in the units of the camera's driver, 0 to 1000000; or `file`.
    #[arg(long, value_name = "GAIN", value_parser = gain)]
    gain: Option<Wanted>,
    /// Images per second, 0.1 to 1000; or `file`.
    #[arg(long, value_name = "HZ", value_parser = rate_hz)]
    rate: Option<Wanted>,
    #[command(flatten)]
    site: SiteArguments,
}

/// A value of the site, or of the camera's own file.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wanted {
    File,
    Site(f64),
}

fn exposure_us(typed: &str) -> Result<Wanted, String> {
    let hint = "write a time with its unit up to 1s, such as 4ms or 250us, or `file`";
    wanted(typed, 1.0..=1e6, hint, |typed| {
        let units = [("us", 1.0), ("ms", 1e3), ("s", 1e6)];
        let number = |(unit, us)| Some((typed.strip_suffix(unit)?, us));
        let (number, us) = units.into_iter().find_map(number)?;
        Some(number.trim().parse::<f64>().ok()? * us)
    })
}

fn gain(typed: &str) -> Result<Wanted, String> {
    let hint = "write a number from 0 to 1000000, or `file`";
    wanted(typed, 0.0..=1e6, hint, |typed| typed.parse().ok())
}

fn rate_hz(typed: &str) -> Result<Wanted, String> {
    let hint = "write images per second from 0.1 to 1000, or `file`";
    wanted(typed, 0.1..=1e3, hint, |typed| typed.parse().ok())
}

fn wanted(
    typed: &str,
    range: std::ops::RangeInclusive<f64>,
    hint: &str,
    read: impl Fn(&str) -> Option<f64>,
) -> Result<Wanted, String> {
    if typed == "file" {
        return Ok(Wanted::File);
    }
    let value = read(typed).filter(|value| range.contains(value));
    value.map(Wanted::Site).ok_or_else(|| hint.to_owned())
}

impl Wanted {
    fn or(wanted: Option<Self>, present: Option<f64>) -> Option<f64> {
        match wanted {
            None => present,
            Some(Self::File) => None,
            Some(Self::Site(value)) => Some(value),
        }
    }
}

/// Sets what is wanted and waits for the camera.
///
/// # Errors
/// Nothing to set; a refusal by the fusion node or the camera; no answer.
pub fn set(arguments: &SetCamera, format: Format) -> anyhow::Result<()> {
    let SetCamera {
        id,
        exposure,
        gain,
        rate,
        site,
    } = arguments;
    if [exposure, gain, rate].iter().all(|wanted| wanted.is_none()) {
        let cause = anyhow!("nothing to set: give --exposure, --gain or --rate");
        bail!(Failure::new(Exit::Usage, cause));
    }
    let site = site.open()?;
    let present = in_force(&site, id)?;
    let settings = CameraSettings {
        camera: id.clone(),
        exposure_us: Wanted::or(*exposure, present.exposure_us),
        gain: Wanted::or(*gain, present.gain),
        rate_hz: Wanted::or(*rate, present.rate_hz),
    };
    let statuses = statuses(&site, id)?;
    change(&site, &site.keys.config_camera(id), &settings, format)?;
    let is_settled = |status: &CameraStatus| {
        let CameraControls { outcome, .. } = &status.controls;
        status.controls.wanted() == settings.values() && *outcome != SettingsOutcome::Pending
    };
    // The first such status may tell of images from before.
    let settled = wait_for(&site, &statuses, is_settled);
    let settled = settled.and_then(|_| wait_for(&site, &statuses, is_settled));
    let Some(status) = settled else {
        let cause = anyhow!(
            "camera {id} has not taken its settings within {} s; it takes them when it connects \
             and has images (`sextant list`)",
            PATIENCE.as_secs()
        );
        bail!(Failure::new(Exit::Unavailable, cause))
    };
    print_status(&status, format)?;
    if let SettingsOutcome::Refused { detail } = &status.controls.outcome {
        let cause = words::plain(detail);
        bail!(Failure::new(
            Exit::Fault,
            anyhow!("camera {id} keeps what it had: {cause}")
        ));
    }
    site.bus.close();
    Ok(())
}

/// Prints exposure, gain and rate: in force, possible and set by the site.
///
/// # Errors
/// No router, no such camera.
pub fn get(id: &CameraId, site: &SiteArguments, format: Format) -> anyhow::Result<()> {
    let site = site.open()?;
    let known: Vec<CameraStatus> = site.latest(&site.keys.camera_status(id))?;
    let Some(status) = known.first() else {
        let cause = anyhow!("no camera {id} is there; `sextant list` shows those that are");
        bail!(Failure::new(Exit::Unavailable, cause))
    };
    print_status(status, format)?;
    site.bus.close();
    Ok(())
}

fn in_force(site: &SiteSession, id: &CameraId) -> anyhow::Result<CameraSettings> {
    let found: Vec<CameraSettings> = site.latest(&site.keys.config_camera(id))?;
    let first = found.into_iter().next();
    Ok(first.unwrap_or_else(|| CameraSettings::none(id.clone())))
}

fn statuses(site: &SiteSession, id: &CameraId) -> anyhow::Result<Subscription> {
    let key = site.keys.camera_status(id);
    let longest = limits::MAX_PAYLOAD_BYTES;
    Ok(site.bus.subscribe(&key, QUEUE, DropRule::Oldest, longest)?)
}

fn wait_for(
    site: &SiteSession,
    statuses: &Subscription,
    is_settled: impl Fn(&CameraStatus) -> bool,
) -> Option<CameraStatus> {
    let deadline = Instant::now() + PATIENCE;
    while Instant::now() < deadline && !site.shutdown.is_requested() {
        let item = statuses.recv_timeout(SHUTDOWN_POLL);
        let status = item.and_then(|item| item.decode::<CameraStatus>().ok());
        if let Some(status) = status.filter(&is_settled) {
            return Some(status);
        }
    }
    None
}

fn print_status(status: &CameraStatus, format: Format) -> anyhow::Result<()> {
    let CameraStatus {
        camera,
        controls,
        brightness,
        rate_hz,
        ..
    } = status;
    let text = match format {
        Format::Json => serde_json::json!({
            "camera": camera, "controls": controls, "brightness": brightness, "rate_hz": rate_hz,
        })
        .to_string(),
        Format::Text => format!(
            "camera {camera}: {}; mean grey level {brightness:.0}, {rate_hz:.1} images/s\n{}",
            words::settings_outcome(&controls.outcome),
            table(controls)
        ),
    };
    Ok(print_line(&text)?)
}

/// A line per setting: value, range and who has set it.
fn table(controls: &CameraControls) -> String {
    [
        format!("  exposure  {}", row(controls.exposure_us, " ms", 1000.0)),
        format!("  gain      {}", row(controls.gain, "", 1.0)),
        format!("  rate      {}", row(controls.rate_hz, " images/s", 1.0)),
    ]
    .join("\n")
}

/// One setting in a unit that is `divisor` of the message's.
fn row(control: Control, unit: &str, divisor: f64) -> String {
    let number = |value: f64| {
        let digits = format!("{:.4}", value / divisor);
        digits
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned()
    };
    let value = match control.value {
        Some(value) => format!("{}{unit}", number(value)),
        None => "chosen by the camera".to_owned(),
    };
    let range = control.range.map_or_else(String::new, |range| {
        let [least, greatest] = range.map(number);
        format!(", possible {least} to {greatest}")
    });
    let by = match control.wanted {
        Some(wanted) if control.value != Some(wanted) => {
            format!(", the site wants {}{unit}", number(wanted))
        }
        Some(_) => ", set by the site".to_owned(),
        None => String::new(),
    };
    format!("{value}{range}{by}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_stays_and_file_removes() {
        let present = Some(4000.0);
        assert_eq!(Wanted::or(None, present), present);
        assert_eq!(Wanted::or(Some(Wanted::File), present), None);
        assert_eq!(Wanted::or(Some(Wanted::Site(8.0)), present), Some(8.0));
    }

    #[test]
    fn an_exposure_has_a_unit() {
        for (typed, us) in [("4ms", 4000.0), ("250us", 250.0), ("0.01 s", 10_000.0)] {
            assert_eq!(exposure_us(typed), Ok(Wanted::Site(us)));
        }
        for wrong in ["4", "ms", "2s", "0us", "NaNms", "soon"] {
            assert!(exposure_us(wrong).unwrap_err().contains("4ms"), "{wrong}");
        }
        assert!(rate_hz("0").is_err());
        assert_eq!(gain("file"), Ok(Wanted::File));
    }

    #[test]
    fn a_row_says_what_is_in_force_and_what_the_site_wants() {
        let control = Control {
            wanted: Some(50.0),
            value: Some(100.0),
            range: Some([100.0, 33_000.0]),
        };
        let said = row(control, " ms", 1000.0);
        assert_eq!(said, "0.1 ms, possible 0.1 to 33, the site wants 0.05 ms");
        assert_eq!(row(Control::default(), "", 1.0), "chosen by the camera");
    }
}
