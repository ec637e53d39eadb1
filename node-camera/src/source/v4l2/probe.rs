//! Which cameras this host has, what they can do, and a first `camera.toml` for one.

use std::fmt::{self, Write};
use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::controls;
use super::device::{ControlKind, Device, Sizes};
use super::kernel::KernelDevice;
use super::negotiation::{offers, rates_hz};
use super::{api_of, device_error};
use crate::source::pixel_formats::{FORMATS, PixelFormat};

/// Images a second that are enough: more cost time, fewer are chosen only where there are none.
const ENOUGH_HZ: f64 = 30.0;
/// Width that is enough for tags across a room; detection time grows with the pixels.
const ENOUGH_WIDTH: u32 = 1280;
/// Sizes that are asked for where a camera takes any.
const USUAL_SIZES: [[u32; 2]; 4] = [[640, 480], [1280, 720], [1280, 800], [1920, 1080]];

/// A video device of this machine, with its formats and controls.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Camera {
    /// Its file: by its place on the bus, where udev gives it such a name.
    pub device: PathBuf,
    /// The camera's own name.
    pub card: String,
    /// Its driver.
    pub driver: String,
    /// Its plug, as the driver names it.
    pub bus: String,
    /// Its formats, in its own order.
    pub formats: Vec<CameraFormat>,
    /// Its controls.
    pub controls: Vec<CameraControl>,
}

/// A format of a camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraFormat {
    /// Its code, as `format` of camera.toml has it.
    pub format: String,
    /// Whether a camera node reads it.
    pub is_readable: bool,
    /// Sizes, with the rates of each.
    pub sizes: Vec<CameraSize>,
}

/// A size of a format.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraSize {
    /// Width and height, pixels.
    pub resolution: [u32; 2],
    /// Images a second, the most first; of a range both ends. Empty where the driver does not say.
    pub rates_hz: Vec<f64>,
}

/// A control of a camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraControl {
    /// Its name, as `controls` of camera.toml has it.
    pub name: String,
    /// Least and greatest value.
    pub range: [i32; 2],
    /// Step between values.
    pub step: i32,
    /// The driver's default.
    pub default: i32,
    /// The value now, where it can be read.
    pub value: Option<i32>,
    /// The words of a menu, with their values.
    pub menu: Vec<(i32, String)>,
}

/// A device that says nothing: its file and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Mute {
    /// Its file.
    pub device: PathBuf,
    /// Why it says nothing.
    pub cause: String,
}

/// Every video device below `/dev`, and what each says of itself. Devices that do not capture are left out.
#[must_use]
pub fn cameras() -> Vec<Result<Camera, Mute>> {
    let mut devices = numbered_devices(Path::new("/dev"));
    devices.sort();
    devices
        .into_iter()
        .filter_map(|(_, device)| camera(&device).transpose())
        .collect()
}

/// What one device says of itself; none where it does not capture.
///
/// # Errors
/// One that cannot be opened or asked.
pub fn camera(file: &Path) -> Result<Option<Camera>, Mute> {
    let mute = |what: &str, cause: &std::io::Error| Mute {
        device: file.to_owned(),
        cause: device_error(file, what, cause).to_string(),
    };
    let device = KernelDevice::open(file).map_err(|cause| mute("cannot be opened", &cause))?;
    let described = describe(&device, &lasting_name(file));
    described.map_err(|cause| mute("cannot be asked what it is", &cause))
}

/// What a device says of itself.
pub(super) fn describe(device: &impl Device, file: &Path) -> std::io::Result<Option<Camera>> {
    let identity = device.identity()?;
    let Ok(api) = api_of(&identity) else {
        return Ok(None);
    };
    let formats = offers(device, api).into_iter().map(|offer| {
        let sizes = offer.sizes.iter().flat_map(|sizes| listed(*sizes));
        let size = |resolution| CameraSize {
            resolution,
            rates_hz: rates_hz(device, offer.fourcc, resolution),
        };
        CameraFormat {
            format: PixelFormat::name(offer.fourcc),
            is_readable: PixelFormat::from_fourcc(offer.fourcc).is_some(),
            sizes: sizes.map(size).collect(),
        }
    });
    let formats = formats.collect();
    let controls = controls::all(device)
        .into_iter()
        .map(|control| CameraControl {
            name: controls::name(&control),
            range: control.range,
            step: control.step,
            default: control.default,
            value: device.control(control.id).ok(),
            menu: menu(device, &control),
        });
    Ok(Some(Camera {
        device: file.to_owned(),
        formats,
        controls: controls.collect(),
        card: identity.card,
        driver: identity.driver,
        bus: identity.bus,
    }))
}

fn menu(device: &impl Device, control: &super::device::Control) -> Vec<(i32, String)> {
    let [least, most] = control.range;
    if control.kind != ControlKind::Menu {
        return Vec::new();
    }
    let entries = (least.max(0)..=most.min(least.saturating_add(63))).filter_map(|index| {
        let words = device.menu_entry(control.id, index.unsigned_abs()).ok()?;
        Some((index, words))
    });
    entries.collect()
}

/// Sizes of which a person may choose.
fn listed(sizes: Sizes) -> Vec<[u32; 2]> {
    let Sizes::Steps {
        width: [least_width, most_width, width_step],
        height: [least_height, most_height, height_step],
    } = sizes
    else {
        let Sizes::One(one) = sizes else {
            return Vec::new();
        };
        return vec![one];
    };
    let fits = |length: u32, [least, most, step]: [u32; 3]| {
        (least..=most).contains(&length) && (length - least).is_multiple_of(step.max(1))
    };
    let usual = USUAL_SIZES.into_iter().filter(|[width, height]| {
        fits(*width, [least_width, most_width, width_step])
            && fits(*height, [least_height, most_height, height_step])
    });
    let mut all: Vec<_> = usual.collect();
    all.push([most_width, most_height]);
    all.dedup();
    all
}

impl Camera {
    /// The best format, size and rate for a camera node: fast enough first, then wide enough, then by format.
    fn best(&self) -> Option<(&CameraFormat, &CameraSize)> {
        let readable = self.formats.iter().filter(|format| format.is_readable);
        let all = readable.flat_map(|format| format.sizes.iter().map(move |size| (format, size)));
        let rank = |format: &CameraFormat| {
            let mut names = FORMATS.iter();
            names.position(|known| PixelFormat::name(known.fourcc) == format.format)
        };
        all.max_by_key(|(format, size)| {
            let [width, height] = size.resolution;
            let is_fast = fastest(size).is_none_or(|rate_hz| rate_hz >= 0.99 * ENOUGH_HZ);
            let is_enough = width <= ENOUGH_WIDTH;
            let pixels = i64::from(width) * i64::from(height);
            let size = if is_enough { pixels } else { -pixels };
            (is_fast, is_enough, size, std::cmp::Reverse(rank(format)))
        })
    }

    /// A first `camera.toml` for this camera; none where it has no format that is read here.
    #[must_use]
    pub fn first_config(&self) -> Option<String> {
        let (format, size) = self.best()?;
        let [width, height] = size.resolution;
        let mut text = format!(
            "# camera.toml of {}, as `sextant camera --probe` found it. `sextant config camera` prints every key.\n\n\
             site = \"demo\"                 # the middle of every key on the network\n\
             camera = \"north\"              # as the rig names it\n\n\
             [source]\n\
             kind = \"v4l2\"\n\
             device = {:?}\n\
             resolution = [{width}, {height}]\n\
             format = \"{}\"\n",
            self.card.escape_debug(),
            self.device.display().to_string(),
            format.format,
        );
        if let Some(rate_hz) = chosen_rate(size) {
            let _ = writeln!(text, "rate_hz = {rate_hz:?}");
        }
        text += "# exposure_us = 4000          # short against motion blur, with light enough; \
            left out: the camera's choice\n";
        text += &self.gain_line();
        text += &self.control_lines();
        text += "\n[network]\nmode = \"client\"\nconnect = [\"tcp/127.0.0.1:7447\"]  # the \
            site's router: the machine of the fusion node\n";
        Some(text)
    }

    fn gain_line(&self) -> String {
        let gain = self.controls.iter().find(|control| control.name == "gain");
        gain.map_or_else(
            String::new,
            |CameraControl {
                 range: [least, most],
                 ..
             }| {
                format!(
                    "# gain = {least}                    # {least} to {most}, in the driver's \
                units; left out: the camera's choice\n"
                )
            },
        )
    }

    /// A lens that focuses by itself has another calibration each time.
    fn control_lines(&self) -> String {
        let is_focus = |name: &str| {
            matches!(
                name,
                "focus_automatic_continuous" | "focus_auto" | "auto_focus"
            )
        };
        let focus = self.controls.iter().find(|control| is_focus(&control.name));
        focus.map_or_else(String::new, |control| {
            format!(
                "controls = {{ {} = 0 }}   # a lens that focuses by itself cannot be calibrated\n",
                control.name
            )
        })
    }
}

fn fastest(size: &CameraSize) -> Option<f64> {
    size.rates_hz.first().copied()
}

/// The slowest rate that is enough, else the fastest.
fn chosen_rate(size: &CameraSize) -> Option<f64> {
    let enough = size.rates_hz.iter().rev();
    enough
        .copied()
        .find(|rate_hz| *rate_hz >= 0.99 * ENOUGH_HZ)
        .or_else(|| fastest(size))
        .map(|rate_hz| (rate_hz * 1000.0).round() / 1000.0)
}

impl fmt::Display for Camera {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let device = self.device.display();
        writeln!(f, "{device}: {} ({}, {})", self.card, self.driver, self.bus)?;
        for format in &self.formats {
            let note = if format.is_readable {
                ""
            } else {
                " (not read here)"
            };
            writeln!(f, "  {}{note}", format.format)?;
            for CameraSize {
                resolution: [width, height],
                rates_hz,
            } in &format.sizes
            {
                let rates: Vec<String> = rates_hz.iter().map(|hz| format!("{hz:.4}")).collect();
                let rates = rates
                    .iter()
                    .map(|hz| hz.trim_end_matches('0').trim_end_matches('.'))
                    .collect::<Vec<_>>()
                    .join(" ");
                writeln!(f, "    {width}x{height}  {rates}")?;
            }
        }
        for control in &self.controls {
            write!(f, "  {control}")?;
        }
        Ok(())
    }
}

impl fmt::Display for CameraControl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            range: [least, most],
            default,
            ..
        } = self;
        let value = self.value.map_or_else(|| "?".to_owned(), |v| v.to_string());
        writeln!(
            f,
            "{name} = {value}  ({least} to {most}, default {default})"
        )?;
        let mut menu = self.menu.iter();
        menu.try_for_each(|(value, words)| writeln!(f, "      {value}: {words}"))
    }
}

fn numbered_devices(dev: &Path) -> Vec<(u32, PathBuf)> {
    let entries = fs::read_dir(dev).into_iter().flatten().flatten();
    let numbered = entries.filter_map(|entry| {
        let name = entry.file_name();
        let number = name.to_str()?.strip_prefix("video")?.parse().ok()?;
        Some((number, entry.path()))
    });
    numbered.collect()
}

/// The name of a device that survives a reboot: by its place on the bus, where udev made such a link.
fn lasting_name(device: &Path) -> PathBuf {
    let links = fs::read_dir("/dev/v4l/by-path").into_iter().flatten();
    let mut links = links.flatten().map(|entry| entry.path());
    let target = fs::canonicalize(device).ok();
    let link = links.find(|link| target.is_some() && fs::canonicalize(link).ok() == target);
    link.unwrap_or_else(|| device.to_owned())
}
