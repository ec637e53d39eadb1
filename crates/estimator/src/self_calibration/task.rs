//! An adjustment as a task of its own: a copy of all that it needs, which any thread may solve while images go on being
//! fused.

use std::sync::OnceLock;

use crate::self_calibration::adjustment::Adjustment;
use crate::self_calibration::held_back::{HeldBack, HeldBackKeyframes};
use crate::self_calibration::imperfections::imperfections;
use crate::self_calibration::keyframes::Keyframes;
use crate::site::ModelledSite;
use crate::site::corrections::Corrections;
use sextant_site_report::Imperfection;

/// An adjustment of the site's files that is due: [`crate::Fusion::task`] gives it out,
/// [`crate::Input::Adjusted`] applies it.
#[derive(Debug)]
pub struct AdjustmentTask {
    adjustment: Adjustment,
    keyframes: Keyframes,
    held_back: HeldBackKeyframes,
    site: ModelledSite,
    solution: OnceLock<Adjusted>,
}

/// What an adjustment has found.
#[derive(Debug)]
pub(crate) struct Adjusted {
    pub adjustment: Adjustment,
    pub keyframes: Keyframes,
    /// `None` where numbers ended.
    pub corrections: Option<Corrections>,
    pub imperfections: Vec<Imperfection>,
    /// What it corrects of the files, where images that are held back are explained clearly better.
    pub proposal: Option<(Corrections, HeldBack)>,
}

impl AdjustmentTask {
    pub(crate) fn new(
        adjustment: &Adjustment,
        keyframes: &Keyframes,
        held_back: &HeldBackKeyframes,
        site: &ModelledSite,
    ) -> Self {
        Self {
            adjustment: adjustment.clone(),
            keyframes: keyframes.clone(),
            held_back: held_back.clone(),
            site: site.clone(),
            solution: OnceLock::new(),
        }
    }

    pub(crate) fn n_keyframes(&self) -> usize {
        self.keyframes.len()
    }

    /// Whether it has been solved.
    pub fn is_solved(&self) -> bool {
        self.solution.get().is_some()
    }

    /// Solves it, which takes up to some tenths of a second; the same task always has the same solution.
    pub fn solve(&self) {
        self.solution();
    }

    pub(crate) fn solution(&self) -> &Adjusted {
        self.solution.get_or_init(|| {
            let (mut adjustment, mut keyframes) = (self.adjustment.clone(), self.keyframes.clone());
            for keyframe in keyframes.iter_mut().filter(|one| !one.is_adjusted) {
                adjustment.align(keyframe, &self.site);
                keyframe.is_adjusted = true;
            }
            let corrections = adjustment.run(&mut keyframes, &self.site);
            let newest = keyframes.iter().last();
            let imperfections = corrections
                .as_ref()
                .map(|corrections| imperfections(corrections, &self.site, newest));
            let proposal = corrections
                .as_ref()
                .and_then(|corrections| self.proposal(&adjustment, corrections));
            Adjusted {
                adjustment,
                keyframes,
                corrections,
                imperfections: imperfections.unwrap_or_default(),
                proposal,
            }
        })
    }

    /// The corrections that are more than negligible, with what the images that are held back say of them.
    fn proposal(
        &self,
        adjustment: &Adjustment,
        corrections: &Corrections,
    ) -> Option<(Corrections, HeldBack)> {
        let file_lens = |camera| Some(&self.site.file_camera(camera)?.lens);
        let corrections = corrections.for_files(file_lens);
        if corrections.cameras.is_empty() && corrections.tags.is_empty() {
            return None;
        }
        let judged = self.held_back.judge(adjustment, &corrections, &self.site)?;
        Some((corrections, judged))
    }
}
