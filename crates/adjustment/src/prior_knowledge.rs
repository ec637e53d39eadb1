//! Standard deviations of the kept parameters before any image.

use crate::parameter::KeptParameter;
use crate::values::Bundle;

/// Prior standard deviations: the units in which directions are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorKnowledge {
    /// The position of a camera or of a robot, metres. Default 3.
    pub camera_position_m: f64,
    /// An attitude, radians. Default 1.
    pub rotation: f64,
    /// A focal length or principal point, relative to the focal length. Default 0.3.
    pub lens: f64,
    /// A distortion coefficient. Default 1.
    pub distortion: f64,
    /// A clock or a robot's delay, seconds. Default 1.
    pub clock_s: f64,
    /// A line delay, seconds. Default 1e-3.
    pub line_delay_s: f64,
    /// A tag's position on the object, metres. Default 0.5.
    pub tag_position_m: f64,
    /// A tag's size, relative. Default 0.3.
    pub tag_size: f64,
    /// A direction whose standard deviation exceeds this share of the prior is weak. Default 0.05: 15 cm or 3 degrees
    /// of a camera.
    pub weak_part: f64,
}

impl Default for PriorKnowledge {
    fn default() -> Self {
        Self {
            camera_position_m: 3.0,
            rotation: 1.0,
            lens: 0.3,
            distortion: 1.0,
            clock_s: 1.0,
            line_delay_s: 1e-3,
            tag_position_m: 0.5,
            tag_size: 0.3,
            weak_part: 0.05,
        }
    }
}

impl PriorKnowledge {
    pub(crate) fn sigma(&self, bundle: &Bundle, parameter: &KeptParameter) -> f64 {
        match *parameter {
            KeptParameter::CameraPosition { .. } | KeptParameter::ArmPosition { .. } => {
                self.camera_position_m
            }
            KeptParameter::CameraRotation { .. }
            | KeptParameter::TagRotation { .. }
            | KeptParameter::ArmRotation { .. } => self.rotation,
            KeptParameter::Lens { camera, parameter } if parameter < 4 => {
                self.lens * bundle.cameras[camera].lens.intrinsics().fx
            }
            KeptParameter::Lens { .. } => self.distortion,
            KeptParameter::Clock { .. } | KeptParameter::ArmDelay => self.clock_s,
            KeptParameter::LineDelay { .. } => self.line_delay_s,
            KeptParameter::TagPosition { .. } => self.tag_position_m,
            KeptParameter::TagSize { .. } | KeptParameter::Scale { .. } => self.tag_size,
        }
    }

    pub(crate) fn unit(&self, parameter: &KeptParameter) -> f64 {
        match *parameter {
            KeptParameter::CameraPosition { .. } | KeptParameter::ArmPosition { .. } => {
                self.camera_position_m
            }
            KeptParameter::CameraRotation { .. }
            | KeptParameter::TagRotation { .. }
            | KeptParameter::ArmRotation { .. } => self.rotation,
            // A focal length of 1000 pixels stands for all lenses: only the order of magnitude matters for comparing
            // directions.
            KeptParameter::Lens { parameter, .. } if parameter < 4 => self.lens * 1000.0,
            KeptParameter::Lens { .. } => self.distortion,
            KeptParameter::Clock { .. } | KeptParameter::ArmDelay => self.clock_s,
            KeptParameter::LineDelay { .. } => self.line_delay_s,
            KeptParameter::TagPosition { .. } => self.tag_position_m,
            KeptParameter::TagSize { .. } | KeptParameter::Scale { .. } => self.tag_size,
        }
    }
}
