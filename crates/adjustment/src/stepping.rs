//! Values after a step of the kept parameters.

use crate::layout::{CameraColumns, Layout, stepped_pose};
use crate::values::{Bundle, BundleCamera, BundleTag, ObjectScale};

impl BundleCamera {
    /// The camera after its step; `None` if that makes no valid lens.
    pub(crate) fn stepped(&self, columns: &CameraColumns, kept: &[f64]) -> Option<Self> {
        let mut parameters = self.lens.parameters();
        for (at, &parameter) in columns.lens_parameters.iter().enumerate() {
            parameters[parameter] += kept[columns.lens + at];
        }
        let lens = match columns.lens_parameters.is_empty() {
            true => self.lens,
            false => self.lens.with_parameters(&parameters).ok()?,
        };
        let step = |column: Option<usize>| column.map_or(0.0, |at| kept[at]);
        Some(Self {
            lens,
            world_from_camera: stepped_pose(&self.world_from_camera, columns.pose, kept),
            clock_offset_s: self.clock_offset_s + step(columns.clock),
            line_delay_s: self.line_delay_s + step(columns.line_delay),
            ..self.clone()
        })
    }
}

/// Most by which the logarithm of a size or scale changes in one step.
const MOST_LOG_STEP: f64 = 1.0;

impl Bundle {
    /// Values of the kept parameters after their step; `None` if a lens would not be valid. Instants and images stay.
    pub(crate) fn stepped_site(&self, layout: &Layout, kept: &[f64]) -> Option<Self> {
        let log_step = |column: Option<usize>| {
            column.map_or(0.0, |at| kept[at].clamp(-MOST_LOG_STEP, MOST_LOG_STEP))
        };
        let cameras = self.cameras.iter().zip(&layout.cameras);
        let cameras = cameras.map(|(camera, columns)| camera.stepped(columns, kept));
        let tags = self.tags.iter().zip(&layout.tags);
        let tags = tags.map(|(tag, columns)| BundleTag {
            object_from_tag: stepped_pose(&tag.object_from_tag, columns.pose, kept),
            size_m: tag.size_m * log_step(columns.size).exp(),
            ..tag.clone()
        });
        let scales = self.scales.iter().zip(&layout.scales);
        let scales = scales.map(|(scale, column)| ObjectScale {
            log_factor: scale.log_factor + log_step(*column),
            ..*scale
        });
        Some(Self {
            cameras: cameras.collect::<Option<_>>()?,
            tags: tags.collect(),
            scales: scales.collect(),
            arm: self.arm.as_ref().map(|arm| arm.stepped(layout, kept)),
            ..Self::default()
        })
    }
}
