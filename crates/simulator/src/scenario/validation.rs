//! Validation of scenarios. Every error names the field and its valid range.

use super::{
    AutoExposure, Background, Face, Flicker, Scenario, SceneCamera, SceneObject, SceneTag,
};
use crate::path::PathEvent;
use nalgebra::Point3;
use sextant_tag_families::Family;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// Why a scenario can't be simulated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// A number is out of its range (or not a number).
    #[error("{field} is {value}, but must be {allowed}")]
    OutOfRange {
        /// Which number, with the id of its camera or object.
        field: String,
        /// As it was given.
        value: String,
        /// What would be right.
        allowed: String,
    },
    /// A list has too few or too many entries.
    #[error("{field} has {count} entries, but must have {allowed}")]
    Count {
        /// Which list.
        field: String,
        /// How many entries it has.
        count: usize,
        /// What would be right.
        allowed: String,
    },
    /// An id is malformed.
    #[error("id \"{0}\" must be 1 to 32 characters of a-z, 0-9, - and _")]
    Id(String),
    /// Two cameras or two objects share an id.
    #[error("id \"{0}\" is used twice")]
    DuplicateId(String),
    /// A tag appears twice in the scenario.
    #[error("tag {1} of family {0} is used twice; every tag of a scenario must be unique")]
    DuplicateTag(Family, u32),
    /// A solid isn't convex, closed and seen from outside.
    #[error("solid {solid} of object \"{object}\": {cause}")]
    Solid {
        /// Which object.
        object: String,
        /// Position in its list of solids, from 0.
        solid: usize,
        /// What is wrong.
        cause: &'static str,
    },
    /// A tag doesn't lie on a face, or its white margin juts out over the face.
    #[error(
        "tag {id} of object \"{object}\" must lie on one face of a solid, white margin included, looking outwards"
    )]
    TagOffFace {
        /// Which object.
        object: String,
        /// Number of the tag.
        id: u32,
    },
    /// There is no camera with this index.
    #[error("there is no camera {0} in this scenario")]
    NoSuchCamera(usize),
}

const MAX_SOLIDS: usize = 8;
const MAX_OBJECTS: usize = 64;
const MAX_CAMERAS: usize = 64;
const MAX_TAGS: usize = 64;
const MAX_EVENTS: usize = 16;

impl Scenario {
    /// Checks everything that rendering relies on.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn validate(&self) -> Result<(), ScenarioError> {
        count("camera", self.cameras.len(), 1..=MAX_CAMERAS)?;
        count("object", self.objects.len(), 1..=MAX_OBJECTS)?;
        if i64::try_from(self.seed).is_err() {
            return Err(out_of_range("seed".into(), self.seed, "below 2^63"));
        }
        self.light.validate()?;
        self.background.validate()?;
        unique(self.cameras.iter().map(|camera| &camera.id))?;
        unique(self.objects.iter().map(|object| &object.id))?;
        self.cameras.iter().try_for_each(SceneCamera::validate)?;
        self.objects.iter().try_for_each(SceneObject::validate)?;
        self.unique_tags()
    }

    fn unique_tags(&self) -> Result<(), ScenarioError> {
        let mut seen = BTreeSet::new();
        let mut tags = self.objects.iter().flat_map(|object| &object.tags);
        match tags.find(|tag| !seen.insert((tag.family, tag.id))) {
            Some(tag) => Err(ScenarioError::DuplicateTag(tag.family, tag.id)),
            None => Ok(()),
        }
    }
}

impl super::Light {
    fn validate(&self) -> Result<(), ScenarioError> {
        let length = self.towards_lamp.iter().map(|x| x * x).sum::<f64>().sqrt();
        within("length of light.towards_lamp", length, 1e-3..=1e6)?;
        within("light.ambient", self.ambient, 0.0..=2.0)?;
        within("light.lamp", self.lamp, 0.0..=2.0)?;
        within("light.pool_radius", self.pool_radius, 0.1..=1000.0)?;
        self.flicker
            .validate(|name| format!("light.flicker.{name}"))?;
        within("light.shadow", self.shadow, 0.0..=1.0)
    }
}

impl Flicker {
    fn validate(&self, field: impl Fn(&str) -> String) -> Result<(), ScenarioError> {
        within(&field("amplitude"), self.amplitude, 0.0..=0.9)?;
        within(&field("rate_hz"), self.rate_hz, 0.0..=1000.0)
    }
}

impl Background {
    fn validate(&self) -> Result<(), ScenarioError> {
        match self {
            Self::Plain { level } => within("background.level", *level, 0.0..=255.0),
            Self::Room { table, clutter } => {
                within("background.table", table[0], 0.2..=4.0)?;
                within("background.table", table[1], 0.2..=4.0)?;
                within("background.clutter", *clutter, 0.0..=1.0)
            }
        }
    }
}

impl SceneCamera {
    fn validate(&self) -> Result<(), ScenarioError> {
        let field = |name: &str| format!("{name} of camera \"{}\"", self.id);
        let check = |name: &str, value: f64, allowed| within(&field(name), value, allowed);
        check("width", f64::from(self.resolution[0]), 16.0..=4096.0)?;
        check("height", f64::from(self.resolution[1]), 16.0..=3072.0)?;
        let position = self.world_from_camera.translation.vector;
        position
            .iter()
            .try_for_each(|&p| check("position", p, -1e4..=1e4))?;
        check("rate_hz", self.rate_hz, 0.1..=1000.0)?;
        check("phase", self.phase, 0.0..=1.0)?;
        check(
            "exposure_ns",
            self.exposure_ns as f64,
            0.0..=1e9 / self.rate_hz,
        )?;
        let longest = 0.1 / f64::from(self.resolution[1]);
        check("line_delay_s", self.line_delay_s, -longest..=longest)?;
        check("gain", self.gain, 0.05..=20.0)?;
        self.flicker
            .validate(|name| field(&format!("flicker.{name}")))?;
        check("vignetting", self.vignetting, 0.0..=0.9)?;
        check("blur_px", self.blur_px, 0.0..=5.0)?;
        check("defocus_px", self.defocus_px, 0.0..=8.0)?;
        check("noise", self.noise, 0.0..=50.0)?;
        check("shot_noise", self.shot_noise, 0.0..=50.0)?;
        let quality = f64::from(self.jpeg_quality.unwrap_or(100));
        check("jpeg_quality", quality, 1.0..=100.0)?;
        self.validate_lens_residual()?;
        self.validate_file_error()?;
        if let Some(auto) = &self.auto_exposure {
            self.validate_auto_exposure(auto)?;
        }
        check("clock.drift_ppm", self.clock.drift_ppm, -1000.0..=1000.0)?;
        check("network.loss", self.network.loss, 0.0..=1.0)?;
        check("network.reorder", self.network.reorder, 0.0..=1.0)?;
        check("network.duplicate", self.network.duplicate, 0.0..=1.0)?;
        check("network.delay_ms", self.network.delay_ms, 0.0..=1e6)?;
        check("network.jitter_ms", self.network.jitter_ms, 0.0..=1e6)?;
        check("network.reorder_ms", self.network.reorder_ms, 0.0..=1e6)?;
        let [from_s, until_s] = self.network.partition_s;
        check("network.partition_s", from_s, 0.0..=1e9)?;
        check("network.partition_s", until_s, from_s..=1e9)
    }

    fn check(
        &self,
        name: &str,
        value: f64,
        allowed: RangeInclusive<f64>,
    ) -> Result<(), ScenarioError> {
        let field = format!("{name} of camera \"{}\"", self.id);
        within(&field, value, allowed)
    }

    fn validate_lens_residual(&self) -> Result<(), ScenarioError> {
        let residual = &self.lens_residual;
        self.check("lens_residual.radial_px", residual.radial_px, -3.0..=3.0)?;
        let mut prism = residual.prism_px.into_iter();
        prism.try_for_each(|px| self.check("lens_residual.prism_px", px, -5.0..=5.0))
    }

    fn validate_file_error(&self) -> Result<(), ScenarioError> {
        let error = &self.file_error;
        for metres in error.position {
            self.check("file_error.position", metres, -1.0..=1.0)?;
        }
        for radians in error.rotation {
            self.check("file_error.rotation", radians, -0.5..=0.5)?;
        }
        self.check("file_error.focal", error.focal, -0.1..=0.1)
    }

    fn validate_auto_exposure(&self, auto: &AutoExposure) -> Result<(), ScenarioError> {
        self.check("auto_exposure.target", auto.target, 5.0..=250.0)?;
        let longest_ns = auto.max_exposure_ns as f64;
        let allowed = 1.0..=1e9 / self.rate_hz;
        self.check("auto_exposure.max_exposure_ns", longest_ns, allowed)?;
        self.check("auto_exposure.max_gain", auto.max_gain, 1.0..=64.0)?;
        self.check("auto_exposure.lag_s", auto.lag_s, 0.0..=10.0)
    }
}

impl SceneObject {
    fn validate(&self) -> Result<(), ScenarioError> {
        let field = |name: &str| format!("{name} of object \"{}\"", self.id);
        count(&field("solid"), self.solids.len(), 1..=MAX_SOLIDS)?;
        count(&field("tag"), self.tags.len(), 0..=MAX_TAGS)?;
        within(&field("path.period_s"), self.path.period_s, 1e-3..=1e6)?;
        let mut numbers = self.path.numbers();
        numbers.try_for_each(|number| within(&field("path"), number, -1e4..=1e4))?;
        for joint in &self.path.joints {
            let length = nalgebra::Vector3::from(joint.axis).norm();
            within(&field("path.joint.axis's length"), length, 0.999..=1.001)?;
        }
        self.validate_events()?;
        for (index, solid) in self.solids.iter().enumerate() {
            within(&field("albedo"), solid.albedo(), 0.0..=1.0)?;
            solid.validate().map_err(|cause| ScenarioError::Solid {
                object: self.id.clone(),
                solid: index,
                cause,
            })?;
        }
        self.tags.iter().try_for_each(|tag| self.validate_tag(tag))
    }

    fn validate_events(&self) -> Result<(), ScenarioError> {
        let field = |name: &str| format!("path.event{name} of object \"{}\"", self.id);
        count(&field(""), self.path.events.len(), 0..=MAX_EVENTS)?;
        for event in &self.path.events {
            let [at_s, duration_s] = event.times_s();
            let period_s = self.path.period_s;
            within(&field(".duration_s"), duration_s, 1e-3..=period_s)?;
            within(&field(".at_s"), at_s, 0.0..=period_s - duration_s)?;
            if let PathEvent::Throw { axis, .. } = event {
                let length = nalgebra::Vector3::from(*axis).norm();
                within(&field(".axis's length"), length, 0.999..=1.001)?;
            }
        }
        Ok(())
    }

    fn validate_tag(&self, tag: &SceneTag) -> Result<(), ScenarioError> {
        let field = |name: &str| format!("{name} of tag {} of object \"{}\"", tag.id, self.id);
        within(&field("size"), tag.size, 1e-3..=10.0)?;
        let n_codes = tag.family.data().codes.len();
        within(&field("print_scale"), tag.print_scale, 0.9..=1.1)?;
        for metres in tag.glue_error.position {
            within(&field("glue_error.position"), metres, -0.02..=0.02)?;
        }
        for radians in tag.glue_error.rotation {
            within(&field("glue_error.rotation"), radians, -0.3..=0.3)?;
        }
        let most = tag.printed_size() / 8.0;
        within(&field("curl.sagitta"), tag.curl.sagitta, -most..=most)?;
        within(&field("curl.direction"), tag.curl.direction, -10.0..=10.0)?;
        within(&field("id"), f64::from(tag.id), 0.0..=n_codes as f64 - 1.0)?;
        match self.face_of(tag) {
            Some(_) => Ok(()),
            None => Err(ScenarioError::TagOffFace {
                object: self.id.clone(),
                id: tag.id,
            }),
        }
    }

    /// Solid and face on which a tag lies, white margin included.
    pub(crate) fn face_of(&self, tag: &SceneTag) -> Option<(usize, usize)> {
        let corners = tag.printed_corners();
        let out_of_tag = tag.object_from_tag.rotation * nalgebra::Vector3::z();
        self.solids.iter().enumerate().find_map(|(index, solid)| {
            let (vertices, faces) = (solid.vertices(), solid.faces());
            let carries = |face: &Face| {
                face.normal.dot(&out_of_tag) > 0.999_999
                    && corners.iter().all(|c| face.holds(&vertices, c))
            };
            Some((index, faces.iter().position(carries)?))
        })
    }
}

impl SceneTag {
    /// Edge of the whole print with its white margin as it was printed, m.
    pub fn printed_size(&self) -> f64 {
        self.true_size() * self.sheet_by_size()
    }

    fn sheet_by_size(&self) -> f64 {
        let data = self.family.data();
        f64::from(data.total_width) / f64::from(data.border_width)
    }

    /// Corners of the print with its white margin as its file has it, in the object's frame.
    fn printed_corners(&self) -> [Point3<f64>; 4] {
        let half = self.size * self.sheet_by_size() / 2.0;
        let corner = |x: f64, y: f64| self.object_from_tag * Point3::new(x * half, y * half, 0.0);
        [
            corner(-1.0, 1.0),
            corner(1.0, 1.0),
            corner(1.0, -1.0),
            corner(-1.0, -1.0),
        ]
    }
}

fn out_of_range(field: String, value: impl ToString, allowed: &str) -> ScenarioError {
    ScenarioError::OutOfRange {
        field,
        value: value.to_string(),
        allowed: allowed.into(),
    }
}

/// Refuses NaN as well.
fn within(field: &str, value: f64, allowed: RangeInclusive<f64>) -> Result<(), ScenarioError> {
    if allowed.contains(&value) {
        return Ok(());
    }
    let allowed = format!("from {} to {}", allowed.start(), allowed.end());
    Err(out_of_range(field.into(), value, &allowed))
}

fn count(field: &str, count: usize, allowed: RangeInclusive<usize>) -> Result<(), ScenarioError> {
    if allowed.contains(&count) {
        return Ok(());
    }
    Err(ScenarioError::Count {
        field: field.into(),
        count,
        allowed: format!("{} to {}", allowed.start(), allowed.end()),
    })
}

fn unique<'a>(ids: impl Iterator<Item = &'a String>) -> Result<(), ScenarioError> {
    let mut seen = BTreeSet::new();
    for id in ids {
        let allowed =
            |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
        if id.is_empty() || id.len() > 32 || !id.chars().all(allowed) {
            return Err(ScenarioError::Id(id.clone()));
        }
        if !seen.insert(id) {
            return Err(ScenarioError::DuplicateId(id.clone()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(break_it: impl FnOnce(&mut Scenario)) -> ScenarioError {
        let mut scenario = Scenario::demo(2, 2, 1);
        scenario.validate().expect("the demo is possible");
        break_it(&mut scenario);
        scenario.validate().expect_err("it must be refused")
    }

    #[test]
    fn a_tag_used_twice_is_refused() {
        let error = refusal(|s| s.objects[1].tags[0].id = s.objects[0].tags[0].id);
        assert!(matches!(
            error,
            ScenarioError::DuplicateTag(Family::Tag36h11, _)
        ));
    }

    #[test]
    fn numbers_out_of_range_are_refused_with_their_name() {
        let error = refusal(|s| s.cameras[1].rate_hz = f64::NAN);
        assert_eq!(
            error.to_string(),
            "rate_hz of camera \"south\" is NaN, but must be from 0.1 to 1000"
        );
        let error = refusal(|s| s.cameras[1].network.partition_s = [3.0, 2.0]);
        assert!(
            error.to_string().contains("network.partition_s of camera"),
            "{error}"
        );
        let error = refusal(|s| s.cameras[0].exposure_ns = 1_000_000_000);
        assert!(
            error
                .to_string()
                .contains("exposure_ns of camera \"north\"")
        );
        let error = refusal(|s| s.objects[0].tags[0].size = -0.04);
        assert!(error.to_string().contains("size of tag"));
        let error = refusal(|s| s.objects[0].path.position[1].mean = f64::INFINITY);
        assert!(error.to_string().contains("path of object"));
    }

    #[test]
    fn faults_out_of_range_are_refused_with_their_name() {
        type Break = fn(&mut Scenario);
        let cases: [(Break, &str); 9] = [
            (
                |s| s.cameras[0].lens_residual.prism_px[1] = 9.0,
                "lens_residual.prism_px of camera \"north\" is 9, but must be from -5 to 5",
            ),
            (
                |s| s.cameras[0].file_error.focal = 1.0,
                "file_error.focal of camera \"north\"",
            ),
            (
                |s| s.cameras[0].jpeg_quality = Some(0),
                "jpeg_quality of camera \"north\" is 0, but must be from 1 to 100",
            ),
            (
                |s| s.cameras[0].defocus_px = 80.0,
                "defocus_px of camera \"north\"",
            ),
            (
                |s| {
                    s.cameras[0].auto_exposure = Some(AutoExposure {
                        target: 100.0,
                        max_exposure_ns: 40_000_000,
                        max_gain: 2.0,
                        lag_s: 0.0,
                    });
                },
                "auto_exposure.max_exposure_ns of camera \"north\"",
            ),
            (
                |s| s.light.flicker.amplitude = 2.0,
                "light.flicker.amplitude is 2",
            ),
            (
                |s| s.objects[0].tags[0].print_scale = 2.0,
                "print_scale of tag 0 of object \"cuboid\"",
            ),
            (
                |s| s.objects[0].tags[0].curl.sagitta = 0.02,
                "curl.sagitta of tag 0 of object \"cuboid\"",
            ),
            (
                |s| {
                    s.objects[0].path.events = vec![PathEvent::Throw {
                        at_s: s.objects[0].path.period_s,
                        duration_s: 0.5,
                        turns: 1,
                        axis: [0.0, 0.0, 1.0],
                    }];
                },
                "path.event.at_s of object \"cuboid\"",
            ),
        ];
        for (break_it, expected) in cases {
            let error = refusal(break_it).to_string();
            assert!(error.starts_with(expected), "{error}");
        }
    }

    #[test]
    fn a_tag_in_the_air_or_jutting_out_is_refused() {
        let off = |s: &mut Scenario| s.objects[0].tags[0].object_from_tag.translation.z += 0.01;
        assert!(matches!(refusal(off), ScenarioError::TagOffFace { .. }));
        let too_large = |s: &mut Scenario| s.objects[0].tags[0].size *= 3.0;
        assert!(matches!(
            refusal(too_large),
            ScenarioError::TagOffFace { .. }
        ));
    }

    #[test]
    fn ids_are_checked() {
        assert_eq!(
            refusal(|s| s.cameras[0].id = "North!".into()),
            ScenarioError::Id("North!".into())
        );
        assert!(matches!(
            refusal(|s| s.objects[1].id = s.objects[0].id.clone()),
            ScenarioError::DuplicateId(_)
        ));
        assert!(matches!(
            refusal(|s| s.cameras.clear()),
            ScenarioError::Count { .. }
        ));
    }
}
