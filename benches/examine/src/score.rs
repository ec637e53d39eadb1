//! Score of a scene: pose errors, consistency of the covariance, and reported faults.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use nalgebra::Matrix6;
use sextant_estimator::{Fusion, FusionOptions, Input, Output};
use sextant_evaluation::{Consistency, PoseError, Spread};
use sextant_geometry::{Pose, se3};
use sextant_site_report::{ObjectEstimate, State};

use crate::models::made;
use crate::random::Random;
use crate::scene::{START_NS, Scene, Shot};
use crate::view::information;

/// Sums over poses.
#[derive(Default, Clone)]
pub struct Score {
    scenes: usize,
    in_band: usize,
    /// Errors of poses, m and rad.
    errors: [Vec<f64>; 2],
    consistency: Consistency,
    /// Instants at which a body was visible, and those of them with a pose.
    seen: f64,
    covered: f64,
    flips: usize,
    /// Squared errors and their Cramér-Rao bounds, at instants with two simultaneous views.
    of_two: [[f64; 2]; 2],
    /// Errors of poses predicted by [`AHEAD_S`], m and rad.
    ahead: [Vec<f64>; 2],
    /// Largest difference between orders of arrival.
    disorder: f64,
    pub faults: BTreeSet<String>,
    pub n_faults: usize,
}

/// Attitude error beyond which a pose counts as flipped, rad.
const FLIP: f64 = 0.35;
/// Prediction horizon, s.
const AHEAD_S: f64 = 0.033;
/// Time after which a scene is scored, s.
const SETTLED_S: f64 = 0.5;

fn seconds_of(time_ns: u64) -> f64 {
    (time_ns as i128 - START_NS as i128) as f64 * 1e-9
}

/// Runs fusion on the images of a scene and scores its poses.
pub fn examined(scene: &Scene, shots: &[Shot]) -> Score {
    let mut score = Score {
        scenes: 1,
        ..Score::default()
    };
    let models = || scene.bodies.iter().map(|body| body.model.clone()).collect();
    let mut fusion = made(Fusion::new(
        scene.stated.clone(),
        models(),
        FusionOptions::default(),
    ));
    let (mut last, mut by_time) = (BTreeMap::new(), InformationByTime::new());
    for shot in shots {
        add_information(scene, shot, &mut by_time);
        fusion.handle(shot.arrival_ns, Input::Image(shot.image.clone()));
        while let Some(output) = fusion.poll_output() {
            let Output::Pose(estimate) = output else {
                continue;
            };
            let mut bodies = scene.bodies.iter();
            let body = bodies.position(|body| *body.model.id() == estimate.object);
            let key = (body.unwrap_or(0), estimate.capture_ns);
            let best = by_time.get(&key).filter(|(cameras, _)| cameras.len() > 1);
            let best = best.map(|(_, sum)| *sum);
            last.insert(key, PublishedEstimate { estimate, best });
        }
        score.foresee(scene, shot, &fusion);
        let said = fusion.faults();
        score.faults.extend(said.iter().map(ToString::to_string));
    }
    score.n_faults = score.faults.len();
    for ((body, time_ns), said) in &last {
        score.take(scene, *body, *time_ns, said);
    }
    score.cover(scene, shots, &last);
    let mean = score.consistency.mean_nees() / 6.0;
    score.in_band = usize::from((0.7..1.5).contains(&mean));
    score
}

/// Cameras with images of a rigid body, and the sum of their information, by body and capture time.
type InformationByTime = BTreeMap<(usize, u64), (BTreeSet<usize>, Matrix6<f64>)>;

/// The last estimate of an instant.
struct PublishedEstimate {
    estimate: ObjectEstimate,
    /// Information of the images received by then, if two of them show the body.
    best: Option<Matrix6<f64>>,
}

fn add_information(scene: &Scene, shot: &Shot, by_time: &mut InformationByTime) {
    let mut cameras = scene.truth.cameras().iter();
    let camera = cameras.position(|camera| camera.id == shot.image.camera);
    let camera = camera.unwrap_or(0);
    for (body, one) in scene.bodies.iter().enumerate() {
        if one.arm.is_none() && sees(scene, body, shot) {
            let sum = by_time.entry((body, shot.image.capture_ns)).or_default();
            if sum.0.insert(camera) {
                sum.1 += information(scene, camera, body, shot.taken_s);
            }
        }
    }
}

fn sees(scene: &Scene, body: usize, shot: &Shot) -> bool {
    let tags = scene.bodies[body].model.tags();
    let is_of = |id| tags.iter().any(|tag| tag.tag == id);
    shot.image.tags.iter().any(|seen| is_of(seen.tag))
}

impl Score {
    fn take(
        &mut self,
        scene: &Scene,
        body: usize,
        time_ns: u64,
        PublishedEstimate { estimate, best }: &PublishedEstimate,
    ) {
        let seconds = seconds_of(time_ns);
        if seconds < SETTLED_S || estimate.state == State::Lost {
            return;
        }
        let links = scene.bodies[body].links(seconds);
        let mut errors = vec![(estimate.world_from_object, estimate.covariance, links[0])];
        if let Some(articulated) = &estimate.articulated {
            let others = articulated.links.iter().zip(&links);
            errors = others
                .map(|(link, truth)| (link.world_from_link, link.covariance, *truth))
                .collect();
        }
        for (pose, covariance, truth) in errors {
            let error = PoseError::between(&pose, &truth);
            let halves = [error.position_m(), error.attitude_rad()];
            self.consistency
                .add(error.nees(&covariance).unwrap_or(f64::INFINITY));
            for (errors, half) in self.errors.iter_mut().zip(halves) {
                errors.push(half);
            }
            if halves[1] > FLIP && estimate.state == State::Tracking {
                self.flips += 1;
            }
            let bound = best.and_then(Matrix6::cholesky).map(|root| root.inverse());
            if let (Some(bound), State::Tracking) = (bound, estimate.state) {
                for (half, error) in halves.iter().enumerate() {
                    self.of_two[half][0] += error.powi(2);
                    self.of_two[half][1] += bound.fixed_view::<3, 3>(3 * half, 3 * half).trace();
                }
            }
        }
    }

    /// Asks for the poses a little after an image, where clocks are right.
    fn foresee(&mut self, scene: &Scene, shot: &Shot, fusion: &Fusion) {
        let time_ns = shot.image.capture_ns + (AHEAD_S * 1e9) as u64;
        for (body, one) in scene.bodies.iter().enumerate() {
            if shot.taken_s < SETTLED_S || !sees(scene, body, shot) {
                continue;
            }
            if let Some(ahead) = fusion.pose_at(one.model.id(), time_ns) {
                let truth = one.links(shot.taken_s + AHEAD_S)[0];
                let error = PoseError::between(&ahead.world_from_object, &truth);
                self.ahead[0].push(error.position_m());
                self.ahead[1].push(error.attitude_rad());
            }
        }
    }

    fn cover(
        &mut self,
        scene: &Scene,
        shots: &[Shot],
        last: &BTreeMap<(usize, u64), PublishedEstimate>,
    ) {
        for body in 0..scene.bodies.len() {
            let of_body = |shot: &&Shot| shot.taken_s > SETTLED_S && sees(scene, body, shot);
            let times: BTreeSet<u64> = shots
                .iter()
                .filter(of_body)
                .map(|shot| (shot.taken_s * 1e3) as u64)
                .collect();
            self.seen += times.len() as f64;
            let poses = last
                .iter()
                .filter(|((of, _), said)| *of == body && said.estimate.state == State::Tracking);
            let poses: BTreeSet<u64> = poses
                .map(|((_, time_ns), _)| (seconds_of(*time_ns) * 1e3) as u64)
                .collect();
            self.covered += times
                .iter()
                .filter(|time| poses.range(**time - 20..**time + 21).next().is_some())
                .count() as f64;
        }
    }

    pub fn join(&mut self, other: &Self) {
        self.scenes += other.scenes;
        self.in_band += other.in_band;
        self.consistency.join(&other.consistency);
        self.seen += other.seen;
        self.covered += other.covered;
        self.flips += other.flips;
        self.n_faults += other.n_faults;
        self.disorder = self.disorder.max(other.disorder);
        for half in 0..2 {
            self.ahead[half].extend(&other.ahead[half]);
            self.errors[half].extend(&other.errors[half]);
            (0..2).for_each(|of| self.of_two[half][of] += other.of_two[half][of]);
        }
    }

    /// Compares what is known at the end with what is after another order of arrival.
    pub fn compare(&mut self, scene: &Scene, shots: &[Shot], random: &mut Random) {
        let end_ns = shots
            .iter()
            .map(|shot| shot.image.capture_ns)
            .max()
            .unwrap_or(0);
        let mut order: Vec<&Shot> = shots
            .iter()
            .filter(|shot| shot.image.capture_ns + 450_000_000 > end_ns)
            .collect();
        let straight = known(scene, &order, end_ns);
        for index in (1..order.len()).rev() {
            order.swap(index, random.count(0, index));
        }
        for pair in straight.iter().zip(&known(scene, &order, end_ns)) {
            self.disorder = self.disorder.max(match pair {
                (Some(a), Some(b)) => gap(a, b),
                (None, None) => 0.0,
                _ => f64::INFINITY,
            });
        }
    }
}

fn gap(a: &ObjectEstimate, b: &ObjectEstimate) -> f64 {
    let apart = |a: &Pose, b: &Pose| se3::difference(a, b).amax();
    let of_links = a
        .articulated
        .iter()
        .zip(&b.articulated)
        .flat_map(|(a, b)| a.links.iter().zip(&b.links));
    let of_links = of_links.map(|(a, b)| {
        apart(&a.world_from_link, &b.world_from_link).max((a.covariance - b.covariance).amax())
    });
    let of_base = apart(&a.world_from_object, &b.world_from_object);
    of_links.fold(
        of_base
            .max((a.covariance - b.covariance).amax())
            .max((a.twist - b.twist).amax()),
        f64::max,
    )
}

/// What is known of all bodies at the images' times once all have come.
fn known(scene: &Scene, shots: &[&Shot], now_ns: u64) -> Vec<Option<ObjectEstimate>> {
    let models = || scene.bodies.iter().map(|body| body.model.clone()).collect();
    let mut fusion = made(Fusion::new(
        scene.stated.clone(),
        models(),
        FusionOptions::default(),
    ));
    shots
        .iter()
        .for_each(|shot| fusion.handle(now_ns, Input::Image(shot.image.clone())));
    let times: BTreeSet<u64> = shots.iter().map(|shot| shot.image.capture_ns).collect();
    let at = |time_ns: u64| {
        scene
            .bodies
            .iter()
            .map(move |body| (body.model.id(), time_ns))
    };
    times
        .into_iter()
        .flat_map(at)
        .map(|(id, time_ns)| fusion.pose_at(id, time_ns))
        .collect()
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let spread = |values: &Vec<f64>| Spread::from_values(values.iter().copied());
        let errors = self.errors.each_ref().map(spread);
        let rms = errors.map(|errors| errors.map_or(f64::NAN, |errors| errors.rms));
        let worst = errors.map(|errors| errors.map_or(f64::NAN, |errors| errors.max));
        let ahead = self.ahead.each_ref().map(spread);
        let ahead = ahead.map(|ahead| ahead.map_or(f64::NAN, |ahead| ahead.p95));
        let ratio = |half: usize| (self.of_two[half][0] / self.of_two[half][1]).sqrt();
        write!(
            f,
            "mm {:.4} deg {:.4} worst {:.3} {:.2}  NEES {:.3} inside {:.3}  covered {:.3}  bound \
             {:.2} {:.2}  ahead {:.2} {:.2}  flips {}  faults {}  order {:.0e}  in band {} of {}",
            rms[0] * 1e3,
            rms[1].to_degrees(),
            worst[0] * 1e3,
            worst[1].to_degrees(),
            self.consistency.mean_nees() / 6.0,
            self.consistency.within_95(),
            self.covered / self.seen,
            ratio(0),
            ratio(1),
            ahead[0] * 1e3,
            ahead[1].to_degrees(),
            self.flips,
            self.n_faults,
            self.disorder,
            self.in_band,
            self.scenes,
        )
    }
}
