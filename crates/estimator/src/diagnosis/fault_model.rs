//! Kinds of faults: which errors of the site each of them enlarges, by how much, and when it is worth naming.

pub(crate) mod camera;
pub(crate) mod clock;
pub(crate) mod lens;
pub(crate) mod tag_pose;
pub(crate) mod tag_size;

use std::ops::Range;

use nalgebra::DVector;

use crate::DiagnosisOptions;
use crate::diagnosis::window::WindowEquations;
use camera::CameraPoseFault;
use clock::ClockFault;
use lens::LensFault;
use sextant_site_model::TagId;
use tag_pose::TagPoseFault;
use tag_size::TagSizeFault;

/// A kind of fault of one camera or tag.
pub(crate) trait FaultModel {
    /// The places among the site's errors that each of its parameters moves; `None` where no keyframe shows it.
    fn moved(&self, equations: &WindowEquations) -> Option<Vec<Vec<usize>>>;

    /// Prior standard deviation of each parameter.
    fn prior(&self) -> &'static [f64];

    /// Share of what six parameters explain that it may leave unexplained to be preferred to them.
    fn unexplained(&self) -> f64 {
        0.03
    }

    /// Share of what a named fault usually explains of the contradiction that this one must explain.
    fn explains(&self) -> f64 {
        1.0
    }

    /// Whether a fault of such parameters is large enough to be named.
    fn is_worth_naming(
        &self,
        parameters: &DVector<f64>,
        equations: &WindowEquations,
        options: &DiagnosisOptions,
    ) -> bool;
}

/// A fault that may explain what images contradict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum FaultHypothesis {
    Clock(ClockFault),
    Camera(CameraPoseFault),
    Lens(LensFault),
    TagSize(TagSizeFault),
    TagPose(TagPoseFault),
}

impl FaultHypothesis {
    /// The kinds of faults of a camera, that with one parameter first.
    pub fn camera_kinds(camera: usize) -> [Self; 2] {
        [
            Self::Clock(ClockFault { camera }),
            Self::Camera(CameraPoseFault { camera }),
        ]
    }

    /// The kinds of faults of a tag, that with one parameter first.
    pub fn tag_kinds(tag: TagId) -> [Self; 2] {
        [
            Self::TagSize(TagSizeFault { tag }),
            Self::TagPose(TagPoseFault { tag }),
        ]
    }

    pub fn model(&self) -> &dyn FaultModel {
        match self {
            Self::Clock(model) => model,
            Self::Camera(model) => model,
            Self::Lens(model) => model,
            Self::TagSize(model) => model,
            Self::TagPose(model) => model,
        }
    }

    /// The camera whose pose or clock is faulty, if that is the fault.
    pub fn camera(&self) -> Option<usize> {
        match self {
            Self::Clock(ClockFault { camera }) | Self::Camera(CameraPoseFault { camera }) => {
                Some(*camera)
            }
            _ => None,
        }
    }

    /// The camera that is moved, if that is the fault.
    pub fn moved_camera(&self) -> Option<usize> {
        match self {
            Self::Camera(model) => Some(model.camera),
            _ => None,
        }
    }
}

/// Consecutive places, each moved by a parameter of its own.
fn each(places: Range<usize>) -> Vec<Vec<usize>> {
    places.map(|place| vec![place]).collect()
}

/// First place of a tag's errors.
fn first_of_tag(tag: &TagId, equations: &WindowEquations) -> Option<usize> {
    Some(equations.layout.tags.get(tag)?.1)
}
