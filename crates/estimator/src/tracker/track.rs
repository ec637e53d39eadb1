//! What is known about one object at one instant.

use nalgebra::{Matrix6, Vector6};
use sextant_geometry::{Pose, se3};

use crate::FusionOptions;
use crate::fading_counter::FadingCounter;
use crate::filter::covariance::white_acceleration;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::{TagView, ViewNoise, WeightedView};
use crate::measurement::planar_poses::area;
use crate::site::{ModelledSite, ObjectImage, SiteCamera};
use crate::time::seconds;
use crate::tracker::clock_knowledge::ClockKnowledge;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::noise_scales::NoiseScales;
use crate::tracker::view_outcome::InstantSummary;
use crate::tracker::{birth, branching};
use sextant_site_report::{ClockOffset, State};

/// What is known about an object at an instant. A value: the next instant's is made from it, never in place.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Track {
    /// The instant in ns.
    pub(crate) time_ns: u64,
    /// When a view last took part, in ns.
    pub(crate) seen_ns: u64,
    /// Since when images contradict everything known, in ns.
    pub(crate) contradicted_since_ns: Option<u64>,
    /// Since when the attitude is in doubt, in ns.
    pub(crate) doubtful_since_ns: Option<u64>,
    /// Whether the attitude has been beyond doubt since the object appeared.
    pub(crate) trusted: bool,
    /// Likeliest first; empty until the object is seen, and again when it is lost.
    pub(crate) hypotheses: Vec<Hypothesis>,
    /// How noisy the cameras' corners are.
    pub(crate) noise: NoiseScales,
    /// What is known about the cameras' clocks.
    pub(crate) timing: ClockKnowledge,
    /// Whether a view of the last images took part.
    pub(crate) took_part: bool,
    /// When a view of each camera last took part, by camera index, ns.
    pub(crate) participation: Vec<(usize, u64)>,
    /// Views of the last second, and those of them that contradict its pose; fading.
    pub(crate) views: FadingCounter,
    /// What the images of this instant contributed.
    pub(crate) summary: InstantSummary,
}

/// Residual of a tag's corners over its edge from which on it contradicts, however noisy its camera is taken to be;
/// less than a pixel never does.
const MOST_OFF: f64 = 0.06;
/// Views, fading, from which on the share of the refused ones means something, and the share from which on the images
/// contradict the track.
const FEWEST_VIEWS: f64 = 4.0;
const MOST_REFUSED: f64 = 0.6;

/// Share of its square by which the step of a corrected model counts as a variance of the pose.
const UNCERTAIN_MOTION: f64 = 0.25;

/// Nanoseconds for which a camera's agreement counts against another that contradicts: three images.
const LATELY_NS: u64 = 100_000_000;

/// By so much another rig may move an object whose track goes on, m and rad: a refinement moves it by less.
const MOVED_ALONG_M: f64 = 0.005;
const MOVED_ALONG_RAD: f64 = 0.01;

/// Factors on the variance of corners by which tags are tried to agree: blur and vibration come with a hit.
const MORE_NOISE: [f64; 3] = [1.0, 10.0, 100.0];

impl Track {
    /// The track after the images of an instant.
    pub(crate) fn stepped(
        &self,
        time_ns: u64,
        images: &[&ObjectImage],
        site: &ModelledSite,
        options: &FusionOptions,
    ) -> Self {
        let weighted_views = self.weighted_views(images, site, options);
        let followed = self
            .is_known_at(time_ns, options)
            .then(|| self.followed(time_ns, &weighted_views, options));
        let Some(followed) = followed else {
            return self.forgotten().born(time_ns, &weighted_views, options);
        };
        if followed.took_part && followed.agrees_with_most(&weighted_views) {
            return followed;
        }
        if !followed.took_part && followed.is_contradicted(options) {
            return self.born(time_ns, &weighted_views, options);
        }
        if self.others_agree_lately(time_ns, &weighted_views) {
            return followed;
        }
        let agreed = self.agreed(time_ns, &weighted_views, options);
        agreed
            .filter(|agreed| agreed.summary.tags > followed.summary.tags)
            .unwrap_or(followed)
    }

    /// The object by two or more tags of an image that agree with one another, with as much more noise as they need for
    /// that: as it moved before, or else anew.
    pub(crate) fn agreed(
        &self,
        time_ns: u64,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) -> Option<Self> {
        let same_camera = |pair: &[WeightedView<'_>]| pair[0].camera_index == pair[1].camera_index;
        if !weighted_views.windows(2).any(same_camera) {
            return None;
        }
        let agreed = |factor: &f64| {
            let noisier = weighted_views
                .iter()
                .map(|weighted| weighted.noisier(*factor));
            let noisier: Vec<WeightedView<'_>> = noisier.collect();
            let followed = self.followed(time_ns, &noisier, options);
            if followed.has_agreeing_tags(&noisier) {
                return Some(followed);
            }
            let born = self.born(time_ns, &noisier, options);
            born.has_agreeing_tags(&noisier).then_some(born)
        };
        MORE_NOISE.iter().find_map(agreed)
    }

    /// Whether the views that took part are more than the others.
    pub(crate) fn agrees_with_most(&self, weighted_views: &[WeightedView<'_>]) -> bool {
        let part = self.hypotheses.first().map_or(0, |best| {
            best.outcomes.iter().filter(|outcome| outcome.part).count()
        });
        2 * part > weighted_views.len()
    }

    /// Whether a camera without a view in this instant has lately agreed with the track and still does.
    pub(crate) fn others_agree_lately(
        &self,
        time_ns: u64,
        weighted_views: &[WeightedView<'_>],
    ) -> bool {
        let Some(best) = self.hypotheses.first() else {
            return false;
        };
        self.participation.iter().any(|(camera, part_ns)| {
            let is_late = part_ns.saturating_add(LATELY_NS) >= time_ns;
            is_late
                && !best.consistency.doubts(*camera)
                && !weighted_views
                    .iter()
                    .any(|weighted| weighted.camera_index == *camera)
        })
    }

    /// Whether two tags of one image agree with one another.
    pub(crate) fn has_agreeing_tags(&self, weighted_views: &[WeightedView<'_>]) -> bool {
        let outcome = self.hypotheses.first().map(|best| &best.outcomes);
        let pairs = outcome
            .into_iter()
            .flat_map(|outcome| weighted_views.iter().zip(outcome));
        let mut cameras: Vec<usize> = pairs
            .filter(|(_, outcome)| outcome.part)
            .map(|(weighted, _)| weighted.camera_index)
            .collect();
        cameras.sort_unstable();
        cameras.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// Whether anything is known at that instant.
    pub fn is_known_at(&self, time_ns: u64, options: &FusionOptions) -> bool {
        !self.hypotheses.is_empty() && seconds(self.seen_ns, time_ns) <= options.lost_s
    }

    pub(crate) fn weighted_views<'a>(
        &self,
        images: &[&'a ObjectImage],
        site: &'a ModelledSite,
        options: &FusionOptions,
    ) -> Vec<WeightedView<'a>> {
        let mut weighted_views =
            Vec::with_capacity(images.iter().map(|image| image.views.len()).sum());
        let usual = self.noise.usual();
        for image in images {
            let Some(camera) = site
                .cameras()
                .get(image.camera_index)
                .and_then(|camera| camera.posed.as_ref())
            else {
                continue;
            };
            let camera_index = image.camera_index;
            let clock = self.timing.clock(image, options);
            let weighted = |view: &'a TagView| {
                let noise = ViewNoise {
                    factor: self.noise.factor(camera_index, view.noise_source, &usual),
                    distortion_share: self.noise.distortion_share(camera_index),
                };
                WeightedView::new(camera_index, camera, view, noise, clock)
            };
            weighted_views.extend(image.views.iter().map(weighted));
        }
        weighted_views
    }

    pub(crate) fn followed(
        &self,
        time_ns: u64,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) -> Self {
        let dt = seconds(self.time_ns, time_ns);
        let follow = |one: &Hypothesis| one.followed(dt, weighted_views, options);
        let followed: Vec<_> = self.hypotheses.iter().map(follow).collect();
        let contradicted = followed.iter().all(|one| one.contradicted);
        let mut ways: Vec<_> = followed.into_iter().flat_map(|one| one.ways).collect();
        let is_wrong = |weighted: &WeightedView<'_>| {
            self.hypotheses[0]
                .consistency
                .is_wrong(weighted.camera_index)
        };
        if contradicted && !weighted_views.iter().all(is_wrong) {
            // Put elsewhere while nobody looked: worth its odds if the views agree among themselves.
            let mut elsewhere = birth::hypotheses(weighted_views, options);
            branching::penalise(&mut elsewhere, options.jolt_odds);
            ways.extend(elsewhere);
        }
        let mut next = self.with_hypotheses(time_ns, ways, weighted_views, options);
        if !next.took_part {
            next.contradicted_since_ns = self.contradicted_since_ns.or(Some(time_ns));
        }
        next
    }

    /// A track without hypotheses that keeps the noise scales and the clock offsets of a lost object, and since when it
    /// has been in doubt: estimates by stills far apart are published after as long a doubt as by images in a row.
    pub(crate) fn forgotten(&self) -> Self {
        let mut timing = self.timing.clone();
        if let Some(best) = self.hypotheses.first().filter(|_| self.trusted) {
            timing.learn(&best.state);
        }
        Self {
            noise: self.noise.clone(),
            timing,
            doubtful_since_ns: self.doubtful_since_ns,
            views: self.views,
            ..Self::default()
        }
    }

    pub(crate) fn born(
        &self,
        time_ns: u64,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) -> Self {
        self.forgotten().with_hypotheses(
            time_ns,
            birth::hypotheses(weighted_views, options),
            weighted_views,
            options,
        )
    }

    /// The track at an instant whose hypotheses are these.
    pub(crate) fn with_hypotheses(
        &self,
        time_ns: u64,
        mut hypotheses: Vec<Hypothesis>,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) -> Self {
        branching::weigh(&mut hypotheses, options);
        let mut next = Self {
            time_ns,
            hypotheses,
            noise: self.noise.clone(),
            trusted: self.trusted,
            timing: self.timing.clone(),
            participation: self.participation.clone(),
            views: self.views,
            ..Self::default()
        };
        if let Some(best) = next.hypotheses.first() {
            let summary = InstantSummary::new(&best.outcomes, weighted_views);
            next.took_part = summary.tags > 0;
            for (weighted, outcome) in weighted_views.iter().zip(&best.outcomes) {
                let most_square_px = 8.0 * (MOST_OFF.powi(2) * area(weighted)).max(1.0);
                let agrees = outcome.part && outcome.square_px <= most_square_px;
                next.views.add(time_ns, !agrees);
            }
            let pairs = weighted_views.iter().zip(&best.outcomes);
            let part = pairs.filter(|(_, outcome)| outcome.part);
            let cameras: Vec<usize> = part.map(|(weighted, _)| weighted.camera_index).collect();
            next.record_participation(&cameras, time_ns);
            let same_instant = self.time_ns == time_ns && !self.hypotheses.is_empty();
            next.summary = if same_instant {
                self.summary.joined(summary)
            } else {
                summary
            };
            // What was hit or not is no doubt about which corners are which.
            let of_one_attitude = next.is_of_one_attitude(options);
            next.seen_ns = if next.took_part {
                time_ns
            } else {
                self.seen_ns
            };
            if of_one_attitude {
                let noise = std::mem::take(&mut next.noise);
                next.noise = next.hypotheses[0].noise_after(noise, weighted_views, options);
            }
            let state = next.state(&next.covariance(), options);
            next.trusted |= state == State::Tracking && !next.is_ambiguous(options);
            let doubtful = state == State::Initialising;
            next.doubtful_since_ns = doubtful.then(|| self.doubtful_since_ns.unwrap_or(time_ns));
        }
        next
    }

    /// Records when cameras last took part; successive views of one camera are one entry.
    fn record_participation(&mut self, cameras: &[usize], time_ns: u64) {
        self.participation
            .retain(|(camera, _)| !cameras.contains(camera));
        for &camera in cameras {
            if self
                .participation
                .last()
                .is_none_or(|(last, _)| *last != camera)
            {
                self.participation.push((camera, time_ns));
            }
        }
    }

    /// Whether the images have contradicted for long enough to start anew; at once if nothing was certain yet.
    pub(crate) fn is_contradicted(&self, options: &FusionOptions) -> bool {
        !self.trusted
            || self
                .contradicted_since_ns
                .is_some_and(|since| seconds(since, self.time_ns) >= options.contradiction_s)
    }

    /// Share of the object's views in the last second that contradict its pose, where these are most; then nothing is
    /// known for certain.
    pub fn refused_share(&self, now_ns: u64) -> Option<f64> {
        let views = self.views.faded(now_ns);
        let share = views.share();
        (views.total >= FEWEST_VIEWS && share > MOST_REFUSED).then_some(share)
    }

    /// Clocks may have jumped, by a standard deviation of `sigma_s`.
    pub fn restart_clocks(&mut self, cameras: &[usize], sigma_s: f64) {
        self.timing.doubt(cameras);
        let states = self.hypotheses.iter_mut().map(|one| &mut one.state);
        for clocks in states.filter_map(|state| state.clocks.as_mut()) {
            cameras
                .iter()
                .for_each(|camera| clocks.doubt(*camera, sigma_s));
        }
        for one in &mut self.hypotheses {
            one.consistency.clear(cameras);
        }
    }

    /// Motion at this instant; `None` where the object is unknown.
    pub fn motion_estimate(&self) -> Option<MotionEstimate<'_>> {
        let state = &self.hypotheses.first()?.state;
        let configuration = state.configuration();
        Some(MotionEstimate {
            track: self,
            state,
            configuration,
        })
    }

    /// Moves the state along with corrected models, which changed the pose of the object from `before` to `after`.
    pub fn move_along(&mut self, before: &Pose, after: &Pose) {
        let motion = after * before.inverse();
        let step = se3::difference(after, before);
        for state in self.hypotheses.iter_mut().map(|one| &mut one.state) {
            state.pose = motion * state.pose;
            let mut of_pose = state.covariance.fixed_view_mut::<6, 6>(0, 0);
            of_pose += step * step.transpose() * UNCERTAIN_MOTION;
        }
    }

    /// Another rig is in force than that of these cameras.
    pub fn take_rig(&mut self, before: &[SiteCamera], site: &ModelledSite) {
        let Some(pose) = self.hypotheses.first().map(|best| best.state.pose) else {
            return;
        };
        let cameras = self.participation.iter();
        let lately = cameras.filter(|(_, at_ns)| at_ns + LATELY_NS >= self.seen_ns);
        let displaced = lately.map(|(camera, _)| {
            let former = before.get(*camera)?.posed.as_ref()?;
            let now = site.cameras().get(*camera)?.posed.as_ref()?;
            let magnified = now.lens.intrinsics().fx / former.lens.intrinsics().fx;
            let mut camera_from_object = former.camera_from_world * pose;
            camera_from_object.translation.vector *= magnified;
            let displaced = now.camera_from_world.inverse() * camera_from_object;
            let step = se3::difference(&displaced, &pose);
            let (by, turn) = (
                step.fixed_rows::<3>(0).norm(),
                step.fixed_rows::<3>(3).norm(),
            );
            (by <= MOVED_ALONG_M && turn <= MOVED_ALONG_RAD).then_some(displaced)
        });
        match displaced.collect::<Option<Vec<Pose>>>().as_deref() {
            Some([first, ..]) => self.move_along(&pose, first),
            Some([]) | None => {
                *self = Self {
                    time_ns: self.time_ns,
                    ..self.forgotten()
                };
            }
        }
    }

    /// From now on `by_s` seconds more are subtracted from the timestamps of a camera.
    pub fn shift_clock(&mut self, camera_index: usize, by_s: f64) {
        self.timing.shift(camera_index, by_s);
        for clocks in self
            .hypotheses
            .iter_mut()
            .filter_map(|one| one.state.clocks.as_mut())
        {
            clocks.take_off(camera_index, by_s);
        }
    }
}

/// Where an object is and how it moves.
pub(crate) struct MotionEstimate<'a> {
    track: &'a Track,
    state: &'a ObjectState,
    configuration: Configuration,
}

impl MotionEstimate<'_> {
    /// Pose of a view's link in the world, or of the object where it is rigid.
    pub fn pose(&self, view: &TagView) -> Pose {
        view.world_from_link(&self.configuration)
    }

    /// Its velocity and angular velocity, m/s and rad/s in world axes.
    pub fn twist(&self, view: &TagView) -> Vector6<f64> {
        let chain_link = view.chain_link.as_ref();
        chain_link.map_or(self.state.twist, |chain_link| {
            chain_link.twist(&self.configuration)
        })
    }

    /// Share of the distortion bias in a camera's corners.
    pub fn distortion_share(&self, camera_index: usize) -> f64 {
        self.track.noise.distortion_share(camera_index)
    }

    /// Factor on the variance of a camera's corners as it is configured or reported.
    pub fn noise_factor(&self, camera_index: usize, view: &TagView) -> f64 {
        let noise = &self.track.noise;
        noise.factor(camera_index, view.noise_source, &noise.usual())
    }

    /// Estimated offset of a camera's clock; `None` where the clock is right.
    pub fn clock_offset(&self, camera_index: usize) -> Option<ClockOffset> {
        let offsets = self.state.clock_offsets().into_iter();
        let mut own = offsets.filter(|(camera, _)| *camera == camera_index);
        own.next().map(|(_, offset)| offset)
    }

    /// Step (dt, dr) of a view's link within `dt` seconds and its covariance, m and rad in world axes.
    pub fn step(&self, view: &TagView, dt: f64) -> (Vector6<f64>, Matrix6<f64>) {
        let of_twist = self.state.covariance.fixed_view::<6, 6>(6, 6).into_owned();
        let accelerated = white_acceleration(dt, self.state.motion.process_noise_psd(dt));
        let twist = self.twist(view);
        let covariance = of_twist * dt.powi(2) + accelerated.fixed_view::<6, 6>(0, 0);
        (twist * dt, covariance)
    }
}

impl Hypothesis {
    /// Noise scales after the views of this instant.
    pub(crate) fn noise_after(
        &self,
        mut noise: NoiseScales,
        weighted_views: &[WeightedView<'_>],
        options: &FusionOptions,
    ) -> NoiseScales {
        let pairs = || weighted_views.iter().zip(&self.outcomes);
        for (weighted, outcome) in pairs() {
            let same_image = |other: &WeightedView<'_>| other.camera_index == weighted.camera_index;
            let image = || pairs().filter(|(other, _)| same_image(other));
            let right = image().filter(|(_, outcome)| outcome.part).count();
            let may_be_noise = || {
                NoiseScales::can_explain(
                    weighted,
                    &weighted.view.moving(&self.state.configuration()),
                )
            };
            // Wrong among right ones is no noise, nor is what is off by more than noise again and again while others
            // are right.
            let is_fault = || {
                2 * right > image().count()
                    || self.consistency.is_wrong(weighted.camera_index) && !may_be_noise()
            };
            if !outcome.part && is_fault() {
                continue;
            }
            noise.learn(weighted, outcome, options);
        }
        noise
    }
}
