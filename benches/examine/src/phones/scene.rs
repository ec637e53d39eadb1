//! The scene: a cube and a column with tags on all sides, carried about a table among four phones.
//!
//! Each phone has a lens of its own: 65 degrees of view along the width within 10 %, with some distortion. Its shutter
//! rolls for 20 ms, its exposure follows the light (up to 16 ms, under lamps on mains), its colours are interpolated.
//! World frame: z up, the table at height 0.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_simulator::{
    AutoExposure, Background, Flicker, Light, Mosaic, Path, Random, Scenario, SceneCamera,
    SceneObject, SceneTag, Solid, Wave,
};
use sextant_tag_families::Family;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Images a second of a film; Chromium plays every MJPEG file at this rate.
pub const RATE_HZ: f64 = 30.0;
/// Edge of all tags, m.
const TAG_M: f64 = 0.07;
/// Edge of the cube, and of the square ends of the column, m.
const EDGE_M: f64 = 0.1;
/// Length of the column, m.
const COLUMN_M: f64 = 0.2;
/// Mean place of both objects, m.
const MIDDLE: [f64; 3] = [0.0, 0.0, 0.45];
/// Half the distance between the objects, m: they cannot touch.
const APART_M: f64 = 0.16;
/// Focal length as a share of the width, for 65 degrees, and its relative error.
const FOCAL: f64 = 0.785;
const FOCAL_ERROR: f64 = 0.1;
const READOUT_S: f64 = 0.02;
const NAMES: [&str; 4] = ["north", "east", "south", "west"];

/// What is to be rendered.
pub struct Wanted {
    pub seed: u64,
    /// Width and height, px.
    pub resolution: [u32; 2],
    /// Length of a film and period of all paths, s.
    pub seconds: u32,
}

pub fn scenario(wanted: &Wanted) -> Scenario {
    let mut random = Random::new(wanted.seed);
    let cameras = (0..NAMES.len()).map(|k| camera(k, wanted.resolution, &mut random));
    let cameras = cameras.collect();
    let phase = random.between(0.0, TAU);
    let mut object = |id: &str, body: (Solid, Vec<SceneTag>), side: f64| SceneObject {
        id: id.to_owned(),
        solids: vec![body.0],
        tags: body.1,
        path: path(wanted.seconds, side, phase, &mut random),
    };
    Scenario {
        seed: wanted.seed & (i64::MAX as u64),
        start_ns: 0,
        light: Light {
            flicker: Flicker {
                amplitude: 0.1,
                rate_hz: 100.0,
            },
            ..Light::default()
        },
        background: Background::default(),
        cameras,
        objects: vec![
            object("cube", boxed(EDGE_M, 0), 1.0),
            object("column", boxed(COLUMN_M, 10), -1.0),
        ],
    }
}

fn camera(k: usize, resolution: [u32; 2], random: &mut Random) -> SceneCamera {
    let bearing = TAU * (k as f64 + random.between(-0.12, 0.12)) / NAMES.len() as f64;
    let height = random.between(15.0, 40.0_f64).to_radians();
    let from = Vector3::new(
        bearing.sin() * height.cos(),
        bearing.cos() * height.cos(),
        height.sin(),
    );
    let middle = Vector3::from(MIDDLE);
    let target = middle + Vector3::from_fn(|_, _| random.between(-0.05, 0.05));
    let place = middle + from * random.between(1.0, 1.2);
    SceneCamera {
        rate_hz: RATE_HZ,
        exposure_ns: 10_000_000,
        line_delay_s: READOUT_S / f64::from(resolution[1]),
        auto_exposure: Some(AutoExposure {
            target: 110.0,
            max_exposure_ns: 16_000_000,
            max_gain: 8.0,
            lag_s: 0.3,
        }),
        vignetting: 0.2,
        blur_px: random.between(0.5, 0.8),
        noise: 1.5,
        shot_noise: 4.0,
        mosaic: Mosaic::Bayer,
        ..SceneCamera::new(
            NAMES[k],
            resolution,
            lens(resolution, random),
            looking(place, target),
        )
    }
}

fn lens([width, height]: [u32; 2], random: &mut Random) -> Lens {
    let [width, height] = [width, height].map(f64::from);
    let focal = FOCAL * width * random.between(1.0 - FOCAL_ERROR, 1.0 + FOCAL_ERROR);
    let mut about = |value: f64, spread: f64| value + random.between(-spread, spread);
    let intrinsics = Intrinsics {
        fx: focal,
        fy: focal * about(1.0, 0.002),
        cx: about(0.5 * (width - 1.0), 0.015 * width),
        cy: about(0.5 * (height - 1.0), 0.015 * width),
    };
    let distortion = [
        about(0.0, 0.08),
        about(0.0, 0.04),
        about(0.0, 4e-4),
        about(0.0, 4e-4),
        0.0,
    ];
    crate::models::made(Lens::brown_conrady(intrinsics, distortion))
}

/// The pose of a camera that looks at a point, its image upright.
fn looking(from: Vector3<f64>, at: Vector3<f64>) -> Pose {
    let forward = (at - from).normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let axes = Matrix3::from_columns(&[right, forward.cross(&right), forward]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Pose::from_parts(from.into(), turn)
}

/// A box with square ends, as long as that along z: a tag on each end, and on each side as many as have room.
fn boxed(length_m: f64, first: u32) -> (Solid, Vec<SceneTag>) {
    let solid = Solid::Box {
        size: [EDGE_M, EDGE_M, length_m],
        object_from_box: Pose::identity(),
        albedo: 0.5,
    };
    let n_rows = (length_m / EDGE_M).round() as u32;
    let end = |sign: f64| {
        let turn = UnitQuaternion::from_euler_angles(if sign > 0.0 { 0.0 } else { PI }, 0.0, 0.0);
        Pose::from_parts(Vector3::new(0.0, 0.0, 0.5 * sign * length_m).into(), turn)
    };
    let side = |k: u32, row: u32| {
        let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, f64::from(k) * FRAC_PI_2)
            * UnitQuaternion::from_euler_angles(FRAC_PI_2, 0.0, 0.0);
        let outwards = turn * Vector3::new(0.0, 0.0, 0.5 * EDGE_M);
        let along = (f64::from(row) - 0.5 * f64::from(n_rows - 1)) * EDGE_M;
        Pose::from_parts((outwards + Vector3::z() * along).into(), turn)
    };
    let sides = (0..4).flat_map(|k| (0..n_rows).map(move |row| side(k, row)));
    let places = [end(1.0), end(-1.0)].into_iter().chain(sides);
    let tags = (first..).zip(places);
    let tags = tags.map(|(id, place)| SceneTag::new(Family::Tag36h11, id, TAG_M, place));
    (solid, tags.collect())
}

/// Both objects go about together, up to 0.4 m/s, one on either side of what both move about.
fn path(seconds: u32, side: f64, phase: f64, random: &mut Random) -> Path {
    // Orders are for a minute.
    let order = |of_minute: f64| (of_minute * f64::from(seconds) / 60.0).round().max(1.0) as u32;
    let [x, y, z] = MIDDLE.map(Wave::still);
    let around = [FRAC_PI_2, 0.0].map(|quarter| (order(4.0), side * APART_M, phase + quarter));
    let mut turn = |of_minute: f64, amplitude: f64| {
        Wave::still(0.0).and(order(of_minute), amplitude, random.between(0.0, TAU))
    };
    Path {
        period_s: f64::from(seconds),
        turns: (side * f64::from(order(3.0 - side))) as i32,
        position: [
            x.and(order(7.0), 0.27, phase)
                .and(order(3.0), 0.1, 2.0 * phase)
                .and(around[0].0, around[0].1, around[0].2),
            y.and(order(5.0), 0.27, 1.0 - phase)
                .and(order(8.0), 0.08, phase)
                .and(around[1].0, around[1].1, around[1].2),
            z.and(order(9.0), 0.13, phase).and(order(4.0), 0.05, 2.0),
        ],
        yaw: Wave::still(0.0),
        pitch: turn(4.0 + side, 1.0),
        roll: turn(3.0, 2.8),
        joints: Vec::new(),
        events: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_valid_and_their_objects_never_touch() {
        for seed in 1..20 {
            let wanted = Wanted {
                seed,
                resolution: [640, 480],
                seconds: 60,
            };
            let scenario = scenario(&wanted);
            scenario.validate().unwrap();
            let at = |object: usize, time_ns| {
                let pose = scenario.objects[object].world_from_object(time_ns);
                pose.translation.vector
            };
            for time_ns in (0..60).map(|second| second * 1_000_000_000) {
                assert!((at(0, time_ns) - at(1, time_ns)).norm() > 0.3);
            }
        }
    }
}
