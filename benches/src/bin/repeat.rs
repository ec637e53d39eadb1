//! Repeats one detection, to be counted by callgrind or timed at its best: `repeat write DIR` makes the images,
//! `repeat DETECTOR FILE N` works on one of them, DETECTOR being sextant, edges, or with the feature `peer` c or c20.

use sextant_apriltag::{Detector, Image, Options, Refinement};
use sextant_benches::{HEIGHT, WIDTH, pictures};
use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

type Outcome = Result<(), Box<dyn Error>>;

fn main() -> Outcome {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["write", folder] => write(Path::new(folder)),
        [detector, file, n] => repeat(detector, &fs::read(file)?, n.parse()?),
        _ => Err("repeat write DIR | repeat sextant|edges|c|c20 FILE N".into()),
    }
}

/// Bare pixels, a file an image.
fn write(folder: &Path) -> Outcome {
    fs::create_dir_all(folder)?;
    for picture in pictures()? {
        let name = picture.name.replace(", ", "-").replace(' ', "-");
        fs::write(folder.join(name), picture.pixels)?;
    }
    Ok(())
}

fn repeat(detector: &str, pixels: &[u8], n: u32) -> Outcome {
    match detector {
        "sextant" => ours(Refinement::Photometric, pixels, n),
        "edges" => ours(Refinement::Edges, pixels, n),
        #[cfg(feature = "peer")]
        "c" | "c20" => {
            let mut peer = sextant_benches::Peer::new(if detector == "c" { 5 } else { 20 });
            print_best(n, || peer.detect(pixels, WIDTH));
            Ok(())
        }
        _ => Err(format!("no detector named {detector} was built").into()),
    }
}

fn ours(refinement: Refinement, pixels: &[u8], n: u32) -> Outcome {
    let mut detector = Detector::new(Options {
        refinement,
        ..Options::default()
    })?;
    let image = Image::new(pixels, WIDTH, HEIGHT, WIDTH)?;
    print_best(n, || detector.detect(&image).len());
    Ok(())
}

fn print_best(n: u32, mut detect: impl FnMut() -> usize) {
    let (mut best, mut tags) = (Duration::MAX, 0);
    for _ in 0..n {
        let start = Instant::now();
        tags = detect();
        best = best.min(start.elapsed());
    }
    println!(
        "{tags} tags, best of {n}: {:.1} us",
        best.as_secs_f64() * 1e6
    );
}
