//! Images to detect tags in, drawn by the simulator from fixed seeds.

use nalgebra::Vector3;
use sextant_geometry::{Intrinsics, Lens, Pose};
use sextant_simulator::{
    Background, Flicker, Light, Path, Renderer, Scenario, ScenarioError, SceneObject, Solid, Wave,
};
use sextant_tag_families::Family;
use std::f64::consts::PI;

/// Pixels in a row.
pub const WIDTH: usize = 640;
/// Rows.
pub const HEIGHT: usize = 480;

/// Standard deviation of usual and of strong noise, grey levels.
const USUAL_NOISE: f64 = 1.5;
const STRONG_NOISE: f64 = 8.0;

/// A grey image and what it shows.
#[derive(Clone, Debug)]
pub struct Picture {
    /// What it shows, for people.
    pub name: &'static str,
    /// Row after row.
    pub pixels: Vec<u8>,
}

/// Every kind.
///
/// # Errors
/// A scene that the simulator refuses, which would be a fault of this file.
pub fn pictures() -> Result<Vec<Picture>, ScenarioError> {
    let kinds = [
        ("empty", empty()),
        ("1 tag", boards(1, USUAL_NOISE)),
        ("3 tags", boards(3, USUAL_NOISE)),
        ("12 tags", boards(12, USUAL_NOISE)),
        ("clutter", cluttered_room()),
        ("3 tags, noise 8", boards(3, STRONG_NOISE)),
    ];
    let drawn = kinds.map(|(name, scenario)| draw(name, &scenario));
    drawn.into_iter().collect()
}

fn draw(name: &'static str, scenario: &Scenario) -> Result<Picture, ScenarioError> {
    let mut pixels = vec![0; WIDTH * HEIGHT];
    let drawn = Renderer::new(scenario, 0)?.render(0, &mut pixels);
    // All cameras here have the same resolution.
    debug_assert!(drawn.is_ok());
    Ok(Picture { name, pixels })
}

/// A room full of things, three objects with several tags each among them.
fn cluttered_room() -> Scenario {
    let mut scenario = Scenario::demo(1, 3, 1);
    scenario.background = Background::Room {
        table: [1.5, 1.2],
        clutter: 1.0,
    };
    scenario.cameras[0].noise = USUAL_NOISE;
    scenario
}

/// A plain ground alone: its one board is behind the camera.
fn empty() -> Scenario {
    let mut scenario = boards(1, USUAL_NOISE);
    scenario.objects[0].path = Path::at_rest(&Pose::translation(0.0, 0.0, 9.0));
    scenario
}

/// Boards with a tag each, 40 to 45 px wide, turned this way and that before a plain ground.
fn boards(count: u32, noise: f64) -> Scenario {
    let mut scenario = Scenario::demo(1, 1, 1);
    scenario.background = Background::Plain { level: 120.0 };
    scenario.light = Light {
        shadow: 0.0,
        pool_radius: 1000.0,
        ..Light::default()
    };
    let camera = &mut scenario.cameras[0];
    let intrinsics = Intrinsics {
        fx: 600.0,
        fy: 600.0,
        cx: 319.5,
        cy: 239.5,
    };
    // A pinhole of these numbers is a lens; otherwise the demonstration's own will do.
    camera.lens = Lens::pinhole(intrinsics).unwrap_or(camera.lens);
    camera.noise = noise;
    camera.flicker = Flicker::default();
    camera.exposure_ns = 0;
    camera.world_from_camera = Pose::translation(0.0, 0.0, 2.0) * Pose::rotation(Vector3::x() * PI);
    let model = scenario.objects[0].clone();
    scenario.objects = (0..count)
        .map(|index| board(&model, index, count))
        .collect();
    scenario
}

fn board(model: &SceneObject, index: u32, count: u32) -> SceneObject {
    const COLUMNS: u32 = 4;
    const STEP_M: f64 = 0.19;
    const HEIGHT_M: f64 = 1.2;
    const THICKNESS_M: f64 = 0.01;
    let (columns, rows) = (count.min(COLUMNS), count.div_ceil(COLUMNS));
    let place = |at: u32, of: u32| STEP_M * (f64::from(at) - f64::from(of - 1) / 2.0);
    let (x, y) = (
        place(index % COLUMNS, columns),
        place(index / COLUMNS, rows),
    );
    let turn = f64::from(index);
    let mut path = Path::at_rest(&Pose::translation(x, y, HEIGHT_M));
    path.yaw = Wave::still(0.3 + 0.7 * turn);
    path.pitch = Wave::still(0.35 * (1.0 + turn).sin());
    path.roll = Wave::still(0.35 * (2.0 + 3.0 * turn).sin());
    let mut board = model.clone();
    board.id = format!("board-{index}");
    board.path = path;
    board.solids = vec![Solid::Box {
        size: [0.1, 0.1, THICKNESS_M],
        object_from_box: Pose::identity(),
        albedo: 0.4,
    }];
    board.tags.truncate(1);
    for tag in &mut board.tags {
        tag.family = Family::Tag36h11;
        tag.id = 40 * index;
        tag.size = 0.06;
        tag.object_from_tag = Pose::translation(0.0, 0.0, THICKNESS_M / 2.0);
    }
    board
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_apriltag::{Detector, Image, Options};

    #[test]
    fn each_picture_shows_the_tags_that_its_name_says() {
        let mut detector = Detector::new(Options::default()).unwrap();
        let mut count = |picture: Picture| {
            let image = Image::new(&picture.pixels, WIDTH, HEIGHT, WIDTH).unwrap();
            (picture.name, detector.detect(&image).len())
        };
        let counts: Vec<_> = pictures().unwrap().into_iter().map(&mut count).collect();
        let named = |name: &str| counts.iter().find(|count| count.0 == name).unwrap().1;
        assert_eq!(
            ["empty", "1 tag", "3 tags", "12 tags", "3 tags, noise 8"].map(named),
            [0, 1, 3, 12, 3]
        );
        assert!(named("clutter") >= 3, "{counts:?}");
    }
}
