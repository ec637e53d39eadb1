//! What a camera sees of a scene: corners, and what they tell of a pose at best.

use nalgebra::{Matrix2, Matrix6, Point2, Point3, SMatrix, SVector, Vector2, Vector3, Vector6};
use sextant_geometry::{Homography, Lens, Pose, se3, tag_corners_in_tag};
use sextant_site_model::{Camera, ObjectTag, TagCorners};

use crate::random::Random;
use crate::scene::{Scene, is_inside};

/// Cosine from a tag's normal to the sight, and length of its shortest side in px, from which on it is found.
const FACING: f64 = 0.25;
const SMALLEST_PX: f64 = 6.0;
/// Radius of a body where it hides others, m.
const RADIUS_M: f64 = 0.045;

pub fn tags(scene: &Scene, camera: usize, taken_s: f64, random: &mut Random) -> Vec<TagCorners> {
    let stated = scene
        .stated_sigma_px
        .map_or(0.0, |sigma_px| sigma_px.powi(2));
    let noise_px = scene.noise_px(camera);
    let mut seen = Vec::new();
    for body in 0..scene.bodies.len() {
        for (tag, corners) in visible(scene, camera, body, taken_s) {
            let mut noise = || Vector2::new(random.gauss(), random.gauss()) * noise_px;
            seen.push(TagCorners {
                tag: tag.tag,
                corners: corners.map(|corner| corner + noise()),
                corner_covariance: [Matrix2::identity() * stated; 4],
                corner_cross_covariance: [Matrix2::zeros(); 6],
            });
        }
    }
    seen
}

type Corners = [Point2<f64>; 4];

/// The tags of a body that a camera finds, with their corners.
fn visible(scene: &Scene, camera: usize, body: usize, taken_s: f64) -> Vec<(&ObjectTag, Corners)> {
    let camera = &scene.truth.cameras()[camera];
    let model = &scene.bodies[body].model;
    let (links, world_from_camera) = (scene.bodies[body].links(taken_s), pose_of(camera));
    let mut seen = Vec::new();
    for tag in model.tags() {
        let link = model.link_of(tag).unwrap_or(0);
        let Some(object_from_tag) = tag.object_from_tag else {
            continue;
        };
        let camera_from_tag = world_from_camera.inverse() * links[link] * object_from_tag;
        let corners = match camera.line_delay_s {
            None => corners(&camera.lens, &camera_from_tag, tag.size_m, scene.fitted),
            Some(line_delay_s) => tag_corners_in_tag(tag.size_m).map(|corner| {
                let (mut after_s, mut seen) = (0.0, None);
                // The row says when, and when says the row: a few rounds settle it.
                for _ in 0..5 {
                    let link = scene.bodies[body].links(taken_s + after_s)[link];
                    let in_camera = world_from_camera.inverse() * link * object_from_tag * corner;
                    seen = Some(camera.lens.project(&in_camera)?);
                    after_s = (seen?.y - 239.5) * line_delay_s;
                }
                seen
            }),
        };
        let [Some(a), Some(b), Some(c), Some(d)] = corners else {
            continue;
        };
        let corners = [a, b, c, d];
        let shortest = (0..4).map(|side| (corners[side] - corners[(side + 1) % 4]).norm());
        let towards = camera_from_tag.translation.vector.normalize();
        let found = -towards.dot(&(camera_from_tag.rotation * Vector3::z())) > FACING
            && shortest.fold(f64::INFINITY, f64::min) > SMALLEST_PX
            && corners
                .iter()
                .all(|corner| is_inside(corner, camera.resolution));
        let place = (links[link] * object_from_tag).translation.vector;
        if found
            && !is_hidden(
                scene,
                body,
                world_from_camera.translation.vector,
                place,
                taken_s,
            )
        {
            seen.push((tag, corners));
        }
    }
    seen
}

fn pose_of(camera: &Camera) -> Pose {
    camera.world_from_camera.unwrap_or_default()
}

/// Whether another body is between.
fn is_hidden(
    scene: &Scene,
    body: usize,
    from: Vector3<f64>,
    to: Vector3<f64>,
    taken_s: f64,
) -> bool {
    let others = scene
        .bodies
        .iter()
        .enumerate()
        .filter(|(other, _)| *other != body);
    let mut between = others.map(|(_, other)| {
        let centre = other.motion.at(taken_s).translation.vector - from;
        let along = (to - from).normalize();
        let (depth, reach) = (centre.dot(&along), (to - from).norm());
        (0.0..reach).contains(&depth) && (centre - along * depth).norm() < RADIUS_M
    });
    between.any(|hides| hides)
}

fn corners(
    lens: &Lens,
    camera_from_tag: &Pose,
    size_m: f64,
    fitted: bool,
) -> [Option<Point2<f64>>; 4] {
    let square = tag_corners_in_tag(size_m);
    let exact = square.map(|corner| lens.project(&(camera_from_tag * corner)));
    let ([Some(a), Some(b), Some(c), Some(d)], true) = (exact, fitted) else {
        return exact;
    };
    let mut places = [a, b, c, d];
    let flat = square.map(|corner| corner.xy());
    let pattern: Vec<Point2<f64>> = (0..81)
        .map(|n| Point2::new((n % 9) as f64, (n / 9) as f64) / 8.0)
        .map(|share| flat[3] + (flat[1] - flat[3]).component_mul(&share.coords))
        .collect();
    for _ in 0..3 {
        let Some(step) = fit_step(lens, camera_from_tag, &flat, &places, &pattern) else {
            return exact;
        };
        (0..4).for_each(|corner| places[corner] -= step.fixed_rows::<2>(2 * corner).into_owned());
    }
    places.map(Some)
}

/// Gauss-Newton on the corners' images, to where the homography through them fits the whole pattern.
fn fit_step(
    lens: &Lens,
    camera_from_tag: &Pose,
    flat: &Corners,
    places: &Corners,
    pattern: &[Point2<f64>],
) -> Option<SVector<f64, 8>> {
    let now = Homography::from_corners(flat, places)?;
    let moved = |place: usize| {
        let mut places = *places;
        places[place / 2][place % 2] += 1e-4;
        Homography::from_corners(flat, &places)
    };
    let moved: Vec<Homography> = (0..8).map(moved).collect::<Option<_>>()?;
    let (mut normal, mut side) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
    for point in pattern {
        let truth = lens.project(&(camera_from_tag * Point3::new(point.x, point.y, 0.0)))?;
        let at = now.apply(point)?;
        let mut slopes = SMatrix::<f64, 2, 8>::zeros();
        for (place, moved) in moved.iter().enumerate() {
            slopes.set_column(place, &((moved.apply(point)? - at) * 1e4));
        }
        normal += slopes.transpose() * slopes;
        side += slopes.transpose() * (at - truth);
    }
    normal.cholesky().map(|root| root.solve(&side))
}

/// What an image tells of a rigid body's pose at best (Fisher's information), by (dt, dr).
pub fn information(scene: &Scene, camera: usize, body: usize, taken_s: f64) -> Matrix6<f64> {
    let lens = &scene.truth.cameras()[camera];
    let pose = scene.bodies[body].motion.at(taken_s);
    let mut sum = Matrix6::zeros();
    for (tag, _) in visible(scene, camera, body, taken_s) {
        for corner in tag_corners_in_tag(tag.size_m) {
            let pixel = |place: usize, step: f64| {
                let mut twist = Vector6::zeros();
                twist[place] = step;
                let world_from_tag = se3::perturb(&pose, &twist) * tag.object_from_tag?;
                lens.lens
                    .project(&(pose_of(lens).inverse() * world_from_tag * corner))
            };
            let mut slopes = SMatrix::<f64, 2, 6>::zeros();
            for place in 0..6 {
                if let (Some(after), Some(before)) = (pixel(place, 1e-5), pixel(place, -1e-5)) {
                    slopes.set_column(place, &((after - before) / 2e-5));
                }
            }
            sum += slopes.transpose() * slopes / scene.noise_px(camera).powi(2);
        }
    }
    sum
}
