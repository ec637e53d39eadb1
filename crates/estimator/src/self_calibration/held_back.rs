//! Keyframes held back from the adjustment: they judge whether corrections of the files explain images that had no part
//! in them.
//!
//! Each of them is explained once with the models of the files and once with the corrected ones, the best pose found
//! anew each time. With g = ln(rms before / rms after) of a keyframe, corrections are better where the mean of g over
//! the keyframes is at least [`LEAST_GAIN`] and at least [`SIGNIFICANT`] times its standard error (a paired t test;
//! logarithms, so that no single bad image decides).

use std::collections::{BTreeMap, BTreeSet};

use crate::measurement::corners::CalibratedCamera;
use crate::self_calibration::adjustment::Adjustment;
use crate::self_calibration::keyframes::{Keyframe, Keyframes};
use crate::site::ModelledSite;
use crate::site::corrections::{CameraCorrection, Corrections};

/// Keyframes of an object before any is held back: the first ones are needed more for the adjustment.
const LEAST_ADJUSTED: usize = 20;
/// Of so many further ones, one is held back.
const PERIOD: usize = 4;
/// Most keyframes; the oldest go.
const MOST: usize = 48;
/// Fewer keyframes judge nothing.
const LEAST: usize = 8;
/// Mean logarithm of the residuals before over those after.
const LEAST_GAIN: f64 = 0.05;
/// Mean over standard error: one in several hundred by chance.
const SIGNIFICANT: f64 = 3.0;
/// Corners of a view.
const CORNERS: f64 = 4.0;
/// Smallest square of a keyframe that is distinguished from zero, px^2.
const LEAST_SQUARE: f64 = 1e-12;

/// How images that had no part in a correction are explained before and after it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldBack {
    /// Number of instants at which an object was seen.
    pub n_images: usize,
    /// Rms distance between corners as seen and as expected, by the files, px.
    pub before_px: f64,
    /// With the correction, px.
    pub after_px: f64,
}

/// Keyframes that the adjustment never sees, oldest first.
#[derive(Debug, Clone, Default)]
pub(crate) struct HeldBackKeyframes {
    keyframes: Vec<Keyframe>,
    /// New keyframes since the last that was held back.
    passed: usize,
}

/// Squares of one instant by the views that two models both explain, px², and the number of these.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SquaresPair {
    before: f64,
    after: f64,
    n_views: usize,
}

impl HeldBackKeyframes {
    /// Holds a keyframe back, or gives it back for the adjustment.
    pub fn offer(&mut self, new: Keyframe, adjusted: &Keyframes) -> Option<Keyframe> {
        let is_same = |one: &Keyframe| one.key() == new.key();
        if let Some(same) = self.keyframes.iter_mut().find(|one| is_same(one)) {
            if new.views.len() > same.views.len() {
                *same = new;
            }
            return None;
        }
        let is_well_known = adjusted.count(new.object) >= LEAST_ADJUSTED;
        if !is_well_known || adjusted.has(&new) || adjusted.show(&new) {
            return Some(new);
        }
        self.passed += 1;
        if self.passed < PERIOD {
            return Some(new);
        }
        self.passed = 0;
        if self.keyframes.len() >= MOST {
            self.keyframes.remove(0);
        }
        self.keyframes.push(new);
        None
    }

    /// The keyframes, oldest first.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Keyframe> {
        self.keyframes.iter_mut()
    }

    /// Keeps those that a condition holds for.
    pub fn retain(&mut self, is_kept: impl FnMut(&Keyframe) -> bool) {
        self.keyframes.retain(is_kept);
    }

    /// What the keyframes say of corrections; `None` unless they are explained clearly better.
    pub fn judge(
        &self,
        adjustment: &Adjustment,
        corrections: &Corrections,
        site: &ModelledSite,
    ) -> Option<HeldBack> {
        if self.keyframes.len() < LEAST {
            return None;
        }
        let models = [&Corrections::default(), corrections];
        let models = models.map(|corrections| (corrections, self.cameras(corrections, site)));
        let pairs = self.keyframes.iter().filter_map(|keyframe| {
            let [before, after] = models.each_ref().map(|(corrections, cameras)| {
                adjustment.squares_px(corrected(keyframe, corrections, site), cameras)
            });
            SquaresPair::from_squares(&before, &after)
        });
        HeldBack::judged(&pairs.collect::<Vec<SquaresPair>>())
    }

    /// The cameras of the keyframes with corrections of the files' models, by index.
    fn cameras(
        &self,
        corrections: &Corrections,
        site: &ModelledSite,
    ) -> BTreeMap<usize, CalibratedCamera> {
        let views = self.keyframes.iter().flat_map(|keyframe| &keyframe.views);
        let seen: BTreeSet<usize> = views.map(|one| one.camera_index).collect();
        let corrected = |camera: usize| {
            let correction = corrections.cameras.get(&camera).copied();
            let correction = correction.unwrap_or(CameraCorrection::NONE);
            let posed = site.file_camera(camera)?.corrected(&correction);
            Some((camera, posed))
        };
        seen.into_iter().filter_map(corrected).collect()
    }
}

impl HeldBack {
    /// What instants that had no part say of the second models; `None` unless these explain them clearly better.
    pub(crate) fn judged(pairs: &[SquaresPair]) -> Option<Self> {
        is_better(pairs).then(|| Self {
            n_images: pairs.len(),
            before_px: rms_px(pairs, |pair| pair.before),
            after_px: rms_px(pairs, |pair| pair.after),
        })
    }
}

impl SquaresPair {
    /// From the squares of each view by the two models; `None` where both explain less than two.
    pub fn from_squares(before: &[Option<f64>], after: &[Option<f64>]) -> Option<Self> {
        let both = before.iter().zip(after);
        let both = both.filter_map(|(before, after)| (*before).zip(*after));
        let mut pair = Self {
            before: 0.0,
            after: 0.0,
            n_views: 0,
        };
        for (before, after) in both {
            pair.before += before;
            pair.after += after;
            pair.n_views += 1;
        }
        // The pose takes up nearly all that a single view shows.
        (pair.n_views > 1).then_some(pair)
    }

    fn gain(&self) -> f64 {
        0.5 * (self.before.max(LEAST_SQUARE) / self.after.max(LEAST_SQUARE)).ln()
    }
}

fn is_better(pairs: &[SquaresPair]) -> bool {
    if pairs.len() < LEAST {
        return false;
    }
    let n = pairs.len() as f64;
    let mean = pairs.iter().map(SquaresPair::gain).sum::<f64>() / n;
    let squares = pairs.iter().map(|pair| (pair.gain() - mean).powi(2));
    let standard_error = (squares.sum::<f64>() / (n - 1.0) / n).sqrt();
    let falls = rms_px(pairs, |pair| pair.after) < rms_px(pairs, |pair| pair.before);
    falls && mean >= LEAST_GAIN && mean >= SIGNIFICANT * standard_error
}

fn rms_px(pairs: &[SquaresPair], square: impl Fn(&SquaresPair) -> f64) -> f64 {
    let n_views: usize = pairs.iter().map(|pair| pair.n_views).sum();
    let sum: f64 = pairs.iter().map(square).sum();
    (sum / (CORNERS * n_views.max(1) as f64)).sqrt()
}

/// A keyframe with corrections of the files' tags.
fn corrected(keyframe: &Keyframe, corrections: &Corrections, site: &ModelledSite) -> Keyframe {
    let mut keyframe = keyframe.clone();
    for one in &mut keyframe.views {
        let correction = corrections.tags.get(&one.view.tag);
        if let Some(place) = site.placement(&one.view.tag) {
            let file = &place.file;
            let tag = correction.map_or_else(|| file.clone(), |correction| correction.tag(file));
            one.view.set_model(&tag);
        }
    }
    keyframe
}
