//! Corners can be found again in an image without noise, to 0.02 px, by a fit of straight lines that knows nothing of the
//! renderer: along each edge of a tag's black square the sum of light across it tells where it runs.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use nalgebra::{Matrix2, Point2, Point3, Vector2};
use sextant_geometry::{Intrinsics, Lens, Pose, tag_corners_in_tag};
use sextant_simulator::{
    Background, Flicker, Harmonic, Light, ObservedTag, Observer, Path, Random, Renderer, Scenario,
    Solid, Visibility, Wave,
};

const SIZE: f64 = 0.24;
/// Half the length of a profile across an edge, px; a module has over 15.
const REACH: i32 = 7;

/// One large tag on a box, before one pinhole camera.
fn scenario(yaw: f64, pitch: f64, roll: f64) -> Scenario {
    let mut scenario = Scenario::demo(1, 1, 1);
    scenario.background = Background::Plain { level: 120.0 };
    scenario.light = Light {
        shadow: 0.0,
        pool_radius: 1000.0,
        ..Light::default()
    };
    let camera = &mut scenario.cameras[0];
    let intrinsics = Intrinsics {
        fx: 800.0,
        fy: 803.0,
        cx: 321.3,
        cy: 237.8,
    };
    camera.lens = Lens::pinhole(intrinsics).unwrap();
    camera.noise = 0.0;
    camera.vignetting = 0.0;
    camera.gain = 1.0;
    camera.flicker = Flicker::default();
    camera.exposure_ns = 0;
    camera.world_from_camera = Pose::translation(0.0, 0.0, 2.0)
        * Pose::rotation(nalgebra::Vector3::x() * std::f64::consts::PI);
    let object = &mut scenario.objects[0];
    object.solids = vec![Solid::Box {
        size: [0.34, 0.34, 0.02],
        object_from_box: Pose::identity(),
        albedo: 0.4,
    }];
    object.tags.truncate(1);
    object.tags[0].size = SIZE;
    object.tags[0].object_from_tag = Pose::translation(0.0, 0.0, 0.01);
    object.path = Path::at_rest(&Pose::translation(0.02, -0.03, 1.0));
    object.path.yaw = Wave::still(yaw);
    object.path.pitch = Wave::still(pitch);
    object.path.roll = Wave::still(roll);
    scenario
}

fn image(scenario: &Scenario) -> Vec<u8> {
    let mut image = vec![0; 640 * 480];
    Renderer::new(scenario, 0)
        .unwrap()
        .render(0, &mut image)
        .unwrap();
    image
}

fn observed(scenario: &Scenario) -> ObservedTag {
    let mut observer = Observer::new(scenario, Visibility::default()).unwrap();
    observer.observe(0, 0, 0.0, &mut Random::new(1)).remove(0)
}

/// A straight line: normal and offset.
type Line = (Vector2<f64>, f64);

/// The line through the edge from a to b, both known to about a pixel.
fn fit_edge(image: &[u8], a: Point2<f64>, b: Point2<f64>) -> Line {
    let along = b - a;
    let upright = along.y.abs() > along.x.abs();
    let mut points = Vec::new();
    let (from, to) = if upright { (a.y, b.y) } else { (a.x, b.x) };
    let (first, last) = (
        from.min(to) + 0.15 * (to - from).abs(),
        from.max(to) - 0.15 * (to - from).abs(),
    );
    for main in first.ceil() as i32..=last.floor() as i32 {
        let share = (f64::from(main) - from) / (to - from);
        let near = if upright {
            a.x + share * along.x
        } else {
            a.y + share * along.y
        };
        let cross = near.round() as i32;
        let level = |offset: i32| {
            let (x, y) = if upright {
                (cross + offset, main)
            } else {
                (main, cross + offset)
            };
            f64::from(image[(y * 640 + x) as usize])
        };
        let (low, high) = (level(-REACH), level(REACH));
        let sum: f64 = (-REACH..=REACH)
            .map(|offset| (level(offset) - high) / (low - high))
            .sum();
        // The edge lies where the first level, ending sharply, would give the same sum.
        let edge = f64::from(cross - REACH) - 0.5 + sum;
        points.push(if upright {
            Point2::new(edge, f64::from(main))
        } else {
            Point2::new(f64::from(main), edge)
        });
    }
    fit_line(&points)
}

fn fit_line(points: &[Point2<f64>]) -> Line {
    let centre = points.iter().map(|p| p.coords).sum::<Vector2<f64>>() / points.len() as f64;
    let spread: Matrix2<f64> = points
        .iter()
        .map(|p| (p.coords - centre) * (p.coords - centre).transpose())
        .sum();
    let eigen = spread.symmetric_eigen();
    let smallest = eigen.eigenvalues.imin();
    let normal = eigen.eigenvectors.column(smallest).into_owned();
    (normal, normal.dot(&centre))
}

fn cross(a: &Line, b: &Line) -> Point2<f64> {
    let normals = Matrix2::from_rows(&[a.0.transpose(), b.0.transpose()]);
    Point2::from(normals.try_inverse().unwrap() * Vector2::new(a.1, b.1))
}

#[test]
fn corners_are_recovered_to_two_hundredths_of_a_pixel() {
    for (yaw, pitch, roll) in [
        (0.0, 0.0, 0.0),
        (0.3, 0.4, -0.2),
        (1.2, -0.5, 0.3),
        (2.5, 0.1, 0.7),
        (0.01, 0.0, 0.0),
    ] {
        let scenario = scenario(yaw, pitch, roll);
        let (image, truth) = (image(&scenario), observed(&scenario).corners);
        let edges: Vec<Line> = (0..4)
            .map(|i| fit_edge(&image, truth[i], truth[(i + 1) % 4]))
            .collect();
        for i in 0..4 {
            let found = cross(&edges[(i + 3) % 4], &edges[i]);
            let error = (found - truth[i]).norm();
            assert!(
                error < 0.02,
                "yaw {yaw}: corner {i} is off by {error:.4} px"
            );
        }
    }
}

#[test]
fn corners_run_clockwise_from_the_tags_top_left() {
    let corners = observed(&scenario(0.0, 0.0, 0.0)).corners;
    assert!(corners[0].x < corners[1].x && corners[0].y < corners[3].y);
    assert!(
        (corners[0].x - corners[3].x).abs() < 1e-9 && (corners[0].y - corners[1].y).abs() < 1e-9
    );
}

#[test]
fn observed_corners_are_the_projected_truth() {
    let scenario = Scenario::demo(3, 3, 4);
    let mut observer = Observer::new(&scenario, Visibility::default()).unwrap();
    let true_ns = 4_200_000_000;
    let tags = observer.observe(1, true_ns, 0.0, &mut Random::new(1));
    assert!(tags.len() > 5);
    let camera = &scenario.cameras[1];
    for seen in tags {
        let object = &scenario.objects[seen.object];
        let tag = object.tags.iter().find(|tag| tag.id == seen.id).unwrap();
        let world_from_tag = object.world_from_object(true_ns) * tag.object_from_tag;
        for (corner, point) in seen.corners.iter().zip(tag_corners_in_tag(tag.size)) {
            let in_camera: Point3<f64> =
                camera.world_from_camera.inverse() * (world_from_tag * point);
            assert!((camera.lens.project(&in_camera).unwrap() - corner).norm() < 1e-9);
        }
    }
}

#[test]
fn noise_of_corners_has_the_stated_sigma() {
    let scenario = scenario(0.3, 0.4, -0.2);
    let truth = observed(&scenario).corners;
    let mut observer = Observer::new(&scenario, Visibility::default()).unwrap();
    let mut random = Random::new(3);
    let mut squares = 0.0;
    for _ in 0..2000 {
        let seen = observer.observe(0, 0, 0.3, &mut random).remove(0);
        squares += (seen.corners[2] - truth[2]).norm_squared();
    }
    assert!(((squares / 4000.0_f64).sqrt() - 0.3).abs() < 0.02);
}

/// A tag that crosses the picture: each corner is where a global shutter would see it at the time of its row.
#[test]
fn a_rolling_shutter_sees_each_corner_when_its_row_is_taken() {
    let mut scenario = Scenario::demo(2, 1, 3);
    scenario.objects[0].path.position[0].harmonics = vec![Harmonic {
        order: 1,
        amplitude: 0.1,
        phase: 0.0,
    }];
    scenario.objects[0].path.period_s = 1.0;
    let mut global = Observer::new(&scenario, Visibility::default()).unwrap();
    scenario.cameras[0].line_delay_s = -3e-5;
    let mut rolling = Observer::new(&scenario, Visibility::default()).unwrap();
    let true_ns = 5_000_000_000;
    let seen = rolling.observe(0, true_ns, 0.0, &mut Random::new(1));
    assert!(!seen.is_empty());
    let mut furthest: f64 = 0.0;
    for tag in &seen {
        for (index, corner) in tag.corners.iter().enumerate() {
            let after_ns = (corner.y - 239.5) * -3e-5 * 1e9;
            let row_ns = true_ns.saturating_add_signed(after_ns.round() as i64);
            let seen_at = |observer: &mut Observer, at_ns: u64| {
                let tags = observer.observe(0, at_ns, 0.0, &mut Random::new(1));
                tags.iter()
                    .find(|other| other.id == tag.id)
                    .unwrap()
                    .corners[index]
            };
            assert!((seen_at(&mut global, row_ns) - corner).norm() < 1e-4);
            furthest = furthest.max((seen_at(&mut global, true_ns) - corner).norm());
        }
    }
    assert!(furthest > 0.3, "{furthest}");
}
