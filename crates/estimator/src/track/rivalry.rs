//! Do the clocks that nobody vouches for agree? Two tracks of the same object are followed, one that takes the clocks at
//! their word and a rival that estimates their offsets, until the evidence is for one of them.
//!
//! The evidence is the Bayesian one: estimating an offset that is zero explains the images no better and pays for its
//! freedom, ignoring one that is not costs a jolt at every image.

use super::{Track, seconds};
use crate::FusionOptions;
use crate::site::{ObjectImage, Site, StatedClock};

/// Logarithm of the odds for agreeing clocks before anything is seen: most of them do.
const AGREEMENT: f64 = 3.0;

/// Sigma in seconds of an offset that is known.
const KNOWN_S: f64 = 0.002;

impl Track {
    /// The track after the images of the instant `time_ns`, which is not before this one's.
    pub fn advanced(
        &self,
        time_ns: u64,
        images: &[&ObjectImage],
        site: &Site,
        options: &FusionOptions,
    ) -> Self {
        let mut next = self.stepped(time_ns, images, site, options);
        let rival = match &self.rival {
            Some(rival) => Some(rival.stepped(time_ns, images, site, options)),
            None if self.shares_shutter(time_ns, images) => {
                next.timing.settled_ns = Some(time_ns);
                None
            }
            None => self
                .challenger(time_ns, images, options)
                .map(|rival| rival.stepped(time_ns, images, site, options)),
        };
        next.rival_since_ns = rival
            .as_ref()
            .map(|_| self.rival_since_ns.unwrap_or(time_ns));
        match rival {
            Some(rival) => next.rivalled(rival, options),
            None => next,
        }
    }

    /// Whether several cameras took their images in the very same nanosecond: free clocks never do, so that one clock
    /// triggers or stamps them all.
    fn shares_shutter(&self, time_ns: u64, images: &[&ObjectImage]) -> bool {
        let unvouched = |image: &&ObjectImage| image.clock == StatedClock::Unknown;
        let others = self.time_ns == time_ns && self.took_part;
        (images.len() > 1 || others) && images.iter().any(unvouched)
    }

    /// This track, as it were with clocks to be estimated; `None` where there is no question, or it is settled.
    fn challenger(
        &self,
        time_ns: u64,
        images: &[&ObjectImage],
        options: &FusionOptions,
    ) -> Option<Self> {
        let unvouched = images
            .iter()
            .any(|image| image.clock == StatedClock::Unknown);
        let again = |settled_ns| seconds(settled_ns, time_ns) >= options.clock_recheck_s;
        if self.timing.open || !unvouched || !self.timing.settled_ns.is_none_or(again) {
            return None;
        }
        let mut rival = self.clone();
        rival.timing.open = true;
        rival.total = self.total - AGREEMENT;
        Some(rival)
    }

    /// The one of the two that explains the images, or both while that is open.
    fn rivalled(mut self, mut rival: Self, options: &FusionOptions) -> Self {
        let lead = rival.total - self.total;
        let age_s = self
            .rival_since_ns
            .map_or(0.0, |since_ns| seconds(since_ns, self.time_ns));
        if lead > options.trusted_odds {
            rival.rival_since_ns = None;
            return rival;
        }
        let settled = lead < -options.trusted_odds && rival.knows_clocks();
        if settled || age_s > options.clock_patience_s {
            self.timing.settled_ns = Some(self.time_ns);
            self.rival_since_ns = None;
        } else {
            self.rival = Some(Box::new(rival));
        }
        self
    }

    /// Whether all offsets are known so well that they would show; before, the rival only pays for its freedom.
    fn knows_clocks(&self) -> bool {
        let clocks = self
            .hypotheses
            .first()
            .and_then(|best| best.state.clocks.as_deref());
        clocks.is_some_and(|clocks| clocks.offsets().all(|(_, clock)| clock.sigma_s < KNOWN_S))
    }

    /// What is to be published: the rival while it lives, for it knows what it does not know.
    pub(super) fn leading(&self) -> &Self {
        self.rival.as_deref().unwrap_or(self)
    }
}
