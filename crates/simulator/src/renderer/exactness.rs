//! Compares the renderer with a ray tracer that shares only the scenario's data and the lens with it.

use super::Renderer;
use crate::path::{Path, Wave};
use crate::random::Random;
use crate::scenario::{Background, Flicker, Light, Scenario, SceneCamera, SceneObject};
use nalgebra::{Point2, Point3, Vector2, Vector3};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_tag_families::module_is_white;

/// Samples of a pixel, evenly spread (M. Roberts' R2 sequence, 2018): finer than a 32 x 32 grid, which can be off by a
/// 64th of the contrast where an edge runs along its lines.
const SAMPLES: usize = 16384;
const LEVEL: f64 = 90.0;

/// No noise, blur, shadows or vignetting: only geometry is left.
fn bare(mut scenario: Scenario) -> Scenario {
    scenario.background = Background::Plain { level: LEVEL };
    scenario.light = Light {
        pool_radius: 1000.0,
        shadow: 0.0,
        ..Light::default()
    };
    for camera in &mut scenario.cameras {
        camera.noise = 0.0;
        camera.blur_px = 0.0;
        camera.exposure_ns = 0;
        camera.gain = 1.0;
        camera.vignetting = 0.0;
        camera.flicker = Flicker::default();
    }
    scenario
}

/// The light of an image before it is rounded to bytes, in grey levels.
fn light(renderer: &mut Renderer, true_ns: u64) -> Vec<f64> {
    renderer.draw(true_ns);
    let frame = renderer
        .backdrop
        .frame()
        .iter()
        .map(|&v| f64::from(v) / 64.0)
        .collect();
    renderer.backdrop.restore(&renderer.regions);
    frame
}

/// Compares `n` pixels on edges with the ray tracer.
fn compare(scenario: &Scenario, camera: usize, true_ns: u64, n: usize) {
    let mut renderer = Renderer::new(scenario, camera).unwrap();
    let image = light(&mut renderer, true_ns);
    let [width, height] = scenario.cameras[camera].resolution.map(|n| n as usize);
    let on_edge = |x: usize, y: usize| {
        let i = y * width + x;
        [i - 1, i + 1, i - width, i + width]
            .iter()
            .any(|&j| (image[i] - image[j]).abs() > 3.0)
    };
    let inside = (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y)));
    let mut candidates: Vec<_> = inside.filter(|&(x, y)| on_edge(x, y)).collect();
    assert!(candidates.len() > n);
    let tracer = Tracer::new(scenario, camera, true_ns);
    let mut random = Random::new(true_ns);
    for _ in 0..n {
        let (x, y) = candidates.swap_remove(random.below(candidates.len()));
        let expected = tracer.pixel(Point2::new(x as f64, y as f64));
        let got = image[y * width + x];
        assert!(
            (got - expected).abs() < 0.5,
            "pixel ({x}, {y}): {got:.2} not {expected:.2}"
        );
    }
}

/// Solid of an object at one instant, as half spaces in the object's frame.
struct Body<'a> {
    object: &'a SceneObject,
    object_from_world: Pose,
    planes: Vec<(Vector3<f64>, f64)>,
    albedo: f64,
}

struct Tracer<'a> {
    camera: &'a SceneCamera,
    light: &'a Light,
    bodies: Vec<Body<'a>>,
}

impl<'a> Tracer<'a> {
    fn new(scenario: &'a Scenario, camera: usize, true_ns: u64) -> Self {
        let bodies = scenario.objects.iter().flat_map(|object| {
            object.solids.iter().map(move |solid| Body {
                object,
                object_from_world: object.world_from_object(true_ns).inverse(),
                planes: solid
                    .faces()
                    .iter()
                    .map(|face| (face.normal, face.offset))
                    .collect(),
                albedo: solid.albedo(),
            })
        });
        Self {
            camera: &scenario.cameras[camera],
            light: &scenario.light,
            bodies: bodies.collect(),
        }
    }

    /// Mean level of a pixel.
    fn pixel(&self, pixel: Point2<f64>) -> f64 {
        let (middle, by_pixel) = self.camera.lens.undistort_with_jacobian(&pixel).unwrap();
        let level = |i: usize| {
            let share = |step: f64| (0.5 + step * i as f64).fract() - 0.5;
            let offset = Vector2::new(
                share(0.754_877_666_246_692_7),
                share(0.569_840_290_998_053_2),
            );
            let at = middle + by_pixel * offset;
            let pose = &self.camera.world_from_camera;
            let origin = Point3::from(pose.translation.vector);
            self.level(&origin, &(pose.rotation * Vector3::new(at.x, at.y, 1.0)))
        };
        (0..SAMPLES).map(level).sum::<f64>() / SAMPLES as f64
    }

    fn level(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> f64 {
        let mut nearest = (f64::INFINITY, LEVEL);
        for body in &self.bodies {
            let origin = body.object_from_world * origin;
            let direction = body.object_from_world * direction;
            let Some((way, normal)) = body.enters(&origin, &direction) else {
                continue;
            };
            if way < nearest.0 {
                let lamp = Vector3::from(self.light.towards_lamp).normalize();
                let facing = normal.dot(&(body.object_from_world * lamp)).max(0.0);
                let light = self.light.ambient + self.light.lamp * facing;
                nearest = (
                    way,
                    255.0 * light * body.albedo(&(origin + direction * way), &normal),
                );
            }
        }
        nearest.1
    }
}

impl Body<'_> {
    /// Where a ray enters the intersection of half spaces, and the normal there.
    fn enters(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
    ) -> Option<(f64, Vector3<f64>)> {
        let (mut enter, mut leave) = ((0.0, Vector3::zeros()), f64::INFINITY);
        for (normal, offset) in &self.planes {
            let (distance, slope) = (normal.dot(&origin.coords) - offset, normal.dot(direction));
            let way = -distance / slope;
            if slope < 0.0 && way > enter.0 {
                enter = (way, *normal);
            } else if slope > 0.0 {
                leave = leave.min(way);
            }
        }
        (enter.0 > 0.0 && enter.0 < leave).then_some(enter)
    }

    fn albedo(&self, point: &Point3<f64>, normal: &Vector3<f64>) -> f64 {
        for tag in &self.object.tags {
            let in_tag = tag.object_from_tag.inverse() * point;
            let tag_normal = tag.object_from_tag.rotation * Vector3::z();
            let module = tag.size / 8.0;
            let (x, y) = (in_tag.x / module + 5.0, 5.0 - in_tag.y / module);
            let on_tag =
                (0.0..10.0).contains(&x) && (0.0..10.0).contains(&y) && in_tag.z.abs() < 1e-6;
            if on_tag && tag_normal.dot(normal) > 0.99 {
                let white = module_is_white(tag.family, tag.id, x as usize, y as usize);
                return if white { 0.9 } else { 0.06 };
            }
        }
        self.albedo
    }
}

#[test]
fn edges_cover_what_a_ray_tracer_finds() {
    let scenario = bare(Scenario::demo(4, 3, 1));
    compare(&scenario, 0, 1_000_000_000, 150);
    compare(&scenario, 2, 3_300_000_000, 150);
}

#[test]
fn hidden_parts_are_exact_where_many_objects_hide_one_another() {
    let mut scenario = bare(Scenario::demo(2, 4, 1));
    // All solids behind one another as seen by the first camera.
    let camera = scenario.cameras[0].world_from_camera;
    for (i, object) in scenario.objects.iter_mut().enumerate() {
        let place = camera
            * Point3::new(
                0.03 * i as f64 - 0.04,
                0.02 * (i % 2) as f64,
                0.9 + 0.25 * i as f64,
            );
        let mut path = Path::at_rest(&Pose::translation(place.x, place.y, place.z));
        path.yaw = Wave::still(0.7 * i as f64);
        object.path = path;
    }
    compare(&scenario, 0, 0, 200);
}

#[test]
fn strong_distortion_is_followed() {
    let mut scenario = bare(Scenario::demo(4, 3, 1));
    let intrinsics = Intrinsics {
        fx: 500.0,
        fy: 505.0,
        cx: 330.0,
        cy: 230.0,
    };
    scenario.cameras[1].lens = Lens::kannala_brandt(intrinsics, [0.08, -0.03, 0.01, 0.0]).unwrap();
    compare(&scenario, 1, 500_000_000, 100);
    scenario.cameras[1].lens =
        Lens::brown_conrady(intrinsics, [-0.3, 0.1, 1e-3, -1e-3, 0.0]).unwrap();
    compare(&scenario, 1, 500_000_000, 100);
}

/// Each row equals that of an image whose mid-exposure time is the row's: with rows read from above and from below,
/// sharp and blurred by motion.
#[test]
fn a_rolling_shutter_draws_each_row_at_its_time() {
    for (exposure_ns, line_delay_s) in [(0, 3e-5), (8_000_000, -3e-5)] {
        let mut scenario = bare(Scenario::demo(1, 2, 1));
        for object in &mut scenario.objects {
            object.path.period_s *= 0.2;
        }
        scenario.cameras[0].exposure_ns = exposure_ns;
        let mut global = Renderer::new(&scenario, 0).unwrap();
        scenario.cameras[0].line_delay_s = line_delay_s;
        let mut rolling = Renderer::new(&scenario, 0).unwrap();
        let middle_ns: u64 = 2_000_000_000;
        let image = light(&mut rolling, middle_ns);
        let at_once = light(&mut global, middle_ns);
        let (width, height) = (640, 480);
        let (mut square, mut square_at_once, mut count) = (0.0, 0.0, 0.0);
        for row in (5..height).step_by(25) {
            let after_ns = (row as f64 - 239.5) * line_delay_s * 1e9;
            let row_ns = middle_ns.saturating_add_signed(after_ns.round() as i64);
            let expected = light(&mut global, row_ns);
            for pixel in row * width..(row + 1) * width {
                if (expected[pixel] - LEVEL).abs() > 1.0 {
                    square += (image[pixel] - expected[pixel]).powi(2);
                    square_at_once += (at_once[pixel] - expected[pixel]).powi(2);
                    count += 1.0;
                }
            }
        }
        let (rms, rms_at_once) = (f64::sqrt(square / count), f64::sqrt(square_at_once / count));
        assert!(
            rms < 1.0 && rms < 0.1 * rms_at_once,
            "{rms} against {rms_at_once}"
        );
    }
}

#[test]
fn blur_of_motion_is_the_mean_over_the_exposure() {
    let mut scenario = bare(Scenario::demo(1, 2, 1));
    let middle_ns = 2_000_000_000;
    let exposure_ns = 20_000_000;
    let mut sharp = Renderer::new(&scenario, 0).unwrap();
    scenario.cameras[0].exposure_ns = exposure_ns;
    let mut blurred = Renderer::new(&scenario, 0).unwrap();
    let n = 200;
    let mut mean = vec![0.0; light(&mut sharp, 0).len()];
    for i in 0..n {
        let instant_ns = middle_ns - exposure_ns / 2 + exposure_ns * (2 * i + 1) / (2 * n);
        for (mean, level) in mean.iter_mut().zip(light(&mut sharp, instant_ns)) {
            *mean += level / n as f64;
        }
    }
    let image = light(&mut blurred, middle_ns);
    let differences = image.iter().zip(&mean).map(|(a, b)| (a - b).abs());
    let worst = differences.fold(0.0, f64::max);
    assert!(worst < 2.0, "{worst}");
}
