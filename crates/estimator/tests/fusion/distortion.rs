//! Lenses that bend lines: corners that are the very points, and corners of a detector that takes a tag for flat in the
//! image.

use nalgebra::{Matrix3, Point2, Point3, SMatrix, SVector, Vector2, Vector3};
use sextant_estimator::FusionOptions;
use sextant_geometry::{Homography, Lens, Pose, tag_corners_in_tag};
use sextant_site_model::{Camera, ImageObservation, ObjectModel, Rig};

use crate::scene::{Random, START_NS, cube, feed, fusion, path_at, rig, run};
use crate::uncertainty::nees;

const SIGMA_PX: f64 = 0.01;

fn bending(rig: &Rig) -> Rig {
    let bending = |camera: &Camera| Camera {
        lens: Lens::brown_conrady(camera.lens.intrinsics(), [-0.35, 0.1, 5e-4, -4e-4, 0.0])
            .unwrap(),
        // Aside, so that the tags are where the lens bends.
        world_from_camera: camera
            .world_from_camera
            .map(|pose| pose * Pose::rotation(Vector3::new(0.15, -0.25, 0.0))),
        ..camera.clone()
    };
    Rig::new(rig.cameras().iter().map(bending).collect())
        .unwrap()
        .exact()
}

/// Corners of the homography (with a one at its end) that follows the whole bent tag best, by linear least squares.
fn fitted(lens: &Lens, camera_from_tag: &Pose, size_m: f64) -> [Point2<f64>; 4] {
    let (mut normal, mut side) = (SMatrix::<f64, 8, 8>::zeros(), SVector::<f64, 8>::zeros());
    let middle = lens.project(&camera_from_tag.translation.vector.into());
    for index in 0..81 {
        let along = |step: usize| 0.25 * step as f64 - 1.0;
        let (x, y) = (along(index % 9), along(index / 9));
        let point = Point2::new(x, y) * (0.5 * size_m);
        let in_camera = camera_from_tag * Point3::new(point.x, point.y, 0.0);
        let seen = lens.project(&in_camera).unwrap() - middle.unwrap();
        for (value, first) in [(seen.x, 0), (seen.y, 3)] {
            let mut row = SVector::<f64, 8>::zeros();
            (row[first], row[first + 1], row[first + 2]) = (x, y, 1.0);
            (row[6], row[7]) = (-x * value, -y * value);
            normal += row * row.transpose();
            side += row * value;
        }
    }
    let numbers = normal.cholesky().unwrap().solve(&side);
    let matrix = Matrix3::from_row_iterator(numbers.iter().copied().chain([1.0]));
    let homography = Homography::from_matrix(&matrix).unwrap();
    tag_corners_in_tag(size_m).map(|corner| {
        homography.apply(&(corner.xy() / (0.5 * size_m))).unwrap() + middle.unwrap().coords
    })
}

fn with_fitted_corners(
    rig: &Rig,
    object: &ObjectModel,
    image: &mut ImageObservation,
    random: &mut Random,
) {
    let camera = rig.camera(&image.camera).unwrap();
    let camera_from_object =
        camera.world_from_camera.unwrap().inverse() * path_at(image.capture_ns);
    for seen in &mut image.tags {
        let mut tags = object.tags().iter();
        let tag = tags.find(|tag| tag.tag == seen.tag).unwrap();
        let camera_from_tag = camera_from_object * tag.object_from_tag.unwrap();
        let corners = fitted(&camera.lens, &camera_from_tag, tag.size_m);
        seen.corners =
            corners.map(|corner| corner + Vector2::new(random.gauss(), random.gauss()) * SIGMA_PX);
    }
}

#[test]
fn how_much_of_the_bow_corners_have_is_found_out_within_a_second() {
    let (rig, object) = (bending(&rig(3)), cube());
    for as_fitted in [false, true] {
        let (mut values, mut random) = (Vec::new(), Random(5));
        let mut fusion = fusion(&rig, &object, FusionOptions::default());
        for mut image in run(&rig, &object, SIGMA_PX, 4.0, &mut Random(3)) {
            if as_fitted {
                with_fitted_corners(&rig, &object, &mut image, &mut random);
            }
            let time_ns = image.capture_ns;
            let said = feed(&mut fusion, image);
            let late = said.iter().filter(|_| time_ns > START_NS + 1_000_000_000);
            values.extend(late.map(|estimate| nees(estimate, &path_at(time_ns))));
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!(
            (0.7..1.4).contains(&mean),
            "fitted {as_fitted}: NEES {mean} of {}",
            values.len()
        );
    }
}
