//! Priors of kept parameters: values with standard deviations.

use crate::parameter::KeptParameter;
use nalgebra::Vector6;
use sextant_geometry::Pose;
use sextant_site_model::PoseSigma;

/// A prior of a kept parameter; without effect where the parameter is not sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// Where a camera is.
    Camera {
        /// Index into [`Bundle::cameras`](crate::Bundle::cameras).
        camera: usize,
        /// Maps points of the camera into the world.
        world_from_camera: Pose,
        /// One deviation an axis.
        sigma: PoseSigma,
    },
    /// Where a tag is.
    Tag {
        /// Index into [`Bundle::tags`](crate::Bundle::tags).
        tag: usize,
        /// Maps points of the tag into the object.
        object_from_tag: Pose,
        /// One deviation an axis.
        sigma: PoseSigma,
        /// Factor on those across the plane of the object's x and y: along its z, and of the turns about x and y. 1
        /// unless it bends.
        across: f64,
    },
    /// How large a tag is.
    Size {
        /// Index into [`Bundle::tags`](crate::Bundle::tags).
        tag: usize,
        /// Metres.
        size_m: f64,
        /// One deviation, as a part of the size.
        sigma: f64,
    },
    /// A lens parameter.
    Lens {
        /// Index into [`Bundle::cameras`](crate::Bundle::cameras).
        camera: usize,
        /// Index into `Lens::parameters`.
        parameter: usize,
        /// In the parameter's unit.
        value: f64,
        /// One deviation, in the same unit.
        sigma: f64,
    },
    /// A common scale of tags: that they are as large as given.
    Scale {
        /// Index into [`Bundle::scales`](crate::Bundle::scales).
        scale: usize,
        /// One deviation of its logarithm.
        sigma: f64,
    },
    /// The offset of a camera's clock.
    Clock {
        /// Index into [`Bundle::cameras`](crate::Bundle::cameras).
        camera: usize,
        /// By how much it is ahead, seconds.
        offset_s: f64,
        /// One deviation, seconds.
        sigma: f64,
    },
    /// The line delay of a camera.
    LineDelay {
        /// Index into [`Bundle::cameras`](crate::Bundle::cameras).
        camera: usize,
        /// Seconds from a row to the next.
        line_delay_s: f64,
        /// One deviation, seconds.
        sigma: f64,
    },
}

fn pose_sigmas(sigma: PoseSigma, across: f64) -> Vector6<f64> {
    let (position, orientation) = (sigma.position_m, sigma.orientation_rad);
    let bent = orientation * across;
    Vector6::new(
        position,
        position,
        position * across,
        bent,
        bent,
        orientation,
    )
}

impl Anchor {
    /// Standard deviation of each element; a scalar's is repeated six times.
    pub fn sigmas(&self) -> Vector6<f64> {
        match *self {
            Self::Camera { sigma, .. } => pose_sigmas(sigma, 1.0),
            Self::Tag { sigma, across, .. } => pose_sigmas(sigma, across),
            Self::Size { sigma, .. }
            | Self::Lens { sigma, .. }
            | Self::Scale { sigma, .. }
            | Self::Clock { sigma, .. }
            | Self::LineDelay { sigma, .. } => Vector6::repeat(sigma),
        }
    }

    /// The anchor with scaled deviations: that of the position or scalar, and that of the orientation.
    #[must_use]
    pub fn scaled(mut self, first: f64, orientation: f64) -> Self {
        match &mut self {
            Self::Camera { sigma, .. } | Self::Tag { sigma, .. } => {
                sigma.position_m *= first;
                sigma.orientation_rad *= orientation;
            }
            Self::Size { sigma, .. }
            | Self::Lens { sigma, .. }
            | Self::Scale { sigma, .. }
            | Self::Clock { sigma, .. }
            | Self::LineDelay { sigma, .. } => *sigma *= first,
        }
        self
    }

    /// Its parameters, in the order of its errors.
    pub fn parameters(&self) -> Vec<KeptParameter> {
        let axes = || 0..3;
        match *self {
            Self::Camera { camera, .. } => {
                let position = axes().map(|axis| KeptParameter::CameraPosition { camera, axis });
                let rotation = axes().map(|axis| KeptParameter::CameraRotation { camera, axis });
                position.chain(rotation).collect()
            }
            Self::Tag { tag, .. } => {
                let position = axes().map(|axis| KeptParameter::TagPosition { tag, axis });
                let rotation = axes().map(|axis| KeptParameter::TagRotation { tag, axis });
                position.chain(rotation).collect()
            }
            Self::Size { tag, .. } => vec![KeptParameter::TagSize { tag }],
            Self::Lens {
                camera, parameter, ..
            } => vec![KeptParameter::Lens { camera, parameter }],
            Self::Scale { scale, .. } => vec![KeptParameter::Scale { scale }],
            Self::Clock { camera, .. } => vec![KeptParameter::Clock { camera }],
            Self::LineDelay { camera, .. } => vec![KeptParameter::LineDelay { camera }],
        }
    }
}
