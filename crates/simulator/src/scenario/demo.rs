//! The demonstration site: cameras on a ring about a table, tagged objects that circle above it.

mod bodies;
mod paths;

use super::arm::{DEMO_REACH_M, demo_arm};
use super::{Background, Flicker, Light, Scenario, SceneCamera, SceneObject};
use crate::random::{Random, key_of_name};
use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use paths::Arena;
use sextant_geometry::{Intrinsics, Lens, Pose};
use std::f64::consts::TAU;

/// The most cameras of a demonstration.
const MAX_CAMERAS: usize = 16;
/// The most objects of a demonstration.
const MAX_OBJECTS: usize = 12;
const RESOLUTION: [u32; 2] = [640, 480];
/// Where the cameras look, above the middle of the table, m.
const TARGET_Z: f64 = 0.17;

/// Cameras are named by the direction in which they stand, north first, clockwise.
const COMPASS: [&str; MAX_CAMERAS] = [
    "north",
    "north-north-east",
    "north-east",
    "east-north-east",
    "east",
    "east-south-east",
    "south-east",
    "south-south-east",
    "south",
    "south-south-west",
    "south-west",
    "west-south-west",
    "west",
    "west-north-west",
    "north-west",
    "north-north-west",
];

impl Scenario {
    /// A site to look at: 1 to 16 cameras on a ring about a table, 1 to 12 objects on it (other numbers become the
    /// nearest of these). Objects move smoothly at up to half a metre and two radians per second and never touch.
    pub fn demo(n_cameras: usize, n_objects: usize, seed: u64) -> Self {
        let n_cameras = n_cameras.clamp(1, MAX_CAMERAS);
        let n_objects = n_objects.clamp(1, MAX_OBJECTS);
        Self::in_arena(&Arena::new(n_objects), n_cameras, seed)
    }

    /// The same about an arm in the middle: the links of an object `arm`, which are objects `arm-base`, `arm-upper` and
    /// `arm-fore` of the scenario with the joints `shoulder` and `elbow` on their paths, after the others.
    pub fn demo_with_arm(n_cameras: usize, n_objects: usize, seed: u64) -> Self {
        let n_cameras = n_cameras.clamp(1, MAX_CAMERAS);
        let n_objects = n_objects.clamp(1, MAX_OBJECTS);
        let arena = Arena::about(DEMO_REACH_M, n_objects);
        let mut scenario = Self::in_arena(&arena, n_cameras, seed);
        let taken = scenario.objects.iter().map(|object| object.tags.len());
        let arm = demo_arm(taken.sum());
        scenario.objects.extend(arm);
        scenario
    }

    fn in_arena(arena: &Arena, n_cameras: usize, seed: u64) -> Self {
        let seed = seed & (i64::MAX as u64);
        let mut random = Random::from_keys(&[seed, key_of_name("demo")]);
        let objects = demo_objects(arena, &mut random);
        let cameras = (0..n_cameras)
            .map(|i| camera(i, n_cameras, arena, &mut random))
            .collect();
        Self {
            seed,
            start_ns: 0,
            light: Light::default(),
            background: Background::default(),
            cameras,
            objects,
        }
    }
}

fn demo_objects(arena: &Arena, random: &mut Random) -> Vec<SceneObject> {
    let mut next_tag = 0;
    let object = |index| {
        let mut object = bodies::object(index, arena.path(index, random), random);
        for tag in &mut object.tags {
            tag.id = next_tag;
            next_tag += 1;
        }
        object
    };
    (0..arena.n_objects()).map(object).collect()
}

fn camera(index: usize, n_cameras: usize, arena: &Arena, random: &mut Random) -> SceneCamera {
    let bearing = TAU * (index as f64 + random.between(-0.12, 0.12)) / n_cameras as f64;
    let distance = arena.camera_distance() * random.between(1.0, 1.06);
    let height = random.between(31.0, 39.0_f64).to_radians();
    let offset = Vector3::new(
        libm::sin(bearing) * libm::cos(height),
        libm::cos(bearing) * libm::cos(height),
        libm::sin(height),
    );
    let target = Vector3::new(0.0, 0.0, TARGET_Z);
    let id = COMPASS[(index * MAX_CAMERAS + n_cameras / 2) / n_cameras % MAX_CAMERAS];
    let lens = lens(arena.focal_px(), random);
    let world_from_camera = looking(target + offset * distance, target);
    SceneCamera {
        phase: index as f64 / n_cameras as f64,
        gain: random.between(0.88, 1.02),
        flicker: Flicker {
            amplitude: 0.02,
            rate_hz: random.between(0.2, 0.6),
        },
        vignetting: random.between(0.12, 0.25),
        blur_px: random.between(0.45, 0.65),
        noise: random.between(1.5, 2.5),
        ..SceneCamera::new(id, RESOLUTION, lens, world_from_camera)
    }
}

/// A small board camera's lens: some barrel distortion, nothing quite centred.
fn lens(focal_px: f64, random: &mut Random) -> Lens {
    let mut about = |value: f64, spread: f64| value + random.between(-spread, spread);
    let focal = about(focal_px, 8.0);
    let intrinsics = Intrinsics {
        fx: focal,
        fy: focal * about(1.0, 0.002),
        cx: about(319.5, 6.0),
        cy: about(239.5, 6.0),
    };
    let distortion = [
        about(-0.11, 0.04),
        about(0.05, 0.02),
        about(0.0, 4e-4),
        about(0.0, 4e-4),
        0.0,
    ];
    let lens = Lens::brown_conrady(intrinsics, distortion);
    // Numbers in these ranges make a valid lens; without distortion it is one in any case.
    lens.or_else(|_| Lens::pinhole(intrinsics))
        .unwrap_or_else(|error| unreachable!("{error}"))
}

/// A camera at `position` that looks at `target`, its image upright.
fn looking(position: Vector3<f64>, target: Vector3<f64>) -> Pose {
    let forward = (target - position).normalize();
    let right = forward.cross(&Vector3::z()).normalize();
    let down = forward.cross(&right);
    let axes = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[right, down, forward]));
    Pose::from_parts(
        Translation3::from(position),
        UnitQuaternion::from_rotation_matrix(&axes),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Observer, Visibility};

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn every_size_of_the_demo_is_possible() {
        for n_cameras in 1..=MAX_CAMERAS {
            for n_objects in 1..=MAX_OBJECTS {
                let scenario = Scenario::demo(n_cameras, n_objects, 1);
                assert_eq!(scenario.validate(), Ok(()));
                assert_eq!(scenario.cameras.len(), n_cameras);
                assert_eq!(scenario.objects.len(), n_objects);
                assert!(
                    scenario
                        .objects
                        .iter()
                        .all(|o| (5..=7).contains(&o.tags.len()))
                );
                let sizes = scenario
                    .objects
                    .iter()
                    .flat_map(|o| &o.tags)
                    .map(|tag| tag.size);
                sizes.for_each(|size| assert!((0.04..=0.06).contains(&size), "{size}"));
            }
        }
    }

    #[test]
    fn the_arm_keeps_clear_of_the_objects_about_it_and_of_the_table() {
        for n_objects in 1..=MAX_OBJECTS {
            let scenario = Scenario::demo_with_arm(4, n_objects, 7);
            assert_eq!(scenario.validate(), Ok(()));
            let (others, arm) = scenario.objects.split_at(n_objects);
            for step in 0..300 {
                let true_ns = step * 25_000_000;
                for link in arm {
                    let pose = link.world_from_object(true_ns);
                    for vertex in link.solids.iter().flat_map(|solid| solid.vertices()) {
                        let vertex = pose * vertex;
                        assert!(vertex.z > 0.0, "{} is in the table", link.id);
                        assert!(vertex.coords.xy().norm() < DEMO_REACH_M, "{}", link.id);
                    }
                }
                for other in others {
                    let (centre, radius) = sphere(other, true_ns);
                    assert!(centre.xy().norm() - radius > DEMO_REACH_M, "{}", other.id);
                }
            }
        }
    }

    #[test]
    fn the_arms_links_are_nearly_always_seen() {
        for (n_cameras, n_objects) in [(4, 3), (4, 6)] {
            let scenario = Scenario::demo_with_arm(n_cameras, n_objects, 1);
            let shares = shares_of(&scenario);
            let links = &shares[n_objects..];
            assert!(links.iter().all(|share| *share > 0.6), "{shares:?}");
            let others = &shares[..n_objects];
            assert!(others.iter().all(|share| *share > 0.9), "{shares:?}");
        }
    }

    #[test]
    fn objects_never_touch_one_another_or_the_table() {
        for n_objects in 1..=MAX_OBJECTS {
            let scenario = Scenario::demo(1, n_objects, 7);
            for step in 0..400 {
                let spheres: Vec<_> = scenario
                    .objects
                    .iter()
                    .map(|o| sphere(o, step * 25_000_000))
                    .collect();
                for (i, (a, radius_a)) in spheres.iter().enumerate() {
                    assert!(a.z > *radius_a, "object {i} is in the table");
                    for (b, radius_b) in &spheres[i + 1..] {
                        assert!(
                            (a - b).norm() > radius_a + radius_b,
                            "{n_objects} objects, object {i}"
                        );
                    }
                }
            }
        }
    }

    fn sphere(object: &SceneObject, true_ns: u64) -> (Vector3<f64>, f64) {
        let vertices = object.solids.iter().flat_map(|solid| solid.vertices());
        let radius = vertices.map(|v| v.coords.norm()).fold(0.0, f64::max);
        (object.world_from_object(true_ns).translation.vector, radius)
    }

    #[test]
    fn objects_move_at_lively_but_human_speeds() {
        let scenario = Scenario::demo(4, 12, 2);
        for object in &scenario.objects {
            let twists: Vec<_> = (0..200).map(|i| object.twist(i * SECOND / 20)).collect();
            let fastest = |rows: fn(&nalgebra::Vector6<f64>) -> f64| {
                twists.iter().map(rows).fold(0.0, f64::max)
            };
            let speed = fastest(|twist| twist.fixed_rows::<3>(0).norm());
            let turning = fastest(|twist| twist.fixed_rows::<3>(3).norm()).to_degrees();
            assert!((0.1..0.5).contains(&speed), "{}: {speed} m/s", object.id);
            assert!(
                (20.0..150.0).contains(&turning),
                "{}: {turning} deg/s",
                object.id
            );
        }
    }

    #[test]
    fn every_object_is_nearly_always_seen_by_two_cameras() {
        for (n_cameras, n_objects) in [(4, 3), (4, 6), (4, 12), (8, 12), (3, 3)] {
            for seed in 1..4 {
                let shares = shares_in_view(n_cameras, n_objects, seed);
                let worst = shares.iter().copied().fold(1.0, f64::min);
                assert!(
                    worst > 0.9,
                    "{n_cameras} cameras, {n_objects} objects, seed {seed}: {shares:?}"
                );
            }
        }
    }

    /// For each object the share of the time in which at least two cameras see a tag of it.
    fn shares_in_view(n_cameras: usize, n_objects: usize, seed: u64) -> Vec<f64> {
        shares_of(&Scenario::demo(n_cameras, n_objects, seed))
    }

    fn shares_of(scenario: &Scenario) -> Vec<f64> {
        let (n_cameras, n_objects) = (scenario.cameras.len(), scenario.objects.len());
        let mut observer = Observer::new(scenario, Visibility::default()).unwrap();
        let mut random = Random::new(1);
        let steps = 60;
        let mut seen = vec![0.0; n_objects];
        for step in 0..steps {
            let mut cameras_of = vec![0; n_objects];
            for camera in 0..n_cameras {
                let tags = observer.observe(camera, step * SECOND / 5, 0.0, &mut random);
                for (object, cameras) in cameras_of.iter_mut().enumerate() {
                    *cameras += usize::from(tags.iter().any(|tag| tag.object == object));
                }
            }
            for (seen, cameras) in seen.iter_mut().zip(cameras_of) {
                *seen += f64::from(u8::from(cameras >= 2)) / steps as f64;
            }
        }
        seen
    }

    #[test]
    fn a_demo_is_made_of_its_seed() {
        assert_eq!(Scenario::demo(4, 3, 5), Scenario::demo(4, 3, 5));
        assert_ne!(Scenario::demo(4, 3, 5), Scenario::demo(4, 3, 6));
    }

    #[test]
    fn a_scenario_comes_back_from_its_file_bit_by_bit() {
        let scenario = Scenario::demo(16, 12, u64::MAX);
        let text = toml::to_string(&scenario).unwrap();
        assert_eq!(toml::from_str::<Scenario>(&text).unwrap(), scenario);
    }

    #[test]
    fn unknown_keys_of_a_file_are_refused() {
        let text = toml::to_string(&Scenario::demo(1, 1, 1)).unwrap();
        let error = toml::from_str::<Scenario>(&text.replace("rate_hz", "rate_khz")).unwrap_err();
        assert!(error.to_string().contains("rate_khz"));
    }
}
