//! Faults of tags, lenses and files, as plain data: each is off by default.
//!
//! A scenario's `size` and `object_from_tag` are what the object file says; [`SceneTag::true_size`] and
//! [`SceneTag::sheet_point`] add what printer, glue and paper did to it. A camera's `lens` and `world_from_camera` are
//! the truth; the rig file has them with [`CameraFileError`]. Metres, radians, pixels.

use super::{SceneCamera, SceneTag};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use sextant_geometry::{Intrinsics, Lens, LensError, Pose};

/// A small rigid motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Displacement {
    /// Translation in x, y, z, m.
    pub position: [f64; 3],
    /// Rotation vector, rad.
    pub rotation: [f64; 3],
}

/// Paper that is bent about an axis in its plane: a piece of a cylinder that touches the face where it is lowest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Curl {
    /// Height of the sheet's middle above its two bent edges, m; negative where the edges are lifted. At most an eighth
    /// of the sheet's edge; 0.5 to 2 mm is what glued paper does.
    pub sagitta: f64,
    /// Direction in the sheet that is bent, from the tag's x axis towards y, rad.
    pub direction: f64,
}

/// What a lens does beyond its model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LensResidual {
    /// Amplitude of a radial wave, px: outwards by `radial_px * sin(2 TAU r)`, r being the distance from the image's
    /// middle by that of its corners. -3 to 3.
    pub radial_px: f64,
    /// Thin prism: displacement `prism_px * r^2` in x and y, px. -5 to 5.
    pub prism_px: [f64; 2],
}

/// A camera that sets exposure and gain by the mean level of its images: first the exposure, beyond its limit the gain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AutoExposure {
    /// Mean grey level of the background that it aims at; 5 to 250.
    pub target: f64,
    /// Longest exposure, ns; below the period.
    pub max_exposure_ns: u64,
    /// Largest gain, which multiplies light and noise alike; 1 to 64.
    pub max_gain: f64,
    /// How far it lags behind light that changes, s; 0 to 10.
    #[serde(default)]
    pub lag_s: f64,
}

/// How colours reach a grey image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mosaic {
    /// A monochrome sensor.
    #[default]
    None,
    /// A Bayer mosaic (RGGB) whose red and blue pixels get less light, white balanced and interpolated bilinearly.
    Bayer,
}

/// How a camera's entry in the rig file differs from the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraFileError {
    /// Of the camera's place in world axes, m; -1 to 1 each.
    pub position: [f64; 3],
    /// Of its attitude: rotation vector in world axes, rad; -0.5 to 0.5 each.
    pub rotation: [f64; 3],
    /// Of fx and fy, relative; -0.1 to 0.1.
    pub focal: f64,
}

impl Displacement {
    /// The displacement as a rigid motion.
    pub fn motion(&self) -> Pose {
        Isometry3::from_parts(
            Translation3::from(Vector3::from(self.position)),
            turn(self.rotation),
        )
    }
}

impl CameraFileError {
    /// The pose that the file has.
    pub fn pose(&self, world_from_camera: &Pose) -> Pose {
        let place = world_from_camera.translation.vector + Vector3::from(self.position);
        Isometry3::from_parts(
            place.into(),
            turn(self.rotation) * world_from_camera.rotation,
        )
    }

    /// The lens that the file has.
    ///
    /// # Errors
    /// Where such a lens is none.
    pub fn lens(&self, lens: &Lens) -> Result<Lens, LensError> {
        let true_intrinsics = lens.intrinsics();
        let mut parameters = lens.parameters();
        let Intrinsics { fx, fy, .. } = true_intrinsics;
        for (parameter, focal) in parameters.iter_mut().zip([fx, fy]) {
            *parameter = focal * (1.0 + self.focal);
        }
        lens.with_parameters(&parameters)
    }
}

impl Curl {
    /// A point of the flat sheet (m from its middle) on the bent one of this edge; paper keeps its lengths.
    pub fn bend(&self, [x, y]: [f64; 2], sheet_edge: f64) -> Point3<f64> {
        if self.sagitta == 0.0 {
            return Point3::new(x, y, 0.0);
        }
        let (cos, sin) = (libm::cos(self.direction), libm::sin(self.direction));
        let along = x * cos + y * sin;
        let half = self.half_width(sheet_edge);
        let half_angle = half_angle(self.sagitta.abs() / half);
        let radius = half / half_angle;
        let angle = along / radius;
        let moved = radius * libm::sin(angle) - along;
        let fallen = radius * (1.0 - libm::cos(angle));
        let z = if self.sagitta > 0.0 {
            self.sagitta - fallen
        } else {
            fallen
        };
        Point3::new(x + moved * cos, y + moved * sin, z)
    }

    /// Half of the sheet's extent in the bent direction, m.
    pub(crate) fn half_width(&self, sheet_edge: f64) -> f64 {
        let (cos, sin) = (libm::cos(self.direction), libm::sin(self.direction));
        0.5 * sheet_edge * (cos.abs() + sin.abs())
    }
}

/// Half the angle of an arc with this ratio of sagitta to half its length: (1 - cos a) / a, by Newton's method.
fn half_angle(ratio: f64) -> f64 {
    let mut angle = 2.0 * ratio;
    for _ in 0..8 {
        let value = 1.0 - libm::cos(angle) - ratio * angle;
        angle -= value / (libm::sin(angle) - ratio);
    }
    angle
}

fn turn(rotation: [f64; 3]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::from(rotation))
}

impl SceneTag {
    /// A tag that agrees with its file.
    pub fn new(
        family: sextant_tag_families::Family,
        id: u32,
        size: f64,
        object_from_tag: Pose,
    ) -> Self {
        Self {
            family,
            id,
            size,
            object_from_tag,
            print_scale: 1.0,
            glue_error: Displacement::default(),
            curl: Curl::default(),
        }
    }

    /// Edge of the square as printed, m.
    pub fn true_size(&self) -> f64 {
        self.size * self.print_scale
    }

    /// Where the tag was glued on.
    pub fn true_object_from_tag(&self) -> Pose {
        if self.glue_error == Displacement::default() {
            return self.object_from_tag;
        }
        self.object_from_tag * self.glue_error.motion()
    }

    /// A point of the printed sheet (m from its middle, x right, y up) in the object's frame, paper bent as it is.
    pub fn sheet_point(&self, at: [f64; 2]) -> Point3<f64> {
        self.true_object_from_tag() * self.curl.bend(at, self.printed_size())
    }

    /// The corners of its black square in the object's frame: top left, top right, bottom right, bottom left.
    pub fn corners_in_object(&self) -> [Point3<f64>; 4] {
        sextant_geometry::tag_corners_in_tag(self.true_size())
            .map(|corner| self.sheet_point([corner.x, corner.y]))
    }
}

impl SceneCamera {
    /// A faultless camera: 30 images a second, 4 ms of exposure, a blur of half a pixel, noise of two grey levels.
    pub fn new(
        id: impl Into<String>,
        resolution: [u32; 2],
        lens: Lens,
        world_from_camera: Pose,
    ) -> Self {
        Self {
            id: id.into(),
            resolution,
            lens,
            world_from_camera,
            lens_residual: LensResidual::default(),
            file_error: CameraFileError::default(),
            rate_hz: super::defaults::rate_hz(),
            phase: 0.0,
            exposure_ns: super::defaults::exposure_ns(),
            line_delay_s: 0.0,
            auto_exposure: None,
            gain: super::defaults::gain(),
            flicker: super::Flicker::default(),
            vignetting: 0.0,
            blur_px: super::defaults::blur_px(),
            defocus_px: 0.0,
            noise: super::defaults::noise(),
            shot_noise: 0.0,
            mosaic: Mosaic::None,
            jpeg_quality: None,
            clock: Default::default(),
            network: Default::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bent_paper_has_the_sagitta_and_keeps_its_lengths() {
        let edge = 0.05;
        for sagitta in [0.002, -0.001] {
            for direction in [0.0, 0.6] {
                let curl = Curl { sagitta, direction };
                let half = curl.half_width(edge);
                let at =
                    |u: f64| curl.bend([u * libm::cos(direction), u * libm::sin(direction)], edge);
                let (middle, end) = (at(0.0).z, at(half).z);
                assert!((middle - end - sagitta).abs() < 1e-12);
                assert!(middle.min(end).abs() < 1e-12, "the lowest line touches");
                let steps = 1000;
                let length: f64 = (0..steps)
                    .map(|i| {
                        let u = |i: i32| half * f64::from(i) / f64::from(steps);
                        (at(u(i + 1)) - at(u(i))).norm()
                    })
                    .sum();
                assert!((length - half).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_file_error_acts_in_world_axes() {
        let error = CameraFileError {
            position: [0.003, 0.0, 0.0],
            rotation: [0.0, 0.0, 0.01],
            focal: 0.004,
        };
        let pose = Pose::translation(1.0, 2.0, 3.0) * Pose::rotation(Vector3::x());
        let written = error.pose(&pose);
        let moved = written.translation.vector - pose.translation.vector;
        assert!((moved - Vector3::new(0.003, 0.0, 0.0)).norm() < 1e-15);
        let turned = (written.rotation * pose.rotation.inverse()).scaled_axis();
        assert!((turned - Vector3::new(0.0, 0.0, 0.01)).norm() < 1e-12);
        let lens = crate::Scenario::demo(1, 1, 1).cameras[0].lens;
        let written = error.lens(&lens).unwrap();
        let ratio = written.intrinsics().fy / lens.intrinsics().fy;
        assert!((ratio - 1.004).abs() < 1e-12);
        assert_eq!(written.distortion(), lens.distortion());
    }
}
