//! How near lenses come to the truth, and how near they could: of twenty sets of board images (640x480, Brown-Conrady,
//! noise of 0.1 pixels) each the errors, the deviations that the images allow at best, and how many sets meet the
//! target: focal length within 0.05 %, centre within 0.5 pixels, 0.1 pixels on average over the picture.
//!
//! `cargo bench -p sextant-calibrator --bench lens`

#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a program that measures may panic and print, and takes what it needs of the tests' scenes"
)]

#[path = "../src/lens/tests/board_walk.rs"]
mod board_walk;
#[path = "../src/lens/tests/difference.rs"]
mod difference;

use board_walk::BoardWalk;
use difference::mean_difference;
use sextant_calibrator::lens::{Hint, LensCalibration, LensOptions, LensSession, Selection};
use sextant_geometry::LensModel;

const SETS: u64 = 20;

/// Errors of one lens and what the images allow.
#[derive(Clone, Copy, Default)]
struct Errors {
    /// Percent of fx, percent of fy, pixels of the centre.
    error: [f64; 4],
    /// One deviation of the same: the bound of Cramer and Rao for these images, as the adjustment's covariance has it.
    bound: [f64; 4],
    /// Pixels, over the picture.
    mean_px: f64,
    views: usize,
}

impl Errors {
    fn measure(found: &LensCalibration) -> Self {
        let truth = board_walk::ordinary();
        let (t, f) = (truth.intrinsics(), found.lens.intrinsics());
        let sigma = &found.sigmas;
        let percent = |x: f64, of: f64| 100.0 * x / of;
        Self {
            error: [
                percent(f.fx - t.fx, t.fx),
                percent(f.fy - t.fy, t.fy),
                f.cx - t.cx,
                f.cy - t.cy,
            ],
            bound: [
                percent(sigma[0], t.fx),
                percent(sigma[1], t.fy),
                sigma[2],
                sigma[3],
            ],
            mean_px: mean_difference(&truth, &found.lens),
            views: found.views,
        }
    }

    fn meet_the_target(&self) -> bool {
        let [fx, fy, cx, cy] = self.error;
        fx.abs() <= 0.05 && fy.abs() <= 0.05 && cx.hypot(cy) <= 0.5 && self.mean_px <= 0.1
    }
}

fn session(selection: Selection) -> LensSession {
    let options = LensOptions {
        resolution: [640, 480],
        model: Some(LensModel::BrownConrady),
        selection,
    };
    LensSession::new(&board_walk::board(1.0, 1.0), options).unwrap()
}

/// Thirty images as they come, the board between two distances.
fn thirty(seed: u64, depth: [f64; 2]) -> Errors {
    let mut walk = BoardWalk::new(board_walk::ordinary(), seed);
    walk.depth = depth;
    let mut session = session(Selection::All);
    for image in walk.images() {
        session.handle(&image).unwrap();
    }
    Errors::measure(&session.solve().unwrap())
}

/// As many as the hints ask for.
fn guided(seed: u64) -> Errors {
    let mut walk = BoardWalk::new(board_walk::ordinary(), seed);
    walk.depth = [0.18, 0.53];
    walk.images = 300;
    let mut session = session(Selection::New);
    for image in walk.images() {
        session.handle(&image).unwrap();
        if session.progress().hint == Hint::Enough {
            break;
        }
    }
    Errors::measure(&session.solve().unwrap())
}

fn tell(what: &str, of_seed: impl Fn(u64) -> Errors) {
    let all: Vec<Errors> = (0..SETS).map(of_seed).collect();
    let rms = |value: &dyn Fn(&Errors) -> f64| {
        let sum: f64 = all.iter().map(|errors| value(errors).powi(2)).sum();
        (sum / all.len() as f64).sqrt()
    };
    let met = all.iter().filter(|errors| errors.meet_the_target()).count();
    let views = all.iter().map(|errors| errors.views).sum::<usize>() as f64 / all.len() as f64;
    println!(
        "{what}, {views:.0} views: {met} of {SETS} meet the target; focal length {:.3} % (bound \
         {:.3}), centre {:.2}, {:.2} px (bound \
         {:.2}, {:.2}), over the picture {:.3} px",
        rms(&|e| e.error[0]),
        rms(&|e| e.bound[0]),
        rms(&|e| e.error[2]),
        rms(&|e| e.error[3]),
        rms(&|e| e.bound[2]),
        rms(&|e| e.bound[3]),
        rms(&|e| e.mean_px),
    );
}

fn main() {
    tell("board at arm's length", |seed| thirty(seed, [0.28, 0.53]));
    tell("board fills the picture", |seed| thirty(seed, [0.2, 0.35]));
    tell("as the hints ask", guided);
}
