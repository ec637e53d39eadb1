//! Jacobians of constant errors: how errors of camera pose, lens and tag pose displace the corners of a view.

use nalgebra::{Matrix6, SMatrix, Vector3, Vector6};
use sextant_geometry::Pose;

use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::WeightedView;
use crate::measurement::view_equations::ViewEquations;
use crate::measurement::whitening::product;
use sextant_site_model::TagId;

/// Source of a constant error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BiasSource {
    /// The pose of the camera of that index.
    Camera(usize),
    /// Its lens.
    Lens(usize),
    /// The place of the tag.
    Tag(TagId),
}

/// Gradient of the corners by the error of a source in an update.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BiasGradient<const D: usize> {
    pub source: BiasSource,
    pub variance: Vector6<f64>,
    /// J^T W dr/de about the observed configuration; zero for the rates, which the few milliseconds of an image hardly
    /// affect.
    pub pull: SMatrix<f64, D, 6>,
}

/// Derivative of the pose of a link, as a view shows it, by the error of a source.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BiasJacobian {
    pub source: BiasSource,
    pub variance: Vector6<f64>,
    pub by: Matrix6<f64>,
}

impl BiasGradient<6> {
    /// About the configuration, given the Jacobian of the link; `None` where the link is the object.
    pub fn about<const D: usize>(&self, link: Option<&SMatrix<f64, 6, D>>) -> BiasGradient<D> {
        let mut pull = SMatrix::<f64, D, 6>::zeros();
        match link {
            Some(link) => pull.copy_from(&link.tr_mul(&self.pull)),
            None => pull.fixed_rows_mut::<6>(0).copy_from(&self.pull),
        }
        BiasGradient {
            source: self.source,
            variance: self.variance,
            pull,
        }
    }
}

impl<const D: usize> BiasGradient<D> {
    /// Adds a part to those of the same source.
    pub fn join(self, parts: &mut Vec<Self>) {
        match parts.iter_mut().find(|other| other.source == self.source) {
            Some(other) => other.pull += self.pull,
            None => parts.push(self),
        }
    }
}

impl WeightedView<'_> {
    /// Gradients of constant errors by this view, about the pose of its link; `normal` is the view linearised there.
    pub fn bias_gradients(
        &self,
        seen: &Configuration,
        normal: &ViewEquations,
    ) -> Vec<BiasGradient<6>> {
        let world_from_link = self.view.world_from_link(seen);
        let bias_jacobians = self.bias_jacobians(&world_from_link);
        let part = |one: BiasJacobian| BiasGradient {
            source: one.source,
            variance: one.variance,
            pull: normal.information * one.by,
        };
        let mut parts: Vec<_> = bias_jacobians.map(part).collect();
        let of_lens = self
            .camera
            .lens_sigma
            .zip(self.pulled_by_lens(seen, normal));
        parts.extend(of_lens.map(|(sigma, pull)| BiasGradient {
            source: BiasSource::Lens(self.camera_index),
            variance: sigma.variance(),
            pull,
        }));
        parts
    }

    /// Derivatives of the pose of the link, as this view shows it, by errors of camera pose and tag pose.
    pub fn bias_jacobians(&self, world_from_link: &Pose) -> impl Iterator<Item = BiasJacobian> {
        let of_camera = self.camera.sigma.map(|sigma| BiasJacobian {
            source: BiasSource::Camera(self.camera_index),
            variance: sigma.variance(),
            by: by_camera(&(world_from_link.translation.vector - self.camera.centre)),
        });
        let of_tag = self.view.tag_sigma.map(|sigma| BiasJacobian {
            source: BiasSource::Tag(self.view.tag),
            variance: sigma.variance(),
            by: by_tag(world_from_link, &self.view.object_from_tag),
        });
        of_camera.into_iter().chain(of_tag)
    }

    /// J^T W dr/de for a pixel more of focal length and one of distortion.
    fn pulled_by_lens(&self, seen: &Configuration, normal: &ViewEquations) -> Option<Matrix6<f64>> {
        self.camera.lens_sigma?;
        let linear = self.linearised(&self.view.moving(seen))?;
        let mut by_lens = [[0.0; 2]; 8];
        for (corner, pixel) in self.view.corners_in_image.iter().enumerate() {
            let displaced = self.camera.displaced_by_lens(pixel) * linear.weights[corner].sqrt();
            for axis in 0..2 {
                by_lens[2 * corner + axis] = [displaced[(axis, 0)], displaced[(axis, 1)]];
            }
        }
        let by_lens = self.view.whitening.whitened(&by_lens, self.noise);
        // The view's weight is in its information.
        let squares = linear.rows.iter().flat_map(|row| &row[..6]);
        let plain: f64 = squares.map(|slope| slope * slope).sum();
        let weight = normal.information.trace() / plain;
        let pulled = product(&linear.rows, &by_lens) * weight;
        let mut pull = Matrix6::zeros();
        pull.fixed_columns_mut::<2>(0)
            .copy_from(&pulled.fixed_rows::<6>(0));
        Some(pull)
    }
}

/// What an error of a camera's pose (its axes those of the world) does to a pose that it sees at `arm` from its centre:
/// dt = dt_c + dr_c x arm, dr = dr_c. The corners are displaced as if the object had moved the other way.
pub(crate) fn by_camera(arm: &Vector3<f64>) -> Matrix6<f64> {
    let mut displacement = Matrix6::identity();
    displacement
        .fixed_view_mut::<3, 3>(0, 3)
        .copy_from(&-arm.cross_matrix());
    -displacement
}

/// How a link would have to move for an error of a tag's place on it (its axes those of the link) to displace the tag's
/// corners as it does: by dt + dr x (p - c), with the tag's centre at c.
pub(crate) fn by_tag(world_from_link: &Pose, link_from_tag: &Pose) -> Matrix6<f64> {
    let turn = world_from_link.rotation.to_rotation_matrix().into_inner();
    let arm = turn * link_from_tag.translation.vector;
    let mut displacement = Matrix6::zeros();
    for (row, column, block) in [
        (0, 0, turn),
        (0, 3, arm.cross_matrix() * turn),
        (3, 3, turn),
    ] {
        displacement
            .fixed_view_mut::<3, 3>(row, column)
            .copy_from(&block);
    }
    displacement
}
