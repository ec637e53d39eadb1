//! What became of the views of an instant, for good, and what they say of faults.

use super::update::Taken;
use super::{Track, seconds};
use crate::articulation::MOST_JOINTS;
use crate::filter::configuration::Configuration;
use crate::filter::consider::Displacing;
use crate::filter::corners::{Sight, View};
use crate::filter::kinematics::Kinematics;
use crate::filter::observed::Observed;
use crate::filter::shutter::Moving;
use crate::health::{Account, SettledView, Testimony};
use crate::site::{ObjectImage, Site};
use crate::{FusionOptions, PoseSigma};
use nalgebra::{Matrix6, SMatrix, Vector6};
use sextant_geometry::se3;

/// Places of the configuration of an object with links.
const WITH_JOINTS: usize = 6 + MOST_JOINTS;

/// The tracks at the instants next to one at which the object seems to have been hit, by cameras that agree with each other.
pub(crate) struct Around<'a> {
    pub before: &'a Track,
    pub after: &'a Track,
}

/// m/s² and rad/s² that a body may be accelerated by between two instants next to one.
const BETWEEN: [f64; 2] = [10.0, 100.0];

/// Where an object is in the eyes of a camera.
struct Seen<'a> {
    state: &'a Kinematics,
    camera_index: usize,
    configuration: Configuration,
    /// Whether its velocity is known well enough to tell time by.
    tells_time: bool,
    covariance: SMatrix<f64, WITH_JOINTS, WITH_JOINTS>,
    of_base: Matrix6<f64>,
}

/// Variance of a velocity, as a share of its square, up to which it tells time.
const TELLS_TIME: f64 = 0.05;

/// Where a view's link is.
struct Place<'a> {
    state: &'a Kinematics,
    camera_index: usize,
    link: Moving,
    /// Zero where it is not known well.
    twist: Vector6<f64>,
    covariance: Matrix6<f64>,
}

impl Track {
    /// Whether the object seems to have been hit before this instant.
    pub fn took_part_as_if_hit(&self) -> bool {
        let best = self.leading().hypotheses.first();
        best.is_some_and(|best| best.taken.iter().any(is_hit))
    }

    /// The density of acceleration learned, against its default.
    pub fn restlessness(&self) -> Option<f64> {
        let best = self.leading().hypotheses.first()?;
        Some(best.state.motion.factor())
    }

    /// What became of the views of this instant; none while the attitude is in doubt. `asked` are the cameras whose views are
    /// to say what they know of faults; those that took no part always do.
    pub fn settled_views(
        &self,
        images: &[&ObjectImage],
        site: &Site,
        options: &FusionOptions,
        asked: impl Fn(usize) -> bool,
        around: Option<Around<'_>>,
    ) -> Vec<SettledView> {
        let track = self.leading();
        let Some(best) = track.hypotheses.first().filter(|_| track.trusted) else {
            return Vec::new();
        };
        let sights = track.sights(images, site, options);
        let pairs = sights.iter().zip(&best.taken);
        let mut seen: Option<(usize, Role, Seen<'_>)> = None;
        let around = around.and_then(|around| around.seen(track.time_ns));
        let settled = pairs.map(|(sight, taken)| {
            let camera_index = sight.camera_index;
            let mut view = SettledView {
                camera_index,
                tag: sight.view.tag,
                agreed: taken.expected,
                hit: is_hit(taken),
                ray: None,
                elsewhere: None,
                account: None,
            };
            if let Some(around) = around.as_ref().filter(|_| view.hit) {
                let place = Place::between(around, sight.view);
                view.account = account(sight, Role::Aside, &place);
                return view;
            }
            if taken.part && !asked(camera_index) {
                return view;
            }
            let role = if taken.part { Role::Part } else { Role::Aside };
            let is_same = |(of, as_role, _): &(usize, Role, Seen<'_>)| {
                (*of, *as_role) == (camera_index, role)
            };
            if !seen.as_ref().is_some_and(is_same) {
                seen = Some((camera_index, role, track.seen_by(camera_index, role)));
            }
            let Some((_, _, seen)) = &seen else {
                return view;
            };
            if !taken.part {
                let size = sight
                    .camera
                    .size_of(sight.view, sight.bowed, &seen.configuration);
                let far = is_far(&size.unwrap_or_default());
                view.ray = far.then(|| sight.camera.ray_to(sight.view)).flatten();
            }
            view.account = account(sight, role, &Place::of(seen, sight.view));
            view
        });
        settled.collect()
    }

    /// What views say of it that are kept from this track, at or after its instant; none while the attitude is in doubt.
    pub fn views_aside(
        &self,
        image: &ObjectImage,
        site: &Site,
        options: &FusionOptions,
    ) -> Vec<SettledView> {
        let then = self.leading().predicted(image.capture_ns);
        if then.hypotheses.is_empty() || !then.trusted {
            return Vec::new();
        }
        let mut seen = then.seen_by(image.camera_index, Role::Aside);
        // How well its velocity tells time shows in what it foretells.
        seen.tells_time = true;
        let sights = then.sights(&[image], site, options);
        let aside = |sight: &Sight<'_>| SettledView {
            camera_index: image.camera_index,
            tag: sight.view.tag,
            agreed: false,
            hit: false,
            ray: None,
            elsewhere: None,
            account: account(sight, Role::Aside, &Place::of(&seen, sight.view)),
        };
        sights.iter().map(aside).collect()
    }

    /// That a clock may be off is one of the faults in question: it excuses no view that took no part.
    fn seen_by(&self, camera_index: usize, role: Role) -> Seen<'_> {
        let state = &self.hypotheses[0].state;
        let unknown = state.covariance.fixed_view::<3, 3>(6, 6).trace();
        let tells_time = unknown < TELLS_TIME * state.velocity().norm_squared();
        if state.joints.is_some() {
            let seen = observed::<WITH_JOINTS>(state, camera_index, role);
            return Seen {
                state,
                camera_index,
                tells_time,
                configuration: seen.configuration,
                of_base: seen.covariance.fixed_view::<6, 6>(0, 0).into_owned(),
                covariance: seen.covariance,
            };
        }
        let seen = observed::<6>(state, camera_index, role);
        Seen {
            state,
            camera_index,
            tells_time,
            configuration: seen.configuration,
            covariance: SMatrix::zeros(),
            of_base: seen.covariance,
        }
    }
}

fn observed<const D: usize>(state: &Kinematics, camera_index: usize, role: Role) -> Observed<D> {
    match role {
        Role::Part => state.observed(camera_index),
        Role::Aside => state.observed_on_time(camera_index),
    }
}

/// Where an object was seen before and after, how much of the time between has passed, and its seconds.
struct Between<'a> {
    ends: [Seen<'a>; 2],
    share: f64,
    span_s: f64,
}

impl<'a> Around<'a> {
    fn seen(&self, time_ns: u64) -> Option<Between<'a>> {
        let [before, after] = [self.before, self.after].map(|track| {
            let track = track.leading();
            let known = !track.hypotheses.is_empty() && track.trusted;
            known.then(|| (track.time_ns, track.seen_by(usize::MAX, Role::Aside)))
        });
        let ((from_ns, from), (to_ns, to)) = (before?, after?);
        let span_s = seconds(from_ns, to_ns);
        let share = seconds(from_ns, time_ns) / span_s;
        let ends = [from, to];
        let between = Between {
            ends,
            share,
            span_s,
        };
        (0.0..=1.0).contains(&share).then_some(between)
    }
}

impl<'a> Place<'a> {
    fn of(seen: &Seen<'a>, view: &View) -> Self {
        let at = &seen.configuration;
        let (twist, covariance) = match &view.limb {
            None => (at.rates.twist, seen.of_base),
            Some(limb) => (limb.twist(at), limb.covariance(at, &seen.covariance)),
        };
        Self {
            state: seen.state,
            camera_index: seen.camera_index,
            link: view.moving(at),
            twist: if seen.tells_time {
                twist
            } else {
                Vector6::zeros()
            },
            covariance,
        }
    }

    /// Where it was, if nothing hit it: on the way from the one to the other.
    fn between(between: &Between<'a>, view: &View) -> Self {
        let [from, to] = [0, 1].map(|end| Self::of(&between.ends[end], view));
        let (share, span_s) = (between.share, between.span_s);
        let step = se3::difference(&to.link.pose, &from.link.pose);
        let twist = step / span_s;
        let mut covariance =
            from.covariance * (1.0 - share).powi(2) + to.covariance * share.powi(2);
        let lag = 0.5 * share * (1.0 - share) * span_s.powi(2);
        for place in 0..6 {
            covariance[(place, place)] += (BETWEEN[place / 3] * lag).powi(2);
        }
        let link = Moving {
            pose: se3::perturb(&from.link.pose, &(step * share)),
            twist: from.link.twist.map(|_| twist),
        };
        Self {
            state: from.state,
            camera_index: from.camera_index,
            link,
            twist,
            covariance,
        }
    }
}

/// Whether a view is part of what is known of the pose.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Part,
    Aside,
}

fn is_hit(taken: &Taken) -> bool {
    taken.part && !taken.expected
}

fn account(sight: &Sight<'_>, role: Role, place: &Place<'_>) -> Option<Account> {
    let normal = sight.without_outliers().normal(&place.link)?;
    let world_from_link = place.link.pose;
    let testimony = Testimony {
        information: normal.information,
        gradient: normal.gradient,
        square: normal.scale.iter().sum(),
        weight: normal.weight(),
        world_from_link,
        twist: place.twist,
        world_from_tag: world_from_link * sight.view.object_from_tag,
        centre: sight.camera.centre,
        stated: [sight.camera.sigma, sight.view.tag_sigma]
            .map(|sigma| sigma.map_or(Vector6::zeros(), PoseSigma::variance)),
    };
    Some(Account {
        testimony,
        covariance: place.covariance,
        took_part: role == Role::Part,
        displacing: displacing(sight, place),
    })
}

/// What errors that last do to the link's pose as the view shows it.
fn displacing(sight: &Sight<'_>, place: &Place<'_>) -> Vec<Displacing> {
    let own: Vec<_> = sight.displacing(&place.link.pose).collect();
    match &sight.view.limb {
        None => place.state.displacing::<6>(place.camera_index, None, own),
        Some(limb) => {
            let link = limb.jacobian::<WITH_JOINTS>(&place.state.configuration());
            place.state.displacing(place.camera_index, Some(&link), own)
        }
    }
}

/// Corners' distance from where they should be, against their distance from the tag's centre, from which on a tag is not
/// loose but somewhere else.
const FAR: f64 = 2.5;

/// Whether a view with these sums of residuals shows the tag far from its place; one that can't be where it should be is.
fn is_far([_, distance, residual]: &[f64; 3]) -> bool {
    *residual >= FAR * FAR * distance
}
