//! Gauge freedom: motions of the whole site, of an object's frame in its tags, and the common scale, which no image
//! determines.
//!
//! Each such motion changes the errors of cameras and tags along a column of the gauge basis and no residual. With the
//! prior precision L, the part of a covariance C that is relative to the rest is P C P', P = I - G (G' L G)^-1 G' L
//! (Teunissen 1985, Zero order design: generalized inverses, adjustment, the datum problem and S-transformations, eq.
//! 3.10). Frames of different objects share no tag. They are taken out body by body, and the motions of the whole site
//! after them.

use nalgebra::{DMatrix, DVector, DVectorView, Matrix3, Matrix6, Vector3};
use sextant_geometry::so3;

use crate::self_calibration::arrow::{Arrow, ArrowInverse, BodyBlocks, InverseBlocks};
use crate::self_calibration::keyframes::Body;
use crate::self_calibration::parameters::{ParameterLayout, SIZE};
use crate::site::ModelledSite;
use sextant_site_model::TagId;

/// A basis of the motions that no image shows.
pub(crate) struct Gauge {
    /// World frame and common scale, as they act on the cameras.
    of_cameras: DMatrix<f64>,
    frames: Vec<BodyFrame>,
    precision: DVector<f64>,
    /// Mean of the cameras' centres: the common scale is about it.
    pub centre: Vector3<f64>,
}

/// How motions act on the tags of one body.
struct BodyFrame {
    body: Body,
    /// First place of its tags.
    first: usize,
    /// Of its own frame, six columns; and of its scale against the places and sizes of its tags, where it has one.
    own: DMatrix<f64>,
    /// World frame and common scale.
    of_site: DMatrix<f64>,
}

/// Columns of the world's frame; the common scale follows.
const OF_WORLD: usize = 6;
const OF_SITE: usize = OF_WORLD + 1;
/// Columns of the frame of a body.
const OF_FRAME: usize = 6;

/// Whether the scale of a body has an error.
fn is_scaled(layout: &ParameterLayout, body: Body) -> bool {
    layout
        .scales
        .get(&body)
        .is_some_and(|at| layout.is_open(*at))
}

impl Gauge {
    pub fn new(layout: &ParameterLayout, precision: &DVector<f64>, site: &ModelledSite) -> Self {
        let centres: Vec<Vector3<f64>> = layout
            .cameras
            .keys()
            .filter_map(|camera| site.file_camera(*camera))
            .map(|file| file.world_from_camera.translation.vector)
            .collect();
        let centre = centres.iter().sum::<Vector3<f64>>() / centres.len().max(1) as f64;
        let mut of_cameras = DMatrix::zeros(layout.n_of_cameras(), OF_SITE);
        for (camera, first) in &layout.cameras {
            let Some(file) = site.file_camera(*camera) else {
                continue;
            };
            let arm = file.world_from_camera.translation.vector - centre;
            rigid(&mut of_cameras, *first, &arm);
            scale(&mut of_cameras, *first, &arm);
        }
        let frame = |(body, places): &(Body, std::ops::Range<usize>)| BodyFrame {
            body: *body,
            first: places.start,
            own: DMatrix::zeros(
                places.len(),
                OF_FRAME + usize::from(is_scaled(layout, *body)),
            ),
            of_site: DMatrix::zeros(places.len(), OF_SITE),
        };
        let mut frames: Vec<BodyFrame> = layout.bodies.iter().map(frame).collect();
        for (tag, (body, first)) in &layout.tags {
            let Some(frame) = frames.iter_mut().find(|frame| frame.body == *body) else {
                continue;
            };
            let (row, place) = (first - frame.first, place(site, tag));
            rigid(&mut frame.own, row, &place);
            scale(&mut frame.of_site, row, &place);
            frame.of_site[(row + SIZE, OF_WORLD)] = 1.0;
            if let Some(at) = layout.scales.get(body).filter(|_| is_scaled(layout, *body)) {
                let mut against = frame.own.fixed_view_mut::<3, 1>(row, OF_FRAME);
                against.copy_from(&place);
                frame.own[(row + SIZE, OF_FRAME)] = 1.0;
                frame.own[(at - frame.first, OF_FRAME)] = -1.0;
            }
        }
        Self {
            of_cameras,
            frames,
            precision: precision.clone(),
            centre,
        }
    }

    /// The part of a covariance that is relative to the rest of the site, between cameras and within each body.
    pub fn relative(&self, covariance: ArrowInverse) -> Option<Arrow> {
        let (covariance, of_bodies) = self.without_frames(covariance)?;
        let basis = || std::iter::once(&self.of_cameras).chain(&of_bodies);
        let precisions = || {
            let bodies = self.frames.iter().map(|frame| self.precisions(frame));
            std::iter::once(self.precision.rows(0, self.of_cameras.nrows())).chain(bodies)
        };
        let weighted: Vec<DMatrix<f64>> = (basis().zip(precisions()))
            .map(|(basis, precision)| weighted(basis, &precision))
            .collect();
        let information = basis().zip(&weighted).map(|(basis, one)| one * basis);
        let inverse = information.sum::<DMatrix<f64>>().try_inverse()?;
        let motions: Vec<DMatrix<f64>> = weighted.iter().map(|one| &inverse * one).collect();
        Some(without_motions(&covariance, basis().collect(), &motions))
    }

    /// A covariance, and the motions of the site as they act on each body, relative to the bodies' own frames.
    fn without_frames(
        &self,
        covariance: ArrowInverse,
    ) -> Option<(ArrowInverse, Vec<DMatrix<f64>>)> {
        let ArrowInverse { cameras, bodies } = covariance;
        let (mut relative, mut of_bodies) = (Vec::new(), Vec::new());
        for (frame, body) in self.frames.iter().zip(bodies) {
            let weighted = weighted(&frame.own, &self.precisions(frame));
            let inverse = (&weighted * &frame.own).try_inverse()?;
            let n = frame.own.nrows();
            let projection = DMatrix::identity(n, n) - &frame.own * (inverse * weighted);
            relative.push(InverseBlocks {
                places: body.places,
                own: &projection * body.own * projection.transpose(),
                gain: &projection * body.gain,
            });
            of_bodies.push(projection * &frame.of_site);
        }
        let bodies = relative;
        Some((ArrowInverse { cameras, bodies }, of_bodies))
    }

    /// Covariance of a body's frame by the priors of its tags.
    pub fn frame_covariance(&self, body: Body) -> Option<Matrix6<f64>> {
        let frame = self.frames.iter().find(|frame| frame.body == body)?;
        let information = weighted(&frame.own, &self.precisions(frame)) * &frame.own;
        information
            .fixed_view::<OF_FRAME, OF_FRAME>(0, 0)
            .into_owned()
            .try_inverse()
    }

    /// Variance of the common scale by all priors. Tags of one object are of one printer, so that their number makes
    /// them no better.
    pub fn scale_variance(&self, site: &ModelledSite) -> f64 {
        let information = |basis: &DMatrix<f64>, precision: DVectorView<'_, f64>| {
            let slopes = basis.column(OF_WORLD);
            slopes.component_mul(&slopes).dot(&precision)
        };
        let of_cameras = self.precision.rows(0, self.of_cameras.nrows());
        let of_bodies = self.frames.iter().map(|frame| {
            let own = information(&frame.of_site, self.precisions(frame));
            // Its tags together, and the print that they share.
            (own.recip() + site.scale_variance(frame.body.0)).recip()
        });
        let all = information(&self.of_cameras, of_cameras) + of_bodies.sum::<f64>();
        all.recip()
    }

    fn precisions(&self, frame: &BodyFrame) -> DVectorView<'_, f64> {
        self.precision.rows(frame.first, frame.own.nrows())
    }
}

/// G' L.
fn weighted(basis: &DMatrix<f64>, precision: &DVectorView<'_, f64>) -> DMatrix<f64> {
    let mut weighted = basis.transpose();
    for (mut column, precision) in weighted.column_iter_mut().zip(precision.iter()) {
        column *= *precision;
    }
    weighted
}

/// P C P' with P = I - G N, where G is given as `basis` and N as `motions`, of the cameras first and then of each body.
fn without_motions(
    covariance: &ArrowInverse,
    basis: Vec<&DMatrix<f64>>,
    motions: &[DMatrix<f64>],
) -> Arrow {
    let ArrowInverse { cameras, bodies } = covariance;
    // N U, and N C of the cameras and of each body.
    let gains = bodies.iter().zip(&motions[1..]);
    let through_cameras = gains.fold(motions[0].clone(), |sum, (body, n)| sum - n * &body.gain);
    let with_cameras = &through_cameras * cameras;
    let with_body = |(body, n): (&InverseBlocks, &DMatrix<f64>)| {
        n * &body.own - &with_cameras * body.gain.transpose()
    };
    let with_bodies: Vec<_> = bodies.iter().zip(&motions[1..]).map(with_body).collect();
    let with = || std::iter::once(&with_cameras).chain(&with_bodies);
    let of_motions = (with().zip(motions)).map(|(with, n)| with * n.transpose());
    let of_motions: DMatrix<f64> = of_motions.sum();
    let removed = |row: usize, column: usize, with: [&DMatrix<f64>; 2]| {
        let (g_row, g_column) = (basis[row], basis[column].transpose());
        g_row * (with[1] - &of_motions * &g_column) + with[0].tr_mul(&g_column)
    };
    let body = |(at, (body, with_body)): (usize, (&InverseBlocks, &DMatrix<f64>))| {
        let through_cameras = &body.gain * cameras;
        let within = &through_cameras * body.gain.transpose() + &body.own;
        BodyBlocks {
            places: body.places.clone(),
            own: within - removed(at + 1, at + 1, [with_body, with_body]),
            coupling: -through_cameras - removed(at + 1, 0, [with_body, &with_cameras]),
        }
    };
    Arrow {
        cameras: cameras - removed(0, 0, [&with_cameras, &with_cameras]),
        bodies: (bodies.iter().zip(&with_bodies))
            .enumerate()
            .map(body)
            .collect(),
    }
}

/// Where a tag's centre is on its object, m.
fn place(site: &ModelledSite, tag: &TagId) -> Vector3<f64> {
    let pose = site
        .placement(tag)
        .and_then(|place| place.file.object_from_tag);
    pose.map_or_else(Vector3::zeros, |pose| pose.translation.vector)
}

/// A rigid motion about the origin of a frame moves a pose at `arm` by dt + dr x arm and turns it by dr.
fn rigid(basis: &mut DMatrix<f64>, row: usize, arm: &Vector3<f64>) {
    let identity = Matrix3::identity();
    for at in [0, 3] {
        let mut block = basis.fixed_view_mut::<3, 3>(row + at, at);
        block.copy_from(&identity);
    }
    let mut lever = basis.fixed_view_mut::<3, 3>(row, 3);
    lever.copy_from(&-so3::hat(arm));
}

/// The common scale moves a pose along its `arm`.
fn scale(basis: &mut DMatrix<f64>, row: usize, arm: &Vector3<f64>) {
    let mut scale = basis.fixed_view_mut::<3, 1>(row, OF_WORLD);
    scale.copy_from(arm);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::self_calibration::arrow::tests::{arrow, layout};

    #[test]
    fn a_relative_covariance_is_that_of_the_dense_projection() {
        let (layout, (arrow, dense)) = (layout(), arrow());
        let number = |row: usize, column: usize| (0.37 * ((row + 1) * (column + 1)) as f64).sin();
        let frame = |(body, places): &(Body, std::ops::Range<usize>)| BodyFrame {
            body: *body,
            first: places.start,
            own: DMatrix::from_fn(places.len(), 6, number),
            of_site: DMatrix::from_fn(places.len(), OF_SITE, |row, column| {
                number(places.start + row, OF_SITE + column)
            }),
        };
        let precision = DVector::from_fn(layout.len(), |at, _| 1.0 + (at % 5) as f64);
        let gauge = Gauge {
            of_cameras: DMatrix::from_fn(layout.n_of_cameras(), OF_SITE, |row, column| {
                number(row, column)
            }),
            frames: layout.bodies.iter().map(frame).collect(),
            precision: precision.clone(),
            centre: Vector3::zeros(),
        };
        let mut basis = DMatrix::zeros(layout.len(), OF_SITE + 6 * gauge.frames.len());
        let rows = gauge.of_cameras.shape();
        basis.view_mut((0, 0), rows).copy_from(&gauge.of_cameras);
        for (k, frame) in gauge.frames.iter().enumerate() {
            let mut site = basis.view_mut((frame.first, 0), frame.of_site.shape());
            site.copy_from(&frame.of_site);
            let mut own = basis.view_mut((frame.first, OF_SITE + 6 * k), frame.own.shape());
            own.copy_from(&frame.own);
        }
        let weighted = basis.transpose() * DMatrix::from_diagonal(&precision);
        let inverse = (&weighted * &basis).try_inverse().unwrap();
        let projection =
            DMatrix::identity(layout.len(), layout.len()) - &basis * inverse * weighted;
        let covariance = dense.cholesky().unwrap().inverse();
        let expected = &projection * covariance * projection.transpose();

        let relative = gauge.relative(arrow.factor().unwrap().inverse()).unwrap();
        let cameras = 0..layout.n_of_cameras();
        for (_, places) in &layout.bodies {
            let own = || cameras.clone().chain(places.clone());
            for (row, column) in own().flat_map(|row| own().map(move |column| (row, column))) {
                let off = relative.get(row, column) - expected[(row, column)];
                assert!(off.abs() < 1e-9, "{row}, {column}: {off:e}");
            }
        }
    }
}
