//! Seeded random scenes by class: cameras, bodies with tags, motions, and the models given to fusion.

use nalgebra::{Point2, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_site_model::{
    Camera, CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, PoseSigma, Prior, Rig,
};

use crate::arm::{Arm, arm};
use crate::models::{made, tag};
use crate::motion::Motion;
use crate::random::Random;

pub const START_NS: u64 = 1_700_000_000_000_000_000;
pub const PERIOD_NS: u64 = 33_333_333;

macro_rules! classes {
    ($($name:literal $class:ident $says:literal)*) => {
        #[derive(Clone, Copy, PartialEq, Eq)]
        pub enum Class { $($class),* }
        /// Name, class and what is special about it.
        pub const CLASSES: &[(&str, Class, &str)] = &[$(($name, Class::$class, $says)),*];
    };
}

classes! {
    "base" Base "2 to 6 cameras around a cube or an irregular body, up to 0.5 m/s and 180 deg/s; \
     half of them fire at once"
    "lone" Lone "one camera"
    "pair" Pair "two cameras"
    "fast" Fast "up to 1.5 m/s and 360 deg/s"
    "jerks" Jerks "speeds change within 30 to 100 ms"
    "stop-and-go" StopAndGo "rest, haste, rest"
    "thrown" Thrown "free fall and bounces"
    "many" Many "3 to 6 bodies that hide one another"
    "bent" Bent "lenses with distortion as usual"
    "strongly-bent" StronglyBent "lenses with strong distortion"
    "bent-fitted" BentFitted "the same, corners as a detector's that fits one homography to a tag"
    "far" Far "tags of 6 to 12 px"
    "clocks" Clocks "clocks that are off by some 10 ms and drift, and nobody says so"
    "free" Free "cameras run free"
    "late" Late "images come up to 0.4 s late, in any order, twice or never"
    "rolling" Rolling "rolling shutters, stated"
    "stated-poses" StatedPoses "camera poses are wrong by what is stated: 0.3 to 2 mm and mrad"
    "calibrated-poses" CalibratedPoses "the same by 0.05 to 0.2 mm and mrad, as a calibration leaves them"
    "unstated-poses" UnstatedPoses "camera poses are wrong by 0.2 mm and 0.2 mrad, and nobody says so"
    "unstated-noise" UnstatedNoise "noise that nobody states"
    "other-noise" OtherNoise "noise of 0.4 to 2.5 times what is stated"
    "arm" Arm "articulated bodies of 2 to 4 links"
    "noisy-camera" NoisyCamera "one camera's noise is 3 to 8 times what is stated"
    "still" Still "bodies that never move"
    "still-lone" StillLone "the same, one camera"
    "slow" Slow "up to 0.02 m/s and 7 deg/s"
}

impl Class {
    fn is_bent(self) -> bool {
        matches!(self, Self::Bent | Self::StronglyBent | Self::BentFitted)
    }

    /// Whether bodies move anywhere in the images.
    fn is_wide(self) -> bool {
        self.is_bent() || self == Self::Many
    }
}

pub struct Body {
    pub model: ObjectModel,
    pub motion: Motion,
    pub arm: Option<Arm>,
}

impl Body {
    /// World from each link.
    pub fn links(&self, seconds: f64) -> Vec<Pose> {
        let base = self.motion.at(seconds);
        let arm = self.arm.as_ref();
        arm.map_or_else(|| vec![base], |arm| arm.links(&self.model, base, seconds))
    }
}

/// Error of the timestamps of a camera.
#[derive(Clone, Copy, Default)]
pub struct Clock {
    pub phase_s: f64,
    pub offset_s: f64,
    pub drift: f64,
    pub stated_error_ns: u64,
}

/// Transport of images to fusion: longest delay in seconds, and shares lost and duplicated.
pub struct Transport {
    pub most_s: f64,
    pub lost: f64,
    pub twice: f64,
}

/// A scene. Its fields can be changed before images are taken.
pub struct Scene {
    /// The true rig.
    pub truth: Rig,
    /// The rig given to fusion.
    pub stated: Rig,
    pub bodies: Vec<Body>,
    pub clocks: Vec<Clock>,
    pub sigma_px: f64,
    pub stated_sigma_px: Option<f64>,
    /// A camera with higher noise, and the factor.
    pub noisy: Option<(usize, f64)>,
    pub way: Transport,
    /// Whether corners are those of a homography fitted to the distorted tag.
    pub fitted: bool,
    pub seconds: f64,
}

/// An image in transit.
pub struct Shot {
    pub arrival_ns: u64,
    /// True capture time from the start of the scene, s.
    pub taken_s: f64,
    pub image: ImageObservation,
}

impl Scene {
    pub fn new(class: Class, seed: u64) -> Self {
        let random = &mut Random(seed.wrapping_mul(0x5851_f42d_4c95_7f2d) ^ class as u64);
        let seconds = 6.0;
        let sigma_px = random.log_within(0.01, 0.3);
        let truth = rig(class, random);
        let bodies = (0..if class == Class::Many {
            random.count(3, 6)
        } else {
            1
        })
            .map(|index| body(class, index, seconds, random))
            .collect();
        let (late, cameras) = (class == Class::Late, truth.cameras().len());
        Self {
            stated: stated(class, &truth, random),
            clocks: clocks(class, truth.cameras().len(), random),
            truth,
            bodies,
            sigma_px,
            stated_sigma_px: match class {
                Class::UnstatedNoise => None,
                Class::OtherNoise => Some(sigma_px / random.log_within(0.4, 2.5)),
                _ => Some(sigma_px),
            },
            noisy: (class == Class::NoisyCamera)
                .then(|| (seed as usize % cameras, random.within(3.0, 8.0))),
            way: Transport {
                most_s: if late { 0.4 } else { 0.012 },
                lost: if late { 0.05 } else { 0.0 },
                twice: if late { 0.1 } else { 0.0 },
            },
            fitted: class == Class::BentFitted,
            seconds,
        }
    }

    /// Standard deviation of the corners of a camera, px.
    pub fn noise_px(&self, camera: usize) -> f64 {
        match self.noisy {
            Some((noisy, times)) if noisy == camera => self.sigma_px * times,
            _ => self.sigma_px,
        }
    }
}

/// Pose of a camera at `from` that looks at `at`, with its x axis level.
fn looking(from: Vector3<f64>, at: Vector3<f64>) -> Pose {
    let down = Vector3::z().cross(&(at - from)).cross(&(at - from));
    let turn = UnitQuaternion::face_towards(&(at - from), &down);
    // face_towards has z forward and y towards the second vector.
    Pose::from_parts(from.into(), turn)
}

/// Cameras in a ring about the origin.
fn rig(class: Class, random: &mut Random) -> Rig {
    let n_cameras = match class {
        Class::Lone | Class::StillLone => 1,
        Class::Pair => 2,
        _ => random.count(2, 6),
    };
    let first = random.within(0.0, 6.0);
    let step = random.within(0.8, 1.2) * std::f64::consts::TAU / n_cameras.max(4) as f64;
    let camera = |index: usize| {
        let angle = first + step * (index as f64 + random.within(-0.2, 0.2));
        let distance = match class {
            Class::Far => random.within(1.8, 2.6),
            Class::Thrown => random.within(1.1, 1.5),
            _ => random.within(0.75, 1.3),
        };
        let level = Vector3::new(angle.cos(), angle.sin(), 0.0);
        let place = level * distance + Vector3::z() * (distance * random.within(0.3, 0.9));
        Camera::new(
            made(CameraId::new(&format!("cam{index}"))),
            [640, 480],
            lens(class, random),
            Some(looking(place, random.gaussian(0.04))),
        )
    };
    let mut cameras: Vec<Camera> = (0..n_cameras).map(camera).collect();
    if class == Class::Rolling {
        for camera in &mut cameras {
            let delay_s = random.within(1e-5, 4e-5);
            let sign = if random.count(0, 3) > 0 { 1.0 } else { -1.0 };
            camera.line_delay_s = Some(delay_s * sign);
        }
    }
    made(Rig::new(cameras))
}

fn lens(class: Class, random: &mut Random) -> Lens {
    let focal = random.within(520.0, 750.0);
    let intrinsics = Intrinsics {
        fx: focal,
        fy: focal * random.within(0.99, 1.01),
        cx: 319.5 + random.within(-8.0, 8.0),
        cy: 239.5 + random.within(-8.0, 8.0),
    };
    let k1 = match class {
        Class::Bent | Class::BentFitted => random.within(-0.28, -0.15),
        Class::StronglyBent => random.within(-0.42, -0.3),
        _ => return made(Lens::pinhole(intrinsics)),
    };
    let small = random.gaussian(0.0005);
    let distortion = [k1, 0.75 * k1 * k1, small.x, small.y, 0.0];
    made(Lens::brown_conrady(intrinsics, distortion))
}

/// The rig given to fusion.
fn stated(class: Class, truth: &Rig, random: &mut Random) -> Rig {
    let sigma = match class {
        Class::StatedPoses => random.log_within(0.0003, 0.002),
        Class::CalibratedPoses => random.log_within(0.00005, 0.0002),
        Class::UnstatedPoses => 0.0002,
        _ => return truth.clone(),
    };
    let mut cameras = truth.cameras().to_vec();
    for camera in &mut cameras {
        let (shift, turn) = (random.gaussian(sigma), random.gaussian(sigma));
        camera.world_from_camera = camera.world_from_camera.map(|pose| {
            let turned = UnitQuaternion::from_scaled_axis(turn) * pose.rotation;
            Pose::from_parts((pose.translation.vector + shift).into(), turned)
        });
        if class != Class::UnstatedPoses {
            camera.pose_prior = Prior::Sigma(PoseSigma {
                position_m: sigma,
                orientation_rad: sigma,
            });
        }
    }
    made(Rig::new(cameras))
}

fn clocks(class: Class, n_cameras: usize, random: &mut Random) -> Vec<Clock> {
    let at_once = class != Class::Free && random.count(0, 1) == 0;
    let period_s = PERIOD_NS as f64 * 1e-9;
    let clock = |camera: usize| Clock {
        phase_s: match at_once {
            true => 0.0,
            false if class == Class::Free => random.within(0.0, period_s),
            false => period_s * camera as f64 / n_cameras as f64,
        },
        ..match class {
            Class::Clocks => Clock {
                offset_s: if camera > 0 {
                    0.01 * random.gauss()
                } else {
                    0.0
                },
                drift: if camera > 0 {
                    3e-5 * random.gauss()
                } else {
                    0.0
                },
                stated_error_ns: ImageObservation::CLOCK_ERROR_UNKNOWN,
                ..Clock::default()
            },
            _ => Clock::default(),
        }
    };
    (0..n_cameras).map(clock).collect()
}

fn body(class: Class, index: usize, seconds: f64, random: &mut Random) -> Body {
    let mut motion = match class {
        Class::Still | Class::StillLone => Motion::smooth(0.0, 0.0, [0.15, 0.6], random),
        Class::Slow => Motion::smooth(0.02, 0.12, [0.15, 0.6], random),
        Class::Fast => Motion::smooth(1.5, std::f64::consts::TAU, [0.3, 1.2], random),
        Class::Jerks => Motion::jerky(seconds, random),
        Class::StopAndGo => Motion::stop_and_go(seconds, random),
        Class::Thrown => Motion::thrown(seconds, random),
        Class::Arm => Motion::smooth(0.2, 0.8, [0.15, 0.6], random),
        _ => Motion::smooth(0.5, std::f64::consts::PI, [0.15, 0.6], random),
    };
    if let (true, Motion::Smooth { middle, .. }) = (class.is_wide(), &mut motion) {
        // To the rims of the images.
        middle.translation.vector = random.gaussian(0.12);
    }
    let id = made(ObjectId::new(&format!("body{index}")));
    if class == Class::Arm {
        let (model, arm) = arm(id, random);
        return Body {
            model,
            motion,
            arm: Some(arm),
        };
    }
    let first = 20 * index as u32;
    let tags = if random.count(0, 1) == 0 {
        cube(first, random)
    } else {
        irregular(first, random)
    };
    Body {
        model: made(ObjectModel::new(id, tags)),
        motion,
        arm: None,
    }
}

fn cube(first: u32, random: &mut Random) -> Vec<ObjectTag> {
    let edge = random.within(0.05, 0.08);
    let turn =
        |about: Vector3<f64>| UnitQuaternion::from_scaled_axis(about * std::f64::consts::FRAC_PI_2);
    let (x, y) = (Vector3::x(), Vector3::y());
    let turns = [x * 0.0, x, x * 2.0, -x, y, -y].map(turn);
    let side = |(id, turn): (u32, UnitQuaternion<f64>)| {
        tag(
            first + id,
            0.67 * edge,
            turn * (Vector3::z() * 0.5 * edge),
            turn,
        )
    };
    (0..).zip(turns).map(side).collect()
}

/// Tags of several sizes that stand out on all sides.
fn irregular(first: u32, random: &mut Random) -> Vec<ObjectTag> {
    let n_tags = random.count(6, 10) as u32;
    let side = |id: u32| {
        // Directions spread over the sphere (golden spiral), each a bit off.
        let height = 1.0 - (2.0 * f64::from(id) + 1.0) / f64::from(n_tags);
        let (level, angle) = ((1.0 - height * height).sqrt(), 2.4 * f64::from(id));
        let even = Vector3::new(level * angle.cos(), level * angle.sin(), height);
        let out = (even + random.gaussian(0.15)).normalize();
        let upright = UnitQuaternion::face_towards(&out, random.direction().as_ref());
        let place = out * random.within(0.03, 0.055);
        tag(first + id, random.within(0.022, 0.045), place, upright)
    };
    (0..n_tags).map(side).collect()
}

/// Whether a pixel lies in the image.
pub fn is_inside(pixel: &Point2<f64>, [width, height]: [u32; 2]) -> bool {
    (0.0..f64::from(width)).contains(&pixel.x) && (0.0..f64::from(height)).contains(&pixel.y)
}
