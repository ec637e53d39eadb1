//! Estimates of an object as they are published.

use std::borrow::Cow;

use nalgebra::Matrix6;
use sextant_geometry::se3;

use crate::FusionOptions;
use crate::filter::covariance::{is_wider_than, symmetric};
use crate::time::seconds;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::track::Track;
use crate::tracker::view_outcome::InstantSummary;
use sextant_site_model::ObjectId;
use sextant_site_report::{ClockOffset, ObjectEstimate, State};

impl Track {
    /// The estimate for the time of a stamp, at or after this track's instant, less the seconds by which the clock is
    /// ahead; `None` where nothing worth publishing is known.
    pub fn estimate(
        &self,
        object: &ObjectId,
        stamp_ns: u64,
        ahead_s: f64,
        options: &FusionOptions,
    ) -> Option<ObjectEstimate> {
        let mut then = self.predicted(stamp_ns);
        if ahead_s != 0.0 {
            let summary = then.summary.clone();
            let ahead_ns = (ahead_s * 1e9).round() as i64;
            let capture_ns = stamp_ns.saturating_add_signed(ahead_ns.saturating_neg());
            let mut captured = then.predicted(capture_ns).into_owned();
            captured.summary = summary;
            then = Cow::Owned(captured);
        }
        let estimate = then.estimate_now(object, options)?;
        then.is_publishable(&estimate, options).then_some(estimate)
    }

    /// The last that is known of an object when it is lost.
    pub fn last_estimate(
        &self,
        object: &ObjectId,
        time_ns: u64,
        options: &FusionOptions,
    ) -> Option<ObjectEstimate> {
        let then = self.predicted(time_ns);
        let estimate = then.estimate_now(object, options)?;
        Some(ObjectEstimate {
            state: State::Lost,
            ..estimate
        })
    }

    pub(crate) fn estimate_now(
        &self,
        object: &ObjectId,
        options: &FusionOptions,
    ) -> Option<ObjectEstimate> {
        let best = self.hypotheses.first()?;
        let covariance = self.covariance();
        let (world_from_object, twist) = best.state.base();
        Some(ObjectEstimate {
            object: object.clone(),
            capture_ns: self.time_ns,
            world_from_object,
            covariance,
            twist,
            state: self.state(&covariance, options),
            cameras: self.summary.cameras,
            tags: self.summary.tags,
            rms_px: self.summary.rms_px(),
            articulated: self.articulated(),
        })
    }

    /// The clocks' offsets by camera index.
    pub fn clock_offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        let best = self.hypotheses.first();
        best.into_iter().flat_map(|best| best.state.clock_offsets())
    }

    /// The track at an instant of which there may be no image.
    pub(crate) fn predicted(&self, time_ns: u64) -> Cow<'_, Self> {
        let has_joints = |one: &Hypothesis| one.state.joints.is_some();
        if time_ns == self.time_ns && !self.hypotheses.iter().any(has_joints) {
            return Cow::Borrowed(self);
        }
        let mut then = self.clone();
        if time_ns != self.time_ns {
            let dt = seconds(self.time_ns, time_ns);
            then.time_ns = time_ns;
            then.summary = InstantSummary::default();
            for one in &mut then.hypotheses {
                one.state = one.state.predicted(dt);
            }
        }
        let states = then.hypotheses.iter_mut().map(|one| &mut one.state);
        for joints in states.filter_map(|state| state.joints.as_mut()) {
            joints.keep_within_limits();
        }
        Cow::Owned(then)
    }

    /// Of all that is possible, about the likeliest: the second moments of the mixture.
    pub fn covariance(&self) -> Matrix6<f64> {
        if let Some(covariance) = self.covariance_of_base() {
            return covariance;
        }
        let mut sum = Matrix6::zeros();
        let mut weights = 0.0;
        for one in &self.hypotheses {
            let weight = one.evidence.exp();
            let off = se3::difference(&one.state.pose, &self.hypotheses[0].state.pose);
            let own = one.state.pose_covariance();
            sum += (own + off * off.transpose()) * weight;
            weights += weight;
            if let Some((step, odds)) = one.twin() {
                let off = off + step;
                sum += (own + off * off.transpose()) * (weight * odds);
                weights += weight * odds;
            }
        }
        symmetric(&(sum / weights))
    }

    pub fn state(&self, covariance: &Matrix6<f64>, options: &FusionOptions) -> State {
        let vague = is_wider(covariance, options.vague_position, options.vague_attitude);
        if vague || self.refused_share(self.time_ns).is_some() {
            State::Initialising
        } else if self.summary.tags == 0 {
            State::Coasting
        } else {
            State::Tracking
        }
    }

    /// A prediction is worth saying while it is sharp, a doubtful attitude when it has been in doubt for long.
    pub(crate) fn is_publishable(
        &self,
        estimate: &ObjectEstimate,
        options: &FusionOptions,
    ) -> bool {
        let doubted_for = |since_ns: u64| seconds(since_ns, self.time_ns);
        let long_doubted = |since_ns: u64| doubted_for(since_ns) >= options.patience_s;
        let (position, attitude) = (options.coasting_position, options.coasting_attitude);
        match estimate.state {
            State::Initialising => {
                self.summary.tags > 0 && self.doubtful_since_ns.is_some_and(long_doubted)
            }
            // What the images of this very time contradict is no sharp prediction, whatever its covariance.
            State::Coasting => {
                self.contradicted_since_ns.is_none()
                    && !is_wider(&estimate.covariance, position, attitude)
            }
            State::Tracking | State::Lost => true,
        }
    }

    /// Whether all that is followed has about the same attitude.
    pub(crate) fn is_of_one_attitude(&self, options: &FusionOptions) -> bool {
        let mut pairs = self.hypotheses.iter().zip(self.hypotheses.iter().skip(1));
        pairs.all(|(a, b)| !a.is_turned_from(b, options))
    }

    /// Whether another attitude, followed or merely possible, is not unlikely enough.
    pub(crate) fn is_ambiguous(&self, options: &FusionOptions) -> bool {
        let Some(best) = self.hypotheses.first() else {
            return false;
        };
        if best.confirmed_odds < options.trusted_odds {
            return true;
        }
        let others = self.hypotheses.iter().skip(1);
        let rivals = others
            .filter(|other| best.is_turned_from(other, options))
            .map(|other| other.evidence);
        rivals
            .chain([best.mirrored])
            .any(|evidence| evidence > -options.trusted_odds)
    }
}

/// Whether one sigma along the worst axis exceeds the metres or the radians.
fn is_wider(covariance: &Matrix6<f64>, position: f64, attitude: f64) -> bool {
    let block = |from: usize| covariance.fixed_view::<3, 3>(from, from).into_owned();
    is_wider_than(&block(0), position.powi(2)) || is_wider_than(&block(3), attitude.powi(2))
}
