//! A host and its camera, as typed.

use sextant_site_model::CameraId;
use std::net::IpAddr;
use std::str::FromStr;

/// Where a camera node goes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// As ssh takes it.
    pub host: String,
    /// The camera that the host has.
    pub camera: CameraId,
}

impl FromStr for Target {
    type Err = String;

    fn from_str(typed: &str) -> Result<Self, String> {
        let (host, camera) = match typed.split_once('=') {
            Some((host, camera)) => (host, camera.to_owned()),
            None => (typed, usual_camera(typed)?),
        };
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "@._:%-[]".contains(c);
        if host.is_empty() || host.starts_with('-') || !host.chars().all(is_plain) {
            return Err(format!("{host:?} is no name of a host"));
        }
        let camera = CameraId::new(&camera)
            .map_err(|cause| format!("{cause}: name the host's camera, such as {host}=north"))?;
        Ok(Self {
            host: host.to_owned(),
            camera,
        })
    }
}

/// The first part of the host's name.
fn usual_camera(host: &str) -> Result<String, String> {
    let name = host.rsplit('@').next().unwrap_or(host);
    if name.parse::<IpAddr>().is_ok() || name.contains(':') {
        return Err(format!("name the camera of {host}, such as {host}=north"));
    }
    let first = name.split('.').next().unwrap_or(name);
    Ok(first.to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(typed: &str) -> Result<(String, String), String> {
        let target: Target = typed.parse()?;
        Ok((target.host, target.camera.to_string()))
    }

    #[test]
    fn a_host_names_its_camera_or_is_given_it() {
        for (typed, host, camera) in [
            ("north", "north", "north"),
            ("pi@North.lab", "pi@North.lab", "north"),
            ("pi@10.0.0.7=south", "pi@10.0.0.7", "south"),
            ("board=left", "board", "left"),
        ] {
            assert_eq!(read(typed), Ok((host.to_owned(), camera.to_owned())));
        }
    }

    #[test]
    fn what_would_be_an_option_or_a_command_is_refused() {
        for typed in [
            "-oProxyCommand=x",
            "a b=north",
            "$(x)=north",
            "10.0.0.7",
            "north=a/b",
            "=north",
        ] {
            assert!(read(typed).is_err(), "{typed}");
        }
    }
}
