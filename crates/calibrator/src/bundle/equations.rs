//! The normal equations: a small dense matrix over the kept parameters, and for every instant its block and its
//! coupling to them. No Jacobian is stored: images are added one by one.
//!
//! `D` is 6 for independent instants and 12 (pose, twist) if the motion of the object is modelled.

use super::anchors;
use super::arm_equations;
use super::image_sums::ImageSums;
use super::layout::Layout;
use super::motion;
use super::node::{Coupling, Node};
use super::residuals::{self, LensColumns, View};
use super::stamps::{self, StampRow};
use super::state::{Bundle, BundleImage};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use sextant_geometry::least_squares::Kernel;

/// The normal equations; `kept` is its upper triangle.
pub(super) struct Equations<const D: usize> {
    pub kept: DMatrix<f64>,
    pub gradient: DVector<f64>,
    pub nodes: Vec<Node<D>>,
    /// Of each image, where the stamps of its camera have errors.
    pub stamps: Vec<Option<StampRow<D>>>,
    /// Sum of the robust squares: twice the cost.
    pub rho: f64,
}

impl<const D: usize> Equations<D> {
    pub(super) fn of(bundle: &Bundle, layout: &Layout, kernel: &Kernel) -> Self {
        let mut equations = Self {
            kept: DMatrix::zeros(layout.n, layout.n),
            gradient: DVector::zeros(layout.n),
            nodes: Vec::with_capacity(bundle.instants.len()),
            stamps: Vec::with_capacity(bundle.images.len()),
            rho: 0.0,
        };
        let mut images = bundle.images.as_slice();
        for instant in 0..bundle.instants.len() {
            let here = images.partition_point(|image| image.instant <= instant);
            let (own, later) = images.split_at(here);
            equations.add_instant(bundle, layout, own, kernel);
            images = later;
        }
        equations.rho += motion::tie(bundle, &mut equations.nodes);
        let (kept, gradient) = (&mut equations.kept, &mut equations.gradient);
        let sums = (&mut *kept, &mut *gradient);
        equations.rho += arm_equations::add(bundle, layout, sums, &mut equations.nodes);
        equations.rho += anchors::add(bundle, layout, kept, gradient) + stamps::rho(bundle);
        equations
    }

    pub(super) fn is_finite(&self) -> bool {
        self.rho.is_finite() && self.gradient.iter().all(|x| x.is_finite())
    }

    fn add_instant(
        &mut self,
        bundle: &Bundle,
        layout: &Layout,
        images: &[BundleImage],
        kernel: &Kernel,
    ) {
        let columns = if bundle.motion.is_some() {
            (0..layout.n).collect() // coupled instants fill in anyway
        } else {
            columns_of(layout, images)
        };
        let mut node = Node {
            own: SMatrix::zeros(),
            gradient: SVector::zeros(),
            coupling: Coupling::<D>::zeros(columns.len()),
            columns,
            next: None,
        };
        for image in images {
            let sums = ImageSums::<D>::of(bundle, layout, image, kernel);
            self.add_kept(layout, image.camera, &sums);
            node.add(layout, image.camera, &sums);
            self.rho += sums.rho;
            let stamp = StampRow::of(bundle, layout, image, &sums);
            if let Some(stamp) = &stamp {
                stamp.eliminate(&mut node, &mut self.kept, &mut self.gradient);
            }
            self.stamps.push(stamp);
        }
        self.nodes.push(node);
    }

    fn add_kept(&mut self, layout: &Layout, camera: usize, sums: &ImageSums<D>) {
        let camera = &layout.cameras[camera];
        let (start, width) = (camera.start(), camera.width());
        let mut own = self.kept.view_mut((start, start), (width, width));
        own += sums.whole.view((0, 0), (width, width));
        let mut gradient = self.gradient.rows_mut(start, width);
        gradient += sums.gradient.rows(0, width);
        for tag in &sums.tags {
            let (first, (column, n)) = (layout.tags[tag.tag].first(), layout.tags[tag.tag].span());
            let mut own = self.kept.view_mut((column, column), (n, n));
            own += tag.own.view((first, first), (n, n));
            let mut gradient = self.gradient.rows_mut(column, n);
            gradient += tag.gradient.rows(first, n);
            let mut across = self.kept.view_mut((start, column), (width, n));
            across += tag.image_by_tag.view((0, first), (width, n));
        }
    }
}

/// Kept columns that the images of an instant depend on.
fn columns_of(layout: &Layout, images: &[BundleImage]) -> Vec<usize> {
    let mut columns = Vec::new();
    for image in images {
        let camera = &layout.cameras[image.camera];
        columns.extend(camera.start()..camera.start() + camera.width());
        for seen in &image.tags {
            let (start, width) = layout.tags[seen.tag].span();
            columns.extend(start..start + width);
        }
    }
    columns.extend(layout.arm.all());
    columns.sort_unstable();
    columns.dedup();
    columns
}

/// Sum of the robust squares, without equations.
pub(super) fn rho(bundle: &Bundle, kernel: &Kernel) -> f64 {
    let images = bundle.images.iter().map(|image| {
        let view = View::of(bundle, image, LensColumns::Unwanted);
        let seen = image.tags.iter().map(|seen| {
            let tag = &bundle.tags[seen.tag];
            residuals::rho(&view, &tag.object_from_tag, tag.size_m, seen, kernel)
        });
        seen.sum::<f64>()
    });
    images.sum::<f64>()
        + motion::rho(bundle)
        + arm_equations::rho(bundle)
        + anchors::rho(bundle)
        + stamps::rho(bundle)
}
