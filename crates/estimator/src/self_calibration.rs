//! Self-calibration: errors of the camera poses, lenses, tag poses and tag sizes in the site's files, estimated from
//! ordinary images.
//!
//! A bounded set of keyframes (one object at one instant, as all cameras saw it) is adjusted jointly with the errors of
//! the site, each of which has a zero-mean Gaussian prior: the sigma given in the file, or the default of how such a
//! number comes about. The scale of each class of priors is estimated as well ([`variance_components`]), so that a site
//! whose files are exact is recognised as such and stays untouched, and one whose files are off by centimetres is
//! corrected by as much. What comes out are [`Corrections`] for the models that the trackers work with, and the
//! covariance that is left.
//!
//! The images determine neither the world frame nor the frame of an object: a rig that is wrong as a whole is another
//! world frame. The errors are therefore estimated with the least norm in units of their priors, and the covariance
//! that is left excludes the motions of the whole site ([`gauge`]). The uncertainty of an object's own frame and of the
//! common scale is reported apart.

pub(crate) mod accelerations;
pub(crate) mod adjustment;
pub(crate) mod arrow;
pub(crate) mod design_effect;
pub(crate) mod evidence;
pub(crate) mod gauge;
pub(crate) mod held_back;
pub(crate) mod imperfections;
pub(crate) mod keyframe_builder;
pub(crate) mod keyframes;
pub(crate) mod normal_equations;
pub(crate) mod parameters;
pub(crate) mod quarantine;
pub(crate) mod task;
pub(crate) mod variance_components;
pub(crate) mod view_rows;

pub use crate::self_calibration::held_back::HeldBack;
pub(crate) use crate::self_calibration::keyframes::Keyframe;
pub use crate::self_calibration::task::AdjustmentTask;
pub(crate) use crate::site::corrections::Corrections;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::self_calibration::adjustment::{Adjustment, LinearisedKeyframe};
use crate::self_calibration::held_back::HeldBackKeyframes;
use crate::self_calibration::keyframes::{FIRST, Keyframes};
use crate::self_calibration::quarantine::Quarantine;
use crate::site::ModelledSite;
use sextant_geometry::Pose;
use sextant_site_report::Imperfection;

/// Share by which the number of keyframes grows between adjustments: early ones change much, late ones little.
const GROWTH: f64 = 0.2;

/// Keyframes with which the site's imperfections are known but for details.
const YOUNG: usize = 10;
/// Keyframes that replace corrections whose own were forgotten.
const FORGOTTEN: usize = 40;
/// Time from one adjustment to the next for each keyframe of it, ns: several times what it takes to solve, whatever
/// moves.
const REST_NS: u64 = 4_000_000;

/// Up to when what an object shows has been offered to self-calibration.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Offered {
    /// Capture time of the last instant, ns.
    pub instant_ns: Option<u64>,
    /// End of the last stretch of time, ns; 0 before the first.
    pub stretch_ns: u64,
}

/// When an object appeared, and how well it has been seen since.
#[derive(Debug, Clone, Copy)]
struct Beginning {
    /// Capture time of its first keyframe, ns.
    first_ns: u64,
    /// Most keyframes of it at a time: those of many objects displace one another.
    n_keyframes: usize,
}

/// Keyframes and what they say about the site.
#[derive(Debug, Default)]
pub(crate) struct SelfCalibration {
    keyframes: Keyframes,
    held_back: HeldBackKeyframes,
    adjustment: Adjustment,
    quarantine: Quarantine,
    /// By object.
    beginnings: BTreeMap<usize, Beginning>,
    /// Keyframes added since the last adjustment.
    added: usize,
    /// Keyframes of the last adjustment.
    n_adjusted: usize,
    /// The adjustment that is due, and the keyframes that were added for it.
    due: Option<(Arc<AdjustmentTask>, usize)>,
    /// Present time before which no other becomes due, ns.
    rests_until_ns: u64,
    imperfections: Vec<Imperfection>,
    /// What the last adjustment corrects of the files, and what images say of it that are held back; `None` unless they
    /// are explained clearly better.
    proposal: Option<(Corrections, HeldBack)>,
    /// What the trackers work with.
    applied: Option<Corrections>,
}

impl SelfCalibration {
    /// Whether so little is known of an object that its newest instant is worth adjusting with each of its images.
    pub fn is_beginning(&self, object: usize) -> bool {
        let beginning = self.beginnings.get(&object);
        beginning.is_none_or(|beginning| beginning.n_keyframes < FIRST)
    }

    /// Whether contradictions are most likely imperfections of the site: little is known of it, or most of what is
    /// waits for the next adjustment.
    pub fn is_young(&self) -> bool {
        let n_keyframes = self.keyframes.len();
        self.n_adjusted.min(n_keyframes) < YOUNG || 2 * self.n_adjusted < n_keyframes
    }

    /// Whether the adjustment that is due is so small that an image may wait for it.
    pub fn is_due_at_once(&self) -> bool {
        self.due().is_some_and(|task| task.n_keyframes() < YOUNG)
    }

    /// Offers an instant of an object; it is kept where it shows something new. Some are held back from the adjustment
    /// and judge it.
    pub fn offer(&mut self, keyframe: Keyframe) {
        let Some(keyframe) = self.held_back.offer(keyframe, &self.keyframes) else {
            return;
        };
        let (object, time_ns) = (keyframe.object, keyframe.time_ns);
        if self.keyframes.offer(keyframe) {
            let beginning = self.beginnings.entry(object).or_insert(Beginning {
                first_ns: time_ns,
                n_keyframes: 0,
            });
            let n_keyframes = self.keyframes.count(object);
            beginning.n_keyframes = beginning.n_keyframes.max(n_keyframes);
            self.added += 1;
        }
    }

    /// Capture time of the first keyframe of an object, ns.
    pub fn first_ns(&self, object: usize) -> Option<u64> {
        Some(self.beginnings.get(&object)?.first_ns)
    }

    /// Keeps a keyframe until it is known whether it shows a fault.
    pub fn quarantine(&mut self, keyframe: Keyframe) {
        self.quarantine.hold(keyframe);
    }

    /// Offers the quarantined keyframes up to a time: they show no fault.
    pub fn release_quarantine(&mut self, until_ns: u64) {
        while let Some(keyframe) = self.quarantine.release(until_ns) {
            self.offer(keyframe);
        }
    }

    /// Timestamps of some cameras mean something else before and after: what these show of moving objects can't be
    /// compared with other images, nor are their offsets those of before. What is in quarantine may be from then.
    pub fn forget_clocks(&mut self, is_affected: impl Fn(usize) -> bool) {
        self.keyframes.forget_clocks(&is_affected);
        self.held_back.retain(|keyframe| keyframe.path.is_none());
        self.discard_quarantine();
        self.discard_adjustment();
        self.added = self.added.min(self.keyframes.len());
        self.adjustment.forget_clocks(is_affected);
    }

    /// The clock was set: what was learned stays, and objects that are known are not new again.
    pub fn forget_times(&mut self) {
        for beginning in self.beginnings.values_mut() {
            beginning.first_ns = 0;
        }
        self.rests_until_ns = 0;
    }

    /// Discards the quarantined keyframes: they may show a fault, or their times mean something else now.
    pub fn discard_quarantine(&mut self) {
        self.quarantine = Quarantine::default();
    }

    /// Prepares an adjustment if enough is new; there is one at a time. Where most keyframes had to be forgotten, the
    /// corrections in force stay until there are enough again: a few keyframes would make files right that are wrong.
    pub fn prepare(&mut self, now_ns: u64, site: &ModelledSite) {
        let enough = (GROWTH * self.keyframes.len() as f64).max(1.0);
        let is_enough = self.added as f64 >= enough;
        let knows_more = self.keyframes.len() < self.n_adjusted.min(FORGOTTEN);
        if is_enough && !knows_more && self.due.is_none() && now_ns >= self.rests_until_ns {
            let task =
                AdjustmentTask::new(&self.adjustment, &self.keyframes, &self.held_back, site);
            self.due = Some((Arc::new(task), std::mem::take(&mut self.added)));
            let rest_ns = self.keyframes.len() as u64 * REST_NS;
            self.rests_until_ns = now_ns.saturating_add(rest_ns);
        }
    }

    /// The adjustment that is due.
    pub fn due(&self) -> Option<&Arc<AdjustmentTask>> {
        self.due.as_ref().map(|(task, _)| task)
    }

    /// What the adjustment that is due was made from is no more: another one will be.
    pub fn discard_adjustment(&mut self) {
        if let Some((_, added)) = self.due.take() {
            self.added += added;
        }
    }

    /// Takes over what the adjustment that is due has found; whether the models of the site have changed by it.
    pub fn take_adjusted(&mut self, site: &mut ModelledSite) -> bool {
        let Some((task, _)) = self.due.take() else {
            return false;
        };
        self.n_adjusted = task.n_keyframes();
        let found = task.solution();
        let Some(corrections) = &found.corrections else {
            return false;
        };
        self.adjustment = found.adjustment.clone();
        self.keyframes.take_adjusted(&found.keyframes);
        self.imperfections.clone_from(&found.imperfections);
        self.proposal.clone_from(&found.proposal);
        let applied = self.applied.as_ref();
        if applied.is_some_and(|applied| corrections.is_close(applied)) {
            return false;
        }
        self.applied = Some(corrections.clone());
        site.correct(corrections);
        true
    }

    /// What a keyframe says of the site's errors against the models in force.
    pub fn linearised(&self, keyframe: Keyframe, site: &ModelledSite) -> LinearisedKeyframe {
        self.adjustment.linearised(keyframe, site)
    }

    /// Errors of the files that are worth a message.
    pub fn imperfections(&self) -> &[Imperfection] {
        &self.imperfections
    }

    /// The corrections of the files that are more than negligible, with what the images that are held back say of them;
    /// `None` unless these are explained clearly better.
    pub fn proposal(&self) -> Option<&(Corrections, HeldBack)> {
        self.proposal.as_ref()
    }

    /// The pose of an object in its newest adjusted keyframe as the trackers had it, and as it is after the last
    /// adjustment.
    pub fn moved(&self, object: usize) -> Option<(Pose, Pose)> {
        let newest = self.keyframes.newest_adjusted(object)?;
        Some((newest.before, newest.pose))
    }

    /// From now on `by_s` seconds more are subtracted from the timestamps of a camera.
    pub fn shift_clock(&mut self, camera_index: usize, by_s: f64) {
        self.discard_adjustment();
        self.adjustment.shift_clock(camera_index, by_s);
        let own = self.keyframes.iter_mut().chain(self.held_back.iter_mut());
        let views = own.flat_map(|keyframe| &mut keyframe.views);
        for one in views.filter(|one| one.camera_index == camera_index) {
            one.after_s -= by_s;
            one.clock_s -= by_s;
        }
    }

    /// The trackers have taken the corrections over, and moved along with them; so do the instants that wait for an
    /// adjustment.
    pub fn mark_applied(&mut self) {
        self.keyframes.move_along();
    }

    /// Forgets everything: the files have changed.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}
