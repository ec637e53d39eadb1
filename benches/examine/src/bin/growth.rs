//! What one fusion process costs in a hall of many cameras and objects: processor, memory and bytes received, by
//! synthetic observations.
//!
//! `growth CAMERAS OBJECTS [exact|off [OWN]]` prints a line. Cameras hang 4 m apart in a grid and look down, so that
//! nearly every object is seen by four of them; each takes 30 images a second. Objects are plates with four tags that
//! move in circles. The files are right; with `exact` they say so, with `off` the cameras are off by centimetres and
//! degrees. Adjustments of the files are solved apart, as a fusion node does, and apply once as much time has passed as
//! their solution took. With OWN the process tracks so many of the objects only, as one of several fusion nodes that
//! share them: it decodes everything, and drops the tags of the others.
//!
//! The line: cameras, objects, time that the images took (100 %: no faster than they come), processor time of all
//! threads, the longest image, adjustments, memory, bytes, poses a second.

#![allow(clippy::expect_used, reason = "a bench ends by panicking")]

use nalgebra::{Point3, UnitQuaternion, Vector3};
use sextant_estimator::{Fusion, FusionOptions, Input};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_proto::{
    ClockQuality, ClockSource, Observations, TagObservation, TagPose, Timing, decode, encode,
};
use sextant_simulator::Random;
use sextant_site_model::{
    Camera, CameraId, ImageObservation, ObjectId, ObjectModel, ObjectTag, Rig, TagId,
};
use sextant_tag_families::Family;
use std::time::{Duration, Instant};

const PITCH_M: f64 = 4.0;
const HEIGHT_M: f64 = 4.0;
const SIDE_PX: u32 = 1280;
const TAG_M: f64 = 0.2;
const SIGMA_PX: f32 = 0.05;
const RATE_HZ: u64 = 30;
const SECOND_NS: u64 = 1_000_000_000;
const START_NS: u64 = 1_800_000_000 * SECOND_NS;
/// Before and while costs are measured.
const WARM_UP_S: u64 = 2;
const MEASURED_S: u64 = 3;

struct Hall {
    rig: Rig,
    objects: Vec<ObjectModel>,
    /// Middles of the circles, m.
    places: Vec<[f64; 2]>,
    random: Random,
}

impl Hall {
    fn new(n_cameras: usize, n_objects: usize) -> Self {
        let columns = (n_cameras as f64).sqrt().ceil() as usize;
        let rows = n_cameras.div_ceil(columns);
        let rig = Rig::new((0..n_cameras).map(|k| camera(k, columns)).collect());
        let mut hall = Self {
            rig: rig.expect("a rig"),
            objects: (0..n_objects).map(plate).collect(),
            places: Vec::new(),
            random: Random::new(1),
        };
        let sides = [columns, rows].map(|n| (n as f64 - 1.0) * PITCH_M);
        hall.places = (0..n_objects)
            .map(|_| sides.map(|side_m| side_m * hall.random.uniform()))
            .collect();
        hall
    }

    fn place(&self, k: usize, seconds: f64) -> Pose {
        let angle = 0.5 * seconds + k as f64;
        let [x, y] = self.places[k];
        let at = Vector3::new(x + 0.3 * angle.cos(), y + 0.3 * angle.sin(), 0.0);
        Pose::from_parts(
            at.into(),
            UnitQuaternion::from_euler_angles(0.0, 0.0, angle),
        )
    }

    fn observe(&mut self, k: usize, seconds: f64) -> Observations {
        let camera = self.rig.cameras()[k].clone();
        let camera_from_world = camera.world_from_camera.expect("it is posed").inverse();
        let mut tags = Vec::new();
        for index in 0..self.objects.len() {
            let camera_from_object = camera_from_world * self.place(index, seconds);
            for tag in self.objects[index].tags().to_vec() {
                tags.extend(self.tag(&camera, &camera_from_object, &tag));
            }
        }
        Observations {
            camera: camera.id,
            sequence: 1,
            capture_ns: START_NS + (seconds * 1e9) as u64,
            exposure_ns: 0,
            clock: ClockQuality {
                source: ClockSource::Ptp,
                error_ns: 0,
            },
            resolution: [SIDE_PX as u16; 2],
            timing: Timing::default(),
            tags,
        }
    }

    fn tag(
        &mut self,
        camera: &Camera,
        camera_from_object: &Pose,
        tag: &ObjectTag,
    ) -> Option<TagObservation> {
        let camera_from_tag = camera_from_object * tag.object_from_tag?;
        let mut corners = [[0.0_f32; 2]; 4];
        for (corner, at) in corners.iter_mut().zip(tag_corners_in_tag(tag.size_m)) {
            let pixel = camera.lens.project(&(camera_from_tag * Point3::from(at)))?;
            *corner = [pixel.x, pixel.y]
                .map(|pixels| pixels as f32 + SIGMA_PX * self.random.normal() as f32);
        }
        let inside = |corner: &[f32; 2]| corner.iter().all(|at| (0.0..SIDE_PX as f32).contains(at));
        let pose = TagPose {
            position: camera_from_tag.translation.vector.cast().into(),
            orientation: camera_from_tag.rotation.coords.cast().into(),
            rms_px: SIGMA_PX,
        };
        corners.iter().all(inside).then(|| TagObservation {
            family: tag.tag.family,
            id: tag.tag.id,
            hamming: 0,
            margin: 60.0,
            corners,
            corner_covariance: [[SIGMA_PX.powi(2), 0.0, SIGMA_PX.powi(2)]; 4],
            corner_cross_covariance: [[0.0; 4]; 6],
            poses: vec![pose; 2],
        })
    }
}

fn camera(k: usize, columns: usize) -> Camera {
    let middle = f64::from(SIDE_PX - 1) / 2.0;
    // Each sees twice the pitch along both axes.
    let focal_px = f64::from(SIDE_PX) / 2.0 * HEIGHT_M / PITCH_M;
    let intrinsics = Intrinsics {
        fx: focal_px,
        fy: focal_px,
        cx: middle,
        cy: middle,
    };
    let [x, y] = [k % columns, k / columns].map(|n| n as f64 * PITCH_M);
    let down = UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0);
    Camera::new(
        CameraId::new(&format!("cam{k}")).expect("an id"),
        [SIDE_PX; 2],
        Lens::pinhole(intrinsics).expect("a lens"),
        Some(Pose::from_parts(Vector3::new(x, y, HEIGHT_M).into(), down)),
    )
}

/// The rig with its cameras a centimetre and a third of a degree off.
fn off(rig: &Rig, random: &mut Random) -> Rig {
    let cameras = rig.cameras().iter().map(|camera| {
        let [dx, dy, dz] = [0.006; 3].map(|sigma_m| sigma_m * random.normal());
        let [a, b, c] = [0.0035; 3].map(|sigma_rad| sigma_rad * random.normal());
        let error = Pose::from_parts(
            Vector3::new(dx, dy, dz).into(),
            UnitQuaternion::from_euler_angles(a, b, c),
        );
        let pose = camera.world_from_camera.expect("it is posed") * error;
        Camera::new(
            camera.id.clone(),
            camera.resolution,
            camera.lens,
            Some(pose),
        )
    });
    Rig::new(cameras.collect()).expect("a rig")
}

fn plate(k: usize) -> ObjectModel {
    let tag = |corner: u32| {
        let [x, y] = [corner % 2, corner / 2].map(|n| 0.3 * (f64::from(n) - 0.5));
        ObjectTag::new(
            TagId {
                family: Family::TagStandard41h12,
                id: 4 * k as u32 + corner,
            },
            TAG_M,
            Some(Pose::translation(x, y, 0.0)),
        )
    };
    let id = ObjectId::new(&format!("object{k}")).expect("an id");
    ObjectModel::new(id, (0..4).map(tag).collect()).expect("an object")
}

#[derive(Default)]
struct Costs {
    poses: usize,
    bytes: usize,
    /// As it passes, which says what a machine with nothing else to do can keep up with.
    passed: Duration,
    /// Of all threads.
    busy: Duration,
    adjusting: Duration,
    longest: Duration,
}

/// The messages of all cameras, in turns.
fn record(hall: &mut Hall, from_s: u64, for_s: u64) -> Vec<Vec<u8>> {
    let n_cameras = hall.rig.cameras().len() as u64;
    let per_s = RATE_HZ * n_cameras;
    let turns = from_s * per_s..(from_s + for_s) * per_s;
    let message = |turn: u64| {
        let seen = hall.observe((turn % n_cameras) as usize, turn as f64 / per_s as f64);
        encode(&seen).expect("few enough tags for a message")
    };
    turns.map(message).collect()
}

/// `applies_ns` is when the adjustment under way applies.
fn fuse(
    fusion: &mut Fusion,
    n_own: usize,
    messages: &[Vec<u8>],
    applies_ns: &mut Option<u64>,
) -> Costs {
    let mut costs = Costs::default();
    for message in messages {
        let (before, begun) = (processor_time(), Instant::now());
        let seen: Observations = decode(message).expect("a message");
        let mut image = ImageObservation::from(&seen);
        image.tags.retain(|seen| seen.tag.id < 4 * n_own as u32);
        let now_ns = seen.capture_ns + SECOND_NS / 100;
        fusion.handle(now_ns, Input::Image(image));
        if applies_ns.is_some_and(|applies_ns| applies_ns <= now_ns) {
            *applies_ns = None;
            fusion.handle(now_ns, Input::Adjusted);
        }
        costs.poses += std::iter::from_fn(|| fusion.poll_output()).count();
        costs.bytes += message.len();
        let passed = begun.elapsed();
        costs.passed += passed;
        costs.longest = costs.longest.max(passed);
        costs.busy += processor_time() - before;
        if let Some(task) = fusion.task().filter(|task| !task.is_solved()) {
            let before = processor_time();
            task.solve();
            let took = processor_time() - before;
            costs.adjusting += took;
            *applies_ns = Some(now_ns + took.as_nanos() as u64);
        }
    }
    costs
}

/// Of all threads of this process, as of the scheduler's last tick.
fn processor_time() -> Duration {
    let of_thread = |folder: std::fs::DirEntry| {
        let text = std::fs::read_to_string(folder.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    };
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    Duration::from_nanos(threads.flatten().filter_map(of_thread).sum())
}

fn resident_mib() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kib = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    kib.unwrap_or_default() / 1024.0
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize| arguments.get(k).and_then(|text| text.parse::<usize>().ok());
    let (Some(n_cameras), Some(n_objects)) = (number(0), number(1)) else {
        eprintln!("usage: growth CAMERAS OBJECTS [exact|off [OWN]]");
        std::process::exit(2);
    };
    let mut hall = Hall::new(n_cameras, n_objects);
    let (mut rig, mut objects) = (hall.rig.clone(), hall.objects.clone());
    match arguments.get(2).map(String::as_str) {
        Some("exact") => {
            rig = rig.exact();
            objects = objects.into_iter().map(ObjectModel::exact).collect();
        }
        Some("off") => rig = off(&hall.rig, &mut hall.random),
        _ => {}
    }
    let n_own = number(3).unwrap_or(n_objects);
    objects.truncate(n_own);
    let fusion = Fusion::new(rig, objects, FusionOptions::default());
    let mut fusion = fusion.expect("a machine");
    fusion.adjust_apart();
    let warm_up = record(&mut hall, 0, WARM_UP_S);
    let measured = record(&mut hall, WARM_UP_S, MEASURED_S);
    let before_mib = resident_mib();
    let mut applies_ns = None;
    fuse(&mut fusion, n_own, &warm_up, &mut applies_ns);
    let costs = fuse(&mut fusion, n_own, &measured, &mut applies_ns);
    let per_s = |count: usize| count as f64 / MEASURED_S as f64;
    println!(
        "| {n_cameras} | {n_objects} | {:.0} % | {:.0} % | {:.0} ms | {:.0} % | {:.0} MiB | {:.1} Mbit/s | {:.0} |",
        100.0 * costs.passed.as_secs_f64() / MEASURED_S as f64,
        100.0 * costs.busy.as_secs_f64() / MEASURED_S as f64,
        costs.longest.as_secs_f64() * 1e3,
        100.0 * costs.adjusting.as_secs_f64() / MEASURED_S as f64,
        resident_mib() - before_mib,
        8e-6 * per_s(costs.bytes),
        per_s(costs.poses),
    );
}
