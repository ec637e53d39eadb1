//! Corners can be found again in an image without noise, to 0.02 px, by a fit of straight lines that knows nothing of
//! the renderer: along each edge of a tag's black square the sum of light across it tells where it runs.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod measured;

use measured::{found_corners, image, observed, scenario};
use nalgebra::Point3;
use sextant_geometry::tag_corners_in_tag;
use sextant_simulator::{Harmonic, Observer, Random, Scenario, Visibility};

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
        let found = found_corners(&image, &truth);
        for i in 0..4 {
            let error = (found[i] - truth[i]).norm();
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
