//! One large tag before one camera, and where its edges and corners are in the picture: found by sums of light across
//! the edges, with nothing of the renderer's.

#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test takes what it needs of this"
)]

use nalgebra::{Matrix2, Point2, Vector2};
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_simulator::{
    Background, Flicker, Light, ObservedTag, Observer, Path, Random, Renderer, Scenario, Solid,
    Visibility, Wave,
};

/// When pictures are taken: a whole number of periods.
const AT_NS: u64 = 2_000_000_000;
const SIZE: f64 = 0.24;
/// Half the length of a profile across an edge, px; a module has over 15.
const REACH: i32 = 7;

/// One large tag on a box, before one pinhole camera.
pub fn scenario(yaw: f64, pitch: f64, roll: f64) -> Scenario {
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

pub fn image(scenario: &Scenario) -> Vec<u8> {
    let mut image = vec![0; 640 * 480];
    Renderer::new(scenario, 0)
        .unwrap()
        .render(AT_NS, &mut image)
        .unwrap();
    image
}

pub fn observed(scenario: &Scenario) -> ObservedTag {
    let mut observer = Observer::new(scenario, Visibility::default()).unwrap();
    observer
        .observe(0, AT_NS, 0.0, &mut Random::new(1))
        .remove(0)
}

/// A straight line: normal and offset.
type Line = (Vector2<f64>, f64);

/// The corners of a square near these, each known to about a pixel: where straight lines through its edges cross.
pub fn found_corners(image: &[u8], near: &[Point2<f64>; 4]) -> [Point2<f64>; 4] {
    let edge = |i: usize| fit_line(&edge_points(image, near[i], near[(i + 1) % 4]));
    let edges: [Line; 4] = std::array::from_fn(edge);
    std::array::from_fn(|i| cross(&edges[(i + 3) % 4], &edges[i]))
}

/// Points of the edge from a to b, both known to about a pixel; one a row or column, the ends left out.
pub fn edge_points(image: &[u8], a: Point2<f64>, b: Point2<f64>) -> Vec<Point2<f64>> {
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
    points
}

pub fn fit_line(points: &[Point2<f64>]) -> Line {
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

pub fn cross(a: &Line, b: &Line) -> Point2<f64> {
    let normals = Matrix2::from_rows(&[a.0.transpose(), b.0.transpose()]);
    Point2::from(normals.try_inverse().unwrap() * Vector2::new(a.1, b.1))
}
