//! What became of the views of an instant, for good, and what they say of faults.

use crate::filter::observed_configuration::ObservedConfiguration;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::Configuration;
use crate::measurement::biases::BiasJacobian;
use crate::measurement::corners::{TagView, WeightedView};
use crate::measurement::pose_innovation::{PoseInnovation, ViewResidual};
use crate::measurement::ray::Ray;
use crate::measurement::rolling_shutter::LinkMotion;
use crate::site::{ObjectImage, Site};
use crate::tracker::track::Track;
use crate::tracker::view_outcome::ViewOutcome;
use crate::{FusionOptions, PoseSigma, TagId};
use nalgebra::{Matrix6, SMatrix, Vector6};
use sextant_site_model::MOST_JOINTS;

/// Where a tag is that is far from where its object has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SeenOn {
    /// Where the object of this index is.
    On(usize),
    /// Where no object is.
    Nowhere,
}

/// A view of an instant that is settled.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FinalisedView {
    pub camera_index: usize,
    pub tag: TagId,
    /// Whether it agreed with the track.
    pub agreed: bool,
    /// Whether it took part, but as if the object had been hit.
    pub hit: bool,
    /// The ray on which it is seen, if that is far from where its object has it.
    pub ray: Option<Ray>,
    /// What is there.
    pub elsewhere: Option<SeenOn>,
    /// What it says of faults, if it was asked.
    pub residual: Option<ViewResidual>,
}

/// Places of the configuration of an object with links.
const WITH_JOINTS: usize = 6 + MOST_JOINTS;

/// Where an object is in the eyes of a camera.
struct PredictedObject<'a> {
    state: &'a ObjectState,
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
struct PredictedLink<'a> {
    state: &'a ObjectState,
    camera_index: usize,
    link: LinkMotion,
    /// Zero where it is not known well.
    twist: Vector6<f64>,
    covariance: Matrix6<f64>,
}

impl Track {
    /// The density of acceleration learned, against its default.
    pub fn process_noise_psd(&self) -> Option<f64> {
        let best = self.leading().hypotheses.first()?;
        Some(best.state.motion.factor())
    }

    /// What became of the views of this instant; none while the attitude is in doubt. `asked` are the cameras whose views are
    /// to say what they know of faults; those that took no part always do.
    pub fn finalised_views(
        &self,
        images: &[&ObjectImage],
        site: &Site,
        options: &FusionOptions,
        asked: impl Fn(usize) -> bool,
    ) -> Vec<FinalisedView> {
        let track = self.leading();
        let Some(best) = track.hypotheses.first().filter(|_| track.trusted) else {
            return Vec::new();
        };
        let weighted_views = track.weighted_views(images, site, options);
        let pairs = weighted_views.iter().zip(&best.taken);
        let mut seen: Option<(usize, Role, PredictedObject<'_>)> = None;
        let settled = pairs.map(|(weighted, taken)| {
            let camera_index = weighted.camera_index;
            let mut view = FinalisedView {
                camera_index,
                tag: weighted.view.tag,
                agreed: taken.expected,
                hit: is_hit(taken),
                ray: None,
                elsewhere: None,
                residual: None,
            };
            if taken.part && !asked(camera_index) {
                return view;
            }
            let role = if taken.part {
                Role::Used
            } else {
                Role::Excluded
            };
            let is_same = |(of, as_role, _): &(usize, Role, PredictedObject<'_>)| {
                (*of, *as_role) == (camera_index, role)
            };
            if !seen.as_ref().is_some_and(is_same) {
                seen = Some((camera_index, role, track.seen_by(camera_index, role)));
            }
            let Some((_, _, seen)) = &seen else {
                return view;
            };
            if !taken.part {
                let size = weighted.camera.size_of(
                    weighted.view,
                    weighted.distortion_share,
                    &seen.configuration,
                );
                let far = is_far(&size.unwrap_or_default());
                view.ray = far.then(|| weighted.camera.ray_to(weighted.view)).flatten();
            }
            view.residual = residual(weighted, role, &PredictedLink::of(seen, weighted.view));
            view
        });
        settled.collect()
    }

    /// What views say of it that are kept from this track, at or after its instant; none while the attitude is in doubt.
    pub fn excluded_views(
        &self,
        image: &ObjectImage,
        site: &Site,
        options: &FusionOptions,
    ) -> Vec<FinalisedView> {
        let then = self.leading().predicted(image.capture_ns);
        if then.hypotheses.is_empty() || !then.trusted {
            return Vec::new();
        }
        let mut seen = then.seen_by(image.camera_index, Role::Excluded);
        // How well its velocity tells time shows in what it foretells.
        seen.tells_time = true;
        let weighted_views = then.weighted_views(&[image], site, options);
        let aside = |weighted: &WeightedView<'_>| FinalisedView {
            camera_index: image.camera_index,
            tag: weighted.view.tag,
            agreed: false,
            hit: false,
            ray: None,
            elsewhere: None,
            residual: residual(
                weighted,
                Role::Excluded,
                &PredictedLink::of(&seen, weighted.view),
            ),
        };
        weighted_views.iter().map(aside).collect()
    }

    /// That a clock may be off is one of the faults in question: it excuses no view that took no part.
    fn seen_by(&self, camera_index: usize, role: Role) -> PredictedObject<'_> {
        let state = &self.hypotheses[0].state;
        let unknown = state.covariance.fixed_view::<3, 3>(6, 6).trace();
        let tells_time = unknown < TELLS_TIME * state.velocity().norm_squared();
        if state.joints.is_some() {
            let seen = observed::<WITH_JOINTS>(state, camera_index, role);
            return PredictedObject {
                state,
                camera_index,
                tells_time,
                configuration: seen.configuration,
                of_base: seen.covariance.fixed_view::<6, 6>(0, 0).into_owned(),
                covariance: seen.covariance,
            };
        }
        let seen = observed::<6>(state, camera_index, role);
        PredictedObject {
            state,
            camera_index,
            tells_time,
            configuration: seen.configuration,
            covariance: SMatrix::zeros(),
            of_base: seen.covariance,
        }
    }
}

fn observed<const D: usize>(
    state: &ObjectState,
    camera_index: usize,
    role: Role,
) -> ObservedConfiguration<D> {
    match role {
        Role::Used => state.observed(camera_index),
        Role::Excluded => state.observed_on_time(camera_index),
    }
}

impl<'a> PredictedLink<'a> {
    pub(crate) fn of(seen: &PredictedObject<'a>, view: &TagView) -> Self {
        let at = &seen.configuration;
        let (twist, covariance) = match &view.chain_link {
            None => (at.rates.twist, seen.of_base),
            Some(chain_link) => (
                chain_link.twist(at),
                chain_link.covariance(at, &seen.covariance),
            ),
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
}

/// Whether a view is part of what is known of the pose.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Used,
    Excluded,
}

fn is_hit(taken: &ViewOutcome) -> bool {
    taken.part && !taken.expected
}

fn residual(
    weighted: &WeightedView<'_>,
    role: Role,
    place: &PredictedLink<'_>,
) -> Option<ViewResidual> {
    let normal = weighted.without_outliers().normal(&place.link)?;
    let world_from_link = place.link.pose;
    let innovation = PoseInnovation {
        information: normal.information,
        gradient: normal.gradient,
        square: normal.scale.iter().sum(),
        weight: normal.weight(),
        world_from_link,
        twist: place.twist,
        world_from_tag: world_from_link * weighted.view.object_from_tag,
        centre: weighted.camera.centre,
        camera_variance: given_variance(weighted.camera.sigma),
        tag_variance: given_variance(weighted.view.tag_sigma),
    };
    Some(ViewResidual {
        innovation,
        covariance: place.covariance,
        took_part: role == Role::Used,
        displacing: displacing(weighted, place),
    })
}

fn given_variance(sigma: Option<PoseSigma>) -> Vector6<f64> {
    sigma.map_or(Vector6::zeros(), PoseSigma::variance)
}

/// What errors that last do to the link's pose as the view shows it.
fn displacing(weighted: &WeightedView<'_>, place: &PredictedLink<'_>) -> Vec<BiasJacobian> {
    let own: Vec<_> = weighted.displacing(&place.link.pose).collect();
    match &weighted.view.chain_link {
        None => place.state.displacing::<6>(place.camera_index, None, own),
        Some(chain_link) => {
            let link = chain_link.jacobian::<WITH_JOINTS>(&place.state.configuration());
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
