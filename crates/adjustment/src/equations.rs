//! The normal equations: a small dense matrix over the kept parameters, and for every instant its block and its
//! coupling to them. No Jacobian is stored: images are added one by one.
//!
//! `D` is 6 for independent instants and 12 (pose, twist) if the motion of the object is modelled.

use crate::layout::Layout;
use crate::node::Node;
use crate::residuals::corners::{ImageModel, RowLayout, TagRows};
use crate::residuals::{hand_pose, prior};
use crate::stamps::{self, StampRow};
use crate::tie::{self, FASTEST, Tie};
use crate::values::{Bundle, BundleImage, TagObservation};
use nalgebra::{DMatrix, DVector};
use sextant_geometry::least_squares::Kernel;

/// The normal equations; `kept` is its upper triangle.
pub(crate) struct NormalEquations<const D: usize> {
    pub kept: DMatrix<f64>,
    pub gradient: DVector<f64>,
    pub nodes: Vec<Node<D>>,
    /// Of each image, where the stamps of its camera have errors.
    pub stamps: Vec<Option<StampRow<D>>>,
    /// Sum of the robust squares: twice the cost.
    pub rho: f64,
}

impl<const D: usize> NormalEquations<D> {
    /// Of all residuals of a bundle at its values.
    pub(crate) fn new(bundle: &Bundle, layout: &Layout, kernel: &Kernel) -> Self {
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
        equations.add_ties(bundle);
        let Self {
            kept,
            gradient,
            nodes,
            ..
        } = &mut equations;
        let hand = hand_pose::add(bundle, layout, kept, gradient, nodes);
        prior::add(bundle, layout, kept, gradient);
        equations.rho += hand + tie::rho(bundle) + prior::rho(bundle) + stamps::rho(bundle);
        equations
    }

    pub(crate) fn is_finite(&self) -> bool {
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
            columns_of(bundle, layout, images)
        };
        self.nodes.push(Node::new(columns));
        for image in images {
            let model = ImageModel::new(bundle, image);
            let mut stamp = StampRow::new(bundle, image);
            for seen in &image.tags {
                let scale = bundle.tags[seen.tag].scale;
                let columns = RowLayout::new(layout, image.camera, seen.tag, scale);
                self.add_tag(
                    &model,
                    seen,
                    &columns,
                    scale.and_then(|at| layout.scales[at]),
                    kernel,
                    &mut stamp,
                );
            }
            if let (Some(stamp), Some(node)) = (&stamp, self.nodes.last_mut()) {
                stamp.eliminate(node, &mut self.kept, &mut self.gradient);
            }
            self.stamps.push(stamp);
        }
    }

    fn add_tag(
        &mut self,
        model: &ImageModel<'_>,
        seen: &TagObservation,
        columns: &RowLayout<'_>,
        scale_column: Option<usize>,
        kernel: &Kernel,
        stamp: &mut Option<StampRow<D>>,
    ) {
        let first = columns.instant_start();
        let mut rows = TagRows::zeros(first + D + 1);
        let (error, rho) = model.linearise::<D>(seen, columns, kernel, &mut rows);
        self.rho += rho;
        let products = rows.tr_mul(&rows);
        let pull = rows.tr_mul(&error);
        let Some(node) = self.nodes.last_mut() else {
            return;
        };
        node.own += products.fixed_view::<D, D>(first, first);
        node.gradient += pull.fixed_rows::<D>(first);
        let blocks = columns
            .kept(scale_column)
            .into_iter()
            .filter(|block| block.width > 0);
        let blocks: Vec<_> = blocks.collect();
        for (at, block) in blocks.iter().enumerate() {
            let mut gradient = self.gradient.rows_mut(block.column, block.width);
            gradient += pull.rows(block.row, block.width);
            let local = node.local(block.column);
            let mut coupling = node.coupling.columns_mut(local, block.width);
            coupling += products.view((first, block.row), (D, block.width));
            for other in &blocks[at..] {
                let shape = (block.width, other.width);
                let mut own = self.kept.view_mut((block.column, other.column), shape);
                own += products.view((block.row, other.row), shape);
            }
        }
        if let Some(stamp) = stamp {
            stamp.add(&blocks, &products, &pull, first);
        }
    }

    /// Ties the instants to one another and bounds their twists.
    fn add_ties(&mut self, bundle: &Bundle) {
        let Some(motion) = bundle.motion.filter(|_| D == 12) else {
            return;
        };
        for (node, instant) in self.nodes.iter_mut().zip(&bundle.instants) {
            for axis in 0..6 {
                node.own[(6 + axis, 6 + axis)] += FASTEST.powi(-2);
                node.gradient[6 + axis] += instant.twist[axis] * FASTEST.powi(-2);
            }
        }
        for (at, pair) in bundle.instants.windows(2).enumerate() {
            let Some(tie) = Tie::between(&pair[0], &pair[1], &motion) else {
                continue;
            };
            let stiffness = tie.stiffness();
            for node in &mut self.nodes[at..at + 2] {
                node.tied += stiffness;
            }
            self.nodes[at].next = Some(tie);
        }
    }
}

/// Kept columns that the images of an instant depend on.
fn columns_of(bundle: &Bundle, layout: &Layout, images: &[BundleImage]) -> Vec<usize> {
    let mut columns = Vec::new();
    for image in images {
        let camera = &layout.cameras[image.camera];
        columns.extend(camera.start()..camera.start() + camera.width());
        for seen in &image.tags {
            let (start, width) = layout.tags[seen.tag].span();
            columns.extend(start..start + width);
            columns.extend(bundle.tags[seen.tag].scale.and_then(|at| layout.scales[at]));
        }
    }
    columns.extend(layout.arm.all());
    columns.sort_unstable();
    columns.dedup();
    columns
}

/// Sum of the robust squares, without equations.
pub(crate) fn rho(bundle: &Bundle, kernel: &Kernel) -> f64 {
    let images = bundle.images.iter().map(|image| {
        let model = ImageModel::new(bundle, image);
        let seen = image.tags.iter().map(|seen| model.rho(seen, kernel));
        seen.sum::<f64>()
    });
    images.sum::<f64>()
        + tie::rho(bundle)
        + hand_pose::rho(bundle)
        + prior::rho(bundle)
        + stamps::rho(bundle)
}
