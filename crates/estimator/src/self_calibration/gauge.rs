//! Gauge freedom: motions of the whole site, of an object's frame in its tags, and the common scale, which no image determines.
//!
//! Each such motion changes the errors of cameras and tags along a column of the gauge basis and no residual. With the prior precision L,
//! the part of a covariance C that is relative to the rest is P C P', P = I - G (G' L G)^-1 G' L (Teunissen 1985, Zero order design:
//! generalized inverses, adjustment, the datum problem and S-transformations, eq. 3.10).

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use sextant_geometry::so3;

use crate::TagId;
use crate::self_calibration::keyframes::Body;
use crate::self_calibration::parameters::ParameterLayout;
use crate::site::Site;

/// A basis of the motions that no image shows, column by column.
pub(crate) struct Gauge {
    basis: DMatrix<f64>,
    precision: DVector<f64>,
    /// Bodies in the order of their columns.
    bodies: Vec<Body>,
    /// Mean of the cameras' centres: the common scale is about it.
    pub centre: Vector3<f64>,
}

/// Columns of the world's frame; the common scale follows, then six an object.
const OF_WORLD: usize = 6;

impl Gauge {
    pub fn of(layout: &ParameterLayout, precision: &DVector<f64>, site: &Site) -> Self {
        let centres: Vec<Vector3<f64>> = layout
            .cameras
            .keys()
            .filter_map(|camera| site.file_camera(*camera))
            .map(|file| file.world_from_camera.translation.vector)
            .collect();
        let centre = centres.iter().sum::<Vector3<f64>>() / centres.len().max(1) as f64;
        let mut bodies: Vec<Body> = layout.tags.values().map(|(body, _)| *body).collect();
        bodies.sort_unstable();
        bodies.dedup();
        let n_columns = OF_WORLD + 1 + 6 * bodies.len();
        let mut basis = DMatrix::zeros(layout.len(), n_columns);
        for (camera, first) in &layout.cameras {
            let Some(file) = site.file_camera(*camera) else {
                continue;
            };
            let arm = file.world_from_camera.translation.vector - centre;
            rigid(&mut basis, (*first, 0), &arm);
            let mut scale = basis.fixed_view_mut::<3, 1>(*first, OF_WORLD);
            scale.copy_from(&arm);
        }
        for (tag, (body, first)) in &layout.tags {
            let (Some(at), place) = (bodies.iter().position(|one| one == body), place(site, tag))
            else {
                continue;
            };
            rigid(&mut basis, (*first, OF_WORLD + 1 + 6 * at), &place);
            let mut scale = basis.fixed_view_mut::<3, 1>(*first, OF_WORLD);
            scale.copy_from(&place);
            basis[(first + 6, OF_WORLD)] = 1.0;
        }
        Self {
            basis,
            precision: precision.clone(),
            bodies,
            centre,
        }
    }

    /// The part of a covariance that is relative to the rest of the site.
    pub fn relative(&self, covariance: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let weighted = self.weighted();
        let inverse = self.information(&weighted).try_inverse()?;
        let removed = &self.basis * (inverse * weighted);
        let projection = DMatrix::identity(covariance.nrows(), covariance.ncols()) - removed;
        Some(&projection * covariance * projection.transpose())
    }

    /// Covariance of a body's frame by the priors of its tags.
    pub fn frame_covariance(&self, body: Body) -> Option<nalgebra::Matrix6<f64>> {
        let at = self.bodies.iter().position(|one| *one == body)?;
        let first = OF_WORLD + 1 + 6 * at;
        let information = self.information(&self.weighted());
        information
            .fixed_view::<6, 6>(first, first)
            .into_owned()
            .try_inverse()
    }

    /// Variance of the common scale by all priors.
    pub fn scale_variance(&self) -> f64 {
        let column = self.basis.column(OF_WORLD);
        let terms = column.iter().zip(self.precision.iter());
        let information: f64 = terms
            .map(|(slope, precision)| slope * slope * precision)
            .sum();
        information.recip()
    }

    fn weighted(&self) -> DMatrix<f64> {
        let mut weighted = self.basis.transpose();
        for (mut column, precision) in weighted.column_iter_mut().zip(self.precision.iter()) {
            column *= *precision;
        }
        weighted
    }

    fn information(&self, weighted: &DMatrix<f64>) -> DMatrix<f64> {
        weighted * &self.basis
    }
}

/// Where a tag's centre is on its object, m.
fn place(site: &Site, tag: &TagId) -> Vector3<f64> {
    let pose = site
        .placement(tag)
        .and_then(|place| place.file.object_from_tag);
    pose.map_or_else(Vector3::zeros, |pose| pose.translation.vector)
}

/// A rigid motion about the origin of a frame moves a pose at `arm` by dt + dr x arm and turns it by dr.
fn rigid(basis: &mut DMatrix<f64>, (row, column): (usize, usize), arm: &Vector3<f64>) {
    let identity = Matrix3::identity();
    for at in [0, 3] {
        let mut block = basis.fixed_view_mut::<3, 3>(row + at, column + at);
        block.copy_from(&identity);
    }
    let mut lever = basis.fixed_view_mut::<3, 3>(row, column + 3);
    lever.copy_from(&-so3::hat(arm));
}
