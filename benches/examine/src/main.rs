//! How honest fusion is on scenes that nobody has seen: random ones by class, with exact truth.
//!
//! `cargo run --release -p sextant-examine -- CLASS FROM TO` runs the seeds FROM..TO of a class (`all`: of each)
//! and prints a line a scene and one of them all: rms of poses in mm and degrees and the worst, NEES per degree of
//! freedom, share inside the 95 % ellipsoid, share of instants with a tracked pose, rms against the Cramér-Rao bound
//! where two views see the body at once, error of poses foreseen by 33 ms that 95 % do not exceed, poses flipped by
//! more than 20 degrees and said to be tracked, faults named (there is none), the difference made by another order of
//! arrival, scenes whose NEES lies in 0.7 to 1.5.
//!
//! `-- refine FROM TO` asks what a proposed calibration is worth ([`refine`]).
//! `-- phones ...` measures browsers as cameras ([`phones`]).
//! `-- faults KIND FROM TO` and `-- quiet MINUTES FROM TO` ask whether what goes wrong is named ([`faults`]).

mod arm;
mod faults;
mod models;
mod motion;
mod phones;
mod random;
mod refine;
mod scene;
mod score;
mod shots;
mod view;
mod wrong;

use random::Random;
use scene::{CLASSES, Class, Scene};
use score::{Score, examined};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(("phones", rest)) = arguments.split_first().map(|(a, b)| (a.as_str(), b)) {
        if let Err(error) = phones::run(rest) {
            eprintln!("{error:#}");
            std::process::exit(2);
        }
        return;
    }
    let number = |index: usize| arguments.get(index).and_then(|text| text.parse().ok());
    if let (Some(what), Some(of), Some(from), Some(to)) = (
        arguments.first().map(String::as_str),
        arguments.get(1),
        number(2),
        number(3),
    ) {
        return match what.split_once('+').unwrap_or((what, "")) {
            ("faults", _) => faults::examine(of, from..to),
            (_, how) => faults::watch(how, of.parse().unwrap_or(10.0), from..to),
        };
    }
    let (Some(wanted), Some(from), Some(to)) = (arguments.first(), number(1), number(2)) else {
        eprintln!(
            "examine phones ..., examine refine FROM TO, examine faults KIND FROM TO, examine \
             quiet MINUTES FROM TO, examine CLASS FROM TO; CLASS is one of"
        );
        CLASSES
            .iter()
            .for_each(|(name, _, says)| eprintln!("  {name}: {says}"));
        std::process::exit(2);
    };
    if wanted == "refine" {
        return refine::examine(from..to);
    }
    for (name, class, _) in CLASSES {
        if wanted == name || wanted == "all" {
            examine(name, *class, from..to, wanted != "all");
        }
    }
}

fn examine(name: &str, class: Class, seeds: std::ops::Range<u64>, each: bool) {
    let mut sum = Score::default();
    for seed in seeds {
        let scene = Scene::new(class, seed);
        let random = &mut Random(seed);
        let shots = scene.shots(0.0, scene.seconds, random);
        let mut score = examined(&scene, &shots);
        score.compare(&scene, &shots, random);
        if each {
            println!("{name} {seed}: {score}");
            score
                .faults
                .iter()
                .for_each(|fault| println!("    {fault}"));
        }
        sum.join(&score);
    }
    println!("{name}: {sum}");
}
