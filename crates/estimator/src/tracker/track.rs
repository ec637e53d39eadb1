//! What is known about one object at one instant.

use nalgebra::{Matrix6, Vector6};
use sextant_geometry::{Pose, se3};

use crate::FusionOptions;
use crate::fading_counter::FadingCounter;
use crate::filter::covariance::white_acceleration;
use crate::filter::state::ObjectState;
use crate::kinematics::configuration::Configuration;
use crate::measurement::corners::TagView;
use crate::site::{ModelledSite, SiteCamera};
use crate::time::seconds;
use crate::tracker::clock_knowledge::ClockKnowledge;
use crate::tracker::hypothesis::Hypothesis;
use crate::tracker::noise_scales::NoiseScales;
use sextant_site_report::ClockOffset;

/// What is known about an object at an instant. A value: [`Track::advance`] makes the next instant's from it, never in
/// place.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Track {
    /// The instant in ns.
    pub(crate) time_ns: u64,
    /// When a view was last used, in ns.
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
    /// Whether a view of the last images was used.
    pub(crate) uses_views: bool,
    /// When a view of each camera was last used, by camera index, ns.
    pub(crate) participation: Vec<(usize, u64)>,
    /// Views of the last second, and those of them that contradict its pose; fading.
    pub(crate) views: FadingCounter,
    /// What the images of this instant contributed.
    pub(crate) summary: InstantSummary,
}

/// Contribution of the images of an instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct InstantSummary {
    /// Cameras of which a view is used.
    pub cameras: u32,
    /// Views that are used.
    pub tags: u32,
    /// Sum of their squared residuals in px².
    pub square_px: f64,
    /// Camera index of each view that is refused.
    pub refused: Vec<usize>,
}

impl InstantSummary {
    /// Joined with that of other images of the same instant.
    pub fn joined(&self, mut other: Self) -> Self {
        other.cameras += self.cameras;
        other.tags += self.tags;
        other.square_px += self.square_px;
        other.refused.extend(&self.refused);
        other
    }

    /// Root mean square of the residuals in pixels, over both axes.
    pub fn rms_px(&self) -> f64 {
        let residuals = 8.0 * f64::from(self.tags.max(1));
        (self.square_px / residuals).sqrt()
    }
}

/// Views, fading, from which on the share of the refused ones means something, and the share from which on the images
/// contradict the track.
const FEWEST_VIEWS: f64 = 4.0;
const MOST_REFUSED: f64 = 0.6;

/// Share of its square by which the step of a corrected model counts as a variance of the pose.
const UNCERTAIN_MOTION: f64 = 0.25;

/// Nanoseconds for which a camera's agreement counts against another that contradicts: three images.
pub(crate) const LATELY_NS: u64 = 100_000_000;

/// By so much another rig may move an object whose track goes on, m and rad: a refinement moves it by less.
const MOVED_ALONG_M: f64 = 0.005;
const MOVED_ALONG_RAD: f64 = 0.01;

impl Track {
    /// Whether anything is known at that instant.
    pub fn is_known_at(&self, time_ns: u64, options: &FusionOptions) -> bool {
        !self.hypotheses.is_empty() && seconds(self.seen_ns, time_ns) <= options.lost_s
    }

    /// A track without hypotheses that keeps the noise scales and the clock offsets of a lost object, and since when it
    /// has been in doubt: estimates by stills far apart are published after as long a doubt as by images in a row.
    pub fn reset(&self) -> Self {
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

    /// Share of the object's views in the last second that contradict its pose, where these are most; then nothing is
    /// known for certain.
    pub fn refused_share(&self, now_ns: u64) -> Option<f64> {
        let views = self.views.faded(now_ns);
        let share = views.share();
        (views.total >= FEWEST_VIEWS && share > MOST_REFUSED).then_some(share)
    }

    /// The clocks' offsets by camera index.
    pub fn clock_offsets(&self) -> impl Iterator<Item = (usize, ClockOffset)> {
        let best = self.hypotheses.first();
        best.into_iter().flat_map(|best| best.state.clock_offsets())
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
                    ..self.reset()
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
