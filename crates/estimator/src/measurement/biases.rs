//! How errors that last displace a view's corners: those of its camera's pose, of its lens and of its tag's place.

use nalgebra::{Cholesky, Const, Matrix6};
use sextant_geometry::Pose;

use crate::filter::consider::{Displacing, Part, Source, by_camera, by_tag};
use crate::filter::least_squares::{Fit, Prior};
use crate::filter::state::Kinematics;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::Sight;
use crate::measurement::edge_modes::product;
use crate::measurement::view_equations::Normal;

impl Sight<'_> {
    /// What errors that last have contributed to this view, about the pose of the tag's link; `normal` is the view's there.
    pub fn lasting(&self, seen: &Configuration, normal: &Normal) -> Vec<Part<6>> {
        let world_from_link = self.view.world_from_link(seen);
        let displacing = self.displacing(&world_from_link);
        let part = |one: Displacing| Part {
            source: one.source,
            variance: one.variance,
            pull: normal.information * one.by,
        };
        let mut parts: Vec<_> = displacing.map(part).collect();
        let of_lens = self
            .camera
            .lens_sigma
            .zip(self.pulled_by_lens(seen, normal));
        parts.extend(of_lens.map(|(sigma, pull)| Part {
            source: Source::Lens(self.camera_index),
            variance: sigma.variance(),
            pull,
        }));
        parts
    }

    /// What errors of its camera's pose and of its tag's place do to the link's pose as this view shows it.
    pub fn displacing(&self, world_from_link: &Pose) -> impl Iterator<Item = Displacing> {
        let of_camera = self.camera.sigma.map(|sigma| Displacing {
            source: Source::Camera(self.camera_index),
            variance: sigma.variance(),
            by: by_camera(&(world_from_link.translation.vector - self.camera.centre)),
        });
        let of_tag = self.view.tag_sigma.map(|sigma| Displacing {
            source: Source::Tag(self.view.tag),
            variance: sigma.variance(),
            by: by_tag(world_from_link, &self.view.object_from_tag),
        });
        of_camera.into_iter().chain(of_tag)
    }

    /// J^T W dr/de for a pixel more of focal length and one of distortion.
    fn pulled_by_lens(&self, seen: &Configuration, normal: &Normal) -> Option<Matrix6<f64>> {
        self.camera.lens_sigma?;
        let linear = self.linearised(&self.view.moving(seen))?;
        let mut by_lens = [[0.0; 2]; 8];
        for (corner, pixel) in self.view.corners_in_image.iter().enumerate() {
            let displaced = self.camera.displaced_by_lens(pixel) * linear.weights[corner].sqrt();
            for axis in 0..2 {
                by_lens[2 * corner + axis] = [displaced[(axis, 0)], displaced[(axis, 1)]];
            }
        }
        let by_lens = self.view.edges.whitened(&by_lens, self.noise);
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

/// Squared sigmas within which a pose of six numbers is what errors as stated make of it: 95 of 100 are.
const AS_STATED: f64 = 12.6;

/// By how much a fit surprises the state: its squared Mahalanobis distance from what was expected, with what errors that last may make
/// of either where that explains it. The view is one of those that were fitted; of several cameras' all share what the first one's
/// error may be.
pub(crate) fn surprise<const D: usize>(
    before: &Kinematics,
    expected: &Prior<D>,
    fit: &Fit<D>,
    sight: &Sight<'_>,
) -> f64 {
    let own = sight.displacing(&fit.configuration.pose);
    let own = own.filter(|one| one.of_camera().is_some()).collect();
    let displacing = before.displacing::<6>(sight.camera_index, None, own);
    let lasting: Matrix6<f64> = displacing.iter().map(Displacing::covariance).sum();
    let apart = || {
        let mut covariance = expected.information.try_inverse()?;
        let mut of_pose = covariance.fixed_view_mut::<6, 6>(0, 0);
        of_pose += lasting;
        let off = fit.configuration.difference::<D>(&expected.configuration);
        let factor = Cholesky::<f64, Const<D>>::new(covariance)?;
        Some(off.dot(&factor.solve(&off)))
    };
    let apart = apart().filter(|apart| *apart < AS_STATED);
    apart.unwrap_or(fit.surprise)
}
