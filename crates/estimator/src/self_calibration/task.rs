//! An adjustment as a task of its own: a copy of all that it needs, which any thread may solve while images go on being fused.

use std::sync::OnceLock;

use crate::self_calibration::adjustment::Adjustment;
use crate::self_calibration::imperfections::imperfections;
use crate::self_calibration::keyframes::Keyframes;
use crate::site::Site;
use crate::site::corrections::Corrections;
use sextant_site_report::Imperfection;

/// An adjustment of the site's files that is due: [`crate::Fusion::adjustment`] gives it out, [`crate::Input::Adjusted`] applies it.
#[derive(Debug)]
pub struct AdjustmentTask {
    adjustment: Adjustment,
    keyframes: Keyframes,
    site: Site,
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
}

impl AdjustmentTask {
    pub(crate) fn new(adjustment: &Adjustment, keyframes: &Keyframes, site: &Site) -> Self {
        Self {
            adjustment: adjustment.clone(),
            keyframes: keyframes.clone(),
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
            let corrections = adjustment.run(&mut keyframes, &self.site);
            let newest = keyframes.iter().last();
            let imperfections = corrections
                .as_ref()
                .map(|corrections| imperfections(corrections, &self.site, newest));
            Adjusted {
                adjustment,
                keyframes,
                corrections,
                imperfections: imperfections.unwrap_or_default(),
            }
        })
    }
}
