//! What a proposed calibration is worth: sites whose files are wrong in a known way, ten minutes of ordinary use, then
//! the proposal taken.
//!
//! A line a scene: residuals of the images held back before and after, px; rms error of poses of further images, mm and
//! degrees, by the files, by the proposal and by exact files. No image shows the frames of the world and of an object,
//! so that the rigid motions of both that fit best are taken off first.

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector6};
use sextant_estimator::{Fusion, FusionOptions, Input, Output};
use sextant_geometry::{Lens, Pose, se3};
use sextant_site_model::{Camera, ObjectModel, ObjectTag, Rig};
use sextant_site_report::Fault;

use crate::models::made;
use crate::random::Random;
use crate::scene::{Class, START_NS, Scene, Shot};

/// Seconds of use, and of further images.
const USE_S: f64 = 600.0;
const FURTHER_S: f64 = 20.0;
/// Seconds of further images that are not scored.
const SETTLING_S: f64 = 2.0;
/// Metres as which a radian counts where frames are fitted.
const LEVER_M: f64 = 0.1;

/// How files are wrong: tags by m and rad, cameras by m and rad, focal lengths by a share; one sigma an axis.
struct Error {
    name: &'static str,
    tags: (f64, f64),
    cameras: (f64, f64),
    focal: f64,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

const ERRORS: [Error; 6] = [
    Error {
        name: "none",
        tags: (0.0, 0.0),
        cameras: (0.0, 0.0),
        focal: 0.0,
    },
    Error {
        name: "tags 0.5 mm, 0.5 deg",
        tags: (0.0005, 0.5 * DEGREE),
        cameras: (0.0, 0.0),
        focal: 0.0,
    },
    Error {
        name: "tags 2 mm, 2 deg",
        tags: (0.002, 2.0 * DEGREE),
        cameras: (0.0, 0.0),
        focal: 0.0,
    },
    Error {
        name: "cameras 10 mm, 0.5 deg",
        tags: (0.0, 0.0),
        cameras: (0.01, 0.5 * DEGREE),
        focal: 0.0,
    },
    Error {
        name: "tags and cameras",
        tags: (0.002, 2.0 * DEGREE),
        cameras: (0.01, 0.5 * DEGREE),
        focal: 0.0,
    },
    Error {
        name: "focal length 0.5 %",
        tags: (0.0, 0.0),
        cameras: (0.0, 0.0),
        focal: 0.005,
    },
];

/// Runs the seeds of every kind of error.
pub fn examine(seeds: std::ops::Range<u64>) {
    for error in &ERRORS {
        for seed in seeds.clone() {
            println!("{:24} {seed}: {}", error.name, refined(error, seed));
        }
    }
}

fn refined(error: &Error, seed: u64) -> RefineOutcome {
    let scene = Scene::new(Class::Base, seed);
    let random = &mut Random(seed);
    let truth = SiteModels {
        rig: scene.truth.clone(),
        objects: scene.bodies.iter().map(|body| body.model.clone()).collect(),
    };
    let files = truth.wrong_by(error, random);
    let used = scene.shots(0.0, USE_S, random);
    let further = scene.shots(USE_S, USE_S + FURTHER_S, random);
    let mut machine = files.machine();
    let mut faults = std::collections::BTreeSet::new();
    for shot in &used {
        machine.handle(shot.arrival_ns, Input::Image(shot.image.clone()));
        while machine.poll_output().is_some() {}
        let is_of_clock = |fault: &&Fault| matches!(fault, Fault::ClockOff { .. });
        let named = machine.faults();
        let named = named.iter().filter(|fault| !is_of_clock(fault));
        faults.extend(named.map(ToString::to_string));
    }
    let proposal = machine.proposal();
    let refined = proposal.as_ref().map_or_else(
        || files.clone(),
        |proposal| SiteModels {
            rig: proposal.rig.clone().unwrap_or_else(|| files.rig.clone()),
            objects: if proposal.objects.is_empty() {
                files.objects.clone()
            } else {
                proposal.objects.clone()
            },
        },
    );
    RefineOutcome {
        cameras: scene.truth.cameras().len(),
        at_once: scene.clocks.iter().all(|clock| clock.phase_s == 0.0),
        noise_px: scene.sigma_px,
        held_back: proposal.map(|proposal| proposal.held_back),
        given: [&files, &refined, &truth].map(|models| error_of(models.given(), &scene, &further)),
        calibrating: [&files, &refined, &truth]
            .map(|models| error_of(models.machine(), &scene, &further)),
        faults: faults.into_iter().collect(),
    }
}

struct RefineOutcome {
    cameras: usize,
    /// Whether all cameras take their images at the same time.
    at_once: bool,
    noise_px: f64,
    held_back: Option<sextant_estimator::HeldBack>,
    /// Of poses by the models as they are: the files', the proposed, the exact; m and rad.
    given: [[f64; 2]; 3],
    /// The same with self-calibration at work.
    calibrating: [[f64; 2]; 3],
    faults: Vec<String>,
}

impl fmt::Display for RefineOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let how = if self.at_once { "at once" } else { "in turn" };
        write!(f, "{} cameras {how}, {:.3} px", self.cameras, self.noise_px)?;
        match &self.held_back {
            Some(held) => write!(
                f,
                ", {} held back {:.3} -> {:.3} px",
                held.n_images, held.before_px, held.after_px
            )?,
            None => write!(f, ", no proposal")?,
        }
        for (what, all) in [
            ("as given", &self.given),
            ("self-calibrating", &self.calibrating),
        ] {
            write!(f, "; {what}")?;
            for [position, attitude] in all {
                write!(
                    f,
                    " {:.3} mm {:.3} deg,",
                    position * 1e3,
                    attitude.to_degrees()
                )?;
            }
        }
        self.faults
            .iter()
            .try_for_each(|fault| write!(f, "\n    {fault}"))
    }
}

#[derive(Clone)]
struct SiteModels {
    rig: Rig,
    objects: Vec<ObjectModel>,
}

impl SiteModels {
    fn wrong_by(&self, error: &Error, random: &mut Random) -> Self {
        let camera = |camera: &Camera| {
            let pose = camera
                .world_from_camera
                .map(|pose| off(&pose, error.cameras.0, error.cameras.1, random));
            let mut numbers = camera.lens.parameters();
            let factor = 1.0 + error.focal * random.gauss();
            numbers[0] *= factor;
            numbers[1] *= factor;
            let lens = made(Lens::from_parameters(camera.lens.model(), &numbers));
            Camera {
                world_from_camera: pose,
                lens,
                ..camera.clone()
            }
        };
        let rig = made(Rig::new(self.rig.cameras().iter().map(camera).collect()));
        let mut object = |object: &ObjectModel| {
            let tag = |tag: &ObjectTag| ObjectTag {
                object_from_tag: tag
                    .object_from_tag
                    .map(|pose| off(&pose, error.tags.0, error.tags.1, random)),
                ..tag.clone()
            };
            made(ObjectModel::new(
                object.id().clone(),
                object.tags().iter().map(tag).collect(),
            ))
        };
        Self {
            rig,
            objects: self.objects.iter().map(&mut object).collect(),
        }
    }

    fn machine(&self) -> Fusion {
        made(Fusion::new(
            self.rig.clone(),
            self.objects.clone(),
            FusionOptions::default(),
        ))
    }

    /// Without self-calibration.
    fn given(&self) -> Fusion {
        let objects = self.objects.iter().cloned().map(ObjectModel::exact);
        let (rig, objects) = (self.rig.clone().exact(), objects.collect());
        made(Fusion::new(rig, objects, FusionOptions::default()))
    }
}

fn off(pose: &Pose, position_m: f64, orientation_rad: f64, random: &mut Random) -> Pose {
    let turn = UnitQuaternion::from_scaled_axis(random.gaussian(orientation_rad));
    Pose::from_parts(
        (pose.translation.vector + random.gaussian(position_m)).into(),
        turn * pose.rotation,
    )
}

/// Rms error of position and attitude, frames of world and object fitted.
fn error_of(mut machine: Fusion, scene: &Scene, shots: &[Shot]) -> [f64; 2] {
    let mut last = BTreeMap::new();
    for shot in shots {
        machine.handle(shot.arrival_ns, Input::Image(shot.image.clone()));
        while let Some(output) = machine.poll_output() {
            if let Output::Pose(estimate) = output {
                last.insert(
                    (estimate.object.clone(), estimate.capture_ns),
                    estimate.world_from_object,
                );
            }
        }
    }
    let mut pairs = Vec::new();
    for body in &scene.bodies {
        for ((object, time_ns), pose) in &last {
            let seconds = (time_ns - START_NS) as f64 * 1e-9;
            if object == body.model.id() && seconds > USE_S + SETTLING_S {
                pairs.push((*pose, body.links(seconds)[0]));
            }
        }
    }
    rms_of_fitted(&pairs)
}

/// Estimate = world motion * truth * object motion, by Gauss-Newton with numeric derivatives.
fn rms_of_fitted(pairs: &[(Pose, Pose)]) -> [f64; 2] {
    let (mut world, mut object) = (Pose::identity(), Pose::identity());
    let residual = |world: &Pose, object: &Pose, (pose, truth): &(Pose, Pose)| -> Vector6<f64> {
        se3::difference(pose, &(world * truth * object))
    };
    let moved = |world: &Pose, object: &Pose, at: usize, by: f64| {
        let mut step = Vector6::zeros();
        step[at % 6] = by;
        match at / 6 {
            0 => (se3::perturb(world, &step), *object),
            _ => (*world, se3::perturb(object, &step)),
        }
    };
    for _ in 0..6 {
        let mut information = DMatrix::<f64>::identity(12, 12) * 1e-9;
        let mut gradient = DVector::<f64>::zeros(12);
        for pair in pairs {
            let weighted = |mut error: Vector6<f64>| {
                error.fixed_rows_mut::<3>(3).scale_mut(LEVER_M);
                error
            };
            let here = weighted(residual(&world, &object, pair));
            let slopes: Vec<Vector6<f64>> = (0..12)
                .map(|at| {
                    let (world, object) = moved(&world, &object, at, 1e-6);
                    (weighted(residual(&world, &object, pair)) - here) / 1e-6
                })
                .collect();
            for row in 0..12 {
                gradient[row] += slopes[row].dot(&here);
                for column in 0..12 {
                    information[(row, column)] += slopes[row].dot(&slopes[column]);
                }
            }
        }
        let Some(factor) = information.cholesky() else {
            break;
        };
        let step = -factor.solve(&gradient);
        for at in 0..12 {
            (world, object) = moved(&world, &object, at, step[at]);
        }
    }
    let mut sums = [0.0; 2];
    for pair in pairs {
        let error = residual(&world, &object, pair);
        for (half, sum) in sums.iter_mut().enumerate() {
            *sum += error.fixed_rows::<3>(3 * half).norm_squared();
        }
    }
    sums.map(|sum| (sum / pairs.len().max(1) as f64).sqrt())
}
