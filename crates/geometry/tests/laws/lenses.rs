//! The laws of a lens, for all models.

use crate::generators::{lens, lens_and_point, lens_with_distortion, vector};
use crate::numeric::{jacobian_at_zero, relative_difference};
use nalgebra::{Point2, Point3, SVector, Vector2, Vector3};
use proptest::prelude::*;
use sextant_geometry::lens::{MAX_PARAMETERS, ParameterJacobian};
use sextant_geometry::{Intrinsics, Lens, LensError, LensModel, LensParameters, UnprojectError};

const INTRINSICS: Intrinsics = Intrinsics {
    fx: 600.0,
    fy: 590.0,
    cx: 320.0,
    cy: 240.0,
};
/// The radius up to which numbers are compared with those by differences: 79 degrees off the axis.
const WIDE: f64 = 5.0;

fn at_depth(normalised: &Point2<f64>, z: f64) -> Point3<f64> {
    Point3::new(normalised.x * z, normalised.y * z, z)
}

proptest! {
    #[test]
    fn undistort_inverts_distort_in_the_whole_field((lens, normalised) in lens_and_point(1.0, 100.0)) {
        let pixel = lens.distort(&normalised).unwrap();
        let back = lens.undistort(&pixel).unwrap();
        prop_assert!((back - normalised).norm() <= 1e-9 * (1.0 + normalised.coords.norm_squared()), "{back}");
    }

    #[test]
    fn undistort_inverts_distort_of_lenses_gone_wild((lens, normalised) in lens_and_point(20.0, 100.0)) {
        let pixel = lens.distort(&normalised).unwrap();
        let back = lens.undistort(&pixel).unwrap();
        prop_assert!((back - normalised).norm() <= 1e-8 * (1.0 + normalised.coords.norm_squared()), "{back}");
    }

    #[test]
    fn unproject_gives_the_ray_that_project_came_from(
        (lens, normalised) in lens_and_point(1.0, WIDE), z in 0.01..100.0
    ) {
        let point_in_camera = at_depth(&normalised, z);
        let ray = lens.unproject(&lens.project(&point_in_camera).unwrap()).unwrap();
        prop_assert!((ray.norm() - 1.0).abs() < 1e-14 && ray.z > 0.0);
        prop_assert!(ray.cross(&point_in_camera.coords).norm() < 1e-9 * z * (1.0 + WIDE * WIDE));
    }

    #[test]
    fn whatever_a_pixel_is_undistorted_to_lies_in_the_field_and_is_seen_there(
        lens in lens_with_distortion(3.0), pixel in vector::<2>(5000.0)
    ) {
        let pixel = Point2::from(pixel);
        match lens.undistort(&pixel) {
            Ok(normalised) => {
                prop_assert!(normalised.coords.norm() <= lens.max_radius() * (1.0 + 1e-12));
                let seen = lens.distort(&(normalised * (1.0 - 1e-15))).unwrap();
                prop_assert!((seen - pixel).norm() < 1e-6);
            }
            Err(error) => {
                let says_where = matches!(error, UnprojectError::OutsideField { .. });
                prop_assert!(says_where, "{}", error);
            }
        }
    }

    #[test]
    fn pixel_by_point_is_the_derivative((lens, normalised) in lens_and_point(1.0, WIDE), z in 0.5..5.0) {
        let point = at_depth(&normalised, z);
        let (pixel, analytic) = lens.project_with_jacobian(&point).unwrap();
        prop_assert_eq!(Some(pixel), lens.project(&point));
        prop_assume!(lens.max_radius() > normalised.coords.norm() + 1e-3);
        let numeric = jacobian_at_zero(|d: &Vector3<f64>| lens.project(&(point + d)).unwrap().coords);
        prop_assert!(relative_difference(&analytic, &numeric) < 1e-6);
    }

    #[test]
    fn pixel_by_parameters_is_the_derivative((lens, normalised) in lens_and_point(1.0, 1.0), z in 0.5..5.0) {
        let point = at_depth(&normalised, z);
        let analytic = lens.parameter_jacobian(&point).unwrap();
        let numeric: ParameterJacobian = jacobian_at_zero(|d: &SVector<f64, MAX_PARAMETERS>| {
            let moved: Vec<f64> = lens.parameters().iter().zip(d.iter()).map(|(p, d)| p + d).collect();
            // A parameter's step moves the field's end as well; a point right there is compared with itself.
            lens.with_parameters(&moved).unwrap().project(&point).unwrap_or(Point2::origin()).coords
        });
        prop_assume!(lens.max_radius() > normalised.coords.norm() + 1e-2);
        prop_assert!(relative_difference(&analytic, &numeric) < 1e-6, "{}{}", analytic, numeric);
    }

    #[test]
    fn normalised_by_pixel_is_the_derivative((lens, normalised) in lens_and_point(1.0, 1.0)) {
        prop_assume!(lens.max_radius() > normalised.coords.norm() + 1e-1);
        let pixel = lens.distort(&normalised).unwrap();
        let (_, analytic) = lens.undistort_with_jacobian(&pixel).unwrap();
        let step = 1e3; // a difference of 1e-3 px
        let numeric = jacobian_at_zero(|d: &Vector2<f64>| lens.undistort(&(pixel + d * step)).unwrap().coords) / step;
        prop_assert!((analytic - numeric).amax() < 1e-6 * analytic.amax());
    }

    #[test]
    fn distortion_never_folds_inside_the_field((lens, normalised) in lens_and_point(20.0, 100.0)) {
        let (_, pixel_by_point) = lens.project_with_jacobian(&at_depth(&normalised, 1.0)).unwrap();
        let f = lens.intrinsics();
        let unscale = nalgebra::Matrix2::new(1.0 / f.fx, 0.0, 0.0, 1.0 / f.fy);
        let distorted_by_normalised: nalgebra::Matrix2<f64> = unscale * pixel_by_point.fixed_view::<2, 2>(0, 0);
        // Positive definite: grows along every direction.
        let asymmetry = distorted_by_normalised.m12 - distorted_by_normalised.m21;
        let trace = distorted_by_normalised.trace();
        prop_assert!(asymmetry.abs() <= 1e-12 * trace);
        prop_assert!(distorted_by_normalised.symmetric_eigenvalues().min() > 0.0);
    }

    #[test]
    fn parameters_make_the_same_lens_again(lens in lens()) {
        prop_assert_eq!(lens.with_parameters(&lens.parameters()), Ok(lens));
        prop_assert_eq!(lens.parameters().len(), lens.n_parameters());
        prop_assert_eq!(Lens::try_from(LensParameters::from(lens)), Ok(lens));
        prop_assert_eq!(lens.model().name().parse::<LensModel>(), Ok(lens.model()));
    }

    #[test]
    fn no_numbers_make_a_lens_that_gives_nan(
        model in prop::sample::select(LensModel::ALL.to_vec()),
        parameters in prop::collection::vec(any::<f64>(), 9),
        point in prop::array::uniform3(any::<f64>()),
    ) {
        if let Ok(lens) = Lens::from_parameters(model, &parameters[..model.n_parameters()]) {
            check_all_finite(&lens, &Point3::from(point));
        }
    }

    #[test]
    fn no_point_or_pixel_gives_nan(lens in lens_with_distortion(20.0), point in prop::array::uniform3(any::<f64>())) {
        check_all_finite(&lens, &Point3::from(point));
    }
}

fn check_all_finite(lens: &Lens, point: &Point3<f64>) {
    assert!(lens.max_radius().is_finite() && lens.max_radius() > 0.0);
    if let Some((pixel, jacobian)) = lens.project_with_jacobian(point) {
        assert!(pixel.iter().all(|x| x.is_finite()), "{pixel}");
        assert!(jacobian.iter().all(|x| x.is_finite()), "{jacobian}");
        assert!(
            lens.parameter_jacobian(point)
                .unwrap()
                .iter()
                .all(|x| x.is_finite())
        );
    }
    if let Ok(ray) = lens.unproject(&point.xy()) {
        assert!(ray.iter().all(|x| x.is_finite()) && ray.z > 0.0, "{ray}");
    }
}

#[test]
fn the_field_of_a_barrel_lens_ends_where_its_radius_stops_growing() {
    let lens = Lens::brown_conrady(INTRINSICS, [-0.3, 0.0, 0.0, 0.0, 0.0]).unwrap();
    let fold = (1.0_f64 / 0.9).sqrt(); // d/dr (r - 0.3 r^3) = 0
    assert!((lens.max_radius() - fold).abs() < 1e-3 && lens.max_radius() < fold);
    assert!(lens.distort(&Point2::new(0.99 * fold, 0.0)).is_some());
    assert_eq!(lens.distort(&Point2::new(1.01 * fold, 0.0)), None);
    // Beyond the fold the polynomial would come back to pixels that inner points already have.
    let beyond = INTRINSICS.cx + INTRINSICS.fx * (fold - 0.3 * fold.powi(3)) + 1.0;
    let error = lens
        .undistort(&Point2::new(beyond, INTRINSICS.cy))
        .unwrap_err();
    assert!(matches!(error, UnprojectError::OutsideField { .. }));
    assert!(
        error.to_string().contains("outside the valid field"),
        "{error}"
    );
    assert!(error.to_string().contains("46.5 degrees"), "{error}");
}

#[test]
fn the_field_of_a_fisheye_ends_where_its_angle_stops_growing() {
    let lens = Lens::kannala_brandt(INTRINSICS, [-0.2, 0.0, 0.0, 0.0]).unwrap();
    let fold = (1.0_f64 / 0.6).sqrt(); // d/da (a - 0.2 a^3) = 0
    assert!((lens.half_angle() - fold).abs() < 1e-3 && lens.half_angle() < fold);
    let beyond = INTRINSICS.cx + INTRINSICS.fx * (fold - 0.2 * fold.powi(3)) + 0.1;
    assert!(lens.undistort(&Point2::new(beyond, INTRINSICS.cy)).is_err());
    assert!(
        lens.undistort(&Point2::new(beyond - 0.3, INTRINSICS.cy))
            .is_ok()
    );
}

#[test]
fn a_fisheye_without_coefficients_is_equidistant() {
    let lens = Lens::kannala_brandt(INTRINSICS, [0.0; 4]).unwrap();
    for degrees in [0.0_f64, 1e-4, 1.0, 45.0, 85.0] {
        let angle = degrees.to_radians();
        let pixel = lens
            .project(&Point3::new(angle.sin(), 0.0, angle.cos()))
            .unwrap();
        assert!((pixel.x - (INTRINSICS.cx + INTRINSICS.fx * angle)).abs() < 1e-9);
    }
}

/// Two points of the camera frame.
const POINTS: [[f64; 3]; 2] = [[0.4, -0.2, 2.0], [-0.5, 0.7, 1.0]];

fn assert_projects(lens: &Lens, pixels: [[f64; 2]; 2]) {
    for (point, expected) in POINTS.into_iter().zip(pixels) {
        let pixel = lens.project(&Point3::from(point)).unwrap();
        assert!(
            (pixel - Point2::from(expected)).norm() < 1e-6,
            "{pixel} is not {expected:?}"
        );
    }
}

#[test]
fn brown_conrady_agrees_with_opencv() {
    // cv2.projectPoints of OpenCV 5.0 with these intrinsics and coefficients.
    let lens = Lens::brown_conrady(INTRINSICS, [0.1, -0.05, 0.002, -0.001, 0.01]).unwrap();
    assert_projects(&lens, [[440.45915, 180.81850125], [3.214328, 676.37023512]]);
}

#[test]
fn kannala_brandt_agrees_with_opencv() {
    // cv2.fisheye.projectPoints of OpenCV 5.0 with these intrinsics and coefficients.
    let lens = Lens::kannala_brandt(INTRINSICS, [0.05, -0.02, 0.004, -0.001]).unwrap();
    assert_projects(
        &lens,
        [[438.33812912, 181.81708652], [67.15048904, 588.08949342]],
    );
}

#[test]
fn points_behind_and_beside_the_camera_are_not_seen() {
    let lens = Lens::pinhole(INTRINSICS).unwrap();
    for point in [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, -1.0],
        [1.0, 0.0, 1e-9],
        [f64::NAN, 0.0, 1.0],
        [0.0, 0.0, f64::NAN],
    ] {
        assert_eq!(lens.project(&Point3::from(point)), None, "{point:?}");
    }
}

#[test]
fn a_pixel_that_is_not_finite_is_named() {
    let lens = Lens::pinhole(INTRINSICS).unwrap();
    let error = lens.unproject(&Point2::new(f64::NAN, 3.0)).unwrap_err();
    assert!(matches!(error, UnprojectError::NotFinite { .. }), "{error}");
}

#[test]
fn numbers_that_are_no_lens_are_refused() {
    let bad_focal = |fx| Lens::pinhole(Intrinsics { fx, ..INTRINSICS });
    for fx in [0.0, -600.0, f64::NAN, f64::INFINITY, 1e7] {
        assert!(
            matches!(
                bad_focal(fx),
                Err(LensError::FocalLength { name: "fx", .. })
            ),
            "{fx}"
        );
    }
    let bad_centre = Lens::pinhole(Intrinsics {
        cy: f64::NAN,
        ..INTRINSICS
    });
    assert!(matches!(
        bad_centre,
        Err(LensError::OutOfRange { name: "cy", .. })
    ));
    let bad_coefficient = Lens::brown_conrady(INTRINSICS, [0.0, 0.0, f64::INFINITY, 0.0, 0.0]);
    assert!(matches!(
        bad_coefficient,
        Err(LensError::OutOfRange { name: "p1", .. })
    ));
    let folded = Lens::brown_conrady(INTRINSICS, [-9000.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(matches!(folded, Err(LensError::FieldTooNarrow { .. })));
    let short = Lens::from_parameters(LensModel::KannalaBrandt, &[600.0; 9]);
    assert_eq!(
        short.unwrap_err().to_string(),
        "a kannala-brandt lens has 8 parameters, 9 were given"
    );
}
