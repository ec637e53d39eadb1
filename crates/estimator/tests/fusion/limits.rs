//! Errors against the Cramer-Rao bound: with ideal corners of known noise no estimate can be better, and this one is
//! not much worse.

use nalgebra::{Matrix6, SMatrix, Vector2, Vector6};
use sextant_geometry::{Pose, se3};
use sextant_site_model::{ImageObservation, ObjectModel, Rig};

use crate::scene::{Eye, Random, START_NS, cube, error, exact_options, feed, fusion, path, rig};

const SIGMA_PX: f64 = 0.05;
/// Of a numeric derivative, m and rad.
const STEP: f64 = 1e-6;

fn corners(image: &ImageObservation) -> Vec<Vector2<f64>> {
    let corners = image.tags.iter().flat_map(|tag| tag.corners);
    corners.map(|corner| corner.coords).collect()
}

/// Fisher's information on the pose in the corners of all cameras at an instant.
fn information(rig: &Rig, object: &ObjectModel, pose: &Pose) -> Matrix6<f64> {
    let eye = Eye {
        rig,
        object,
        sigma_px: 0.0,
    };
    let mut sum = Matrix6::zeros();
    for camera in 0..rig.cameras().len() {
        let seen = |step: f64, axis: usize| {
            let moved = se3::perturb(pose, &(Vector6::ith(axis, step)));
            corners(&eye.image(camera, START_NS, &moved, &mut Random(0)))
        };
        let slopes: Vec<Vec<Vector2<f64>>> = (0..6)
            .map(|axis| {
                let (ahead, behind) = (seen(STEP, axis), seen(-STEP, axis));
                let pairs = ahead.iter().zip(&behind);
                pairs.map(|(a, b)| (a - b) / (2.0 * STEP)).collect()
            })
            .collect();
        for corner in 0..slopes[0].len() {
            let columns: Vec<_> = slopes.iter().map(|of_axis| of_axis[corner]).collect();
            let jacobian = SMatrix::<f64, 2, 6>::from_columns(&columns);
            sum += jacobian.transpose() * jacobian / SIGMA_PX.powi(2);
        }
    }
    sum
}

/// Root mean squares of the errors of position and attitude over those of the bound, for an object seen at one instant.
fn against_the_bound(cameras: usize, trials: u64) -> [f64; 2] {
    let (rig, object) = (rig(cameras), cube());
    let eye = Eye {
        rig: &rig,
        object: &object,
        sigma_px: SIGMA_PX,
    };
    let (mut squares, mut bounds) = ([0.0; 2], [0.0; 2]);
    for trial in 0..trials {
        let (pose, mut random) = (path(0.37 * trial as f64), Random(trial));
        let mut fusion = fusion(&rig, &object, exact_options());
        let mut last = None;
        for camera in 0..cameras {
            let image = eye.image(camera, START_NS, &pose, &mut random);
            last = feed(&mut fusion, image).pop().or(last);
        }
        let off = error(&last.unwrap(), &pose);
        let bound = information(&rig, &object, &pose).try_inverse().unwrap();
        for part in 0..2 {
            squares[part] += off.fixed_rows::<3>(3 * part).norm_squared();
            bounds[part] += bound.fixed_view::<3, 3>(3 * part, 3 * part).trace();
        }
    }
    [0, 1].map(|part| f64::sqrt(squares[part] / bounds[part]))
}

#[test]
fn two_views_give_what_their_corners_can_tell() {
    for cameras in [2, 3, 4] {
        for ratio in against_the_bound(cameras, 400) {
            assert!((0.9..1.1).contains(&ratio), "{cameras} cameras: {ratio}");
        }
    }
}
