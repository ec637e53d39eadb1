//! Columns of the kept parameters in the reduced system.

use crate::parameter::{ArmPose, KeptParameter};
use crate::values::{Bundle, Freedom};
use nalgebra::Vector6;
use sextant_geometry::lens::MAX_PARAMETERS;
use sextant_geometry::{Pose, se3};

/// Columns of one tag: six of the pose, one of the size (a step of its logarithm), if free, without gaps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TagColumns {
    /// First of the six columns of the pose.
    pub pose: Option<usize>,
    /// Column of the size.
    pub size: Option<usize>,
}

impl TagColumns {
    /// First column and number of columns; (0, 0) without any.
    pub(crate) fn span(&self) -> (usize, usize) {
        let start = self.pose.or(self.size).unwrap_or(0);
        let width = self.pose.map_or(0, |_| 6) + self.size.map_or(0, |_| 1);
        (start, width)
    }
}

/// Columns of one camera: six of the pose, one of the clock, one of the line delay, then those of the lens, if free,
/// without gaps.
#[derive(Clone, Debug, Default)]
pub(crate) struct CameraColumns {
    /// First of the six columns of the pose.
    pub pose: Option<usize>,
    /// Column of the clock.
    pub clock: Option<usize>,
    /// Column of the line delay.
    pub line_delay: Option<usize>,
    /// First of `lens_parameters.len()` columns, following the others.
    pub lens: usize,
    /// Free parameters, as indices into `Lens::parameters`.
    pub lens_parameters: Vec<usize>,
}

/// Kept columns of an arm: base and hand, and the delay.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ArmColumns {
    /// First of twelve columns.
    pub pose: Option<usize>,
    /// Column of the delay, after them.
    pub delay: Option<usize>,
}

impl ArmColumns {
    /// All of them, ascending.
    pub(crate) fn all(&self) -> impl Iterator<Item = usize> {
        let pose = self.pose.map_or(0..0, |at| at..at + 12);
        pose.chain(self.delay)
    }
}

/// Columns of every block.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    pub cameras: Vec<CameraColumns>,
    pub tags: Vec<TagColumns>,
    /// Column of each common scale, if it is free.
    pub scales: Vec<Option<usize>>,
    /// Those of the robot, the last ones.
    pub arm: ArmColumns,
    /// Total number of columns.
    pub n: usize,
}

impl CameraColumns {
    /// First column.
    pub(crate) fn start(&self) -> usize {
        self.pose
            .or(self.clock)
            .or(self.line_delay)
            .unwrap_or(self.lens)
    }

    /// Number of columns of pose, clock and line delay.
    pub(crate) fn moving(&self) -> usize {
        self.lens - self.start()
    }

    /// Total number of columns.
    pub(crate) fn width(&self) -> usize {
        self.moving() + self.lens_parameters.len()
    }

    /// Column of a lens parameter, if it is free.
    pub(crate) fn lens_column(&self, parameter: usize) -> Option<usize> {
        let at = self.lens_parameters.iter().position(|&p| p == parameter);
        at.map(|at| self.lens + at)
    }
}

impl Layout {
    pub(crate) fn new(bundle: &Bundle) -> Self {
        let mut layout = Self::default();
        for camera in &bundle.cameras {
            let free = &camera.free_lens.0[..camera.lens.n_parameters().min(MAX_PARAMETERS)];
            let free = free.iter().enumerate();
            let lens_parameters: Vec<usize> = free
                .filter(|(_, freedom)| **freedom == Freedom::Free)
                .map(|(index, _)| index)
                .collect();
            let pose = layout.take(camera.pose, 6);
            let clock = layout.take(camera.clock, 1);
            let line_delay = layout.take(camera.line_delay, 1);
            let lens = layout.n;
            layout.n += lens_parameters.len();
            layout.cameras.push(CameraColumns {
                pose,
                clock,
                line_delay,
                lens,
                lens_parameters,
            });
        }
        for tag in &bundle.tags {
            let pose = layout.take(tag.pose, 6);
            let size = layout.take(tag.size, 1);
            layout.tags.push(TagColumns { pose, size });
        }
        for scale in &bundle.scales {
            let column = layout.take(scale.freedom, 1);
            layout.scales.push(column);
        }
        if let Some(arm) = &bundle.arm {
            layout.arm.pose = layout.take(Freedom::Free, 12);
            let delay = match arm.seeks_delay {
                true => Freedom::Free,
                false => Freedom::Fixed,
            };
            layout.arm.delay = layout.take(delay, 1);
        }
        layout
    }

    fn take(&mut self, freedom: Freedom, width: usize) -> Option<usize> {
        let start = self.n;
        (freedom == Freedom::Free).then(|| {
            self.n += width;
            start
        })
    }

    /// The parameter of each column.
    pub(crate) fn parameters(&self) -> Vec<KeptParameter> {
        let mut names = Vec::with_capacity(self.n);
        for (camera, columns) in self.cameras.iter().enumerate() {
            if columns.pose.is_some() {
                names.extend((0..3).map(|axis| KeptParameter::CameraPosition { camera, axis }));
                names.extend((0..3).map(|axis| KeptParameter::CameraRotation { camera, axis }));
            }
            if columns.clock.is_some() {
                names.push(KeptParameter::Clock { camera });
            }
            if columns.line_delay.is_some() {
                names.push(KeptParameter::LineDelay { camera });
            }
            let free = columns.lens_parameters.iter();
            names.extend(free.map(|&parameter| KeptParameter::Lens { camera, parameter }));
        }
        for (tag, columns) in self.tags.iter().enumerate() {
            if columns.pose.is_some() {
                names.extend((0..3).map(|axis| KeptParameter::TagPosition { tag, axis }));
                names.extend((0..3).map(|axis| KeptParameter::TagRotation { tag, axis }));
            }
            names.extend(columns.size.map(|_| KeptParameter::TagSize { tag }));
        }
        for (scale, column) in self.scales.iter().enumerate() {
            names.extend(column.map(|_| KeptParameter::Scale { scale }));
        }
        if self.arm.pose.is_some() {
            for pose in [ArmPose::Base, ArmPose::Hand] {
                names.extend((0..3).map(|axis| KeptParameter::ArmPosition { pose, axis }));
                names.extend((0..3).map(|axis| KeptParameter::ArmRotation { pose, axis }));
            }
            names.extend(self.arm.delay.map(|_| KeptParameter::ArmDelay));
        }
        names
    }
}

/// The pose after the step in its columns, if it has any.
pub(crate) fn stepped_pose(pose: &Pose, columns: Option<usize>, kept: &[f64]) -> Pose {
    columns.map_or(*pose, |at| {
        se3::perturb(pose, &Vector6::from_column_slice(&kept[at..at + 6]))
    })
}
