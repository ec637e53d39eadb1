//! Whether reported standard deviations are honest: of two hundred simulated calibrations each, how many true values
//! lie within two of them. Ends with 1 where that is not between 90 and 99 %.
//!
//! `cargo bench -p sextant-calibrator --bench honesty`, for one of them with `-- rig`, `-- lens` or `-- learn`.

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a program that measures may panic and print, and takes what it needs of the tests' scenes"
)]

#[path = "../src/lens/tests/board_walk.rs"]
mod board_walk;
#[path = "../tests/procedures/scene.rs"]
mod scene;

use board_walk::BoardWalk;
use sextant_calibrator::lens::{LensOptions, LensSession, Selection};
use sextant_calibrator::{Gauge, LearnPlan, LearnSession, Origin, RigPlan, RigSession};
use sextant_geometry::{LensModel, se3};
use sextant_site_model::Rig;
use std::ops::Range;
use std::process::ExitCode;

const SEEDS: Range<u64> = 1000..1200;
const RIG_NOISE_PX: f64 = 0.2;

/// One calibration's errors in units of their reported deviations.
type Errors = Vec<f64>;

/// Position and attitude of three cameras relative to the first, of a walk with 24 instants.
fn rig(seed: u64) -> Errors {
    let truth = scene::rig();
    let noise = scene::Lack {
        sigma_px: RIG_NOISE_PX,
        wrong: 0.0,
    };
    let plan = RigPlan {
        object: scene::board(),
        origin: Origin::FirstCamera,
    };
    let mut session = RigSession::new(scene::blind(&truth), plan).unwrap();
    for image in scene::walk(&truth, &scene::board(), 24, 0.3, noise, seed) {
        session.handle(&image);
    }
    let found = session.solve().unwrap();
    let relative = |rig: &Rig, at: usize| {
        let pose = |at: usize| rig.cameras()[at].world_from_camera.unwrap();
        pose(0).inverse() * pose(at)
    };
    let of_camera = |at: usize| {
        let error = se3::difference(&relative(&found.rig, at), &relative(&truth, at));
        let stated = &found.report.cameras[at];
        let position = [0, 1, 2].map(|axis| error[axis] * 1e3 / stated.sigma_axes_mm[axis]);
        let attitude =
            [0, 1, 2].map(|axis| error[3 + axis].to_degrees() / stated.sigma_axes_deg[axis]);
        position.into_iter().chain(attitude)
    };
    (1..truth.cameras().len()).flat_map(of_camera).collect()
}

/// The parameters of a lens from 15 images of a board.
fn lens(seed: u64) -> Errors {
    let truth = board_walk::ordinary();
    let mut walk = BoardWalk::new(truth, seed);
    walk.images = 15;
    let options = LensOptions {
        resolution: [640, 480],
        model: Some(LensModel::BrownConrady),
        selection: Selection::All,
    };
    let mut session = LensSession::new(&board_walk::board(1.0, 1.0), options).unwrap();
    for image in walk.images() {
        session.handle(&image).unwrap();
    }
    let found = session.solve().unwrap();
    let errors = truth.parameters().into_iter().zip(found.lens.parameters());
    let errors = errors.zip(&found.sigmas);
    errors
        .map(|((truth, found), sigma)| (found - truth) / sigma)
        .collect()
}

/// Six tags relative to the first, of 45 images of a thing that is turned before a camera.
fn learn(seed: u64) -> Errors {
    let mut camera = scene::rig().cameras()[0].clone();
    camera.world_from_camera = Some(scene::looking([-0.4, 0.35, 0.5], [0.0, 0.0, 0.0]));
    let truth = scene::thing();
    let plan = LearnPlan {
        object: truth.id().clone(),
        tags: truth
            .tags()
            .iter()
            .map(|tag| (tag.tag, tag.size_m))
            .collect(),
        cameras: Vec::new(),
        gauge: Gauge::Tag(truth.tags()[0].tag),
        from: None,
    };
    let rig = Rig::new(vec![camera.clone()]).unwrap();
    let mut session = LearnSession::new(scene::blind(&rig), plan).unwrap();
    let mut noise = scene::Random::new(seed);
    for at in 0..45 {
        let seconds = 0.2 * f64::from(at);
        session.handle(&scene::image(
            &camera,
            &truth,
            &scene::turned(seconds),
            seconds,
            scene::SHARP,
            &mut noise,
        ));
    }
    let found = session.solve().unwrap();
    let of_tag = |at: usize| {
        let pose = |at: usize| truth.tags()[at].object_from_tag.unwrap();
        let placed = found.object.tags()[at].object_from_tag.unwrap();
        let error = se3::difference(&placed, &(pose(0).inverse() * pose(at)));
        let stated = &found.report.tags[at];
        let position = [0, 1, 2].map(|axis| error[axis] * 1e3 / stated.sigma_axes_mm[axis]);
        let attitude =
            [0, 1, 2].map(|axis| error[3 + axis].to_degrees() / stated.sigma_axes_deg[axis]);
        position.into_iter().chain(attitude)
    };
    (1..truth.tags().len()).flat_map(of_tag).collect()
}

/// Prints the share within two deviations, of each value and of all; whether all is as it should be: values that are
/// understated must not hide behind others that are overstated.
fn judge(what: &str, calibration: impl Fn(u64) -> Errors) -> bool {
    let errors: Vec<Errors> = SEEDS.map(calibration).collect();
    let mut shares = Vec::new();
    for value in 0..errors[0].len() {
        let of_value: Vec<f64> = errors.iter().map(|errors| errors[value]).collect();
        shares.push(print_share(&format!("{what}, value {value}"), &of_value));
    }
    let all: Vec<f64> = errors.concat();
    let share = print_share(&format!("{what}, all"), &all);
    // A value's share of 200 itself has a deviation of 1.5 %.
    (0.90..=0.99).contains(&share) && shares.iter().all(|share| *share > 0.88)
}

fn print_share(what: &str, errors: &[f64]) -> f64 {
    let n = errors.len() as f64;
    let share = errors.iter().filter(|e| e.abs() < 2.0).count() as f64 / n;
    let mean = errors.iter().sum::<f64>() / n;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    println!(
        "{what}: {:.1} % within two deviations, mean {mean:+.2}, rms {rms:.2}",
        100.0 * share
    );
    share
}

fn main() -> ExitCode {
    let named: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |what: &str| {
        let other = |n: &String| n != what && ["rig", "lens", "learn"].contains(&n.as_str());
        !named.iter().any(other) || named.iter().any(|n| n == what)
    };
    let honest = [
        !wanted("rig") || judge("rig", rig),
        !wanted("lens") || judge("lens", lens),
        !wanted("learn") || judge("learn", learn),
    ];
    ExitCode::from(u8::from(honest.contains(&false)))
}
