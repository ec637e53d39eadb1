//! Each fault of tags, lens, sensor, light and motion does to the picture what it says, and nothing where it is off.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod measured;

use measured::{edge_points, found_corners, image, observed, scenario};
use nalgebra::{Point2, Vector3};
use sextant_geometry::Pose;
use sextant_simulator::{
    AutoExposure, Background, CameraFileError, Curl, Displacement, Flicker, Imperfections,
    LensResidual, Mosaic, PathEvent, Random, Renderer, Scenario, Visibility, Wave,
};

/// How far the corners that are found in the picture are from those of another scenario, px.
fn errors(drawn: &Scenario, expected: &Scenario) -> [f64; 4] {
    let expected = observed(expected).corners;
    let found = found_corners(&image(drawn), &observed(drawn).corners);
    std::array::from_fn(|i| (found[i] - expected[i]).norm())
}

fn largest(errors: [f64; 4]) -> f64 {
    errors.into_iter().fold(0.0, f64::max)
}

/// The fault moves corners by more than `least_px`, to where it says.
fn moves_corners(least_px: f64, fault: impl FnOnce(&mut Scenario)) {
    let sound = scenario(0.3, 0.4, -0.2);
    let mut faulty = sound.clone();
    fault(&mut faulty);
    assert!(
        largest(errors(&faulty, &faulty)) < 0.03,
        "{:?}",
        errors(&faulty, &faulty)
    );
    assert!(largest(errors(&faulty, &sound)) > least_px);
}

#[test]
fn a_print_that_is_too_large_has_longer_edges() {
    let edge = |scenario: &Scenario| {
        let corners = found_corners(&image(scenario), &observed(scenario).corners);
        (corners[1] - corners[0]).norm()
    };
    let sound = scenario(0.3, 0.0, 0.0);
    let mut scaled = sound.clone();
    scaled.objects[0].tags[0].print_scale = 1.01;
    assert!((edge(&scaled) / edge(&sound) - 1.01).abs() < 1e-4);
    let built = scaled.as_built();
    assert!((built.objects[0].tags[0].size / sound.objects[0].tags[0].size - 1.01).abs() < 1e-12);
    assert_eq!(
        scaled.as_written().unwrap().objects[0].tags,
        sound.objects[0].tags
    );
}

#[test]
fn a_tag_that_is_glued_on_crookedly_is_seen_where_it_is() {
    moves_corners(2.0, |scenario| {
        scenario.objects[0].tags[0].glue_error = Displacement {
            position: [0.003, -0.001, 0.0005],
            rotation: [0.01, 0.02, 0.03],
        };
    });
}

/// How far the points of the tag's edges in the picture are from where they should be, and from straight lines, px.
fn bends(scenario: &Scenario) -> [f64; 2] {
    let (camera, tag) = (&scenario.cameras[0], &scenario.objects[0].tags[0]);
    let camera_from_object =
        camera.world_from_camera.inverse() * scenario.objects[0].world_from_object(0);
    let half = tag.true_size() / 2.0;
    let seen = |[x, y]: [f64; 2]| {
        let point = camera_from_object * tag.sheet_point([x * half, y * half]);
        camera.project(&point).unwrap()
    };
    let image = image(scenario);
    let (mut off_curve, mut off_line): (f64, f64) = (0.0, 0.0);
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    for i in 0..4 {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        let at = |share: f64| seen([0, 1].map(|k| from[k] + share * (to[k] - from[k])));
        let curve: Vec<Point2<f64>> = (0..=1000).map(|i| at(f64::from(i) / 1000.0)).collect();
        let chord = at(1.0) - at(0.0);
        for point in edge_points(&image, at(0.0), at(1.0)) {
            let ways = curve.windows(2).map(|piece| {
                let (a, along) = (piece[0], piece[1] - piece[0]);
                let share = ((point - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (point - (a + along * share)).norm()
            });
            off_curve = off_curve.max(ways.fold(f64::INFINITY, f64::min));
            off_line = off_line.max(chord.perp(&(point - at(0.0))).abs() / chord.norm());
        }
    }
    [off_curve, off_line]
}

#[test]
fn straight_edges_are_straight_without_a_fault() {
    let [_, off_line] = bends(&scenario(0.2, 0.5, 0.3));
    assert!(off_line < 0.05, "{off_line}");
}

#[test]
fn a_lens_shows_what_its_model_lacks() {
    let mut scenario = scenario(0.2, 0.5, 0.3);
    scenario.cameras[0].lens_residual = LensResidual {
        radial_px: 0.8,
        prism_px: [3.0, -2.0],
    };
    let [off_curve, off_line] = bends(&scenario);
    assert!(off_curve < 0.05 && off_line > 0.5, "{off_curve} {off_line}");
}

#[test]
fn bent_paper_bends_the_tags_edges() {
    for sagitta in [0.004, -0.004] {
        let mut scenario = scenario(0.2, 0.5, 0.3);
        scenario.objects[0].tags[0].curl = Curl {
            sagitta,
            direction: 0.3,
        };
        let [off_curve, off_line] = bends(&scenario);
        assert!(off_curve < 0.05 && off_line > 0.4, "{off_curve} {off_line}");
    }
}

/// A plain wall of grey level 120 at gain 1.
fn wall() -> Scenario {
    let mut scenario = scenario(0.0, 0.0, 0.0);
    let away = sextant_simulator::Path::at_rest(&Pose::translation(0.0, 0.0, 9.0));
    scenario.objects[0].path = away;
    scenario
}

fn mean(image: &[u8], columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> f64 {
    let n = (columns.len() * rows.len()) as f64;
    let pixels = rows.flat_map(|y| columns.clone().map(move |x| y * 640 + x));
    pixels.map(|i| f64::from(image[i])).sum::<f64>() / n
}

#[test]
fn vignetting_darkens_the_corners_by_its_share() {
    let mut scenario = wall();
    scenario.cameras[0].vignetting = 0.4;
    let image = image(&scenario);
    assert!((mean(&image, 310..330, 230..250) - 120.0).abs() < 0.6);
    assert!((mean(&image, 0..4, 0..4) - 0.6 * 120.0).abs() < 1.5);
}

#[test]
fn dim_light_and_auto_exposure() {
    let lit = |ambient: f64, auto_exposure| {
        let mut scenario = scenario(0.0, 0.0, 0.0);
        scenario.light.ambient = ambient;
        scenario.light.lamp = 0.0;
        scenario.background = Background::Room {
            table: [4.0, 4.0],
            clutter: 0.0,
        };
        scenario.cameras[0].exposure_ns = 2_000_000;
        scenario.cameras[0].auto_exposure = auto_exposure;
        scenario
    };
    let paper = |scenario: &Scenario| {
        let corners = observed(scenario).corners;
        let (x, y) = (corners[0].x as usize + 20, corners[0].y as usize - 12);
        mean(&image(scenario), x..x + 100, y..y + 8)
    };
    let (bright, dim) = (paper(&lit(0.5, None)), paper(&lit(0.05, None)));
    assert!((dim / bright - 0.1).abs() < 0.01, "{dim} of {bright}");
    let auto = AutoExposure {
        target: 60.0,
        max_exposure_ns: 8_000_000,
        max_gain: 16.0,
        lag_s: 0.0,
    };
    let aimed = |ambient| {
        let scenario = lit(ambient, Some(auto));
        let background = mean(&image(&scenario), 0..80, 0..480);
        (
            background,
            Renderer::new(&scenario, 0).unwrap().camera().exposure_ns,
        )
    };
    let ((bright, short_ns), (dim, long_ns)) = (aimed(0.5), aimed(0.05));
    assert!((dim - bright).abs() < 3.0, "{bright} and {dim}");
    assert!(short_ns < long_ns && long_ns == 8_000_000);
}

#[test]
fn defocus_spreads_edges_over_its_disk() {
    let rise = |defocus_px: f64| {
        let mut scenario = scenario(0.0, 0.0, 0.0);
        scenario.cameras[0].blur_px = 0.0;
        scenario.cameras[0].defocus_px = defocus_px;
        let corners = observed(&scenario).corners;
        let (x, y) = (corners[0].x.round() as usize, corners[0].y as usize + 40);
        let image = image(&scenario);
        let row = &image[y * 640 + x - 10..y * 640 + x + 10];
        let (white, black) = (f64::from(row[0]), f64::from(row[19]));
        let between = |&&level: &&u8| {
            let share = (f64::from(level) - black) / (white - black);
            (0.01..0.99).contains(&share)
        };
        row.iter().filter(between).count()
    };
    assert!(rise(0.0) <= 1);
    assert!((6..=9).contains(&rise(4.0)), "{}", rise(4.0));
}

/// A tag that crosses the picture at v px/s: corners are skewed by v times the line delay a row.
#[test]
fn a_rolling_shutter_skews_a_moving_tag() {
    let moving = |line_delay_s: f64| {
        let mut scenario = scenario(0.0, 0.0, 0.0);
        scenario.objects[0].path.period_s = 2.0;
        scenario.objects[0].path.position[0] = Wave::still(0.0).and(1, 0.15, 0.0);
        scenario.cameras[0].line_delay_s = line_delay_s;
        scenario
    };
    let skew = |scenario: &Scenario| {
        let corners = found_corners(&image(scenario), &observed(scenario).corners);
        (corners[3].x - corners[0].x) / (corners[3].y - corners[0].y)
    };
    let (still, rolling) = (moving(0.0), moving(5e-5));
    let speed_px_s = {
        let distance_m = 2.0 - 1.0 - 0.01;
        rolling.objects[0].twist(0)[0] * 800.0 / distance_m
    };
    assert!((skew(&rolling) - skew(&still) - speed_px_s * 5e-5).abs() < 3e-4);
    let off = errors(&rolling, &rolling);
    assert!(largest(off) < 0.08, "{off:?}");
    assert!(largest(errors(&rolling, &still)) > 0.8);
}

#[test]
fn a_thrown_object_is_drawn_where_it_flies() {
    let mut flying = scenario(0.0, 0.0, 0.0);
    flying.objects[0].path.events = vec![PathEvent::Throw {
        at_s: 0.0,
        duration_s: 0.3,
        turns: 0,
        axis: [0.0, 0.0, 1.0],
    }];
    let seen = |scenario: &Scenario, true_ns: u64| {
        let mut observer =
            sextant_simulator::Observer::new(scenario, Visibility::default()).unwrap();
        let mut image = vec![0; 640 * 480];
        let mut renderer = Renderer::new(scenario, 0).unwrap();
        renderer.render(true_ns, &mut image).unwrap();
        let tag = observer
            .observe(0, true_ns, 0.0, &mut Random::new(1))
            .remove(0);
        (found_corners(&image, &tag.corners), tag.corners)
    };
    let (found, expected) = seen(&flying, 150_000_000);
    assert!((found[0] - expected[0]).norm() < 0.03);
    // It is 11 cm nearer to the camera.
    let edge = |corners: &[Point2<f64>; 4]| (corners[1] - corners[0]).norm();
    let (at_rest, _) = seen(&flying, 500_000_000);
    assert!((edge(&found) / edge(&at_rest) - 0.99 / (0.99 - 9.81 * 0.0225 / 2.0)).abs() < 1e-3);
}

#[test]
fn files_with_errors_change_no_picture() {
    let scenario = Scenario::demo(2, 2, 3);
    let mut wrong = scenario.clone();
    wrong.cameras[0].file_error = CameraFileError {
        position: [0.01, 0.0, 0.0],
        rotation: [0.0, 0.01, 0.0],
        focal: 0.01,
    };
    assert_eq!(image(&scenario), image(&wrong));
    let written = wrong.as_written().unwrap();
    let moved: Vector3<f64> = written.cameras[0].world_from_camera.translation.vector
        - scenario.cameras[0].world_from_camera.translation.vector;
    assert!((moved.x - 0.01).abs() < 1e-15);
    assert_eq!(written.cameras[1], scenario.cameras[1]);
}

/// Everything at once.
fn world(seed: u64) -> Scenario {
    let mut scenario = Scenario::demo(2, 3, seed).with_imperfections(&Imperfections::TYPICAL);
    scenario.light.flicker = Flicker {
        amplitude: 0.2,
        rate_hz: 100.0,
    };
    scenario.light.ambient = 0.1;
    scenario.light.lamp = 0.15;
    for camera in &mut scenario.cameras {
        camera.lens_residual = LensResidual {
            radial_px: 0.3,
            prism_px: [0.4, 0.2],
        };
        camera.auto_exposure = Some(AutoExposure {
            target: 90.0,
            max_exposure_ns: 12_000_000,
            max_gain: 8.0,
            lag_s: 0.1,
        });
        (camera.defocus_px, camera.shot_noise) = (1.5, 4.0);
        (camera.mosaic, camera.jpeg_quality) = (Mosaic::Bayer, Some(70));
        camera.line_delay_s = 2e-5;
    }
    for (i, tag) in scenario
        .objects
        .iter_mut()
        .flat_map(|o| &mut o.tags)
        .enumerate()
    {
        tag.curl = Curl {
            sagitta: 0.0015,
            direction: 0.4 * i as f64,
        };
    }
    scenario.objects[0].path.events = vec![PathEvent::Hit {
        at_s: 1.0,
        duration_s: 0.4,
        velocity: [0.5, 0.0, 0.5],
        spin: [0.0, 4.0, 0.0],
    }];
    scenario
}

#[test]
fn all_faults_at_once_follow_from_the_seed_and_leave_nothing_behind() {
    let scenario = world(1);
    let render = |renderer: &mut Renderer, true_ns: u64| {
        let mut image = vec![0; 640 * 480];
        renderer.render(true_ns, &mut image).unwrap();
        image
    };
    let mut used = Renderer::new(&scenario, 1).unwrap();
    let first = render(&mut used, 1_100_000_000);
    render(&mut used, 3_000_000_000);
    assert_eq!(render(&mut used, 1_100_000_000), first);
    assert_eq!(
        render(&mut Renderer::new(&world(1), 1).unwrap(), 1_100_000_000),
        first
    );
    assert_ne!(
        render(&mut Renderer::new(&world(2), 1).unwrap(), 1_100_000_000),
        first
    );
}

#[test]
fn a_scenario_with_faults_comes_back_from_its_file() {
    let scenario = world(4);
    let text = toml::to_string(&scenario).unwrap();
    for key in [
        "file_error",
        "print_scale",
        "glue_error",
        "curl",
        "mosaic = \"bayer\"",
    ] {
        assert!(text.contains(key), "{key}");
    }
    assert_eq!(toml::from_str::<Scenario>(&text).unwrap(), scenario);
    let sound = toml::to_string(&Scenario::demo(2, 3, 4)).unwrap();
    for key in [
        "file_error",
        "print_scale",
        "glue_error",
        "curl",
        "mosaic",
        "event",
    ] {
        assert!(
            !sound.contains(key),
            "{key}: faults that are off need no key"
        );
    }
}
