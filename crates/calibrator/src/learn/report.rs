//! Report on a learned constellation.

use super::LearnSession;
use super::solved::{SolvedConstellation, fitting};
use crate::discovered_tags::DiscoveredTags;
use crate::held_out::{self, HeldOutImages};
use crate::verdict::{Finding, Grade, PosePart, ScaleSource, Verdict};
use serde::Serialize;
use sextant_adjustment::KeptParameter;

/// One tag of a learned object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearnedTag {
    /// Family and number, as text.
    pub tag: String,
    /// Images that show it.
    pub images: usize,
    /// Number of these that do not fit well and were left out.
    pub left_out: usize,
    /// Number of these that place it elsewhere on the object.
    pub elsewhere: usize,
    /// One standard deviation of its position (root mean square over the axes), millimetres, in the frame of `Gauge`.
    pub sigma_mm: f64,
    /// Standard deviation of its attitude (root mean square of the axes), degrees.
    pub sigma_deg: f64,
    /// Along the object's axes, millimetres.
    pub sigma_axes_mm: [f64; 3],
    /// About the object's axes, degrees.
    pub sigma_axes_deg: [f64; 3],
    /// RMS reprojection error, pixels.
    pub rms_px: f64,
    /// Its size relative to the given one, by comparison with the other tags; 1 if right.
    pub size_ratio: f64,
    /// Standard deviation of the ratio.
    pub size_ratio_sigma: f64,
}

/// Accuracy of a learned constellation, and a verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LearnReport {
    /// The object's name.
    pub object: String,
    /// Number of images received.
    pub images: usize,
    /// Images used.
    pub images_used: usize,
    /// RMS reprojection error over all used corners, pixels.
    pub rms_px: f64,
    /// Corner noise as a multiple of the detector's; 1 is expected.
    pub noise_ratio: f64,
    /// Residuals of images that had no part in a solution; `None` where there are too few.
    pub held_out: Option<HeldOutImages>,
    /// The learned tags.
    pub tags: Vec<LearnedTag>,
    /// Tags of the given object that kept their poses.
    pub kept: Vec<String>,
    /// Weakly determined parts of tag poses.
    pub weak: Vec<Finding>,
    /// Tags that could not be placed and are left out, with cause and remedy.
    pub unsolved: Vec<String>,
    /// Tags of initially unknown size and their estimated sizes, metres; only for discovered objects.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub solved_sizes: Vec<(String, f64)>,
    /// Roles of the discovered tags; only for discovered objects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<DiscoveredTags>,
    /// Grade and findings.
    pub verdict: Verdict,
}

/// Standard deviations below which a tag is well placed (metres, radians); three times as much is usable.
const WELL_PLACED: (f64, f64) = (0.0003, 0.004);
/// Least number of images that determine a tag.
const FEW_IMAGES: usize = 5;
/// Largest harmless relative difference of a size.
const HARMLESS_SIZE: f64 = 0.004;
/// Share of a tag's images from which outliers are reported.
const MANY_LEFT_OUT: f64 = 0.15;

impl LearnSession {
    pub(super) fn report(&self, solved: &SolvedConstellation) -> LearnReport {
        let all: Vec<LearnedTag> = (0..self.images.wanted.len())
            .map(|at| self.tag(solved, at))
            .collect();
        let sought = |wanted: bool| {
            let both = all.iter().zip(&solved.sought);
            both.filter(move |(_, s)| **s == wanted)
                .map(|(tag, _)| tag.clone())
        };
        let tags: Vec<LearnedTag> = sought(true).collect();
        let held_out = solved.adjusted.held_out(&solved.views);
        let mut verdict = self.verdict(&tags, solved);
        held_out::judge(held_out.as_ref(), &mut verdict);
        LearnReport {
            held_out,
            object: self.plan.object.to_string(),
            images: self.images.stored.n_received(),
            images_used: solved.adjusted.used().count(),
            rms_px: solved.adjusted.solution.rms_px,
            noise_ratio: solved.adjusted.noise_ratio(),
            kept: sought(false).map(|tag| tag.tag).collect(),
            weak: self.weak(solved),
            unsolved: Vec::new(),
            solved_sizes: Vec::new(),
            found: None,
            verdict,
            tags,
        }
    }

    fn tag(&self, solved: &SolvedConstellation, at: usize) -> LearnedTag {
        let solution = &solved.adjusted.solution;
        let counts = fitting(self.images.wanted.len(), &solved.views, &solved.adjusted)[at];
        let axes = |first: usize| {
            let row = 6 * at + first;
            [row, row + 1, row + 2].map(|r| solved.covariance[(r, r)].max(0.0).sqrt())
        };
        let (axes_mm, axes_deg) = (axes(0).map(|s| s * 1e3), axes(3).map(f64::to_degrees));
        let size_m = solution.bundle.tags[at].size_m;
        let sigma = solution
            .covariance
            .sigma(KeptParameter::TagSize { tag: at });
        LearnedTag {
            tag: self.images.wanted[at].tag.to_string(),
            images: counts.seen,
            left_out: counts.seen - counts.fits.min(counts.seen),
            elsewhere: counts.elsewhere,
            sigma_mm: root_mean_square(&axes_mm),
            sigma_deg: root_mean_square(&axes_deg),
            sigma_axes_mm: axes_mm,
            sigma_axes_deg: axes_deg,
            rms_px: rms_of(solved, at),
            size_ratio: size_m / self.images.wanted[at].size_m,
            size_ratio_sigma: sigma.unwrap_or(0.0),
        }
    }

    fn weak(&self, solved: &SolvedConstellation) -> Vec<Finding> {
        let weak = solved
            .adjusted
            .solution
            .weak
            .iter()
            .filter_map(|direction| {
                let (parameter, _) = direction.made_of.first()?;
                let (part, tag) = match *parameter {
                    KeptParameter::TagPosition { tag, .. } => (PosePart::Position, tag),
                    KeptParameter::TagRotation { tag, .. } => (PosePart::Attitude, tag),
                    _ => return None,
                };
                let tag = self.images.wanted[tag].tag;
                Some(Finding::WeakTag { tag, part })
            });
        let mut weak: Vec<Finding> = weak.collect();
        weak.dedup();
        weak
    }

    fn verdict(&self, tags: &[LearnedTag], solved: &SolvedConstellation) -> Verdict {
        let mut verdict = Verdict::new();
        if let Some(finding) = self.images.stored.thinned() {
            verdict.add(Grade::Good, finding);
        }
        let (well_mm, well_deg) = (WELL_PLACED.0 * 1e3, WELL_PLACED.1.to_degrees());
        for (factor, grade) in [(3.0, Grade::Poor), (1.0, Grade::Usable)] {
            let vague = tags.iter().filter(|t| {
                let excess = (t.sigma_mm / well_mm).max(t.sigma_deg / well_deg);
                excess > factor && (factor > 1.0 || excess <= 3.0)
            });
            let tags: Vec<String> = vague.map(|t| t.tag.clone()).collect();
            if !tags.is_empty() {
                let (mm, deg) = (well_mm * factor, well_deg * factor);
                verdict.add(grade, Finding::UncertainTags { tags, mm, deg });
            }
        }
        for tag in tags.iter().filter(|t| t.images - t.left_out < FEW_IMAGES) {
            let fits = tag.images - tag.left_out;
            let tag = tag.tag.clone();
            verdict.add(Grade::Usable, Finding::FewImages { tag, fits });
        }
        for tag in tags
            .iter()
            .filter(|t| t.elsewhere as f64 > MANY_LEFT_OUT * t.images as f64)
        {
            verdict.add(
                Grade::Usable,
                Finding::Elsewhere {
                    tag: tag.tag.clone(),
                    elsewhere: tag.elsewhere,
                    seen: tag.images,
                },
            );
        }
        judge_sizes(tags, &mut verdict);
        for (&tag, &images) in self.images.doubled() {
            verdict.add(Grade::Usable, Finding::Duplicated { tag, images });
        }
        for weak in self.weak(solved) {
            verdict.add(Grade::Poor, weak);
        }
        verdict
    }
}

/// Reports sizes that differ from the given ones; they are estimated.
fn judge_sizes(tags: &[LearnedTag], verdict: &mut Verdict) {
    for tag in tags {
        let off = tag.size_ratio - 1.0;
        if off.abs() > HARMLESS_SIZE && off.abs() > 4.0 * tag.size_ratio_sigma {
            verdict.add(
                Grade::Usable,
                Finding::SizesDiffer {
                    tags: vec![tag.tag.clone()],
                    ratio: tag.size_ratio,
                    scale: ScaleSource::OtherTags,
                },
            );
        }
    }
}

/// Root mean square of three deviations.
pub(crate) fn root_mean_square(axes: &[f64; 3]) -> f64 {
    (axes.iter().map(|s| s * s).sum::<f64>() / 3.0).sqrt()
}

fn rms_of(solved: &SolvedConstellation, tag: usize) -> f64 {
    let bundle = &solved.adjusted.solution.bundle;
    let own = bundle
        .residuals()
        .filter(|r| bundle.images[r.image].tags[r.seen].tag == tag);
    let squares: Vec<f64> = own.map(|r| r.rms_px().powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}
