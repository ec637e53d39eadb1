//! Do the clocks agree that nobody vouches for, or that are in doubt for what their cameras contradict? Two tracks of the same
//! object are followed, one that takes the clocks at their word and a rival that estimates their offsets, until the evidence is
//! for one of them.
//!
//! The evidence is what the rival has found out: offsets that might as well be zero, or not. (How well either explains the
//! images says less: a track with wrong clocks refuses views, and one that knows nothing of its clocks pays for that.)

use crate::FusionOptions;
use crate::filter::clock_states::{ClockStates, Synchrony};
use crate::site::{ClockPrior, ObjectImage};
use crate::time::seconds;
use crate::tracker::track::Track;

/// Logarithm of the odds for agreeing clocks before anything is seen: most of them do.
const AGREEMENT: f64 = 3.0;

/// Seconds after which what was foretold counts 1/e: what the rival does not know at first is forgotten.
pub(crate) const RECENT_S: f64 = 0.2;

/// Seconds, of images, for which clocks are tried that were taken to agree.
const TRIAL_S: f64 = 1.0;

/// Sigma in seconds of an offset that is known.
const KNOWN_S: f64 = 0.001;

impl Track {
    /// Whether several cameras took their images in the very same nanosecond: free clocks never do, so that one clock
    /// triggers or stamps them all.
    pub(crate) fn is_simultaneous(&self, time_ns: u64, images: &[&ObjectImage]) -> bool {
        let others = self.time_ns == time_ns && self.took_part;
        (images.len() > 1 || others) && self.unvouched(images).next().is_some()
    }

    /// This track, as it were with clocks to be estimated; `None` where there is no question, or it is settled.
    pub(crate) fn clock_alternative(
        &self,
        time_ns: u64,
        images: &[&ObjectImage],
        options: &FusionOptions,
    ) -> Option<Self> {
        let asked = |camera| !self.timing.is_settled(camera, time_ns, options);
        if self.timing.open || !self.unvouched(images).any(asked) {
            return None;
        }
        let mut alternative = self.clone();
        alternative.timing.open = true;
        alternative.clear_standing(self.timing.doubted());
        Some(alternative)
    }

    /// The one of the two that explains the images, or both while that is open.
    pub(crate) fn select_clock_model(
        mut self,
        mut alternative: Self,
        options: &FusionOptions,
    ) -> Self {
        let age_s = self
            .alternative_since_ns
            .map_or(0.0, |since_ns| seconds(since_ns, self.time_ns));
        let asked: Vec<usize> = self.asked(&alternative).collect();
        let best = alternative.hypotheses.first();
        let mut heard = asked.clone();
        heard.retain(|camera| best.is_some_and(|best| !best.standing.doubts(*camera)));
        let agreement = alternative.agreement(&heard, options);
        let known = agreement.filter(|agreement| agreement.sigma_s < KNOWN_S);
        let odds = known.map_or(0.0, |known| known.odds + AGREEMENT);
        let is_trial = self.timing.are_doubted(&asked);
        let is_trial_over = is_trial && age_s > TRIAL_S;
        // What is not known closely may yet be told from nothing, if the images say so as well.
        let is_told = |of: Synchrony| of.odds + AGREEMENT < -options.trusted_odds;
        let is_won =
            is_trial_over && self.ahead < -options.hopeless_odds && agreement.is_some_and(is_told);
        if is_won || (odds < -options.trusted_odds && self.ahead < options.trusted_odds) {
            alternative.alternative_since_ns = None;
            return alternative;
        }
        let patience_s = match known {
            _ if is_trial => TRIAL_S,
            Some(_) => options.clock_patience_s,
            None => options.clock_recheck_s,
        };
        let is_refuted = age_s > 2.0 * RECENT_S && self.ahead > options.hopeless_odds;
        let is_behind = !is_trial_over && self.ahead < -options.hopeless_odds;
        if !is_behind && (odds > options.trusted_odds || is_refuted || age_s > patience_s) {
            let mut settled = asked;
            if is_trial {
                settled.extend(self.timing.doubted());
            }
            self.timing.settle(self.time_ns, &settled);
            self.alternative_since_ns = None;
        } else {
            self.alternative = Some(Box::new(alternative));
        }
        self
    }

    /// The cameras whose clocks the rival alone estimates.
    pub(crate) fn asked(&self, alternative: &Self) -> impl Iterator<Item = usize> {
        let cameras = |track: &Self| -> Vec<usize> {
            let clocks = track
                .hypotheses
                .first()
                .and_then(|best| best.state.clocks.as_deref());
            clocks.into_iter().flat_map(ClockStates::cameras).collect()
        };
        let vouched = cameras(self);
        cameras(alternative)
            .into_iter()
            .filter(move |camera| !vouched.contains(camera))
    }

    /// Whether the clocks of these cameras agree, by the likeliest attitude.
    pub(crate) fn agreement(&self, asked: &[usize], options: &FusionOptions) -> Option<Synchrony> {
        let best = self.hypotheses.first()?;
        let prior_s = options.unknown_clock_s;
        best.state.clock_agreement(prior_s, asked)
    }

    /// Whether the clocks that nobody vouches for are known not to agree, and by how much.
    pub fn knows_clocks(&self) -> bool {
        self.timing.open
    }

    /// What is to be published: the rival while it lives, for it knows what it does not know.
    pub(crate) fn leading(&self) -> &Self {
        self.alternative.as_deref().unwrap_or(self)
    }

    pub(crate) fn accepted(&self, image: &ObjectImage) -> ClockPrior {
        self.timing.accepted(image.camera_index, image.clock)
    }

    /// The cameras among these images whose clocks nobody vouches for, or not to be believed.
    pub(crate) fn unvouched<'a>(
        &'a self,
        images: &'a [&ObjectImage],
    ) -> impl Iterator<Item = usize> + 'a {
        let unknown = |image: &&&ObjectImage| self.accepted(image) == ClockPrior::Unknown;
        let unknown = images.iter().filter(unknown);
        unknown.map(|image| image.camera_index)
    }
}
