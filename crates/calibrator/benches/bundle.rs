//! The bundle adjustment at the size of a large site: 20 cameras, 2000 instants, an object of 24 tags of which one is
//! known.
//!
//! `cargo bench -p sextant-calibrator --bench bundle` with synchronised cameras; with `-- free-running`, cameras that
//! take images when they like and whose clocks are off, so that the object's motion and the clocks are sought too.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a program that measures may panic and print"
)]

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3, Vector6};
use sextant_adjustment::*;
use sextant_geometry::{Intrinsics, Lens, Pose, se3, tag_corners_in_tag};
use sextant_simulator::Random;
use std::f64::consts::PI;
use std::time::Instant as Clock;

const CAMERAS: usize = 20;
const INSTANTS: usize = 2000;
const TAGS: usize = 24;
const NOISE_PX: f64 = 0.2;
const RESOLUTION: [f64; 2] = [1280.0, 800.0];

fn twist(random: &mut Random, translation: f64, rotation: f64) -> Vector6<f64> {
    Vector6::from_fn(|at, _| random.normal() * if at < 3 { translation } else { rotation })
}

/// Along the walls of a room of 8 by 6 metres, looking to its middle.
fn camera(at: usize) -> BundleCamera {
    let intrinsics = Intrinsics {
        fx: 760.0,
        fy: 762.0,
        cx: 642.0,
        cy: 396.0,
    };
    let lens = Lens::brown_conrady(intrinsics, [-0.1, 0.02, 0.0, 0.0, 0.0]).unwrap();
    let angle = 2.0 * PI * at as f64 / CAMERAS as f64;
    let height = 2.0 + 0.3 * (at % 3) as f64;
    let from = Point3::new(4.0 * angle.cos(), 3.0 * angle.sin(), height);
    let pose = Isometry3::face_towards(&from, &Point3::new(0.0, 0.0, 1.0), &-Vector3::z());
    BundleCamera::with_known_lens(lens, pose)
}

/// Four on each face of a cube of 40 cm.
fn tag(at: usize) -> BundleTag {
    let face = match at / 4 {
        side @ 0..4 => Vector3::new(0.0, PI / 2.0 * side as f64, 0.0),
        4 => Vector3::new(PI / 2.0, 0.0, 0.0),
        _ => Vector3::new(-PI / 2.0, 0.0, 0.0),
    };
    let (x, y) = ((at % 2) as f64 - 0.5, (at / 2 % 2) as f64 - 0.5);
    BundleTag {
        object_from_tag: Isometry3::new(Vector3::zeros(), face)
            * Isometry3::translation(0.19 * x, 0.19 * y, 0.2),
        size_m: 0.15,
        pose: Freedom::Free,
        size: Freedom::Fixed,
        scale: None,
    }
}

/// Carried through the room and turned to everyone.
fn carried(seconds: f64) -> Pose {
    let wave = |period: f64, phase: f64| (2.0 * PI * seconds / period + phase).sin();
    let position = Vector3::new(
        2.0 * wave(19.0, 0.3),
        1.5 * wave(23.0, 1.0),
        1.1 + 0.4 * wave(11.0, 2.0),
    );
    let tilt = Vector3::new(0.6 * wave(7.0, 0.0), 0.5 * wave(9.0, 1.5), 0.0);
    Isometry3::new(position, Vector3::z() * (2.0 * PI * seconds / 13.0))
        * Isometry3::new(Vector3::zeros(), tilt)
}

/// `None` from behind, too slanted, or out of the picture.
fn corners(camera: &BundleCamera, object: &Pose, tag: &BundleTag) -> Option<[Point2<f64>; 4]> {
    let camera_from_tag = camera.world_from_camera.inverse() * object * tag.object_from_tag;
    let towards = camera_from_tag.translation.vector.normalize();
    if -towards.dot(&(camera_from_tag.rotation * Vector3::z())) < 0.3 {
        return None;
    }
    let mut seen = [Point2::origin(); 4];
    for (seen, corner) in seen.iter_mut().zip(tag_corners_in_tag(tag.size_m)) {
        *seen = camera.lens.project(&(camera_from_tag * corner))?;
    }
    let inside = |p: &Point2<f64>| {
        (0.0..RESOLUTION[0]).contains(&p.x) && (0.0..RESOLUTION[1]).contains(&p.y)
    };
    seen.iter().all(inside).then_some(seen)
}

/// Everything where it is, and what is seen of it with noise.
fn truth(free_running: bool, noise: &mut Random) -> Bundle {
    let mut bundle = Bundle {
        cameras: (0..CAMERAS).map(camera).collect(),
        tags: (0..TAGS).map(tag).collect(),
        motion: free_running.then_some(Motion {
            acceleration: 3.0,
            angular_acceleration: 10.0,
            longest_gap_s: 0.3,
        }),
        ..Bundle::default()
    };
    bundle.cameras[0].pose = Freedom::Fixed;
    bundle.tags[0].pose = Freedom::Fixed;
    for at in 0..INSTANTS {
        let seconds = 0.1 * at as f64;
        let h = 1e-4;
        bundle.instants.push(Instant {
            body: BodyId::Moving(0),
            seconds,
            world_from_object: carried(seconds),
            twist: se3::difference(&carried(seconds + h), &carried(seconds - h)) / (2.0 * h),
        });
        for camera in 0..CAMERAS {
            let delay = if free_running {
                0.002 * camera as f64
            } else {
                0.0
            };
            let image = image(&bundle, camera, at, delay, noise);
            bundle.images.extend(image);
        }
    }
    bundle
}

fn image(
    bundle: &Bundle,
    camera: usize,
    instant: usize,
    delay: f64,
    noise: &mut Random,
) -> Option<BundleImage> {
    let object = carried(bundle.instants[instant].seconds + delay);
    let see = |(at, tag): (usize, &BundleTag)| {
        let seen = corners(&bundle.cameras[camera], &object, tag)?;
        let seen = seen.map(|p| p + Vector2::new(noise.normal(), noise.normal()) * NOISE_PX);
        Some(TagObservation::with_sigma(at, seen, NOISE_PX))
    };
    let tags: Vec<TagObservation> = bundle.tags.iter().enumerate().filter_map(see).collect();
    (!tags.is_empty()).then_some(BundleImage {
        camera,
        instant,
        seconds_after_instant: delay,
        stamp_error_s: 0.0,
        tags,
    })
}

/// Moves everything sought away from the truth: centimetres and degrees, clocks by 5 ms.
fn displace(bundle: &mut Bundle, noise: &mut Random) {
    for camera in &mut bundle.cameras[1..] {
        camera.world_from_camera = se3::exp(&twist(noise, 0.03, 0.02)) * camera.world_from_camera;
        if bundle.motion.is_some() {
            camera.clock = Freedom::Free;
            camera.clock_offset_s = 0.005 * noise.normal();
        }
    }
    for tag in &mut bundle.tags[1..] {
        tag.object_from_tag = se3::exp(&twist(noise, 0.01, 0.05)) * tag.object_from_tag;
    }
    for instant in &mut bundle.instants {
        instant.world_from_object *= se3::exp(&twist(noise, 0.03, 0.05));
    }
}

/// Root mean square of position (mm) and attitude (degrees) of poses that were found against those that are right.
fn errors<'a>(pairs: impl Iterator<Item = (&'a Pose, &'a Pose)>) -> (f64, f64) {
    let (mut n, mut position, mut attitude) = (0.0, 0.0, 0.0);
    for (found, right) in pairs {
        let error = se3::difference(found, right);
        n += 1.0;
        position += error.fixed_rows::<3>(0).norm_squared();
        attitude += error.fixed_rows::<3>(3).norm_squared();
    }
    let rms = |squares: f64| (squares / n).sqrt();
    (rms(position) * 1e3, rms(attitude).to_degrees())
}

fn most_memory_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kb = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kb.unwrap_or(f64::NAN) / 1024.0
}

fn report(solution: &BundleSolution, right: &Bundle) {
    let found = &solution.bundle;
    let cameras = found.cameras.iter().zip(&right.cameras).skip(1);
    let cameras = errors(cameras.map(|(f, r)| (&f.world_from_camera, &r.world_from_camera)));
    let tags = found.tags.iter().zip(&right.tags).skip(1);
    let tags = errors(tags.map(|(f, r)| (&f.object_from_tag, &r.object_from_tag)));
    let poses = found.instants.iter().zip(&right.instants);
    let poses = errors(poses.map(|(f, r)| (&f.world_from_object, &r.world_from_object)));
    println!(
        "rms {:.4} px, noise in units of what is stated {:.4}",
        solution.rms_px,
        solution.variance_factor.sqrt()
    );
    for (what, (mm, deg)) in [("cameras", cameras), ("tags", tags), ("object", poses)] {
        println!("{what}: {mm:.3} mm, {deg:.4} degrees rms from the truth");
    }
    let clocks = found.cameras.iter().map(|c| c.clock_offset_s.abs());
    println!("clocks: {:.4} ms at most", clocks.fold(0.0, f64::max) * 1e3);
}

fn main() {
    let free_running = std::env::args().any(|argument| argument == "free-running");
    let mut noise = Random::new(1);
    let right = truth(free_running, &mut noise);
    let mut start = right.clone();
    displace(&mut start, &mut noise);
    let tags: usize = right.images.iter().map(|image| image.tags.len()).sum();
    println!(
        "{CAMERAS} cameras, {INSTANTS} instants, {TAGS} tags: {} images, {} corners",
        right.images.len(),
        4 * tags
    );
    let clock = Clock::now();
    let solution = solve(start, &BundleOptions::default()).unwrap();
    println!(
        "{} iterations, {:.2} s, {:.0} MB at most, converged: {}",
        solution.iterations,
        clock.elapsed().as_secs_f64(),
        most_memory_mb(),
        solution.converged
    );
    report(&solution, &right);
}
