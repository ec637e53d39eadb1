//! A scenario: everything about a simulated site, as plain data (`scenario.toml`).
//!
//! Cameras, objects with their tags and paths, light, background, and the faults of clocks and network. Metres,
//! radians, grey levels from 0 to 255; frames as everywhere (`world_from_camera`, `object_from_tag`). Faults are off
//! where a key is left out. What the site's files say is [`Scenario::as_written`], what it truly is
//! [`Scenario::as_built`].

mod arm;
mod demo;
mod faults;
mod imperfections;
mod network_faults;
mod solid;
mod solid_validity;
mod validation;

pub use faults::{AutoExposure, CameraFileError, Curl, Displacement, LensResidual, Mosaic};
pub use imperfections::Imperfections;
pub use network_faults::NetworkFaults;
pub use solid::{Face, Solid};
pub use validation::ScenarioError;

use crate::clock::{Clock, ClockFaults, Schedule};
use crate::path::Path;
use crate::pose_format;
use nalgebra::Vector6;
use serde::{Deserialize, Serialize};
use sextant_geometry::{Lens, Pose};
use sextant_tag_families::Family;

/// A simulated site: cameras, objects, light and faults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Everything random follows from it; below 2^63, the largest integer of a TOML file.
    pub seed: u64,
    /// True time in ns from which the clocks drift.
    #[serde(default)]
    pub start_ns: u64,
    /// The lamp and the light from everywhere.
    #[serde(default)]
    pub light: Light,
    /// The static background.
    #[serde(default)]
    pub background: Background,
    /// At least one.
    #[serde(rename = "camera")]
    pub cameras: Vec<SceneCamera>,
    /// At least one.
    #[serde(rename = "object")]
    pub objects: Vec<SceneObject>,
}

/// A camera: its entry in the rig file, its image acquisition, and its faults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneCamera {
    /// Letters a-z, digits, - and _; at most 32.
    pub id: String,
    /// Width and height in pixels.
    pub resolution: [u32; 2],
    /// From points in the camera's frame to pixels.
    pub lens: Lens,
    /// Where the camera is.
    #[serde(with = "pose_format")]
    pub world_from_camera: Pose,
    /// What the lens does beyond its model.
    #[serde(default, skip_serializing_if = "is_default")]
    pub lens_residual: LensResidual,
    /// How the rig file differs from `lens` and `world_from_camera`.
    #[serde(default, skip_serializing_if = "is_default")]
    pub file_error: CameraFileError,
    /// Images per second; 0.1 to 1000.
    #[serde(default = "defaults::rate_hz")]
    pub rate_hz: f64,
    /// When in the period the images fall due, 0 to 1: cameras with equal phase fire together.
    #[serde(default)]
    pub phase: f64,
    /// Duration of the exposure, ns; moving edges blur over it. Below the period.
    #[serde(default = "defaults::exposure_ns")]
    pub exposure_ns: u64,
    /// Seconds from a row to the next, below zero where the lowest is read first: the capture time is that of the
    /// middle row. All rows together at most 0.1 s.
    #[serde(default)]
    pub line_delay_s: f64,
    /// Exposure and gain that follow the brightness of the background; none: both stay as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub auto_exposure: Option<AutoExposure>,
    /// Brightness: grey levels are multiplied by it; 0.05 to 20.
    #[serde(default = "defaults::gain")]
    pub gain: f64,
    /// Brightness that changes from image to image.
    #[serde(default)]
    pub flicker: Flicker,
    /// Share of the light that is lost in the image's corners, 0 to 0.9.
    #[serde(default)]
    pub vignetting: f64,
    /// Standard deviation of the lens's blur, px; 0 to 5.
    #[serde(default = "defaults::blur_px")]
    pub blur_px: f64,
    /// Radius of the disk into which a lens out of focus spreads a point, px; 0 to 8.
    #[serde(default, skip_serializing_if = "is_default")]
    pub defocus_px: f64,
    /// Standard deviation of the noise, grey levels; 0 to 50.
    #[serde(default = "defaults::noise")]
    pub noise: f64,
    /// Standard deviation of the photons' noise at level 255, grey levels; its square falls with the light. 0 to 50.
    #[serde(default, skip_serializing_if = "is_default")]
    pub shot_noise: f64,
    /// How colours reach the grey image.
    #[serde(default, skip_serializing_if = "is_default")]
    pub mosaic: Mosaic,
    /// Quality of the JPEG through which images go, 1 to 100; none: they are not compressed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jpeg_quality: Option<u8>,
    /// The camera's clock.
    #[serde(default)]
    pub clock: ClockFaults,
    /// The camera's way to the fusion node.
    #[serde(default)]
    pub network: NetworkFaults,
}

/// Brightness that swings: it is multiplied by `1 + amplitude * sin(TAU * rate * t)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Flicker {
    /// 0 (none) to 0.9.
    pub amplitude: f64,
    /// Swings per second; 0 to 1000.
    pub rate_hz: f64,
}

/// An object: solids with tags on them, on a path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneObject {
    /// Letters a-z, digits, - and _; at most 32.
    pub id: String,
    /// Its body: convex solids that may touch but not cut one another.
    #[serde(rename = "solid")]
    pub solids: Vec<Solid>,
    /// The tags on its faces.
    #[serde(rename = "tag")]
    pub tags: Vec<SceneTag>,
    /// Where it goes.
    pub path: Path,
}

/// A printed tag on a face of an object, with its white margin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneTag {
    /// Family of the tag.
    pub family: Family,
    /// Its number in the family; no tag appears twice in a scenario.
    pub id: u32,
    /// Edge of the square that a detector reports, m.
    pub size: f64,
    /// Where it sits: on a face of a solid, its z axis out of the face.
    #[serde(with = "pose_format")]
    pub object_from_tag: Pose,
    /// Printed size by `size`, 0.9 to 1.1: printers scale, alike for all tags of a sheet.
    #[serde(default = "defaults::print_scale", skip_serializing_if = "is_one")]
    pub print_scale: f64,
    /// Where it was glued on, from `object_from_tag`, in the tag's frame; up to 20 mm and 0.3 rad.
    #[serde(default, skip_serializing_if = "is_default")]
    pub glue_error: Displacement,
    /// How the paper is bent.
    #[serde(default, skip_serializing_if = "is_default")]
    pub curl: Curl,
}

/// The light of the room. White paper that faces the lamp has grey level `230 * (ambient + lamp)` at gain 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Light {
    /// Direction towards the lamp, world axes, any length above 0.
    pub towards_lamp: [f64; 3],
    /// Light from everywhere, 0 to 2.
    pub ambient: f64,
    /// Light of the lamp on a surface that faces it, 0 to 2.
    pub lamp: f64,
    /// Radius of the lamp's pool of light about the world's z axis, m: there it has fallen to 3/4. 0.1 to 1000.
    pub pool_radius: f64,
    /// All light that swings, as lamps on mains do at 100 or 120 Hz: less the longer the exposure, in bands where the
    /// shutter rolls.
    #[serde(skip_serializing_if = "is_default")]
    pub flicker: Flicker,
    /// How much of the light a shadow on the table takes away, 0 (no shadows) to 1.
    pub shadow: f64,
}

/// What is behind all objects, at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Background {
    /// One grey level everywhere and no table: for measurements.
    Plain {
        /// 0 to 255.
        level: f64,
    },
    /// A room with a table at height 0, seeded.
    Room {
        /// Edges of the table in x and y, m; 0.2 to 4.
        table: [f64; 2],
        /// How many things lie about: 0 (an empty table) to 1.
        clutter: f64,
    },
}

impl Default for Light {
    fn default() -> Self {
        Self {
            towards_lamp: [0.35, -0.25, 0.9],
            ambient: 0.48,
            lamp: 0.47,
            pool_radius: 2.0,
            flicker: Flicker::default(),
            shadow: 0.45,
        }
    }
}

impl Default for Background {
    fn default() -> Self {
        Self::Room {
            table: [1.5, 1.2],
            clutter: 0.7,
        }
    }
}

impl Scenario {
    /// The index of a camera.
    pub fn camera_index(&self, id: &str) -> Option<usize> {
        self.cameras.iter().position(|camera| camera.id == id)
    }

    /// The index of an object.
    pub fn object_index(&self, id: &str) -> Option<usize> {
        self.objects.iter().position(|object| object.id == id)
    }

    /// The clock of a camera; none for an index beyond the cameras.
    pub fn clock(&self, camera: usize) -> Option<Clock> {
        let camera = self.cameras.get(camera)?;
        Some(Clock::new(camera.clock, self.start_ns))
    }
}

impl SceneCamera {
    /// Seconds from the capture time to the time of a row.
    pub fn row_after_s(&self, row: f64) -> f64 {
        (row - 0.5 * (f64::from(self.resolution[1]) - 1.0)) * self.line_delay_s
    }

    /// When it takes its images.
    pub fn schedule(&self) -> Schedule {
        Schedule::new(self.rate_hz, self.phase)
    }
}

impl SceneObject {
    /// The object's true pose at a true time in ns.
    pub fn world_from_object(&self, true_ns: u64) -> Pose {
        self.path.world_from_object(true_ns)
    }

    /// Its true twist: (v, w) in world axes, m/s and rad/s.
    pub fn twist(&self, true_ns: u64) -> Vector6<f64> {
        self.path.twist(true_ns)
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn is_one(value: &f64) -> bool {
    *value == 1.0
}

mod defaults {
    pub fn print_scale() -> f64 {
        1.0
    }

    pub fn rate_hz() -> f64 {
        30.0
    }

    pub fn exposure_ns() -> u64 {
        4_000_000
    }

    pub fn gain() -> f64 {
        1.0
    }

    pub fn blur_px() -> f64 {
        0.5
    }

    pub fn noise() -> f64 {
        2.0
    }
}
