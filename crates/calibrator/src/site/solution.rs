//! A solved site before its report: models in the frame of the adjustment, and what they are judged by.

use super::members::{BodyViews, Members};
use super::scales::ScaleContradiction;
use crate::adjustment::AdjustmentResult;
use crate::learn::framing::whole_covariance;
use crate::rig::clocks::Clocks;
use nalgebra::DMatrix;
use sextant_adjustment::{Freedom, KeptCovariance};
use sextant_geometry::Pose;
use sextant_site_model::Rig;

/// A solved site, in the frame of the adjustment.
pub(super) struct SiteSolution {
    /// The cameras with their former lenses.
    pub rig: Rig,
    pub members: Members,
    pub seen: BodyViews,
    pub adjusted: AdjustmentResult,
    pub clocks: Clocks,
    pub is_placed: Vec<bool>,
    pub reference: usize,
    pub synchronised: bool,
    /// Bodies with other sizes than given.
    pub contradictions: Vec<ScaleContradiction>,
}

/// A static tag in the frame of the adjustment.
#[derive(Clone, Copy, Debug)]
pub(super) struct StillTag {
    /// Index into the wanted tags.
    pub tag: usize,
    pub adjusted_from_tag: Pose,
    /// How many cameras see it.
    pub n_cameras: usize,
}

impl SiteSolution {
    /// Mean logarithm of the adjusted sizes by the given ones. Images tell only their ratios; the motion model would
    /// have all of them smaller.
    pub(super) fn common_size_error(&self) -> f64 {
        let tags = &self.adjusted.solution.bundle.tags;
        let free = tags.iter().zip(&self.members.wanted);
        let free = free.filter(|(tag, _)| tag.size == Freedom::Free);
        let errors = free.map(|(tag, wanted)| (tag.size_m / wanted.size_m).ln());
        let errors: Vec<f64> = errors.collect();
        errors.iter().sum::<f64>() / errors.len().max(1) as f64
    }

    /// Covariance of the tags' poses on their bodies, six rows each, the common scale apart; zero for tags that define
    /// a frame or stand still.
    pub(super) fn covariance_at_known_scale(&self) -> DMatrix<f64> {
        let covariance: KeptCovariance = self.adjusted.solution.covariance.at_known_scale();
        whole_covariance(self.members.wanted.len(), &covariance)
    }

    /// The static tags that were adjusted.
    pub(super) fn still_tags(&self) -> Vec<StillTag> {
        let bundle = &self.adjusted.solution.bundle;
        let tags = self.members.n_carried()..self.members.wanted.len();
        let still = tags.filter_map(|tag| {
            let own = bundle.images.iter();
            let own = own.filter(|image| image.tags.iter().any(|seen| seen.tag == tag));
            let mut cameras: Vec<usize> = own.clone().map(|image| image.camera).collect();
            cameras.sort_unstable();
            cameras.dedup();
            let instant = own.clone().next()?.instant;
            Some(StillTag {
                tag,
                adjusted_from_tag: bundle.instants[instant].world_from_object,
                n_cameras: cameras.len(),
            })
        });
        still.collect()
    }

    /// Whether a tag of a body has images that fit.
    pub(super) fn is_tag_placed(&self, tag: usize) -> bool {
        let images = self.adjusted.solution.bundle.images.iter();
        let mut seen = images.flat_map(|image| &image.tags);
        seen.any(|seen| seen.tag == tag)
    }
}
