//! `sextant phone`: links and QR codes by which phones become cameras, and first guesses of their lenses.

use crate::output::{Format, print_line};
use clap::{Args, ValueEnum};
use node_viewer_bridge::{PhoneLink, phone_links};
use sextant_geometry::{Intrinsics, Lens};
use sextant_process::{Exit, WithExit};
use sextant_site_files::rig_toml;
use sextant_site_model::{Camera, CameraId, LensSigma, Prior, Rig};
use std::path::PathBuf;

/// Arguments of `sextant phone`.
#[derive(Args, Debug)]
#[command(after_help = "For example: sextant phone --config viewer.toml
             sextant phone --rig-entry pocket --device phone --image 1280x720 >> rig.toml
Scan the code with a phone's camera and open the link: the page explains what the browser asks. docs/phones.md goes the
whole way. With --json, a line a link: {\"camera\",\"used\",\"url\",\"qr\"}; camera is null where the phone chooses a
name. The link of a site with keys contains the phone's token: keep it private. It is for the first device that uses
it.")]
pub struct PhoneArguments {
    /// File of the viewer bridge that serves the page.
    #[arg(long, default_value = "viewer.toml", conflicts_with = "rig_entry")]
    config: PathBuf,
    /// Print the entry of such a camera for rig.toml, with a guess of its lens, instead of links.
    #[arg(long, value_name = "NAME")]
    rig_entry: Option<CameraId>,
    /// Kind of device, from whose usual field of view the lens is guessed.
    #[arg(long, value_enum, default_value = "phone", requires = "rig_entry")]
    device: Device,
    /// Size of its images, pixels, as the camera's page shows it.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720", value_parser = size, requires = "rig_entry")]
    image: [u32; 2],
}

/// Kinds of device with usual fields of view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Device {
    /// Main camera of a phone that is held across.
    Phone,
    /// Main camera of a phone that is held upright.
    UprightPhone,
    /// Camera above the screen of a laptop.
    Laptop,
    /// USB webcam.
    Webcam,
}

impl Device {
    /// Field of view along the image's width, degrees, and the standard deviation of the focal length as a share of it.
    fn field(self) -> (f64, f64) {
        match self {
            Self::Phone => (65.0, 0.10),
            Self::UprightPhone => (40.0, 0.10),
            Self::Laptop => (65.0, 0.15),
            Self::Webcam => (70.0, 0.15),
        }
    }

    fn lens(self, [width, height]: [f64; 2]) -> Option<(Lens, LensSigma)> {
        /// Of a lens whose distortion is unknown, as a share of the image's width.
        const DISTORTION: f64 = 0.01;
        /// The largest that a rig takes.
        const LARGEST_SIGMA_PX: f64 = 100.0;
        let (degrees, share) = self.field();
        let focal = (width / 2.0 / (degrees.to_radians() / 2.0).tan()).round();
        let intrinsics = Intrinsics {
            fx: focal,
            fy: focal,
            cx: (width - 1.0) / 2.0,
            cy: (height - 1.0) / 2.0,
        };
        let sigma = LensSigma {
            focal_px: (share * focal).round().min(LARGEST_SIGMA_PX),
            distortion_px: DISTORTION * width,
        };
        let lens = Lens::brown_conrady(intrinsics, [0.0; 5]).ok()?;
        Some((lens, sigma))
    }
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || "write WIDTHxHEIGHT, such as 1280x720".to_owned();
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    let size = [width, height].map(|side| side.parse::<u32>().ok());
    match size {
        [Some(width @ 16..=4096), Some(height @ 16..=4096)] => Ok([width, height]),
        _ => Err(wrong()),
    }
}

/// Runs `sextant phone`.
///
/// # Errors
/// A file of a viewer bridge that is missing or wrong.
pub fn run(arguments: &PhoneArguments, format: Format) -> anyhow::Result<()> {
    if let Some(camera) = &arguments.rig_entry {
        let entry = rig_entry(camera, arguments.device, arguments.image).exit_with(Exit::Input)?;
        return Ok(print_line(entry.trim_end())?);
    }
    if !arguments.config.exists() {
        let file = arguments.config.display();
        return Err(anyhow::anyhow!(
            "{file}: no such file; name the file of the viewer bridge \
            with --config, or write one: `sextant config viewer > viewer.toml`. The demo's page \
            for cameras is http://127.0.0.1:8600/camera"
        ))
        .exit_with(Exit::Input);
    }
    let links = phone_links(&arguments.config)?;
    for link in &links.links {
        match format {
            Format::Json => print_line(&serde_json::to_string(link)?)?,
            Format::Text => print_line(&text(link))?,
        }
    }
    if let Some(caution) = links.caution {
        eprintln!("{caution}");
    }
    Ok(())
}

fn text(link: &PhoneLink) -> String {
    let name = link.camera.as_ref();
    let used = match link.used {
        true => ", used by a device: on the page, \"Add a camera\" frees the link for another one",
        false => "",
    };
    let name = name.map_or(String::new(), |name| format!("camera {name}{used}\n"));
    format!("{name}{}{}", link.qr_text(), link.url)
}

fn rig_entry(id: &CameraId, device: Device, size: [u32; 2]) -> anyhow::Result<String> {
    let (lens, sigma) = device
        .lens(size.map(f64::from))
        .ok_or_else(|| anyhow::anyhow!("images of this size have no lens"))?;
    let camera = Camera {
        lens_prior: Prior::Sigma(sigma),
        ..Camera::new(id.clone(), size, lens, None)
    };
    Ok(rig_toml(&Rig::new(vec![camera])?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_files::parse_rig;
    use std::path::Path;

    #[test]
    fn a_guess_is_an_entry_of_a_rig() {
        let id = CameraId::new("pocket").unwrap();
        let text = rig_entry(&id, Device::Phone, [1280, 720]).unwrap();
        let rig = parse_rig(Path::new("rig.toml"), &text).unwrap();
        let camera = &rig.cameras()[0];
        assert_eq!(camera.resolution, [1280, 720]);
        let focal = camera.lens.intrinsics().fx;
        assert!((950.0..1050.0).contains(&focal), "{text}");
        assert!(text.contains("lens_sigma"), "{text}");
        assert_eq!(camera.world_from_camera, None);
    }

    #[test]
    fn sizes_are_read_or_refused() {
        assert_eq!(size("1280x720"), Ok([1280, 720]));
        for wrong in ["", "1280", "0x720", "99999x9", "axb"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }
}
