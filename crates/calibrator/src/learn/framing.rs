//! The solution in the frame of the result, as an object.

use super::gauge::{Gauge, aligned, centroid, turned};
use super::solved::SolvedConstellation;
use super::{LearnError, LearnSession};
use crate::adjustment::AdjustmentResult;
use crate::image_store::ImageView;
use nalgebra::DMatrix;
use sextant_adjustment::{KeptCovariance, KeptParameter};
use sextant_geometry::Pose;
use sextant_site_model::{ObjectModel, ObjectTag, PoseSigma};

impl LearnSession {
    /// Transforms the solution into the frame of the result.
    pub(super) fn framed(
        &self,
        views: Vec<ImageView>,
        adjusted: AdjustmentResult,
    ) -> SolvedConstellation {
        let tags = &adjusted.solution.bundle.tags;
        let sought: Vec<bool> = self.known().iter().map(Option::is_none).collect();
        let mut poses: Vec<Pose> = tags.iter().map(|tag| tag.object_from_tag).collect();
        let mut covariance = whole_covariance(tags.len(), &adjusted.solution.covariance);
        if sought.iter().all(|sought| *sought) {
            let frame = match self.plan.gauge {
                Gauge::Tag(tag) => {
                    let at = self.images.wanted.iter().position(|w| w.tag == tag);
                    at.map_or_else(Pose::identity, |at| poses[at])
                }
                Gauge::Centroid => {
                    covariance = aligned(&covariance, &poses);
                    Pose::translation(centroid(&poses).x, centroid(&poses).y, centroid(&poses).z)
                }
            };
            poses = poses.iter().map(|pose| frame.inverse() * pose).collect();
            covariance = turned(&covariance, &frame.rotation.inverse());
        }
        SolvedConstellation {
            views,
            adjusted,
            covariance,
            poses,
            sought,
        }
    }

    pub(super) fn object(&self, solved: &SolvedConstellation) -> Result<ObjectModel, LearnError> {
        let solution = &solved.adjusted.solution;
        let learned = self.images.wanted.iter().enumerate().map(|(at, wanted)| {
            let size_m = solution.bundle.tags[at].size_m;
            let pose_sigma = solved.sought[at].then(|| sigma(&solved.covariance, at));
            let size_sigma = solution
                .covariance
                .sigma(KeptParameter::TagSize { tag: at });
            ObjectTag {
                pose_prior: pose_sigma.into(),
                size_prior: size_sigma.map(|sigma| sigma.min(1.0) * size_m).into(),
                ..ObjectTag::new(wanted.tag, size_m, Some(solved.poses[at]))
            }
        });
        let object = ObjectModel::new(self.plan.object.clone(), learned.collect())?;
        Ok(match &self.plan.from {
            Some(from) => object.holding_on_to(from),
            None => object,
        })
    }
}

/// Standard deviations of a tag pose: root mean squares of the axes.
pub(crate) fn sigma(covariance: &DMatrix<f64>, tag: usize) -> PoseSigma {
    let of_axes = |first: usize| {
        let variance = (first..first + 3)
            .map(|row| covariance[(row, row)].max(0.0))
            .sum::<f64>();
        (variance / 3.0).sqrt().clamp(0.0, 1.0)
    };
    PoseSigma {
        position_m: of_axes(6 * tag),
        orientation_rad: of_axes(6 * tag + 3),
    }
}

/// Six rows for each of `n` tags, zero for those that were fixed.
pub(crate) fn whole_covariance(n: usize, covariance: &KeptCovariance) -> DMatrix<f64> {
    let parameters = covariance.parameters();
    let row = |parameter: &KeptParameter| match *parameter {
        KeptParameter::TagPosition { tag, axis } => Some(6 * tag + axis),
        KeptParameter::TagRotation { tag, axis } => Some(6 * tag + 3 + axis),
        _ => None,
    };
    let mut whole = DMatrix::zeros(6 * n, 6 * n);
    let matrix = covariance.matrix();
    for (i, of) in parameters.iter().enumerate() {
        for (j, by) in parameters.iter().enumerate() {
            if let (Some(i_whole), Some(j_whole)) = (row(of), row(by)) {
                whole[(i_whole, j_whole)] = matrix[(i, j)];
            }
        }
    }
    whole
}
